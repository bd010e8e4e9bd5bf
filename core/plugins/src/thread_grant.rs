//! Use of plugin instances on threads other than the one that created them.

/// A value, passed to another thread, through which that thread calls plugin instances.
///
/// Instances are plain pointers, and no Rust type expresses on which threads their plugin may be called: the plugin
/// declares it. Only this type carries instances to other threads.
pub struct ThreadGrant<T>(T);

impl<T> ThreadGrant<T> {
    /// Permits another thread to use a value.
    ///
    /// # Safety
    /// Each plugin whose instances are called through the value must have declared that this thread may call them: a
    /// language by `TATU_LANGUAGE_SIDE_BY_SIDE`, a command by `TATU_COMMAND_SIDE_BY_SIDE`, a function of a table by the
    /// tag `[parallel]` in the header. While the other thread has the value, no other thread may change anything else
    /// that the value refers to.
    pub unsafe fn new(value: T) -> Self {
        ThreadGrant(value)
    }

    /// Returns the value.
    pub fn get(&mut self) -> &mut T {
        &mut self.0
    }
}

// SAFETY: the caller of `ThreadGrant::new` guarantees that the plugins permit calls from this thread, and that no other
// thread changes anything that the value refers to.
unsafe impl<T> Send for ThreadGrant<T> {}
