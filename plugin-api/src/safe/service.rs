//! Services: what lives beside worlds, with threads of its own.

use std::{ffi::c_void, ops::Deref};

use super::value::Room;
use super::{
    Fail, Host, Param, Params, Plugin, Result, Value, ValueRef, World, fail::bytes_of, fail::text_raw, guard,
    offer::Keep, plugin::Started,
};
use crate::abi::*;

/// A service. One value per session; dropping it ends it, threads included.
///
/// Only `barrier`, `event` and `resume` reach a world, each in the thread of its session. Threads of the service put
/// down what came in, call [`Session::wake`], and do nothing else with the host but write to its log.
pub trait Service: Sized + 'static {
    /// The plugin that offers it.
    type Plugin: Plugin;
    /// What scenes and command lines write.
    const ID: &'static str;
    /// One sentence.
    const TEXT: &'static str;

    /// Names of the events that [`event`](Self::event) is told; `*`: all but "collision", "separation" and "contact",
    /// which cost something. Empty: "started", "paused", "resumed", "stopped", "fault".
    const EVENTS: &'static [&'static str] = &[];

    /// Its parameters.
    fn params() -> Vec<Param>;
    /// Starts it. Dropping the value must join its threads.
    fn start(plugin: &Self::Plugin, host: &Host, session: Session, params: &Params<'_>) -> Result<Self>;
    /// Its turn before a step, and while a world is stopped or paused: executes what came in, never blocks. After an
    /// error or a panic the service is switched off.
    fn barrier(&self, turn: &Turn<'_>, step: u64) -> Result<Answer>;
    /// Something happened: one of [`EVENTS`](Self::EVENTS).
    fn event(&self, turn: &Turn<'_>, name: &str, payload: ValueRef<'_>) {
        let _ = (turn, name, payload);
    }
    /// Calls a function of a client that it gave as an argument, by [`Turn::function`]. It may wait for the client, asking
    /// [`World::is_interrupted`] every 50 ms; commands that the client calls meanwhile cannot wait. What it gives.
    fn call_func(&self, turn: &Turn<'_>, local: u32, args: &[ValueRef<'_>]) -> Result<Vec<Value>> {
        let _ = (turn, local, args);
        Err(Fail::unsupported("this service gives no functions of clients"))
    }
    /// Version of what [`Service::save`] writes; count it when that changes.
    const STATE_VERSION: u32 = 0;
    /// What of it belongs to a world, for a snapshot. Most services have no such thing: clients are not in a snapshot.
    fn save(&self) -> Result<Vec<u8>> {
        Ok(Vec::new())
    }
    /// Takes back what `save` of `version` wrote.
    fn load(&self, bytes: &[u8], version: u32) -> Result {
        let _ = version;
        if bytes.is_empty() { Ok(()) } else { Err(Fail::unsupported("it reads no state")) }
    }
    /// The last barrier: this world ends. It can be looked at, and not changed; who waits for an answer can still get one.
    fn last(&self, turn: &Turn<'_>) -> Result {
        let _ = turn;
        Ok(())
    }
    /// A command that waited has ended; `token` is the one that [`Turn::call`] was given.
    fn resume(&self, turn: &Turn<'_>, token: u64, result: Result<&[ValueRef<'_>]>) {
        let _ = (turn, token, result);
    }
}

/// What a service wants at the barrier.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Answer {
    /// Time may go on.
    Go,
    /// Time stands until the service has been woken and says go.
    Hold,
}

/// How a call went.
#[derive(Debug, Clone, PartialEq)]
pub enum Called {
    /// Its results.
    Done(Vec<Value>),
    /// It goes on later; [`Service::resume`] will have its token.
    Waits,
}

/// The session, as the threads of a service may use it.
#[derive(Clone, Copy)]
pub struct Session {
    raw: *mut tatu_session,
    host: Host,
}

// SAFETY: from other threads only `wake` is called, which is for any thread.
unsafe impl Send for Session {}
// SAFETY: the session and the world of this turn live through the call.
unsafe impl Sync for Session {}

