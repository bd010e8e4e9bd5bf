//! A script: an instance of the language, with the process that runs it.

use std::{
    cell::{Cell, RefCell},
    path::PathBuf,
};

use tatu_plugin_api::{abi::*, safe::*};

use crate::{
    host::CommandService,
    message::{self, to},
    process::{Child, Settings},
};

/// The permission that scripts need.
pub(crate) const PERMISSION: &str = "python";

/// A script.
pub(crate) struct PythonScript {
    world: *mut tatu_world,
    host: Host,
    pub instance: Instance,
    pub settings: Settings,
    pub commands: CommandService,
    /// The process, from `load` until the script ends or fails beyond repair.
    pub child: RefCell<Option<Child>>,
    /// Why there is no process any more; empty while there is one.
    pub lost: RefCell<String>,
    pub source: RefCell<Source>,
    pub numbers: Numbers,
    /// Whether the process waits for the result of a command, and can therefore answer other questions.
    pub serves: Cell<bool>,
    /// Number of commands that the script has called.
    pub calls: Cell<u64>,
}

/// The script's source.
#[derive(Default)]
pub(crate) struct Source {
    pub text: Vec<u8>,
    /// Callbacks and functions that the host has looked up; their numbers are their positions, from 1.
    pub callables: Vec<(u32, Box<[u8]>)>,
    /// Whether the callback `cleanup` has been called.
    pub is_cleaned_up: bool,
    /// Orders in which scripts are called, each after the version since which it applies.
    pub orders: Vec<(String, String)>,
}

/// The last numbers that were assigned, and counts.
#[derive(Default)]
pub(crate) struct Numbers {
    pub token: Cell<u64>,
    /// Number of commands that wait, and whose callers the process has not reported as waiting.
    pub waits: Cell<u32>,
    pub kept: Cell<u32>,
    /// The generation of the host's commands that the process knows.
    pub generation: Cell<u64>,
}

/// First number of a kept function; lower numbers belong to functions that are valid during a call.
pub(crate) const FIRST_KEPT: u32 = 1 << 31;

// SAFETY: the world's pointer is only passed to functions of the host, which check the calling thread; everything else
// belongs to this script alone.
unsafe impl Send for PythonScript {}

impl PythonScript {
    pub fn new(world: &World<'_>, instance: Instance) -> Result<Self> {
        let host = world.host();
        let commands = CommandService::of(host).ok_or_else(|| {
            Fail::unsupported("this host does not provide the command service, so scripts cannot run")
        })?;
        Ok(PythonScript {
            world: world.raw().ptr(),
            host: *host,
            instance,
            settings: Settings::default(),
            commands,
            child: RefCell::default(),
            lost: RefCell::default(),
            source: RefCell::default(),
            numbers: Numbers::default(),
            serves: Cell::new(false),
            calls: Cell::new(0),
        })
    }

    /// Returns the world to which the script belongs.
    pub fn world(&self) -> World<'_> {
        // SAFETY: the world outlives its scripts, and the host calls a script only on the thread that may use the
        // world; all callers run inside such a call.
        unsafe { World::new(self.world, &self.host) }
    }
    pub fn world_ref(&self) -> WorldRef<'_> {
        self.world().raw()
    }

    /// Returns a text property of an object; empty if there is none.
    pub fn property(&self, object: tatu_object, key: &str) -> String {
        let value = self.world().get(object, self.host.prop(key));
        value.ok().and_then(|v| v.as_str().map(std::borrow::Cow::into_owned)).unwrap_or_default()
    }

    /// Returns the folder of the scene's file, if there is one.
    pub fn scene_folder(&self) -> Option<PathBuf> {
        let file = self.property(0, "scene.file");
        let folder = PathBuf::from(file).parent().map(PathBuf::from)?;
        std::path::absolute(if folder.as_os_str().is_empty() { ".".into() } else { folder }).ok()
    }

    /// Retains a function under a permanent number. The process learns of it before its call returns.
    pub fn keep(&self, local: u32) -> u32 {
        let number = self.numbers.kept.get() + 1;
        if number >= FIRST_KEPT || !self.tell(to::KEEP, &[local, FIRST_KEPT | number]) {
            return 0;
        }
        self.numbers.kept.set(number);
        FIRST_KEPT | number
    }

    pub fn drop_kept(&self, local: u32) {
        if local >= FIRST_KEPT {
            self.tell(to::DROP, &[local]);
        }
    }

    /// Adds a message that needs no answer, and is sent with the next one. Returns whether there is a process.
    pub fn tell(&self, kind: u8, numbers: &[u32]) -> bool {
        let Ok(mut child) = self.child.try_borrow_mut() else { return false };
        let Some(child) = child.as_mut() else { return false };
        let mut out = message::begin(kind);
        numbers.iter().for_each(|n| out.extend(n.to_le_bytes()));
        message::complete(&mut out);
        child.channel.queue(&out);
        true
    }
}
