//! The activity in a world, and its results.

use std::{
    borrow::Cow,
    cell::{Cell, RefCell},
    path::Path,
    sync::Arc,
};

use tatu_errors::Fault;

use super::{
    calls::Calls, folders::Folders, lines::Lines, outside::Outside, script_kinds::CallbackMask, scripts::Scripts,
    stand_ins::StandIns,
};

/// Scripts, calls of commands, services, lines and faults.
pub(crate) struct Run {
    pub scripts: RefCell<Scripts>,
    /// Which callbacks there have been among its scripts, so that the rest are not searched for.
    pub callback_mask: CallbackMask,
    pub calls: Calls,
    /// The stages that are running, outermost first, and who asked for each.
    pub stages: RefCell<Vec<(u32, Cow<'static, str>)>>,
    /// What comes from outside: services, the log of what they did, what is replayed.
    pub outside: Outside,
    /// Where scripts open files.
    pub folders: Folders,
    /// Stand-ins for what scripts ask for, in runs without a scene.
    pub stand_ins: StandIns,
    pub faults: RefCell<Vec<Fault>>,
    pub lines: Lines,
    /// Bytes of the lines that are kept; all bits: they take too much, which has been reported.
    pub line_bytes: Cell<u64>,
    pub pool: Arc<rayon::ThreadPool>,
}

impl Run {
    /// `file`: that of the scene, whose folder scripts may read.
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
            lines: Lines::default(),
            line_bytes: Cell::default(),
            pool,
        }
    }
    /// Runs `f` with the world's pool of threads.
    pub fn install<T: Send>(&self, f: impl FnOnce() -> T + Send) -> T {
        self.pool.install(f)
    }
    /// The world's threads.
    pub fn pool(&self) -> &rayon::ThreadPool {
        &self.pool
    }
}