impl Session {
    /// Wakes a session that waits at its barrier. Until the service has ended.
    pub fn wake(&self) {
        if let Some(wake) = self.host.session.and_then(|s| s.wake) {
            // SAFETY: the session lives as long as the service.
            unsafe { wake(self.raw) };
        }
    }
    /// Writes a line to the host's log: `TATU_LOG_*`.
    pub fn log(&self, level: u32, text: &str) {
        self.host.log(level, text);
    }
}

/// A world while it is a service's turn.
pub struct Turn<'a> {
    world: World<'a>,
    session: Session,
}

impl<'a> Deref for Turn<'a> {
    type Target = World<'a>;
    fn deref(&self) -> &World<'a> {
        &self.world
    }
}

impl Turn<'_> {
    /// For which client the calls that follow are made, by a number of the service's choice: for the input log.
    pub fn client(&self, client: u64) {
        if let Some(f) = self.session.host.session.and_then(|s| s.client) {
            // SAFETY: the world of this turn.
            unsafe { f(self.world.raw(), client) };
        }
    }
    /// A function of a client as an argument for commands: [`Value::Func`]. Who calls it comes to [`Service::call_func`] with
    /// this number.
    pub fn function(&self, local: u32) -> Result<Value> {
        let Some(function) = self.session.host.session.and_then(|s| s.function) else {
            return Err(Fail::unsupported("this host takes no functions of clients"));
        };
        let mut func = 0;
        // SAFETY: the world of this turn; a place for the function.
        match unsafe { function(self.world.raw(), local, &mut func) } {
            TATU_OK => Ok(Value::Func(func)),
            status => Err(Fail::with_code(status, "functions of clients are given in the turn of a service")),
        }
    }
    /// `TATU_STOPPED`, `TATU_RUNNING` or `TATU_PAUSED`.
    pub fn state(&self) -> u32 {
        // SAFETY: the session and the world of this turn live through the call.
        self.session.host.session.and_then(|s| s.state).map_or(TATU_RUNNING, |f| unsafe { f(self.world.raw()) })
    }
    /// The place of this world among those of its session, from 0, and how many these are.
    pub fn worlds(&self) -> (usize, usize) {
        let Some(worlds) = self.session.host.session.and_then(|s| s.worlds) else { return (0, 1) };
        let (mut all, mut n) = (vec![std::ptr::null_mut(); 64], 0_u32);
        loop {
            // SAFETY: as much room as is told; the session lives as long as the service.
            unsafe { worlds(self.session.raw, all.as_mut_ptr(), all.len() as u32, &mut n) };
            if n as usize <= all.len() {
                break;
            }
            all.resize(n as usize, std::ptr::null_mut());
        }
        (all.iter().take(n as usize).position(|w| *w == self.world.raw()).unwrap_or(0), n as usize)
    }
    /// Calls a command by any of its names. `token` 0: it is not to wait; else it may, and comes back by this token.
    pub fn call(&self, name: &str, args: &[Value], token: u64) -> Result<Called> {
        let commands = self.session.host.commands;
        let (Some(find), Some(call), Some(mark), Some(release)) = (
            commands.and_then(|t| t.find),
            commands.and_then(|t| t.call),
            commands.and_then(|t| t.mark),
            commands.and_then(|t| t.release),
        ) else {
            return Err(Fail::unsupported("this host cannot call commands"));
        };
        let world = self.world.raw();
        let mut alias = 0;
        // SAFETY: the world of this turn; the name is valid during the call.
        let command = unsafe { find(world, text_raw(name), &mut alias) };
        if command == 0 {
            return Err(Fail::with_code(TATU_ERR_UNKNOWN, format!("there is no command `{name}`")));
        }
        let mut room = Room::default();
        let args = room.all(args);
        let mut results = [ValueRef::NIL.raw(); 64];
        // SAFETY: an all-zero frame is a valid empty one.
        let mut frame: tatu_call = unsafe { std::mem::zeroed() };
        frame.size = size_of::<tatu_call>() as u32;
        (frame.command, frame.alias, frame.wait_token) = (command, alias, token);
        (frame.args, frame.n_args) = (args.as_ptr(), args.len() as u32);
        (frame.results, frame.results_cap) = (results.as_mut_ptr(), results.len() as u32);
        // SAFETY: the frame and its arrays live through the call; results are copied before the release.
        unsafe {
            let here = mark(world);
            let out = match call(world, &mut frame) {
                TATU_WAIT => Ok(Called::Waits),
                status if status < 0 => Err(Fail::read(status, frame.error)),
                _ => {
                    let results = ValueRef::slice(frame.results, frame.n_results as usize);
                    results.iter().map(|v| v.to_value()).collect::<Result<_>>().map(Called::Done)
                }
            };
            release(world, here);
            out
        }
    }
}

