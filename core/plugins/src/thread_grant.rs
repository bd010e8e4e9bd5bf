//! Plugins' instances on threads other than the one that created them.

/// A value through which instances of plugins are called, handed to another thread.
///
/// Instances are plain pointers, and nothing in Rust's types says on which threads their plugin may be called: the
/// plugin declares it. This is the only type that carries instances to other threads.
pub struct ThreadGrant<T>(T);

impl<T> ThreadGrant<T> {
    /// Grants a thread the use of a value.
    ///
    /// # Safety
    /// Each plugin whose instances are called through the value has declared that this thread may call them: a language
    /// by
    /// `TATU_LANGUAGE_SIDE_BY_SIDE`, a command by `TATU_COMMAND_SIDE_BY_SIDE`, a function of a table by the tag
    /// `[parallel]` in the header. What else the value refers to is changed by nobody but this thread as long as it has
    /// the value.
    pub unsafe fn new(value: T) -> Self {
        ThreadGrant(value)
    }

    /// The value.
    pub fn get(&mut self) -> &mut T {
        &mut self.0
    }
}

// SAFETY: the caller of `ThreadGrant::new` has promised that plugins have declared the flag that lets this thread call
// them, and that nothing changes what the value refers to meanwhile.
unsafe impl<T> Send for ThreadGrant<T> {}
