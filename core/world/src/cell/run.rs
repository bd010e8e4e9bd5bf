//! The scripts, calls, services, log lines and faults of a world.

use std::{
    borrow::Cow,
    cell::{Cell, RefCell},
    collections::BTreeSet,
    path::Path,
    sync::Arc,
};

use tatu_errors::Fault;

use super::{
    calls::Calls, folders::Folders, lines::Lines, outside::Outside, script_kinds::CallbackMask, scripts::Scripts,
    stand_ins::StandIns,
};

/// Scripts, calls of commands, services, log lines and faults.
pub(crate) struct Run {
    pub scripts: RefCell<Scripts>,
    /// The callbacks that any script of the world has defined so far. Scripts are not searched for other callbacks.
    pub callback_mask: CallbackMask,
    pub calls: Calls,
    /// The running stages, outermost first, each with the name of the caller that requested it.
    pub stages: RefCell<Vec<(u32, Cow<'static, str>)>>,
    /// Services, the input log, and the log being replayed.
    pub outside: Outside,
    /// The folders in which scripts open files.
    pub folders: Folders,
    /// Stand-ins for objects that scripts look up, in runs without a scene.
    pub stand_ins: StandIns,
    pub faults: RefCell<Vec<Fault>>,
    /// Indices of the faults that have been reported in the current run, or since the last one started.
    pub reported: RefCell<BTreeSet<usize>>,
    pub lines: Lines,
    /// Total bytes of the stored lines. `u64::MAX` means that the limit was exceeded, and that this has been reported.
    pub line_bytes: Cell<u64>,
    pub pool: Arc<rayon::ThreadPool>,
}

impl Run {
    /// Creates the state of a run. `file` is the scene's file; scripts may read files in its folder.
    pub fn new(file: Option<&Path>, pool: Arc<rayon::ThreadPool>) -> Self {
        Run {
            scripts: RefCell::new(Scripts::default()),
            callback_mask: CallbackMask::default(),
            calls: Calls::new(),
            stages: RefCell::default(),
            outside: Outside::default(),
            folders: Folders::new(file),
            stand_ins: StandIns::default(),
            faults: RefCell::default(),
            reported: RefCell::default(),
            lines: Lines::default(),
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