struct Data<S> {
    service: S,
    session: Session,
}

impl<S> Data<S> {
    /// # Safety
    /// `world` is a living world of the session, in whose thread this is called.
    unsafe fn turn(&self, world: *mut tatu_world) -> Turn<'_> {
        // SAFETY: the caller promises it.
        Turn { world: unsafe { World::new(world, &self.session.host) }, session: self.session }
    }
}

pub(crate) fn table<S: Service>(keep: &mut Keep) -> *const tatu_service {
    let params = S::params().iter().map(|p| p.keep(keep)).collect();
    let raw = tatu_service {
        size: size_of::<tatu_service>() as u32,
        flags: 0,
        id: keep.text(S::ID),
        text: keep.text(S::TEXT),
        params: keep.list(params),
        life: keep.table(tatu_life {
            size: size_of::<tatu_life>() as u32,
            state_bytes: 0,
            create: Some(start::<S>),
            destroy: Some(stop::<S>),
            configure: None,
            save: Some(save::<S>),
            load: Some(load::<S>),
            version: S::STATE_VERSION,
            reserved: 0,
        }),
        barrier: Some(barrier::<S>),
        event: Some(event::<S>),
        resume: Some(resume::<S>),
        events: if S::EVENTS.is_empty() { std::ptr::null() } else { keep.texts(S::EVENTS) },
        call_func: Some(call_func::<S>),
        last: Some(last::<S>),
    };
    keep.table(raw)
}

unsafe extern "C" fn start<S: Service>(
    me: *mut c_void,
    info: *const tatu_instance,
    data: *mut *mut c_void,
    error: *mut tatu_error,
) -> tatu_status {
    guard::run(error, || {
        let declared = S::params();
        // SAFETY: `me` was made by `init`; the host gives valid pointers, and one value per declared parameter.
        let (started, info) = unsafe { (&*me.cast::<Started<S::Plugin>>(), &*info) };
        // SAFETY: as many values as the host tells.
        let values = unsafe { ValueRef::slice(info.params, info.n_params as usize) };
        let session = Session { raw: info.session, host: started.host };
        let service = S::start(&started.plugin, &started.host, session, &Params::new(values, &declared))?;
        // SAFETY: the host gives a place for the pointer.
        unsafe { *data = Box::into_raw(Box::new(Data { service, session })).cast() };
        Ok(TATU_OK)
    })
}

unsafe extern "C" fn stop<S: Service>(data: *mut c_void) {
    guard::quiet(|| {
        // SAFETY: made by `start`, given back once.
        drop(unsafe { Box::from_raw(data.cast::<Data<S>>()) });
    });
}

unsafe extern "C" fn save<S: Service>(
    data: *mut c_void,
    writer: *const tatu_writer,
    error: *mut tatu_error,
) -> tatu_status {
    // SAFETY: made by `start`; the host gives a valid writer.
    guard::run(error, || unsafe { guard::write(writer, &(*data.cast::<Data<S>>()).service.save()?) })
}

unsafe extern "C" fn load<S: Service>(
    data: *mut c_void,
    bytes: tatu_str,
    version: u32,
    error: *mut tatu_error,
) -> tatu_status {
    guard::run(error, || {
        // SAFETY: made by `start`; the bytes are valid during the call.
        unsafe { (*data.cast::<Data<S>>()).service.load(bytes_of(bytes), version)? };
        Ok(TATU_OK)
    })
}

