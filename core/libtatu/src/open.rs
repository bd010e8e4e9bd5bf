//! The table of open worlds. Handles are integers that are never reused, so a stale handle is rejected; they are never
//! dereferenced.

use std::{
    collections::BTreeMap,
    sync::{
        Arc, Mutex, PoisonError,
        atomic::{AtomicUsize, Ordering::Relaxed},
    },
};

use tatu_embed::{Host, Seat, Setup};
use tatu_plugin_api::{
    abi::{TATU_ERR_GONE, tatu_str, tatu_value},
    safe::{Owned, Value},
};

use crate::answer::Wrong;

/// The type to which handles nominally point. No value of this type exists, since handles are integers.
pub enum Handle {}

/// An open world, and the memory that its last answer lends to the caller.
struct Open {
    host: Host,
    /// Memory to which the last answer points.
    answer: Mutex<Answer>,
}

/// Memory that an answer lends to the caller until the next answer of the same kind replaces it.
#[derive(Default)]
pub struct Answer {
    values: Owned,
    bytes: Vec<u8>,
}

/// Pointers into the memory of an [`Answer`], on their way to the caller.
pub struct Lent<T>(pub T);

// SAFETY: the pointers are passed from the world's thread to the caller, who alone uses them; what they point to is
// owned by the open world, and does not move.
unsafe impl<T> Send for Lent<T> {}

impl Lent<tatu_str> {
    /// An empty string.
    pub const EMPTY: Self = Lent(tatu_str { ptr: std::ptr::null(), len: 0 });
}

impl Answer {
    /// Stores a value, and returns its form in the ABI.
    pub fn value(&mut self, value: &Value) -> Lent<tatu_value> {
        self.values = Owned::default();
        Lent(self.values.raw(value))
    }
    /// Stores several values, and returns their forms in the ABI.
    pub fn values(&mut self, values: &[Value]) -> Lent<Vec<tatu_value>> {
        self.values = Owned::default();
        Lent(values.iter().map(|v| self.values.raw(v)).collect())
    }
    /// Stores bytes, and returns their form in the ABI.
    pub fn bytes(&mut self, bytes: Vec<u8>) -> Lent<tatu_str> {
        self.bytes = bytes;
        Lent(tatu_str { ptr: self.bytes.as_ptr().cast(), len: self.bytes.len() as u64 })
    }
}

static OPEN: Mutex<BTreeMap<usize, Arc<Open>>> = Mutex::new(BTreeMap::new());
static NEXT: AtomicUsize = AtomicUsize::new(1);

/// Opens a world and returns its handle.
pub fn add(setup: Setup) -> Result<*mut Handle, Wrong> {
    Ok(keep(Host::open(setup)?))
}

/// Opens a copy of a world and returns its handle.
pub fn fork(world: *mut Handle) -> Result<*mut Handle, Wrong> {
    Ok(keep(find(world)?.host.fork()?))
}

fn keep(host: Host) -> *mut Handle {
    let handle = NEXT.fetch_add(1, Relaxed);
    let open = Arc::new(Open { host, answer: Mutex::default() });
    OPEN.lock().unwrap_or_else(PoisonError::into_inner).insert(handle, open);
    std::ptr::without_provenance_mut(handle)
}

fn find(world: *mut Handle) -> Result<Arc<Open>, Wrong> {
    let all = OPEN.lock().unwrap_or_else(PoisonError::into_inner);
    all.get(&world.addr()).cloned().ok_or_else(stranger)
}

fn stranger() -> Wrong {
    Wrong(TATU_ERR_GONE, "there is no such world: it was never opened, or has been closed".into())
}

/// Closes a world, so its handle becomes invalid. The world ends as soon as no other thread uses it.
pub fn remove(world: *mut Handle) -> Result<(), Wrong> {
    let open = OPEN.lock().unwrap_or_else(PoisonError::into_inner).remove(&world.addr());
    open.map(drop).ok_or_else(stranger)
}

/// Calls `f` with a world, on the thread of the world.
pub fn with<T: Send>(
    world: *mut Handle,
    f: impl FnOnce(&mut Seat, &mut Answer) -> Result<T, Wrong> + Send,
) -> Result<T, Wrong> {
    let open = find(world)?;
    let mut answer = open.answer.lock().unwrap_or_else(PoisonError::into_inner);
    let answer = &mut *answer;
    // Errors of `f` are passed through unchanged, with their status.
    open.host.with(|seat| Ok(f(seat, answer)))?
}
