//! The worlds that are open. A handle is a number that was never used before: one that is stale is refused, and nothing
//! is read through it.

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

/// What handles point to, in name only.
pub enum Handle {}

/// An open world.
struct Open {
    host: Host,
    /// What the last answer points to.
    answer: Mutex<Answer>,
}

/// Memory of an answer, which lives until the next one.
#[derive(Default)]
pub struct Answer {
    values: Owned,
    bytes: Vec<u8>,
}

/// Pointers into an answer.
pub struct Lent<T>(pub T);

// SAFETY: the pointers are passed from the world's thread to the caller, who alone uses them; what they point to is owned
// by the open world, and does not move.
unsafe impl<T> Send for Lent<T> {}

impl Lent<tatu_str> {
    /// An empty text.
    pub const EMPTY: Self = Lent(tatu_str { ptr: std::ptr::null(), len: 0 });
}

impl Answer {
    /// Keeps a value, and returns it in the ABI's form.
    pub fn value(&mut self, value: &Value) -> Lent<tatu_value> {
        self.values = Owned::default();
        Lent(self.values.raw(value))
    }
    /// Keeps several.
    pub fn values(&mut self, values: &[Value]) -> Lent<Vec<tatu_value>> {
        self.values = Owned::default();
        Lent(values.iter().map(|v| self.values.raw(v)).collect())
    }
    /// Keeps bytes.
    pub fn bytes(&mut self, bytes: Vec<u8>) -> Lent<tatu_str> {
        self.bytes = bytes;
        Lent(tatu_str { ptr: self.bytes.as_ptr().cast(), len: self.bytes.len() as u64 })
    }
}

static OPEN: Mutex<BTreeMap<usize, Arc<Open>>> = Mutex::new(BTreeMap::new());
static NEXT: AtomicUsize = AtomicUsize::new(1);

/// Opens a world.
pub fn add(setup: Setup) -> Result<*mut Handle, Wrong> {
    Ok(keep(Host::open(setup)?))
}

/// Opens a copy of a world.
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

/// Ends a world, once no other thread uses it.
pub fn remove(world: *mut Handle) -> Result<(), Wrong> {
    let open = OPEN.lock().unwrap_or_else(PoisonError::into_inner).remove(&world.addr());
    open.map(drop).ok_or_else(stranger)
}

/// Does something with a world, on its thread.
pub fn with<T: Send>(
    world: *mut Handle,
    f: impl FnOnce(&mut Seat, &mut Answer) -> Result<T, Wrong> + Send,
) -> Result<T, Wrong> {
    let open = find(world)?;
    let mut answer = open.answer.lock().unwrap_or_else(PoisonError::into_inner);
    let answer = &mut *answer;
    // What goes wrong within is passed through as it is, with its status.
    open.host.with(|seat| Ok(f(seat, answer)))?
}
