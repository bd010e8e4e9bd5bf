//! The table of open worlds. Handles are integers that are never reused, so a stale handle is rejected; they are never
//! dereferenced.

use std::{
    collections::BTreeMap,
    sync::{
        Arc, Mutex, PoisonError,
        atomic::{AtomicUsize, Ordering::Relaxed},
    },
};

use tatu_embed::{WorldHost, WorldSetup, WorldSlot};
use tatu_plugin_api::{
    abi::{TATU_ERR_GONE, tatu_str, tatu_value},
    safe::{Owned, Value},
};

use crate::answer::CallError;

/// The type to which handles nominally point. No value of this type exists, since handles are integers.
pub enum OpaqueWorld {}

/// An open world, and the memory that its last answer lends to the caller.
struct OpenWorld {
    host: WorldHost,
    /// Memory to which the last answer points.
    answer: Mutex<AnswerMemory>,
}

/// Memory that an answer lends to the caller until the next answer of the same kind replaces it.
#[derive(Default)]
pub struct AnswerMemory {
    values: Owned,
    bytes: Vec<u8>,
}

/// Pointers into the memory of an [`AnswerMemory`], on their way to the caller.
pub struct LentPointer<T>(pub T);

// SAFETY: the pointers are passed from the world's thread to the caller, who alone uses them; what they point to is
// owned by the open world, and does not move.
unsafe impl<T> Send for LentPointer<T> {}

impl LentPointer<tatu_str> {
    /// An empty string.
    pub const EMPTY: Self = LentPointer(tatu_str { ptr: std::ptr::null(), len: 0 });
}

impl AnswerMemory {
    /// Stores a value, and returns its form in the ABI.
    pub fn value(&mut self, value: &Value) -> LentPointer<tatu_value> {
        self.values = Owned::default();
        LentPointer(self.values.raw(value))
    }
    /// Stores several values, and returns their forms in the ABI.
    pub fn values(&mut self, values: &[Value]) -> LentPointer<Vec<tatu_value>> {
        self.values = Owned::default();
        LentPointer(values.iter().map(|v| self.values.raw(v)).collect())
    }
    /// Stores bytes, and returns their form in the ABI.
    pub fn bytes(&mut self, bytes: Vec<u8>) -> LentPointer<tatu_str> {
        self.bytes = bytes;
        LentPointer(tatu_str { ptr: self.bytes.as_ptr().cast(), len: self.bytes.len() as u64 })
    }
}

static OPEN_WORLDS: Mutex<BTreeMap<usize, Arc<OpenWorld>>> = Mutex::new(BTreeMap::new());
static NEXT_HANDLE: AtomicUsize = AtomicUsize::new(1);

/// Opens a world and returns its handle.
pub fn add(setup: WorldSetup) -> Result<*mut OpaqueWorld, CallError> {
    Ok(insert(WorldHost::open(setup)?))
}

/// Opens a copy of a world and returns its handle.
pub fn fork(world: *mut OpaqueWorld) -> Result<*mut OpaqueWorld, CallError> {
    Ok(insert(find(world)?.host.fork()?))
}

fn insert(host: WorldHost) -> *mut OpaqueWorld {
    let handle = NEXT_HANDLE.fetch_add(1, Relaxed);
    let open = Arc::new(OpenWorld { host, answer: Mutex::default() });
    OPEN_WORLDS.lock().unwrap_or_else(PoisonError::into_inner).insert(handle, open);
    std::ptr::without_provenance_mut(handle)
}

fn find(world: *mut OpaqueWorld) -> Result<Arc<OpenWorld>, CallError> {
    let all = OPEN_WORLDS.lock().unwrap_or_else(PoisonError::into_inner);
    all.get(&world.addr()).cloned().ok_or_else(unknown_world)
}

fn unknown_world() -> CallError {
    CallError(TATU_ERR_GONE, "there is no such world: it was never opened, or has been closed".into())
}

/// Closes a world, so its handle becomes invalid. The world ends as soon as no other thread uses it.
pub fn remove(world: *mut OpaqueWorld) -> Result<(), CallError> {
    let open = OPEN_WORLDS.lock().unwrap_or_else(PoisonError::into_inner).remove(&world.addr());
    open.map(drop).ok_or_else(unknown_world)
}

/// Calls `f` with a world, on the thread of the world.
pub fn with_world<T: Send>(
    world: *mut OpaqueWorld,
    f: impl FnOnce(&mut WorldSlot, &mut AnswerMemory) -> Result<T, CallError> + Send,
) -> Result<T, CallError> {
    let open = find(world)?;
    let mut answer = open.answer.lock().unwrap_or_else(PoisonError::into_inner);
    let answer = &mut *answer;
    // Errors of `f` are passed through unchanged, with their status.
    open.host.with(|seat| Ok(f(seat, answer)))?
}
