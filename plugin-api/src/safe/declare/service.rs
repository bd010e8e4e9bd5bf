//! Services: components that run beside worlds, with their own threads.

use std::{
    ffi::c_void,
    mem::MaybeUninit,
    ops::Deref,
    sync::{Arc, Mutex, PoisonError, atomic::AtomicPtr},
};

use crate::abi::*;
use crate::safe::{
    Called, Fail, Host, Param, Params, Plugin, Result, Value, ValueRef, World,
    call::{outgoing, shared_world::service},
    declare::plugin::StartedPlugin,
    entry::{
        life::{self, InstanceInfo, InstanceLife},
        panics,
    },
    value::{
        fail::bytes_of,
        list_cache::cached_list,
        owned::{Room, given},
        table_arena::TableArena,
    },
};

/// A service. There is one value per session; dropping the value ends the service and its threads.
///
/// Only functions with a [`Turn`] can access a world; they are called on the thread of the session. The service's own
/// threads must queue what they receive and call [`Session::wake`]; otherwise they may use only the host's log.
pub trait Service: Sized + 'static {
    /// The plugin that offers this service.
    type Plugin: Plugin;
    /// Id of the service in scene files and on the command line.
    const ID: &'static str;
    /// Description for documentation and lists, one sentence.
    const TEXT: &'static str;

    /// Names of the events that [`event`](Self::event) receives. `*` means all except "collision", "separation" and
    /// "contact", which are expensive. An empty list means "started", "paused", "resumed", "stopped" and "fault".
    const EVENTS: &'static [&'static str] = &[];

    /// Declares the parameters of the service.
    fn params() -> Vec<Param>;
    /// Starts the service. Dropping the value must join its threads.
    fn start(plugin: &Self::Plugin, host: &Host, session: Session, params: &Params<'_>) -> Result<Self>;
    /// Executes queued requests; called before each step, and while a world is stopped or paused. Must not block. If it
    /// fails or panics, the service is switched off.
    fn barrier(&self, turn: &Turn<'_>, step: u64) -> Result<Answer>;
    /// Handles an event, one of [`EVENTS`](Self::EVENTS).
    fn event(&self, turn: &Turn<'_>, name: &str, payload: ValueRef<'_>) {
        let _ = (turn, name, payload);
    }
    /// Calls a function of a client, which was passed as an argument with [`Turn::function`], and returns its results.
    /// It may wait for the client, and must then poll [`World::is_interrupted`] every 50 ms; commands that the client
    /// calls meanwhile cannot wait.
    fn call_func(&self, turn: &Turn<'_>, local: u32, args: &[ValueRef<'_>]) -> Result<Vec<Value>> {
        let _ = (turn, local, args);
        Err(Fail::unsupported("this service does not pass functions of clients"))
    }
    /// Version of the data that [`Service::save`] writes; increase it when the format of the data changes.
    const STATE_VERSION: u32 = 0;
    /// Saves the service's state that concerns one world, for a snapshot. Most services have no such state, because
    /// clients are not part of a snapshot.
    fn save(&self) -> Result<Vec<u8>> {
        Ok(Vec::new())
    }
    /// Restores data that version `version` of `save` wrote.
    fn load(&self, bytes: &[u8], version: u32) -> Result {
        let _ = version;
        if bytes.is_empty() { Ok(()) } else { Err(Fail::unsupported("this service cannot restore a saved state")) }
    }
    /// Called once before a world ends. The world can be read but not changed; clients that wait for a response can
    /// still be sent one.
    fn last(&self, turn: &Turn<'_>) -> Result {
        let _ = turn;
        Ok(())
    }
    /// Receives the result of a command that waited; `token` is the one passed to [`Turn::call`].
    fn resume(&self, turn: &Turn<'_>, token: u64, result: Result<&[ValueRef<'_>]>) {
        let _ = (turn, token, result);
    }
}

/// A service's answer at the barrier.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Answer {
    /// Simulation time may advance.
    Go,
    /// Simulation time does not advance until the service is woken and returns `Go`.
    Hold,
}

/// A session, for use by the threads of a service. After the service has ended, [`wake`](Self::wake) has no effect.
#[derive(Clone)]
pub struct Session {
    /// Null once the service has ended.
    raw: Arc<Mutex<AtomicPtr<tatu_session>>>,
    host: Host,
}

