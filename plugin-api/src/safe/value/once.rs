//! Lists that a type declares, read once, so that they match what the host got, whatever the type returns later.

use std::{
    any::{Any, TypeId},
    collections::BTreeMap,
    sync::{Arc, Mutex, PoisonError},
};

/// The list of a key; `make` is called the first time only.
pub(crate) fn once<Key: 'static, T: Send + Sync + 'static>(make: impl FnOnce() -> Vec<T>) -> Arc<[T]> {
    static LISTS: Mutex<BTreeMap<TypeId, Arc<dyn Any + Send + Sync>>> = Mutex::new(BTreeMap::new());
    let key = TypeId::of::<fn(Key) -> T>();
    let known = LISTS.lock().unwrap_or_else(PoisonError::into_inner).get(&key).cloned();
    // Not under the lock: what makes a list may ask for another one.
    let list = known.unwrap_or_else(|| {
        let made: Arc<Arc<[T]>> = Arc::new(make().into());
        LISTS.lock().unwrap_or_else(PoisonError::into_inner).entry(key).or_insert(made).clone()
    });
    // The key has the type: this cannot fail.
    list.downcast::<Arc<[T]>>().map_or_else(|_| Vec::new().into(), |list| (*list).clone())
}
