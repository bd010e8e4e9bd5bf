//! Kinds of scripts, and the callbacks that the host knows by name.

use std::cell::Cell;
use tatu_plugin_api::abi::*;

/// Whose a script is, and how long its state lives.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Kind {
    /// Runs the stages of a pass itself; from start to stop.
    Main,
    /// From start to stop.
    Child,
    /// As long as the world.
    Customization,
    /// Of nothing in the scene; as long as the world.
    Addon,
    /// The same, called after all others.
    Sandbox,
}

impl Kind {
    /// By its name in documents and in the ABI.
    pub fn parse(name: &str) -> Option<Self> {
        use Kind::*;
        let at = tatu_scene::document::SCRIPT_KINDS.iter().chain(OUTSIDE_KINDS).position(|k| *k == name)?;
        // What runs as a thread is a child script in all else; its language gets the word.
        Some([Child, Customization, Main, Child, Addon, Sandbox][at])
    }
    /// Whether its state lives from start to stop only.
    pub fn of_run(self) -> bool {
        matches!(self, Kind::Main | Kind::Child)
    }
}

/// Kinds that come from outside a document: see [`World::attach`](crate::run::World::attach).
pub const OUTSIDE_KINDS: &[&str] = &["addon", "sandbox"];

macro_rules! callbacks {
    ($($name:ident $text:literal, $when:literal;)*) => {
        /// A callback of the life cycle.
        #[derive(Debug, Clone, Copy, PartialEq, Eq)]
        pub(crate) enum Callback { $(#[doc = $when] $name),* }

        /// Their names in the ABI, in the order of [`Callback`]; `init` comes before any other is looked for.
        pub(crate) const CALLBACKS: &[&str] = &[$($text),*];
    };
}

callbacks! {
    Actuation "actuation", "In each pass, before physics.";
    Sensing "sensing", "In each pass, after sensors measured.";
    Cleanup "cleanup", "Before its state ends.";
    Thread "thread", "Once after `init`, as a coroutine.";
    NonSimulation "nonSimulation", "In each pass of a stopped world.";
    BeforeSimulation "beforeSimulation", "Once, before the start is prepared.";
    AfterSimulation "afterSimulation", "Once, when the scene is back where it was.";
    Suspend "suspend", "Once, when time begins to stand.";
    Suspended "suspended", "In each pass while time stands.";
    Resume "resume", "Once, before time goes on.";
    Run "run", "Of scripts from outside: at the end of each pass, whatever the world does.";
    BeforeStep "beforeStep", "In each pass, before its stages.";
    Dyn "dyn", "Before and after each physics step.";
    Joint "joint", "In each physics step, for joints whose control is a callback.";
    Contact "contact", "After the physics step in which two shapes began to touch.";
    Measured "measured", "After the sensor that it belongs to has measured in the sensing stage.";
}

/// Which callbacks any script of a world has had, and what else there has been: a first look, before one at all
/// scripts.
#[derive(Default)]
pub(crate) struct CallbackMask(Cell<u32>);

impl CallbackMask {
    const DRIVER: u32 = 1 << 31;
    const LATE: u32 = 1 << 30;

    /// A script has these callbacks.
    pub(crate) fn note(&self, numbers: &CallbackIds) {
        let bits = numbers.iter().enumerate().filter(|(_, n)| **n != 0).map(|(i, _)| 1 << i);
        self.0.set(bits.fold(self.0.get(), |all, bit| all | bit));
    }
    /// A script of this kind was added; `late`: while the world ran.
    pub(crate) fn note_kind(&self, kind: Kind, late: bool) {
        let bits = if kind == Kind::Main { Self::DRIVER } else { 0 } | if late { Self::LATE } else { 0 };
        self.0.set(self.0.get() | bits);
    }
    pub(crate) fn has(&self, callback: Callback) -> bool {
        self.0.get() & 1 << callback as u32 != 0
    }
    pub(crate) fn any_driver(&self) -> bool {
        self.0.get() & Self::DRIVER != 0
    }
    pub(crate) fn any_late(&self) -> bool {
        self.0.get() & Self::LATE != 0
    }
}

const _: () = assert!(CALLBACKS.len() <= 30);

/// The language's numbers for a script's callbacks, by [`Callback`]; 0: it has none.
pub(crate) type CallbackIds = [u32; CALLBACKS.len()];

/// The order in which scripts are called: see `script_order`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(crate) enum Order {
    /// Down the trees.
    ParentsFirst,
    /// Up each tree, by kind.
    ByKind,
    /// Deepest first over the whole scene.
    #[default]
    DeepestFirst,
}

impl Order {
    /// By its number in the ABI.
    pub fn of(number: u32) -> Option<Self> {
        match number {
            TATU_ORDER_PARENTS_FIRST => Some(Order::ParentsFirst),
            TATU_ORDER_BY_KIND => Some(Order::ByKind),
            TATU_ORDER_DEEPEST_FIRST => Some(Order::DeepestFirst),
            _ => None,
        }
    }
}
