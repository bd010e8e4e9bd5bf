//! A shared value that a reload can replace between two steps.

use std::{
    cell::{Cell, RefCell},
    ops::Deref,
    ptr::NonNull,
    sync::Arc,
};

/// A shared value that can be replaced while references to previous values exist: all values are retained until the
/// `SwapCell` is dropped. Reading costs as much as reading through an `Arc`.
pub(crate) struct SwapCell<T> {
    current: Cell<NonNull<T>>,
    retained: RefCell<Vec<Arc<T>>>,
}

impl<T> SwapCell<T> {
    pub fn new(value: Arc<T>) -> Self {
        SwapCell { current: Cell::new(NonNull::from(&*value)), retained: RefCell::new(vec![value]) }
    }
    /// Replaces the value.
    pub fn set(&self, value: Arc<T>) {
        let mut kept = self.retained.borrow_mut();
        self.current.set(NonNull::from(&*value));
        if !kept.iter().any(|k| Arc::ptr_eq(k, &value)) {
            kept.push(value);
        }
    }
    /// Returns the current value.
    pub fn shared(&self) -> Arc<T> {
        let kept = self.retained.borrow();
        let now = kept.iter().find(|k| std::ptr::eq(Arc::as_ptr(k), self.current.get().as_ptr()));
        now.or(kept.last()).map(Arc::clone).unwrap_or_else(|| unreachable!("it is never empty"))
    }
}

impl<T> Deref for SwapCell<T> {
    type Target = T;
    fn deref(&self) -> &T {
        // SAFETY: `current` points into an `Arc` in `retained`, which only grows, so the value lives as long as `self`;
        // it is never modified.
        unsafe { self.current.get().as_ref() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn replaced_value_remains_readable() {
        let first = Arc::new(String::from("first"));
        let swap = SwapCell::new(first.clone());
        let held: &String = &swap;
        swap.set(Arc::new("second".into()));
        assert_eq!((held.as_str(), swap.as_str(), swap.shared().as_str()), ("first", "second", "second"));
        swap.set(first);
        assert_eq!((swap.as_str(), swap.shared().as_str()), ("first", "first"));
    }
}
