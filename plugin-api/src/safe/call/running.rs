//! A running call to a command: access to its arguments and results, and the functions with which it waits.

use std::ops::{Deref, DerefMut};

use crate::abi::*;
use crate::safe::{
    Called, Fail, Host, PerWorld, Plugin, Result, SharedWorld, Value, ValueRef, World,
    call::{frame::CallFrame, outgoing, shared_world::service},
    declare::plugin::{Call, ExclusiveFn, Outcome, SharedCall, SharedFn, StartedPlugin},
    entry::{
        life::{self, WorldState},
        panics,
    },
    value::{
        fail::{bytes_of, text_raw},
        owned::{Room, raw_int, raw_span, type_name},
    },
};

/// A handle that delivers, once and from any thread, the result for which a command waits.
pub struct Ticket {
    host: Host,
    number: u64,
}

impl Ticket {
    /// Delivers the result, which is copied. The command continues at the next barrier of the world; if the world has
    /// ended, the result is ignored.
    pub fn wake(self, result: &[u8]) -> Result {
        let wake = self.host.commands.and_then(|c| c.wake).ok_or_else(no_tickets)?;
        // SAFETY: the host lives until the plugin's shutdown, and the header permits this call on any thread.
        match unsafe { wake(self.host.raw(), self.number, result.into()) } {
            TATU_OK => Ok(()),
            status => Err(Fail::with_code(
                status,
                "the host rejected the result: the ticket is unknown or has already been used",
            )),
        }
    }
}

#[cold]
fn no_tickets() -> Fail {
    Fail::unsupported("this host does not support commands that wait for a thread")
        .help("update the program that loads this plugin")
}

/// The return type of a command's function: `()`, or an [`Outcome`] if it may wait.
pub trait IntoResult {
    /// Returns the outcome to be reported to the host.
    fn into_outcome(self) -> Outcome;
}
impl IntoResult for () {
    fn into_outcome(self) -> Outcome {
        Outcome::Done
    }
}
impl IntoResult for Outcome {
    fn into_outcome(self) -> Outcome {
        self
    }
}

impl<'a, P: Plugin> Deref for Call<'a, P> {
    type Target = SharedCall<'a, P>;
    fn deref(&self) -> &SharedCall<'a, P> {
        &self.0
    }
}

impl<P: Plugin> DerefMut for Call<'_, P> {
    fn deref_mut(&mut self) -> &mut Self::Target {
        &mut self.0
    }
}

/// Types that a command can return as a result: numbers, booleans, texts, bytes, arrays of numbers, a [`Value`] or
/// [`ValueRef`], and references to these.
pub trait Return {
    /// Converts the result to the form of the ABI, and copies the data that it points to into `room`. Returns `None` if
    /// there is not enough memory or the value is nested too deep.
    fn to_raw(&self, room: &mut dyn Room) -> Option<tatu_value>;
}
impl<T: Return + ?Sized> Return for &T {
    fn to_raw(&self, room: &mut dyn Room) -> Option<tatu_value> {
        (**self).to_raw(room)
    }
}
impl Return for f64 {
    fn to_raw(&self, _: &mut dyn Room) -> Option<tatu_value> {
        Some(tatu_value { tag: TATU_F64, reserved: 0, u: tatu_payload { f: *self } })
    }
}
impl Return for i64 {
    fn to_raw(&self, _: &mut dyn Room) -> Option<tatu_value> {
        Some(raw_int(TATU_I64, *self))
    }
}
impl Return for i32 {
    fn to_raw(&self, _: &mut dyn Room) -> Option<tatu_value> {
        Some(raw_int(TATU_I64, (*self).into()))
    }
}
impl Return for u32 {
    fn to_raw(&self, _: &mut dyn Room) -> Option<tatu_value> {
        Some(raw_int(TATU_I64, (*self).into()))
    }
}
impl Return for bool {
    fn to_raw(&self, _: &mut dyn Room) -> Option<tatu_value> {
        Some(raw_int(TATU_BOOL, i64::from(*self)))
    }
}
impl Return for Value {
    fn to_raw(&self, room: &mut dyn Room) -> Option<tatu_value> {
        Value::to_raw(self, room)
    }
}
impl Return for ValueRef<'_> {
    fn to_raw(&self, room: &mut dyn Room) -> Option<tatu_value> {
        self.to_value().ok()?.to_raw(room)
    }
}
impl Return for [f64] {
    fn to_raw(&self, room: &mut dyn Room) -> Option<tatu_value> {
        raw_span(TATU_F64S, self, room)
    }
}
impl<T, const N: usize> Return for [T; N]
where
    [T]: Return,
{
    fn to_raw(&self, room: &mut dyn Room) -> Option<tatu_value> {
        self.as_slice().to_raw(room)
    }
}
impl<T> Return for Vec<T>
where
    [T]: Return,
{
    fn to_raw(&self, room: &mut dyn Room) -> Option<tatu_value> {
        self.as_slice().to_raw(room)
    }
}
impl Return for [i64] {
    fn to_raw(&self, room: &mut dyn Room) -> Option<tatu_value> {
        raw_span(TATU_I64S, self, room)
    }
}
impl Return for str {
    fn to_raw(&self, room: &mut dyn Room) -> Option<tatu_value> {
        raw_span(TATU_TEXT, self.as_bytes(), room)
    }
}
impl Return for String {
    fn to_raw(&self, room: &mut dyn Room) -> Option<tatu_value> {
        self.as_str().to_raw(room)
    }
}
/// Bytes are returned as text, which need not be valid UTF-8.
impl Return for [u8] {
    fn to_raw(&self, room: &mut dyn Room) -> Option<tatu_value> {
        raw_span(TATU_TEXT, self, room)
    }
}