impl Session {
    fn new(raw: *mut tatu_session, host: Host) -> Self {
        Session { raw: Arc::new(Mutex::new(raw.into())), host }
    }
    /// Calls `f` with the session, which cannot end during the call; returns `None` if it has ended.
    fn with<T>(&self, f: impl FnOnce(*mut tatu_session) -> T) -> Option<T> {
        let mut raw = self.raw.lock().unwrap_or_else(PoisonError::into_inner);
        let session = *raw.get_mut();
        (!session.is_null()).then(|| f(session))
    }
    fn end(&self) {
        *self.raw.lock().unwrap_or_else(PoisonError::into_inner) = AtomicPtr::default();
    }
    /// Wakes a session that waits at its barrier.
    pub fn wake(&self) {
        let Some(wake) = self.host.session.and_then(|s| s.wake) else { return };
        // SAFETY: the session outlives the service; `end` clears the pointer under the lock that `with` holds, so
        // `session` is live here.
        self.with(|session| unsafe { wake(session) });
    }
    /// Asks the running script to return, because a client wants to stop the run. A script that does not return within
    /// a second is ended. The stop itself must be requested in a turn of the service.
    pub fn stop(&self) {
        let Some(stop) = self.host.session.and_then(|s| s.stop) else { return };
        // SAFETY: as in `wake`.
        self.with(|session| unsafe { stop(session) });
    }
    /// Writes a line to the host's log; `level` is one of `TATU_LOG_*`.
    pub fn log(&self, level: u32, text: &str) {
        self.host.log(level, text);
    }
}

/// A world to which a service has access while the host calls the service.
pub struct Turn<'a> {
    world: World<'a>,
    session: &'a Session,
}

impl<'a> Deref for Turn<'a> {
    type Target = World<'a>;
    fn deref(&self) -> &World<'a> {
        &self.world
    }
}

impl Turn<'_> {
    /// Sets the client on whose behalf the following calls are made, a number chosen by the service; it is recorded in
    /// the input log.
    pub fn client(&self, client: u64) {
        if let Some(f) = self.host().session.and_then(|s| s.client) {
            f(self.raw(), client);
        }
    }
    /// Returns a function of a client as an argument for commands, a [`Value::Func`]. When it is called, the host calls
    /// [`Service::call_func`] with the number `local`.
    pub fn function(&self, local: u32) -> Result<Value> {
        let mut func = 0;
        match service!(self.session.function)(self.raw(), local, Some(&mut func)) {
            TATU_OK => Ok(Value::Func(func)),
            status => {
                Err(Fail::with_code(status, "functions of clients can be passed only during the service's barrier"))
            }
        }
    }
    /// Returns the state of the world: `TATU_STOPPED`, `TATU_RUNNING` or `TATU_PAUSED`.
    pub fn state(&self) -> u32 {
        self.host().session.and_then(|s| s.state).map_or(TATU_RUNNING, |f| f(self.raw()))
    }
    /// Returns the index of this world in its session, from 0, and the number of worlds.
    pub fn worlds(&self) -> (usize, usize) {
        let Some(worlds) = self.host().session.and_then(|s| s.worlds) else { return (0, 1) };
        let all = self.session.with(|session| {
            let (mut all, mut n) = (vec![std::ptr::null_mut(); 64], 0_u32);
            loop {
                // SAFETY: `all` has room for as many pointers as stated; `with` guarantees that the session has not
                // ended.
                unsafe { worlds(session, all.as_mut_ptr(), all.len() as u32, Some(&mut n)) };
                if n as usize <= all.len() {
                    all.truncate(n as usize);
                    return all;
                }
                all.resize(n as usize, std::ptr::null_mut());
            }
        });
        let all = all.unwrap_or_default();
        (all.iter().position(|w| *w == self.raw().ptr()).unwrap_or(0), all.len().max(1))
    }
    /// Calls a command by any of its names. If `token` is 0, the command must not wait. Otherwise it may wait, and
    /// [`Service::resume`] is called with this token when it has finished.
    pub fn call(&self, name: &str, args: &[Value], token: u64) -> Result<Called> {
        outgoing::call_by_name(&self.world, name, args, token)
    }
}

struct ServiceInstance<S> {
    /// The first field, so that the service is dropped before its session.
    service: S,
    session: SessionGuard,
}

/// Clears a service's session when it is dropped.
struct SessionGuard(Session);

impl Drop for SessionGuard {
    fn drop(&mut self) {
        self.0.end();
    }
}

struct ServiceParams<S>(S);

fn params_of<S: Service>() -> Arc<[Param]> {
    cached_list::<ServiceParams<S>, _>(S::params)
}

impl<S: Service> InstanceLife for ServiceInstance<S> {
    type Plugin = S::Plugin;
    const STATE_VERSION: u32 = S::STATE_VERSION;

