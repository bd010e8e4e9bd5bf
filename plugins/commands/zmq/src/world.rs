//! The plugin, and the contexts, sockets and messages of a world.

use std::{
    cell::{RefCell, RefMut},
    collections::{BTreeMap, BTreeSet},
};

use serde::{Deserialize, Serialize};
use tatu_plugin_api::{
    abi::TATU_ERR_BUSY,
    safe::{Call, Fail, Prop, Result},
};

use crate::{
    errors::Errno,
    links::{Limits, Socket},
    operation::Operation,
};

/// The plugin, with the property that contains the permissions of a run.
pub struct Zmq {
    pub allow: Prop,
}

pub type Ctx<'a> = Call<'a, Zmq>;

/// Maximum number of open sockets of a world, and of contexts.
const MAX_SOCKETS: usize = 64;
/// Maximum number of messages of a world that scripts have created.
const MAX_MESSAGES: usize = 1000;

/// A message that a script has created.
#[derive(Default, Clone, Serialize, Deserialize)]
pub struct ScriptMessage {
    pub data: Vec<u8>,
    /// Whether further parts follow.
    pub more: bool,
}

/// The part of the state that is saved in a snapshot. Sockets cannot be saved: in a restored world, they are closed,
/// and their handles are not reused.
#[derive(Default, Serialize, Deserialize)]
pub struct SavedState {
    last: u64,
    pub errno: i64,
    /// The scripts in which failed calls raise errors.
    pub raising: BTreeSet<u64>,
    contexts: BTreeSet<String>,
    singleton: Option<String>,
    pub messages: BTreeMap<String, ScriptMessage>,
}

/// The open sockets of a world, its calls that wait, and the state that is saved in snapshots.
#[derive(Default)]
pub struct WorldState {
    pub saved: SavedState,
    pub sockets: BTreeMap<String, (String, Socket)>,
    /// Closed sockets that are still sending queued messages, each with its context.
    closing: Vec<(String, Socket)>,
    /// Calls that wait for the next step, by the number with which they resume.
    pub waits: BTreeMap<u64, Operation>,
    limits: Limits,
}

impl WorldState {
    /// Returns a number that has not been used in this world.
    pub fn next_number(&mut self) -> u64 {
        self.saved.last += 1;
        self.saved.last
    }
    /// Creates a context and returns its handle. Fails if there are too many contexts.
    pub fn new_context(&mut self) -> Result<String, Errno> {
        if self.saved.contexts.len() >= MAX_SOCKETS {
            return Err(Errno::TOO_MANY);
        }
        let handle = format!("context:{}", self.next_number());
        self.saved.contexts.insert(handle.clone());
        Ok(handle)
    }
    /// Returns the handle of the context that all scripts share, and creates this context if necessary.
    pub fn singleton(&mut self) -> Result<String, Errno> {
        if let Some(handle) = self.saved.singleton.clone().filter(|h| self.saved.contexts.contains(h)) {
            return Ok(handle);
        }
        let handle = self.new_context()?;
        self.saved.singleton = Some(handle.clone());
        Ok(handle)
    }
    pub fn check_context(&self, handle: &str) -> Result<(), Errno> {
        if self.saved.contexts.contains(handle) { Ok(()) } else { Err(Errno::FAULT) }
    }
    /// Ends a context: closes its sockets, and waits until their messages have been sent.
    pub fn end_context(&mut self, handle: &str) -> Result<(), Errno> {
        if !self.saved.contexts.remove(handle) {
            return Err(Errno::FAULT);
        }
        self.shut_down(handle);
        self.closing.retain(|(context, _)| context != handle);
        Ok(())
    }
    /// Closes the sockets of a context.
    pub fn shut_down(&mut self, handle: &str) {
        let sockets = self.sockets.extract_if(.., |_, (context, _)| context == handle).map(|(_, socket)| socket);
        let mut sockets = sockets.collect::<Vec<_>>();
        sockets.iter_mut().for_each(|(_, socket)| socket.close());
        self.closing.append(&mut sockets);
    }
    /// Creates a socket and returns its handle.
    pub fn new_socket(&mut self, context: &str, kind: i64) -> Result<String, Errno> {
        self.check_context(context)?;
        let kind = crate::kinds::Kind::of(kind).ok_or(Errno::INVALID)?;
        self.closing.retain(|(_, socket)| !socket.is_over());
        if self.sockets.len() + self.closing.len() >= MAX_SOCKETS {
            return Err(Errno::TOO_MANY);
        }
        let handle = format!("socket:{}", self.next_number());
        self.sockets.insert(handle.clone(), (context.to_owned(), Socket::new(kind, &self.limits)));
        Ok(handle)
    }
    pub fn socket(&mut self, handle: &str) -> Result<&mut Socket, Errno> {
        self.sockets.get_mut(handle).map(|(_, socket)| socket).ok_or(Errno::NOT_SOCKET)
    }
    pub fn close_socket(&mut self, handle: &str) -> Result<(), Errno> {
        let (context, mut socket) = self.sockets.remove(handle).ok_or(Errno::NOT_SOCKET)?;
        socket.close();
        self.closing.push((context, socket));
        self.closing.retain(|(_, socket)| !socket.is_over());
        Ok(())
    }
    /// Creates a message and returns its handle.
    pub fn new_message(&mut self) -> Result<String, Errno> {
        if self.saved.messages.len() >= MAX_MESSAGES {
            return Err(Errno::TOO_MANY);
        }
        let handle = format!("message:{}", self.next_number());
        self.saved.messages.insert(handle.clone(), ScriptMessage::default());
        Ok(handle)
    }
    pub fn message(&mut self, handle: &str) -> Result<&mut ScriptMessage, Errno> {
        self.saved.messages.get_mut(handle).ok_or(Errno::FAULT)
    }
}

/// The state of a world. Commands borrow it while they are called.
#[derive(Default)]
pub struct Shared(RefCell<WorldState>);

impl Shared {
    pub fn borrow(&self) -> Result<RefMut<'_, WorldState>> {
        self.0.try_borrow_mut().map_err(|_| Fail::with_code(TATU_ERR_BUSY, "another command is using the sockets"))
    }
}

/// Borrows the state of the world.
pub fn state<'a>(c: &Ctx<'a>) -> Result<RefMut<'a, WorldState>> {
    c.instance().borrow()
}

/// Returns the permissions of the run, separated by commas.
pub fn allowed(c: &Ctx<'_>) -> Result<String> {
    Ok(c.world().get(0, c.plugin().allow)?.as_str().unwrap_or_default().into_owned())
}

/// Stores the error of a failed call. Raises it if the script has requested this.
pub fn fail(c: &Ctx<'_>, errno: Errno) -> Result {
    let mut world = state(c)?;
    world.saved.errno = errno.0;
    if world.saved.raising.contains(&c.caller_script()) { Err(Fail::new(errno.text())) } else { Ok(()) }
}

/// Returns 0 to the script, or -1 after a failure.
pub fn status(c: &mut Ctx<'_>, done: Result<(), Errno>) -> Result {
    if let Err(errno) = done {
        fail(c, errno)?;
    }
    c.ret(if done.is_ok() { 0_i64 } else { -1 });
    Ok(())
}