impl<'a, P: Plugin> SharedCall<'a, P> {
    /// Returns the plugin.
    pub fn plugin(&self) -> &'a P {
        &self.started.plugin
    }
    /// Returns the world, read-only.
    pub fn world(&self) -> SharedWorld<'a> {
        *self.full_world()
    }
    fn full_world(&self) -> World<'a> {
        World::of(self.raw.world, &self.started.host)
    }
    /// Returns the index of the name by which the command was called; 0 is the first one.
    pub fn alias(&self) -> u32 {
        self.raw.alias
    }
    /// Returns the object that the calling script belongs to, or 0 if there is none.
    pub fn caller_object(&self) -> tatu_object {
        self.raw.caller_object
    }
    /// Returns the calling script, or 0 if there is none.
    pub fn caller_script(&self) -> tatu_object {
        self.raw.caller_script
    }
    /// Returns the calling script's dialect, which is empty if there is none.
    pub fn caller_dialect(&self) -> &'a [u8] {
        self.raw.dialect
    }

    /// Returns all arguments.
    pub fn args(&self) -> &'a [ValueRef<'a>] {
        self.raw.args
    }
    /// Returns argument `i`, or nil if it is missing.
    pub fn arg(&self, i: usize) -> ValueRef<'a> {
        self.args().get(i).copied().unwrap_or(ValueRef::NIL)
    }
    /// Returns whether argument `i` was passed and is not nil.
    pub fn has(&self, i: usize) -> bool {
        !self.arg(i).is_nil()
    }
    #[cold]
    fn wrong_argument(&self, i: usize, expected: &str) -> Fail {
        Fail::argument(format!("argument {}: expected {expected}, found {}", i + 1, type_name(self.arg(i).tag())))
    }
    /// Returns argument `i` as a number.
    #[inline]
    pub fn f64(&self, i: usize) -> Result<f64> {
        self.arg(i).as_f64().ok_or_else(|| self.wrong_argument(i, "a number"))
    }
    /// Returns argument `i` as an integer; floats are truncated.
    #[inline]
    pub fn i64(&self, i: usize) -> Result<i64> {
        self.arg(i).as_i64().ok_or_else(|| self.wrong_argument(i, "an integer"))
    }
    /// Returns argument `i`, a text, as bytes.
    #[inline]
    pub fn bytes(&self, i: usize) -> Result<&'a [u8]> {
        self.arg(i).as_bytes().ok_or_else(|| self.wrong_argument(i, "a text"))
    }
    /// Returns argument `i` as text; invalid UTF-8 is replaced.
    pub fn text(&self, i: usize) -> Result<String> {
        self.bytes(i).map(|b| String::from_utf8_lossy(b).into_owned())
    }
    /// Returns exactly `N` numbers from argument `i`.
    pub fn array<const N: usize>(&self, i: usize) -> Result<[f64; N]> {
        self.arg(i).array().ok_or_else(|| self.wrong_argument(i, &format!("a table of {N} numbers")))
    }

    /// Adds a result. If there is no room for it, the call fails when the command returns.
    #[inline]
    pub fn ret(&mut self, value: impl Return) {
        let raw = value.to_raw(&mut self.raw);
        // SAFETY: `to_raw` has stored what the value points to in memory that is valid until the results have been read.
        self.overflow |= !raw.is_some_and(|raw| unsafe { self.raw.push(raw) });
    }
}

