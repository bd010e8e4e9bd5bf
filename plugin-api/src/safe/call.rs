//! A running command: its arguments, results and waits.

use super::value::Room;
use super::{
    Fail, Plugin, Result, Value, ValueRef, World,
    command::Run,
    fail::{bytes_of, text_raw},
    guard,
    plugin::Started,
    value::{raw_int, type_name},
};
use crate::abi::*;

/// How a command ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Outcome {
    /// Its results are there.
    #[default]
    Done,
    /// It goes on later; see [`Call::wait_steps`] and its like.
    Waiting,
}

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

/// One call of a command.
pub struct Call<'a, P: Plugin> {
    raw: &'a mut tatu_call,
    started: &'a Started<P>,
    overflow: bool,
}

/// A result that a command returns.
pub trait Return {
    /// The border form; spans go into memory of the call.
    fn to_raw(&self, alloc: &mut dyn FnMut(usize) -> *mut u8) -> Option<tatu_value>;
}
impl Return for f64 {
    fn to_raw(&self, _: &mut dyn FnMut(usize) -> *mut u8) -> Option<tatu_value> {
        Some(tatu_value { tag: TATU_F64, reserved: 0, u: tatu_payload { f: *self } })
    }
}
impl Return for i64 {
    fn to_raw(&self, _: &mut dyn FnMut(usize) -> *mut u8) -> Option<tatu_value> {
        Some(raw_int(TATU_I64, *self))
    }
}
impl Return for bool {
    fn to_raw(&self, _: &mut dyn FnMut(usize) -> *mut u8) -> Option<tatu_value> {
        Some(raw_int(TATU_BOOL, i64::from(*self)))
    }
}
impl Return for Value {
    fn to_raw(&self, alloc: &mut dyn FnMut(usize) -> *mut u8) -> Option<tatu_value> {
        Value::to_raw(self, alloc)
    }
}
fn span_return<T: Copy>(tag: u32, data: &[T], alloc: &mut dyn FnMut(usize) -> *mut u8) -> Option<tatu_value> {
    let to = alloc(size_of_val(data).max(1)).cast::<T>();
    if to.is_null() {
        return None;
    }
    // SAFETY: `alloc` gave room for exactly this, 8-byte aligned.
    unsafe { std::ptr::copy_nonoverlapping(data.as_ptr(), to, data.len()) };
    Some(tatu_value { tag, reserved: 0, u: tatu_payload { s: tatu_span_t { ptr: to.cast(), len: data.len() as u64 } } })
}
impl Return for [f64] {
    fn to_raw(&self, alloc: &mut dyn FnMut(usize) -> *mut u8) -> Option<tatu_value> {
        span_return(TATU_F64S, self, alloc)
    }
}
impl<const N: usize> Return for [f64; N] {
    fn to_raw(&self, alloc: &mut dyn FnMut(usize) -> *mut u8) -> Option<tatu_value> {
        span_return(TATU_F64S, self, alloc)
    }
}
impl Return for [i64] {
    fn to_raw(&self, alloc: &mut dyn FnMut(usize) -> *mut u8) -> Option<tatu_value> {
        span_return(TATU_I64S, self, alloc)
    }
}
impl Return for str {
    fn to_raw(&self, alloc: &mut dyn FnMut(usize) -> *mut u8) -> Option<tatu_value> {
        span_return(TATU_TEXT, self.as_bytes(), alloc)
    }
}
impl Return for [u8] {
    fn to_raw(&self, alloc: &mut dyn FnMut(usize) -> *mut u8) -> Option<tatu_value> {
        span_return(TATU_TEXT, self, alloc)
    }
}
impl Return for ValueRef<'_> {
    fn to_raw(&self, alloc: &mut dyn FnMut(usize) -> *mut u8) -> Option<tatu_value> {
        self.to_value().ok()?.to_raw(alloc)
    }
}

