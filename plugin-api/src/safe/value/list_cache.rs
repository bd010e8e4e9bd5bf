//! Caches the lists that a type declares, so that they are always those that were declared to the host, even if the
//! type would return different lists later.

use std::{
    any::{Any, TypeId},
    collections::BTreeMap,
    sync::{Arc, Mutex, PoisonError},
};

/// Returns the cached list of the type `Key`, which `make` creates in the first call.
pub(crate) fn cached_list<Key: 'static, T: Send + Sync + 'static>(make: impl FnOnce() -> Vec<T>) -> Arc<[T]> {
    static CACHED_LISTS: Mutex<BTreeMap<TypeId, Arc<dyn Any + Send + Sync>>> = Mutex::new(BTreeMap::new());
    let key = TypeId::of::<fn(Key) -> T>();
    let known = CACHED_LISTS.lock().unwrap_or_else(PoisonError::into_inner).get(&key).cloned();
    // `make` is called without holding the lock, because it may itself request another list.
    let list = known.unwrap_or_else(|| {
        let made: Arc<Arc<[T]>> = Arc::new(make().into());
        CACHED_LISTS.lock().unwrap_or_else(PoisonError::into_inner).entry(key).or_insert(made).clone()
    });
    // The key determines the type, so this cannot fail.
    list.downcast::<Arc<[T]>>().map_or_else(|_| Vec::new().into(), |list| (*list).clone())
}