impl<'a, P: Plugin> Call<'a, P> {
    /// Adds a result. If there is no room for it, the call fails when the command returns.
    #[inline]
    pub fn ret(&mut self, value: impl Return) {
        // Repeated here because a call through `DerefMut` would borrow `c` mutably before the argument is evaluated, so
        // `c.ret(2.0 * c.f64(0)?)` would not compile.
        self.0.ret(value);
    }
    /// Returns the world.
    pub fn world(&self) -> World<'a> {
        self.full_world()
    }
    /// Returns the plugin's state of this world.
    ///
    /// # Panics
    /// Panics if the plugin has not called [`Offer::per_world`](crate::safe::Offer::per_world).
    pub fn instance(&self) -> &'a P::World
    where
        P: PerWorld,
    {
        assert!(
            !self.0.raw.instance.is_null(),
            "the plugin has no state per world: `Plugin::offer` must call `offer.per_world()`"
        );
        // SAFETY: for commands with exclusive access, `instance` is the `data` that `create` made for this plugin (null
        // was excluded above), and it lives until the world ends.
        unsafe { &life::instance_at::<WorldState<P>>(self.0.raw.instance).0 }
    }

    /// Returns whether this caller can wait.
    pub fn can_wait(&self) -> bool {
        self.0.raw.wait_token != 0
    }
    /// Returns the number `resume` that was passed to the `wait_*` function before the command was suspended, or 0 in
    /// the first call to the command. After a wait, the arguments are no longer available, so store the data that you
    /// need in the instance, under that number. If the script ends during the wait, the command is not called again, so
    /// discard stale entries.
    pub fn resumed(&self) -> u64 {
        self.0.raw.resume
    }
    fn wait(&mut self, until: u32, value: f64, name: &str, resume: u64) -> Result<Outcome> {
        let call = &mut self.0.raw;
        let wait = call.api().and_then(|a| a.wait);
        let wait = wait.ok_or_else(|| {
            Fail::unsupported("this host does not support commands that wait")
                .help("update the program that loads this plugin")
        })?;
        // SAFETY: the function is that of this call, whose frame is passed to it; the name lives during the call.
        match unsafe { wait(call.ptr(), until, value, text_raw(name), resume) } {
            status if status < 0 => Err(call.fail(status)),
            _ => Ok(Outcome::Waiting),
        }
    }
    /// Waits for `steps` steps; then the command is called again, and [`Call::resumed`] returns `resume`, which must
    /// not be 0. The command must return the outcome at once: `return c.wait_steps(1, resume)`.
    pub fn wait_steps(&mut self, steps: u32, resume: u64) -> Result<Outcome> {
        self.wait(TATU_UNTIL_STEPS, f64::from(steps), "", resume)
    }
    /// Waits until the simulation time is `time`, s; otherwise as [`Call::wait_steps`].
    pub fn wait_until(&mut self, time: f64, resume: u64) -> Result<Outcome> {
        self.wait(TATU_UNTIL_TIME, time, "", resume)
    }
    /// Waits until a signal with this name exists; otherwise as [`Call::wait_steps`].
    pub fn wait_signal(&mut self, name: &str, resume: u64) -> Result<Outcome> {
        self.wait(TATU_UNTIL_SIGNAL, 0.0, name, resume)
    }
    /// Waits until the next step, to check a condition in each step; otherwise as [`Call::wait_steps`].
    pub fn wait_poll(&mut self, resume: u64) -> Result<Outcome> {
        self.wait(TATU_UNTIL_POLL, 0.0, "", resume)
    }

    /// Returns a ticket for work on one of the plugin's own threads, which delivers its result with [`Ticket::wake`];
    /// the command then returns [`Call::wait_wake`]. Returns `None` in a replay, where the result is in the input log:
    /// the command must wait as well, but not start a thread.
    pub fn ticket(&mut self) -> Result<Option<Ticket>> {
        let host = *self.world().host();
        let (call, mut number) = (&mut self.0.raw, 0);
        let ticket = call.api().filter(|a| a.size as usize >= size_of::<tatu_call_api>());
        let ticket = ticket.and_then(|a| a.ticket).ok_or_else(no_tickets)?;
        // SAFETY: the function is that of this call, whose frame is passed to it; the number lives during the call.
        match unsafe { ticket(call.ptr(), &mut number) } {
            status if status < 0 => Err(call.fail(status)),
            _ => Ok((number != 0).then_some(Ticket { host, number })),
        }
    }
    /// Waits for the result of the thread that received the ticket of this call; [`Call::woken`] returns it afterwards.
    pub fn wait_wake(&mut self, resume: u64) -> Result<Outcome> {
        self.wait(TATU_UNTIL_WAKE, 0.0, "", resume)
    }
    /// Returns the result that [`Ticket::wake`] delivered, in the call to the command that follows the wait.
    pub fn woken(&mut self) -> Result<&'a [u8]> {
        let (call, mut result) = (&mut self.0.raw, tatu_str { ptr: std::ptr::null(), len: 0 });
        let woken = call.api().filter(|a| a.size as usize >= size_of::<tatu_call_api>());
        let woken = woken.and_then(|a| a.woken).ok_or_else(no_tickets)?;
        // SAFETY: the function is that of this call, whose frame is passed to it. Its result is valid until the call
        // returns, and `'a` is the call.
        unsafe {
            match woken(call.ptr(), &mut result) {
                status if status < 0 => Err(call.fail(status)),
                _ => Ok(bytes_of(result)),
            }
        }
    }

    /// Retains a function of a script until it is released or its script ends; returns its retained id.
    pub fn keep_func(&self, func: tatu_func) -> Result<tatu_func> {
        let (world, mut kept) = (self.world(), 0);
        match service!(world.commands.retain)(world.raw(), func, Some(&mut kept)) {
            TATU_OK => Ok(kept),
            status => Err(Fail::with_code(status, "the function cannot be retained")),
        }
    }
    /// Releases a function that [`Call::keep_func`] has retained.
    pub fn drop_func(&self, func: tatu_func) {
        if let Some(drop) = self.world().host().commands.and_then(|t| t.drop) {
            drop(self.world().raw(), func);
        }
    }
    /// Calls a function of a script; returns its results.
    pub fn call_func(&mut self, func: tatu_func, args: &[Value]) -> Result<Vec<Value>> {
        let world = self.world();
        let call = service!(world.commands.call_func);
        // SAFETY: `outgoing::call` passes a complete frame that lives during the call.
        let call = |world: WorldRef<'_>, frame: &mut tatu_call| unsafe { call(world, func, frame) };
        outgoing::call(&world, tatu_call::empty(), args, call).map(Called::done)
    }
}

