//! The scripts, calls, services, log lines and faults of a world.

use std::{
    borrow::Cow,
    cell::{Cell, RefCell},
    collections::BTreeSet,
    path::Path,
    sync::Arc,
};

use tatu_errors::Fault;

use crate::cell::{
    calls::stack::CallStack, records::lines::LogBuffer, scripts::folders::ScriptFolders, scripts::kinds::CallbackMask,
    scripts::list::Scripts, scripts::stand_ins::StandIns, session::connections::Connections,
};

/// Scripts, calls of commands, services, log lines and faults.
pub(crate) struct WorldRuntime {
    pub scripts: RefCell<Scripts>,
    /// The callbacks that any script of the world has defined so far. Scripts are not searched for other callbacks.
    pub callback_mask: CallbackMask,
    pub calls: CallStack,
    /// The running stages, outermost first, each with the name of the caller that requested it.
    pub stages: RefCell<Vec<(u32, Cow<'static, str>)>>,
    /// Services, the input log, and the log being replayed.
    pub connections: Connections,
    /// The folders in which scripts open files.
    pub folders: ScriptFolders,
    /// Stand-ins for objects that scripts look up, in runs without a scene.
    pub stand_ins: StandIns,
    pub faults: RefCell<Vec<Fault>>,
    /// Indices of the faults that have been reported in the current run, or since the last one started.
    pub reported: RefCell<BTreeSet<usize>>,
    pub lines: LogBuffer,
    /// Total bytes of the stored lines. `u64::MAX` means that the limit was exceeded, and that this has been reported.
    pub line_bytes: Cell<u64>,
    pub pool: Arc<rayon::ThreadPool>,
}

impl WorldRuntime {
    /// Creates the state of a run. `file` is the scene's file; scripts may read files in its folder.
    pub fn new(file: Option<&Path>, pool: Arc<rayon::ThreadPool>) -> Self {
        WorldRuntime {
            scripts: RefCell::new(Scripts::default()),
            callback_mask: CallbackMask::default(),
            calls: CallStack::new(),
            stages: RefCell::default(),
            connections: Connections::default(),
            folders: ScriptFolders::new(file),
            stand_ins: StandIns::default(),
            faults: RefCell::default(),
            reported: RefCell::default(),
            lines: LogBuffer::default(),
            line_bytes: Cell::default(),
            pool,
        }
    }
    /// Runs `f` in the world's thread pool.
    pub fn install<T: Send>(&self, f: impl FnOnce() -> T + Send) -> T {
        self.pool.install(f)
    }
    /// Returns the world's thread pool.
    pub fn pool(&self) -> &rayon::ThreadPool {
        &self.pool
    }
}
