//! A shared value that a reload can replace between two steps.

use std::{
    cell::{Cell, RefCell},
    ops::Deref,
    ptr::NonNull,
    sync::Arc,
};

/// A shared value that can be replaced while references to previous values exist: all values are retained until the
/// `Swap` is dropped. Reading costs as much as reading through an `Arc`.
pub(crate) struct Swap<T> {
    now: Cell<NonNull<T>>,
    kept: RefCell<Vec<Arc<T>>>,
}

impl<T> Swap<T> {
    pub fn new(value: Arc<T>) -> Self {
        Swap { now: Cell::new(NonNull::from(&*value)), kept: RefCell::new(vec![value]) }
    }
    /// Replaces the value.
    pub fn set(&self, value: Arc<T>) {
        let mut kept = self.kept.borrow_mut();
        self.now.set(NonNull::from(&*value));
        if !kept.iter().any(|k| Arc::ptr_eq(k, &value)) {
            kept.push(value);
        }
    }
    /// Returns the current value.
    pub fn shared(&self) -> Arc<T> {
        let kept = self.kept.borrow();
        let now = kept.iter().find(|k| std::ptr::eq(Arc::as_ptr(k), self.now.get().as_ptr()));
        now.or(kept.last()).map(Arc::clone).unwrap_or_else(|| unreachable!("it is never empty"))
    }
}

impl<T> Deref for Swap<T> {
    type Target = T;
    fn deref(&self) -> &T {
        // SAFETY: `now` points into an `Arc` in `kept`, which only grows, so the value lives as long as `self`; it is
        // never modified.
        unsafe { self.now.get().as_ref() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_was_there_before_can_still_be_read() {
        let first = Arc::new(String::from("first"));
        let swap = Swap::new(first.clone());
        let held: &String = &swap;
        swap.set(Arc::new("second".into()));
        assert_eq!((held.as_str(), swap.as_str(), swap.shared().as_str()), ("first", "second", "second"));
        swap.set(first);
        assert_eq!((swap.as_str(), swap.shared().as_str()), ("first", "first"));
    }
}