    fn create(started: &StartedPlugin<S::Plugin>, info: &InstanceInfo<'_>) -> Result<Self> {
        let session = SessionGuard(Session::new(info.session, started.host));
        let params = params_of::<S>();
        let params = Params::new(info.params, &params);
        let service = S::start(&started.plugin, &started.host, session.0.clone(), &params)?;
        Ok(ServiceInstance { service, session })
    }
    fn save(&self) -> Result<Vec<u8>> {
        self.service.save()
    }
    fn load(&self, bytes: &[u8], version: u32) -> Result {
        self.service.load(bytes, version)
    }
}

pub(crate) fn table<S: Service>(keep: &mut TableArena) -> *const tatu_service {
    let params = params_of::<S>().iter().map(|p| p.to_table(keep)).collect();
    let raw = tatu_service {
        size: size_of::<tatu_service>() as u32,
        flags: 0,
        id: keep.text(S::ID),
        text: keep.text(S::TEXT),
        params: keep.list(params),
        life: keep.table(life::table::<ServiceInstance<S>>(0)),
        barrier: Some(barrier::<S>),
        event: Some(event::<S>),
        resume: Some(resume::<S>),
        events: if S::EVENTS.is_empty() { std::ptr::null() } else { keep.texts(S::EVENTS) },
        call_func: Some(call_func::<S>),
        last: Some(last::<S>),
    };
    keep.table(raw)
}

/// Runs a call by the host that passes a world.
///
/// # Safety
/// `data` must have been created by `start` and be alive; `world` must belong to the session, on the session's thread.
unsafe fn enter<S: Service>(
    data: *mut c_void,
    world: *mut tatu_world,
    error: *mut tatu_error,
    f: impl FnOnce(&S, &Turn<'_>) -> Result<tatu_status>,
) -> tatu_status {
    panics::run(error, || {
        // SAFETY: the caller guarantees that `data` points to a live `ServiceInstance<S>` and that `world` is valid
        // during the call.
        let (ServiceInstance { service, session }, world) = unsafe {
            let data = life::instance_at::<ServiceInstance<S>>(data);
            (data, World::new(world, &data.session.0.host))
        };
        f(service, &Turn { world, session: &session.0 })
    })
}

unsafe extern "C" fn barrier<S: Service>(
    data: *mut c_void,
    world: *mut tatu_world,
    step: u64,
    error: *mut tatu_error,
) -> tatu_status {
    // SAFETY: the host passes the `data` that `start` made, while it is live, and a world of the session, on the
    // session's thread.
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
    // SAFETY: the host passes the `data` that `start` made, while it is live, and a world of the session, on its
    // thread; `name` and `payload` are valid during the call.
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
    // SAFETY: the host passes the `data` that `start` made, while it is live, and a world of the session, on its
    // thread; the frame and its error are valid during the call.
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
    // SAFETY: the host passes the `data` that `start` made, while it is live, and a world of the session, on the
    // session's thread.
    unsafe { enter(data, world, error, |service: &S, turn| service.last(turn).map(|()| TATU_OK)) }
}

unsafe extern "C" fn call_func<S: Service>(
    data: *mut c_void,
    world: *mut tatu_world,
    local: u32,
    frame: *mut tatu_call,
) -> tatu_status {
    // SAFETY: the host passes the `data` that `start` made, while it is live, and a world of the session, on its
    // thread; the frame is complete, with an error object and room for `results_cap` results.
    unsafe {
        enter(data, world, (*frame).error, |service: &S, turn| {
            let args = ValueRef::slice((*frame).args, (*frame).n_args as usize);
            let mut room = WorldRoom(turn);
            for value in service.call_func(turn, local, args)?.iter().take((*frame).results_cap as usize) {
                let raw = value.to_raw(&mut room);
                let raw = raw.ok_or_else(|| Fail::with_code(TATU_ERR_SPACE, "not enough memory for the results"))?;
                *(*frame).results.add((*frame).n_results as usize) = raw;
                (*frame).n_results += 1;
            }
            Ok(TATU_OK)
        })
    }
}

/// Memory in the world's arena, valid until the caller of a function has read its results.
struct WorldRoom<'a>(&'a World<'a>);

impl Room for WorldRoom<'_> {
    fn words(&mut self, n: usize) -> Option<&mut [MaybeUninit<u64>]> {
        let alloc = self.0.host().commands.and_then(|t| t.alloc)?;
        // SAFETY: `alloc` returns null or a pointer to 8-byte aligned memory of this size, which belongs to this call
        // alone and lives until its results have been read.
        unsafe { given(alloc(self.0.raw(), 8 * n as u64).cast(), n) }
    }
}
