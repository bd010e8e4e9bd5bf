//! The kinds of scripts, and the callbacks that the host calls by name.

use std::cell::Cell;
use tatu_plugin_api::abi::*;

/// The kind of a script, which determines the lifetime of its state.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum ScriptKind {
    /// Requests the stages of a pass itself; its state exists from start to stop.
    Main,
    /// Its state exists from start to stop.
    Child,
    /// Its state exists as long as the world.
    Customization,
    /// Judges a run, so other scripts, plugins and clients can neither see nor affect it: it begins before all other
    /// scripts, is called after them, and outlives its object. Its state exists from start to stop.
    Referee,
    /// Belongs to no object of the scene; its state exists as long as the world.
    Addon,
    /// Like an add-on, but called after all others.
    Sandbox,
}

impl ScriptKind {
    /// Returns the kind with this name, as used in documents and in the ABI.
    pub fn parse(name: &str) -> Option<Self> {
        use ScriptKind::*;
        let at = tatu_scene::document::SCRIPT_KINDS.iter().chain(OUTSIDE_KINDS).position(|k| *k == name)?;
        // "threaded" is a child script as well; only its language distinguishes them, by the name.
        Some([Child, Customization, Main, Child, Referee, Addon, Sandbox][at])
    }
    /// Returns whether the state of such a script exists only from start to stop.
    pub fn ends_with_run(self) -> bool {
        matches!(self, ScriptKind::Main | ScriptKind::Child | ScriptKind::Referee)
    }
}

/// Kinds of scripts that are not part of a document: see [`World::attach`](crate::run::World::attach).
pub const OUTSIDE_KINDS: &[&str] = &["addon", "sandbox"];

macro_rules! callbacks {
    ($($name:ident $text:literal, $when:literal;)*) => {
        /// A callback of the life cycle.
        #[derive(Debug, Clone, Copy, PartialEq, Eq)]
        pub(crate) enum Callback { $(#[doc = $when] $name),* }

        /// The names of the callbacks in the ABI, in the order of [`Callback`]. `init` is not among them, because it is
        /// called before the others are looked up.
        pub(crate) const CALLBACKS: &[&str] = &[$($text),*];
    };
}

callbacks! {
    Actuation "actuation", "In each pass, before physics.";
    Sensing "sensing", "In each pass, after sensors have been measured.";
    Cleanup "cleanup", "Once, before its state ends.";
    Thread "thread", "Once, after `init`, as a coroutine.";
    NonSimulation "nonSimulation", "In each pass of a stopped world.";
    BeforeSimulation "beforeSimulation", "Once, before the start is prepared.";
    AfterSimulation "afterSimulation", "Once, when the scene has been restored.";
    Suspend "suspend", "Once, when a pause begins.";
    Suspended "suspended", "In each pass of a pause.";
    Resume "resume", "Once, before time continues after a pause.";
    Run "run", "For scripts that are not part of the document: at the end of each pass, whether the world runs or not.";
    BeforeStep "beforeStep", "In each pass, before its stages.";
    Dyn "dyn", "Before and after each physics step.";
    Joint "joint", "In each physics step, for joints whose control is a callback.";
    Contact "contact", "After the physics step in which two shapes begin to touch.";
    Measured "measured", "After the sensor that the script belongs to has been measured in the sensing stage.";
}

/// The callbacks and kinds of all scripts that a world has had. Checking this mask often avoids a search of all
/// scripts.
#[derive(Default)]
pub(crate) struct CallbackMask(Cell<u32>);

impl CallbackMask {
    const HAS_DRIVER: u32 = 1 << 31;
    const HAS_LATE_SCRIPT: u32 = 1 << 30;

    /// Records the callbacks of a script.
    pub(crate) fn note(&self, numbers: &CallbackIds) {
        let bits = numbers.iter().enumerate().filter(|(_, n)| **n != 0).map(|(i, _)| 1 << i);
        self.0.set(bits.fold(self.0.get(), |all, bit| all | bit));
    }
    /// Records the kind of a script that was added; `late` is set if the world was running.
    pub(crate) fn note_kind(&self, kind: ScriptKind, late: bool) {
        let bits =
            if kind == ScriptKind::Main { Self::HAS_DRIVER } else { 0 } | if late { Self::HAS_LATE_SCRIPT } else { 0 };
        self.0.set(self.0.get() | bits);
    }
    pub(crate) fn has(&self, callback: Callback) -> bool {
        self.0.get() & 1 << callback as u32 != 0
    }
    pub(crate) fn any_driver(&self) -> bool {
        self.0.get() & Self::HAS_DRIVER != 0
    }
    pub(crate) fn any_late(&self) -> bool {
        self.0.get() & Self::HAS_LATE_SCRIPT != 0
    }
}

const _: () = assert!(CALLBACKS.len() <= 30);

/// The language's ids of a script's callbacks, indexed by [`Callback`]; 0 if the script does not define the callback.
pub(crate) type CallbackIds = [u32; CALLBACKS.len()];

/// The order in which scripts are called: see `script_order`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(crate) enum ScriptOrder {
    /// Each tree from its root down, parents first.
    ParentsFirst,
    /// Grouped by kind of script; within a kind, each tree from the leaves up.
    ByKind,
    /// Ordered by depth in the whole scene, deepest first.
    #[default]
    DeepestFirst,
}

impl ScriptOrder {
    /// Returns the order that a value of `TATU_ORDER_*` denotes.
    pub fn of(number: u32) -> Option<Self> {
        match number {
            TATU_ORDER_PARENTS_FIRST => Some(ScriptOrder::ParentsFirst),
            TATU_ORDER_BY_KIND => Some(ScriptOrder::ByKind),
            TATU_ORDER_DEEPEST_FIRST => Some(ScriptOrder::DeepestFirst),
            _ => None,
        }
    }
}
