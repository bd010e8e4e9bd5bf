//! A running command: its arguments, results and waits.

use std::{
    mem::MaybeUninit,
    ops::{Deref, DerefMut},
    ptr::null_mut,
};

use crate::abi::*;
use crate::safe::{
    Called, Fail, PerWorld, Plugin, Result, SharedWorld, Value, ValueRef, World,
    call::{outgoing, shared_world::service},
    declare::plugin::{Call, Outcome, Run, RunShared, SharedCall, Started},
    entry::{
        guard,
        life::{self, Kept},
    },
    value::{
        fail::{bytes_of, text_raw},
        owned::{Room, given, raw_int, raw_span, type_name},
    },
};

/// What a command's function may return: nothing, or whether it waits.
pub trait IntoResult {
    /// As an outcome.
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

/// What a command returns as one result: numbers, booleans, texts, lists of numbers, a [`Value`], and references to
/// these.
pub trait Return {
    /// The ABI form; what it points to is put into memory of the call. `None`: out of memory.
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
/// A text of any bytes.
impl Return for [u8] {
    fn to_raw(&self, room: &mut dyn Room) -> Option<tatu_value> {
        raw_span(TATU_TEXT, self, room)
    }
}

/// Memory of a call, valid until its results have been read; 8-byte aligned; null: out of memory.
pub(crate) fn alloc(call: &mut tatu_call, bytes: usize) -> *mut u8 {
    // SAFETY: the api table lives as long as the call, whose frame this is.
    unsafe { call.api.as_ref().and_then(|a| a.alloc).map_or(null_mut(), |f| f(call, bytes as u64).cast()) }
}

struct CallRoom<'a>(&'a mut tatu_call);

impl Room for CallRoom<'_> {
    fn words(&mut self, n: usize) -> Option<&mut [MaybeUninit<u64>]> {
        // SAFETY: the host gives room for as many words, to this call alone.
        unsafe { given(alloc(self.0, 8 * n), n) }
    }
}

impl<'a, P: Plugin> SharedCall<'a, P> {
    /// The plugin.
    pub fn plugin(&self) -> &'a P {
        &self.started.plugin
    }
    /// The world, read-only.
    pub fn world(&self) -> SharedWorld<'a> {
        *self.whole_world()
    }
    fn whole_world(&self) -> World<'a> {
        // SAFETY: the host gives the world to the call, which 'a is.
        unsafe { World::new(self.raw.world, &self.started.host) }
    }
    /// The index of the name that was called; 0: the first.
    pub fn alias(&self) -> u32 {
        self.raw.alias
    }
    /// The object that the calling script belongs to; 0: none.
    pub fn caller_object(&self) -> tatu_object {
        self.raw.caller_object
    }
    /// The calling script; 0: none.
    pub fn caller_script(&self) -> tatu_object {
        self.raw.caller_script
    }
    /// The calling script's dialect; empty: none.
    pub fn caller_dialect(&self) -> &'a [u8] {
        // SAFETY: valid during the call.
        unsafe { bytes_of(self.raw.caller_dialect) }
    }

    /// All arguments.
    pub fn args(&self) -> &'a [ValueRef<'a>] {
        // SAFETY: the host gives `n_args` values, valid during the call.
        unsafe { ValueRef::slice(self.raw.args, self.raw.n_args as usize) }
    }
    /// Argument `i`; nil if it is missing.
    pub fn arg(&self, i: usize) -> ValueRef<'a> {
        self.args().get(i).copied().unwrap_or(ValueRef::NIL)
    }
    /// Whether argument `i` was given and is not nil.
    pub fn has(&self, i: usize) -> bool {
        !self.arg(i).is_nil()
    }
    #[cold]
    fn wrong(&self, i: usize, expected: &str) -> Fail {
        Fail::argument(format!("argument {}: expected {expected}, found {}", i + 1, type_name(self.arg(i).tag())))
    }
    /// A number.
    #[inline]
    pub fn f64(&self, i: usize) -> Result<f64> {
        self.arg(i).as_f64().ok_or_else(|| self.wrong(i, "a number"))
    }
    /// An integer; floats are truncated.
    #[inline]
    pub fn i64(&self, i: usize) -> Result<i64> {
        self.arg(i).as_i64().ok_or_else(|| self.wrong(i, "an integer"))
    }
    /// A text, as bytes.
    #[inline]
    pub fn bytes(&self, i: usize) -> Result<&'a [u8]> {
        self.arg(i).as_bytes().ok_or_else(|| self.wrong(i, "a text"))
    }
    /// A text; bytes that are not UTF-8 are replaced.
    pub fn text(&self, i: usize) -> Result<String> {
        self.bytes(i).map(|b| String::from_utf8_lossy(b).into_owned())
    }
    /// Exactly `N` numbers.
    pub fn array<const N: usize>(&self, i: usize) -> Result<[f64; N]> {
        self.arg(i).array().ok_or_else(|| self.wrong(i, &format!("a table of {N} numbers")))
    }

    /// Adds a result.
    #[inline]
    pub fn ret(&mut self, value: impl Return) {
        match value.to_raw(&mut CallRoom(self.raw)) {
            Some(v) if self.raw.n_results < self.raw.results_cap => {
                // SAFETY: the caller's array has room for `results_cap`.
                unsafe { *self.raw.results.add(self.raw.n_results as usize) = v };
                self.raw.n_results += 1;
            }
            _ => self.overflow = true,
        }
    }
}

