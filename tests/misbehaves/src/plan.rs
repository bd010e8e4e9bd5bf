//! Selects the function that misbehaves, and how.

use std::{ffi::c_void, time::Duration};

use tatu_plugin_api::{
    abi::*,
    safe::{Fail, Result},
};

/// How a function misbehaves.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Misbehaviour {
    Panic,
    Error,
    Nonsense,
    Hang,
}

/// The plugin's data: the name of one function, and how it misbehaves.
pub struct MisbehaviourPlan {
    function: String,
    how: Option<Misbehaviour>,
    pub host: *const tatu_host,
}

impl MisbehaviourPlan {
    /// Reads the plan from environment variables. Called once, when the plugin is loaded.
    pub fn new(host: *const tatu_host) -> Self {
        let asked = std::env::var("TATU_MISBEHAVE").unwrap_or_default();
        let (function, how) = asked.split_once('=').unwrap_or_default();
        let how = match how {
            "panic" => Some(Misbehaviour::Panic),
            "error" => Some(Misbehaviour::Error),
            "nonsense" => Some(Misbehaviour::Nonsense),
            "hang" => Some(Misbehaviour::Hang),
            _ => None,
        };
        MisbehaviourPlan { function: function.to_owned(), how, host }
    }
    /// Returns the plan behind the plugin's `self` pointer.
    ///
    /// # Safety
    /// `me` was made by `init`, and `shutdown` has not been called.
    pub unsafe fn of<'a>(me: *mut c_void) -> &'a MisbehaviourPlan {
        // SAFETY: the caller guarantees that `me` points to a live plan.
        unsafe { &*me.cast::<MisbehaviourPlan>() }
    }
    /// Returns how `function` misbehaves, or `None` if it behaves correctly.
    pub fn misbehaviour_of(&self, function: &str) -> Option<Misbehaviour> {
        self.how.filter(|_| self.function == function)
    }
    fn announce(&self, function: &str, how: Misbehaviour) {
        eprintln!("misbehaving in {function}: {how:?}");
    }

    /// Misbehaves if `function` is selected: fails, panics, hangs, or returns the result of `nonsense`.
    pub fn act<T>(&self, function: &str, nonsense: impl FnOnce() -> Result<T>) -> Result<Option<T>> {
        let Some(how) = self.misbehaviour_of(function) else { return Ok(None) };
        self.announce(function, how);
        match how {
            Misbehaviour::Panic => panic!("on request"),
            Misbehaviour::Error => Err(Fail::new("failed on request")),
            Misbehaviour::Nonsense => nonsense().map(Some),
            Misbehaviour::Hang => hang(),
        }
    }
    /// Like [`MisbehaviourPlan::act`], for functions that cannot return an error; errors are logged.
    pub fn act_quietly<T>(&self, function: &str, nonsense: impl FnOnce() -> T) -> Option<T> {
        match self.act(function, || Ok(nonsense())) {
            Ok(done) => done,
            Err(fail) => {
                self.log(fail.text());
                None
            }
        }
    }
    /// Writes an error to the host's log.
    pub fn log(&self, text: &str) {
        // SAFETY: the host and its tables are valid until shutdown; the log accepts a null world.
        unsafe {
            let Some(service) = (*self.host).service else { return };
            let log = service(self.host, TATU_HOST_LOG.as_ptr()).cast::<tatu_host_log>();
            if let Some(write) = log.as_ref().and_then(|l| l.write) {
                write(self.host, WorldRef::new(std::ptr::null_mut()), TATU_LOG_ERROR, text.into());
            }
        }
    }
}

fn hang() -> ! {
    loop {
        std::thread::sleep(Duration::from_millis(50));
    }
}

/// Changes the floating-point mode, which is how functions without a result misbehave.
pub fn change_float_mode() {
    #[cfg(target_arch = "x86_64")]
    {
        let mut mode = 0u32;
        // SAFETY: this changes only the control register of this thread: flush to zero, and denormals are zero.
        unsafe {
            std::arch::asm!("stmxcsr [{0}]", "or dword ptr [{0}], 0x8040", "ldmxcsr [{0}]", in(reg) &raw mut mode);
        }
    }
    #[cfg(target_arch = "aarch64")]
    // SAFETY: this changes only the control register of this thread: flush to zero.
    unsafe {
        std::arch::asm!("mrs {0}, fpcr", "orr {0}, {0}, #(1 << 24)", "msr fpcr, {0}", out(reg) _);
    }
}