/// Runs a command with exclusive access to the world; the `call` of its declaration.
///
/// # Safety
/// `user` must point to an [`ExclusiveFn`] of the plugin, and `raw` to the frame of a running call.
pub(crate) unsafe extern "C" fn call_exclusive<P: Plugin>(raw: *mut tatu_call) -> tatu_status {
    // SAFETY: the caller guarantees that `user` points to an `ExclusiveFn<P>` and `raw` to the frame of a running call.
    unsafe { run_command(raw, |run: &ExclusiveFn<P>, call| run(call)) }
}

/// Runs a command that may run in parallel with others; the `call` of its declaration.
///
/// # Safety
/// `user` must point to a [`SharedFn`] of the plugin, and `raw` to the frame of a running call.
pub(crate) unsafe extern "C" fn call_shared<P: Plugin>(raw: *mut tatu_call) -> tatu_status {
    // SAFETY: the caller guarantees that `user` points to a `SharedFn<P>` and `raw` to the frame of a running call.
    unsafe { run_command(raw, |run: &SharedFn<P>, call: &mut Call<'_, P>| run(&mut call.0)) }
}

/// Runs a command.
///
/// # Safety
/// `user` must point to an `R`, and `raw` to the frame of a running call.
#[inline(always)]
unsafe fn run_command<P: Plugin, R>(
    raw: *mut tatu_call,
    f: impl FnOnce(&R, &mut Call<'_, P>) -> Result<Outcome>,
) -> tatu_status {
    // SAFETY: `raw` points to the frame of a running call. `init` created its `self_`, and its `user` is that of the
    // command's declaration; both live until shutdown.
    let (raw, started, run) =
        unsafe { (CallFrame::at(raw), &*(*raw).self_.cast::<StartedPlugin<P>>(), &*(*raw).user.cast::<R>()) };
    panics::run(raw.error, || {
        let mut call = Call(SharedCall { raw, started, overflow: false });
        let outcome = f(run, &mut call)?;
        if call.0.overflow {
            return Err(Fail::with_code(TATU_ERR_SPACE, "not enough room for the results"));
        }
        Ok(if outcome == Outcome::Waiting { TATU_WAIT } else { TATU_OK })
    })
}