impl<'a, P: Plugin> Call<'a, P> {
    /// The plugin.
    pub fn plugin(&self) -> &'a P {
        &self.started.plugin
    }
    /// The world.
    pub fn world(&self) -> World<'a> {
        // SAFETY: the host calls commands in `[step]` of this world.
        unsafe { World::new(self.raw.world, &self.started.host) }
    }
    /// What the plugin keeps for this world. Not in a command that a script calls beside those of other threads: the call fails.
    ///
    /// # Panics
    /// In such a call, since what is kept for a world belongs to one thread. The panic becomes the error of the call.
    pub fn instance(&self) -> &'a P::World {
        assert!(!self.raw.instance.is_null(), "a command that runs side by side with others has no instance to use");
        // SAFETY: made by `Plugin::world`; lives until the world ends, and the host gives it to the world's own thread alone.
        unsafe { &*self.raw.instance.cast::<P::World>() }
    }
    /// Which of the command's names was used: 0 for the first.
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
    /// Argument `i`; nil if it was not given.
    pub fn arg(&self, i: usize) -> ValueRef<'a> {
        self.args().get(i).copied().unwrap_or(ValueRef::NIL)
    }
    /// Whether argument `i` is there and not nil.
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
    pub fn ret<R: Return + ?Sized>(&mut self, value: impl std::borrow::Borrow<R>) {
        self.push(value.borrow());
    }
    fn push<R: Return + ?Sized>(&mut self, value: &R) {
        let call: *mut tatu_call = self.raw;
        let alloc = self.raw.api;
        let mut alloc = |bytes: usize| {
            // SAFETY: the api table lives as long as the call.
            let f = unsafe { alloc.as_ref() }.and_then(|a| a.alloc);
            f.map_or(std::ptr::null_mut(), |f| {
                // SAFETY: `call` is the running call.
                unsafe { f(call, bytes as u64) }.cast()
            })
        };
        match value.to_raw(&mut alloc) {
            Some(v) if self.raw.n_results < self.raw.results_cap => {
                // SAFETY: the caller's array has room for `results_cap`.
                unsafe { *self.raw.results.add(self.raw.n_results as usize) = v };
                self.raw.n_results += 1;
            }
            _ => self.overflow = true,
        }
    }

    /// Whether this caller can wait.
    pub fn can_wait(&self) -> bool {
        self.raw.wait_token != 0
    }
    /// Not 0: a wait is over, and this is the word that was given to it.
    pub fn resumed(&self) -> u64 {
        self.raw.resume
    }
    fn wait(&mut self, until: u32, value: f64, name: &str, resume: u64) -> Result<Outcome> {
        // SAFETY: the api table lives as long as the call.
        let wait = unsafe { self.raw.api.as_ref() }
            .and_then(|a| a.wait)
            .ok_or_else(|| Fail::unsupported("this host cannot wait"))?;
        // SAFETY: the running call.
        let status = unsafe { wait(self.raw, until, value, text_raw(name), resume) };
        if status < 0 {
            // SAFETY: the host's error of this call.
            return Err(unsafe { Fail::read(status, self.raw.error) });
        }
        Ok(Outcome::Waiting)
    }
    /// Goes on `steps` steps later: `Ok(c.wait_steps(1, word)?)`.
    pub fn wait_steps(&mut self, steps: u32, resume: u64) -> Result<Outcome> {
        self.wait(TATU_UNTIL_STEPS, f64::from(steps), "", resume)
    }
    /// Goes on at a simulation time, s.
    pub fn wait_until(&mut self, time: f64, resume: u64) -> Result<Outcome> {
        self.wait(TATU_UNTIL_TIME, time, "", resume)
    }
    /// Goes on when a signal exists.
    pub fn wait_signal(&mut self, name: &str, resume: u64) -> Result<Outcome> {
        self.wait(TATU_UNTIL_SIGNAL, 0.0, name, resume)
    }
    /// Is called again in each step.
    pub fn wait_poll(&mut self, resume: u64) -> Result<Outcome> {
        self.wait(TATU_UNTIL_POLL, 0.0, "", resume)
    }

    /// Makes a function that a script gave last until it is dropped or its script ends.
    pub fn keep_func(&self, func: tatu_func) -> Result<tatu_func> {
        let Some(retain) = self.started.host.commands.and_then(|t| t.retain) else {
            return Err(Fail::unsupported("this host cannot keep functions"));
        };
        let mut kept = 0;
        // SAFETY: the running call's world.
        match unsafe { retain(self.raw.world, func, &mut kept) } {
            TATU_OK => Ok(kept),
            status => Err(Fail::with_code(status, "the function cannot be kept")),
        }
    }
    /// Gives a kept function up.
    pub fn drop_func(&self, func: tatu_func) {
        if let Some(drop) = self.started.host.commands.and_then(|t| t.drop) {
            // SAFETY: the running call's world.
            unsafe { drop(self.raw.world, func) };
        }
    }
    /// Calls a function that a script gave; its results.
    pub fn call_func(&mut self, func: tatu_func, args: &[Value]) -> Result<Vec<Value>> {
        let commands = self.started.host.commands;
        let (Some(call), Some(mark), Some(release)) =
            (commands.and_then(|t| t.call_func), commands.and_then(|t| t.mark), commands.and_then(|t| t.release))
        else {
            return Err(Fail::unsupported("this host cannot call functions"));
        };
        let mut room = Room::default();
        let args = room.all(args);
        let mut results = [ValueRef::NIL.raw(); 16];
        // SAFETY: an all-zero frame is a valid empty one.
        let mut frame: tatu_call = unsafe { std::mem::zeroed() };
        frame.size = size_of::<tatu_call>() as u32;
        (frame.args, frame.n_args) = (args.as_ptr(), args.len() as u32);
        (frame.results, frame.results_cap) = (results.as_mut_ptr(), results.len() as u32);
        // SAFETY: the frame and its arrays live through the call; results are copied before the release.
        unsafe {
            let here = mark(self.raw.world);
            let status = call(self.raw.world, func, &mut frame);
            let out = if status < 0 {
                Err(Fail::read(status, frame.error))
            } else {
                ValueRef::slice(frame.results, frame.n_results as usize).iter().map(|v| v.to_value()).collect()
            };
            release(self.raw.world, here);
            out
        }
    }
}

pub(crate) unsafe extern "C" fn trampoline<P: Plugin>(raw: *mut tatu_call) -> tatu_status {
    // SAFETY: the host gives a live call, `self` as made by `init`, and `user` as declared.
    let (raw, started) = unsafe { (&mut *raw, &*(*raw).self_.cast::<Started<P>>()) };
    let error = raw.error;
    guard::run(error, || {
        // SAFETY: `user` is a boxed `Run<P>` that lives until shutdown.
        let run = unsafe { &*raw.user.cast::<Run<P>>() };
        let mut call = Call { raw, started, overflow: false };
        let outcome = run(&mut call)?;
        if call.overflow {
            return Err(Fail::with_code(TATU_ERR_SPACE, "the results do not fit"));
        }
        Ok(if outcome == Outcome::Waiting { TATU_WAIT } else { TATU_OK })
    })
}