/// Runs a call that gets a world.
///
/// # Safety
/// `data` was made by `start`; a world of the session, in its thread.
unsafe fn enter<S: Service>(
    data: *mut c_void,
    world: *mut tatu_world,
    error: *mut tatu_error,
    f: impl FnOnce(&S, &Turn<'_>) -> Result<tatu_status>,
) -> tatu_status {
    guard::run(error, || {
        // SAFETY: the caller promises it.
        let (data, turn) = unsafe { (&*data.cast::<Data<S>>(), (*data.cast::<Data<S>>()).turn(world)) };
        f(&data.service, &turn)
    })
}

unsafe extern "C" fn barrier<S: Service>(
    data: *mut c_void,
    world: *mut tatu_world,
    step: u64,
    error: *mut tatu_error,
) -> tatu_status {
    // SAFETY: by the contract.
    unsafe {
        enter(data, world, error, |service: &S, turn| match service.barrier(turn, step)? {
            Answer::Go => Ok(TATU_GO),
            Answer::Hold => Ok(TATU_HOLD),
        })
    }
}

unsafe extern "C" fn event<S: Service>(
    data: *mut c_void,
    world: *mut tatu_world,
    name: tatu_str,
    payload: *const tatu_value,
    error: *mut tatu_error,
) -> tatu_status {
    // SAFETY: by the contract; name and payload are valid during the call.
    unsafe {
        enter(data, world, error, |service: &S, turn| {
            let payload = payload.as_ref().map_or(ValueRef::NIL, |p| ValueRef::new(*p));
            service.event(turn, &String::from_utf8_lossy(bytes_of(name)), payload);
            Ok(TATU_OK)
        })
    }
}

unsafe extern "C" fn resume<S: Service>(
    data: *mut c_void,
    world: *mut tatu_world,
    token: u64,
    status: tatu_status,
    frame: *const tatu_call,
    error: *mut tatu_error,
) -> tatu_status {
    // SAFETY: by the contract; the frame is valid during the call.
    unsafe {
        enter(data, world, error, |service: &S, turn| {
            let result = if status < 0 {
                Err(Fail::read(status, (*frame).error))
            } else {
                Ok(ValueRef::slice((*frame).results, (*frame).n_results as usize))
            };
            service.resume(turn, token, result);
            Ok(TATU_OK)
        })
    }
}

unsafe extern "C" fn last<S: Service>(
    data: *mut c_void,
    world: *mut tatu_world,
    error: *mut tatu_error,
) -> tatu_status {
    // SAFETY: by the contract.
    unsafe { enter(data, world, error, |service: &S, turn| service.last(turn).map(|()| TATU_OK)) }
}

unsafe extern "C" fn call_func<S: Service>(
    data: *mut c_void,
    world: *mut tatu_world,
    local: u32,
    frame: *mut tatu_call,
) -> tatu_status {
    // SAFETY: the session and the world of this turn live through the call, and so does the frame, with its error object.
    unsafe {
        guard::run((*frame).error, || {
            let data = &*data.cast::<Data<S>>();
            let turn = data.turn(world);
            let args = ValueRef::slice((*frame).args, (*frame).n_args as usize);
            let results = data.service.call_func(&turn, local, args)?;
            let alloc = data.session.host.commands.and_then(|t| t.alloc);
            let mut alloc = |n: usize| alloc.map_or(std::ptr::null_mut(), |f| f(world, n as u64).cast());
            for value in results.iter().take((*frame).results_cap as usize) {
                let raw = value.to_raw(&mut alloc);
                let raw = raw.ok_or_else(|| Fail::with_code(TATU_ERR_SPACE, "the results do not fit into memory"))?;
                *(*frame).results.add((*frame).n_results as usize) = raw;
                (*frame).n_results += 1;
            }
            Ok(TATU_OK)
        })
    }
}
