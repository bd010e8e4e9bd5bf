//! The worlds that each thread has opened. Handles are integers that are never reused, so a stale handle, or a handle
//! of another thread, is rejected; they are never dereferenced.

use std::{
    cell::{Cell, RefCell},
    collections::BTreeMap,
    mem::ManuallyDrop,
    rc::Rc,
    sync::{
        Arc,
        atomic::{AtomicUsize, Ordering::Relaxed},
    },
};

use tatu_core::{World, plugins::Registry};
use tatu_plugin_api::{
    abi::*,
    safe::{Owned, Value},
};

use crate::{
    answer::CallError,
    open::{self, TestSetup},
    report,
};

/// An open world, and the memory that its last answer lends to the test.
pub struct OpenWorld {
    pub world: World,
    registry: Arc<Registry>,
    /// Memory to which the last answer points.
    values: RefCell<Owned>,
    text: RefCell<String>,
    /// Number of occurrences of each fault that have been reported to the test.
    reported: RefCell<Vec<u64>>,
    /// Whether a call by the test is running in the world.
    busy: Cell<bool>,
}

thread_local! {
    /// The open worlds of this thread, by handle. They are not dropped when the thread exits, because a world cannot be
    /// ended properly at that point.
    static OPEN_WORLDS: ManuallyDrop<RefCell<BTreeMap<usize, Rc<OpenWorld>>>> = const { ManuallyDrop::new(RefCell::new(BTreeMap::new())) };
}
static NEXT_HANDLE: AtomicUsize = AtomicUsize::new(1);

/// Opens a world and returns its handle.
pub fn add(setup: &TestSetup<'_>) -> Result<*mut tatu_test_world, CallError> {
    let (world, registry) = open::open(setup)?;
    let handle = NEXT_HANDLE.fetch_add(1, Relaxed);
    let open = OpenWorld {
        world,
        registry,
        values: RefCell::default(),
        text: RefCell::default(),
        reported: RefCell::default(),
        busy: Cell::new(false),
    };
    OPEN_WORLDS.with(|all| all.borrow_mut().insert(handle, Rc::new(open)));
    Ok(std::ptr::without_provenance_mut(handle))
}

/// Calls `f` with the world of a handle. Fails if a call by the test is already running in the world.
pub fn with<T>(
    handle: *mut tatu_test_world,
    f: impl FnOnce(&OpenWorld) -> Result<T, CallError>,
) -> Result<T, CallError> {
    let open = OPEN_WORLDS.with(|all| all.borrow().get(&handle.addr()).cloned()).ok_or_else(unknown_world)?;
    if open.busy.replace(true) {
        return Err(CallError(
            TATU_ERR_BUSY,
            "the world is busy with another call from the test, or an earlier call panicked".into(),
        ));
    }
    let done = f(&open);
    open.busy.set(false);
    done
}

fn unknown_world() -> CallError {
    let text = "there is no such world: it was never opened, has been closed, or belongs to another thread";
    CallError(TATU_ERR_GONE, text.into())
}

/// Stops and ends a world. Fails with the faults that have not been reported to the test yet, and with the errors that
/// occur when the plugins end.
pub fn remove(handle: *mut tatu_test_world) -> Result<(), CallError> {
    let open = OPEN_WORLDS.with(|all| all.borrow_mut().remove(&handle.addr())).ok_or_else(unknown_world)?;
    open.world.stop();
    open.world.end();
    let mut wrong: Vec<String> = open.new_faults();
    if let Some(open) = Rc::into_inner(open) {
        wrong.extend(open::close(open.world, open.registry));
    }
    if wrong.is_empty() { Ok(()) } else { Err(CallError(TATU_ERR, wrong.join("\n"))) }
}

impl OpenWorld {
    /// Converts a value to its ABI form, which is valid until the next answer.
    pub fn lend(&self, value: &Value) -> tatu_value {
        let mut room = Owned::default();
        let raw = room.raw(value);
        *self.values.borrow_mut() = room;
        raw
    }
    /// Converts several values to their ABI form, which is valid until the next answer.
    pub fn lend_all(&self, values: &[Value]) -> Vec<tatu_value> {
        let mut room = Owned::default();
        let raw = values.iter().map(|v| room.raw(v)).collect();
        *self.values.borrow_mut() = room;
        raw
    }
    /// Stores a string and returns its ABI form, which is valid until the next string is stored.
    pub fn lend_text(&self, text: String) -> tatu_str {
        let mut kept = self.text.borrow_mut();
        *kept = text;
        tatu_str { ptr: kept.as_ptr().cast(), len: kept.len() as u64 }
    }
    /// Returns the faults that have not been reported yet, or have occurred again since.
    pub fn new_faults(&self) -> Vec<String> {
        let mut told = self.reported.borrow_mut();
        let all = self.world.faults();
        told.resize(all.len(), 0);
        let new = all.iter().zip(told.iter_mut()).filter(|(fault, told)| fault.count > **told);
        new.map(|(fault, told)| report::fault_line(fault, fault.count - std::mem::replace(told, fault.count))).collect()
    }
}