impl<'a, P: Plugin> Call<'a, P> {
    /// Adds a result.
    #[inline]
    pub fn ret(&mut self, value: impl Return) {
        // Here too, so that an argument may ask the call: `c.ret(2.0 * c.f64(0)?)`.
        self.0.ret(value);
    }
    /// The world.
    pub fn world(&self) -> World<'a> {
        self.whole_world()
    }
    /// What the plugin keeps for this world. It panics if the plugin has not called [`Offer::per_world`](crate::safe::Offer::per_world).
    pub fn instance(&self) -> &'a P::World
    where
        P: PerWorld,
    {
        assert!(
            !self.0.raw.instance.is_null(),
            "nothing is kept for a world: `Plugin::offer` lacks `offer.per_world()`"
        );
        // SAFETY: the host gives the instance to every command that runs alone; it lives until the world ends.
        unsafe { &life::of::<Kept<P>>(self.0.raw.instance).0 }
    }

    /// Whether this caller can wait.
    pub fn can_wait(&self) -> bool {
        self.0.raw.wait_token != 0
    }
    /// Not 0: a wait has ended, and this is the word that was passed to it. The arguments are gone: keep what you need
    /// of them in the instance under that word. If the script has ended, there is no such call: discard stale entries.
    pub fn resumed(&self) -> u64 {
        self.0.raw.resume
    }
    fn wait(&mut self, until: u32, value: f64, name: &str, resume: u64) -> Result<Outcome> {
        let call = &mut *self.0.raw;
        // SAFETY: the api table lives as long as the call, whose frame and error this is.
        unsafe {
            let wait = call.api.as_ref().and_then(|a| a.wait);
            let wait = wait.ok_or_else(|| Fail::unsupported("this host cannot wait"))?;
            match wait(call, until, value, text_raw(name), resume) {
                status if status < 0 => Err(Fail::read(status, call.error)),
                _ => Ok(Outcome::Waiting),
            }
        }
    }
    /// Resumes `steps` steps later: `Ok(c.wait_steps(1, word)?)`.
    pub fn wait_steps(&mut self, steps: u32, resume: u64) -> Result<Outcome> {
        self.wait(TATU_UNTIL_STEPS, f64::from(steps), "", resume)
    }
    /// Resumes at a simulation time, s.
    pub fn wait_until(&mut self, time: f64, resume: u64) -> Result<Outcome> {
        self.wait(TATU_UNTIL_TIME, time, "", resume)
    }
    /// Resumes when a signal exists.
    pub fn wait_signal(&mut self, name: &str, resume: u64) -> Result<Outcome> {
        self.wait(TATU_UNTIL_SIGNAL, 0.0, name, resume)
    }
    /// Resumes in each step. As with all waits, the word must not be 0.
    pub fn wait_poll(&mut self, resume: u64) -> Result<Outcome> {
        self.wait(TATU_UNTIL_POLL, 0.0, "", resume)
    }

    /// Retains a function of a script, until it is released or its script ends.
    pub fn keep_func(&self, func: tatu_func) -> Result<tatu_func> {
        let (world, mut kept) = (self.world(), 0);
        match service!(world.commands.retain)(world.raw(), func, Some(&mut kept)) {
            TATU_OK => Ok(kept),
            status => Err(Fail::with_code(status, "the function cannot be kept")),
        }
    }
    /// Releases a retained function.
    pub fn drop_func(&self, func: tatu_func) {
        if let Some(drop) = self.world().host().commands.and_then(|t| t.drop) {
            drop(self.world().raw(), func);
        }
    }
    /// Calls a function of a script; returns its results.
    pub fn call_func(&mut self, func: tatu_func, args: &[Value]) -> Result<Vec<Value>> {
        let world = self.world();
        let call = service!(world.commands.call_func);
        // SAFETY: the frame is whole.
        let call = |world: WorldRef<'_>, frame: &mut tatu_call| unsafe { call(world, func, frame) };
        outgoing::call(&world, tatu_call::empty(), args, call).map(Called::done)
    }
}

/// # Safety
/// `user` is a [`Run`] of the plugin.
pub(crate) unsafe extern "C" fn alone<P: Plugin>(raw: *mut tatu_call) -> tatu_status {
    // SAFETY: the caller promises it.
    unsafe { enter(raw, |run: &Run<P>, call| run(call)) }
}

/// # Safety
/// `user` is a [`RunShared`] of the plugin.
pub(crate) unsafe extern "C" fn shared<P: Plugin>(raw: *mut tatu_call) -> tatu_status {
    // SAFETY: the caller promises it.
    unsafe { enter(raw, |run: &RunShared<P>, call: &mut Call<'_, P>| run(&mut call.0)) }
}

/// Runs a command.
///
/// # Safety
/// `user` is an `R`.
#[inline(always)]
unsafe fn enter<P: Plugin, R>(
    raw: *mut tatu_call,
    f: impl FnOnce(&R, &mut Call<'_, P>) -> Result<Outcome>,
) -> tatu_status {
    // SAFETY: the host gives a live call, `self` as made by `init`, and `user` as declared, which lives until shutdown.
    let (raw, started, run) = unsafe { (&mut *raw, &*(*raw).self_.cast::<Started<P>>(), &*(*raw).user.cast::<R>()) };
    guard::run(raw.error, || {
        let mut call = Call(SharedCall { raw, started, overflow: false });
        let outcome = f(run, &mut call)?;
        if call.0.overflow {
            return Err(Fail::with_code(TATU_ERR_SPACE, "the results do not fit"));
        }
        Ok(if outcome == Outcome::Waiting { TATU_WAIT } else { TATU_OK })
    })
}
