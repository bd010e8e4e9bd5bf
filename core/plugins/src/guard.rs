//! State of thread and process that a plugin must leave unchanged.
//!
//! Of the thread: floating-point mode and direction flag. After a library built with `-ffast-math` has been loaded,
//! everything else on that thread computes different results; with the direction flag set, copies run backwards. Of the
//! process: the locale (with a decimal comma no number can be read any more), the working folder, what signals do,
//! standard output and error.
//!
//! All is restored and the plugin is reported. Reading the mode is cheap, so it is checked around every outermost
//! call, the direction flag around every call; locale and x87 control word ([`ProcessState`]) after loading,
//! after creating instances, and once per stage; what takes system calls (`process`) likewise, but in one stage of
//! 64.

mod process;

use std::{
    cell::RefCell,
    ffi::{CStr, CString},
    sync::atomic::{AtomicBool, Ordering::Relaxed},
};

/// The floating-point mode of this thread: rounding, subnormal numbers, traps; not the flags of past operations.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Mode(u64);

#[cfg(target_arch = "x86_64")]
mod register {
    use core::arch::asm;

    /// The six lowest bits are flags of past operations.
    pub const CONTROL: u64 = 0xFFC0;

    #[inline]
    pub fn read() -> u64 {
        let mut now = 0u32;
        // SAFETY: stores 4 bytes into `now`.
        unsafe { asm!("stmxcsr [{}]", in(reg) &raw mut now, options(nostack, preserves_flags)) };
        now.into()
    }
    pub fn write(mode: u64) {
        let mode = mode as u32;
        // SAFETY: a value that was read from the register, so no reserved bit is set.
        unsafe { asm!("ldmxcsr [{}]", in(reg) &raw const mode, options(nostack, readonly, preserves_flags)) };
    }
    /// The control word of the x87 floating-point unit, which `long double` in C uses.
    pub fn read_old() -> u16 {
        let mut now = 0u16;
        // SAFETY: stores 2 bytes into `now`.
        unsafe { asm!("fnstcw [{}]", in(reg) &raw mut now, options(nostack, preserves_flags)) };
        now
    }
    pub fn write_old(word: u16) {
        // SAFETY: a value that was read from the register.
        unsafe { asm!("fldcw [{}]", in(reg) &raw const word, options(nostack, readonly, preserves_flags)) };
    }
}

#[cfg(target_arch = "aarch64")]
mod register {
    use core::arch::asm;

    pub const CONTROL: u64 = u64::MAX;

    #[inline]
    pub fn read() -> u64 {
        let now: u64;
        // SAFETY: reads a register that every program may read.
        unsafe { asm!("mrs {}, fpcr", out(reg) now, options(nomem, nostack, preserves_flags)) };
        now
    }
    pub fn write(mode: u64) {
        // SAFETY: a value that was read from the register.
        unsafe { asm!("msr fpcr, {}", in(reg) mode, options(nomem, nostack, preserves_flags)) };
    }
    pub fn read_old() -> u16 {
        0
    }
    pub fn write_old(_: u16) {}
}

#[cfg(not(any(target_arch = "x86_64", target_arch = "aarch64")))]
mod register {
    pub const CONTROL: u64 = 0;

    pub fn read() -> u64 {
        0
    }
    pub fn write(_: u64) {}
    pub fn read_old() -> u16 {
        0
    }
    pub fn write_old(_: u16) {}
}

/// Clears the direction flag of the processor; whether it was set.
#[cfg(target_arch = "x86_64")]
#[inline]
pub fn clear_direction() -> bool {
    let flags: u64;
    // SAFETY: reads the flags through the stack, and leaves the direction flag as compiled code expects it.
    unsafe { core::arch::asm!("pushfq", "pop {}", "cld", out(reg) flags) };
    flags & 0x400 != 0
}
/// There is no such flag.
#[cfg(not(target_arch = "x86_64"))]
#[inline]
pub fn clear_direction() -> bool {
    false
}

impl Mode {
    /// The mode of this thread now.
    #[inline]
    pub fn now() -> Self {
        Mode(register::read() & register::CONTROL)
    }
    /// Restores this mode; returns whether it had changed.
    #[inline]
    pub fn restore(self) -> bool {
        let changed = Self::now() != self;
        if changed {
            register::write(self.0);
        }
        changed
    }
}

thread_local! {
    /// Errors that are logged without a world during [`capture_errors`]: for functions that cannot return an error.
    static SAID: RefCell<Option<Vec<String>>> = const { RefCell::new(None) };
}

/// Calls a function that has no error object, and returns the errors that were logged on this thread meanwhile: the
/// host reports them, with the name of the function.
pub fn capture_errors<T>(f: impl FnOnce() -> T) -> (T, Vec<String>) {
    let outer = SAID.replace(Some(Vec::new()));
    let done = f();
    (done, SAID.replace(outer).unwrap_or_default())
}
/// Collects an error that a plugin logs; returns whether errors are being captured. An endlessly logging plugin must
/// not fill the memory.
pub fn say(text: &str) -> bool {
    SAID.with_borrow_mut(|said| {
        let Some(said) = said else { return false };
        if said.len() < 64 {
            said.push(text.to_owned());
        }
        true
    })
}

/// Calls a plugin; returns what it changed of its thread's state, which has then been restored.
#[inline]
pub fn watched<T>(f: impl FnOnce() -> T) -> (T, Option<&'static str>) {
    let before = Mode::now();
    let done = f();
    let (turned, moved) = (clear_direction(), before.restore());
    end_if_child();
    let what = match (turned, moved) {
        (false, false) => None,
        (true, _) => Some(DIRECTION),
        (false, true) => Some(MODE),
    };
    (done, what)
}

/// This process is a copy of the program, made by a fork within a plugin's call.
static IS_CHILD: AtomicBool = AtomicBool::new(false);

/// Set by the program in a forked copy of itself: it ends when the plugin's call returns.
pub fn this_is_a_child() {
    IS_CHILD.store(true, Relaxed);
}

/// After a call of a plugin: a copy of the process must not go on.
#[inline]
pub fn end_if_child() {
    if IS_CHILD.load(Relaxed) {
        end_child();
    }
}

/// A copy has one thread, and would wait for the others for ever, or write what the program itself writes.
#[cold]
fn end_child() {
    #[cfg(unix)]
    // SAFETY: does not return, and runs nothing of this process.
    unsafe {
        libc::_exit(1)
    };
}

/// A known good state of thread and process.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ProcessState {
    mode: Mode,
    old: u16,
    locale: Option<CString>,
    process: process::State,
}

impl ProcessState {
    /// As it is now.
    pub fn now() -> Self {
        ProcessState {
            mode: Mode::now(),
            old: register::read_old(),
            locale: with_locale(|l| l.map(CStr::to_owned)),
            process: process::State::now(),
        }
    }
    /// Takes the present state of the process as good: the program itself has changed it.
    pub fn take_process_anew(&mut self) {
        self.process = process::State::now();
    }
    /// Restores it; returns what had been changed, in words.
    pub fn restore(&self) -> Option<String> {
        let mut changed: Vec<String> = self.restore_quickly().map(str::to_owned).into_iter().collect();
        changed.extend(self.process.restore());
        (!changed.is_empty()).then(|| changed.join(" and "))
    }
    /// The same for what takes no system call.
    pub fn restore_quickly(&self) -> Option<&'static str> {
        let mut changed = self.mode.restore();
        if register::read_old() != self.old {
            register::write_old(self.old);
            changed = true;
        }
        let moved = !with_locale(|l| l == self.locale.as_deref());
        if moved {
            set_locale(self.locale.as_deref());
        }
        match (changed, moved) {
            (true, true) => Some(BOTH),
            (true, false) => Some(MODE),
            (false, true) => Some("the locale of the process"),
            (false, false) => None,
        }
    }
}

/// What was changed, for messages.
pub const MODE: &str = "the floating-point mode";
/// The same.
pub const DIRECTION: &str = "the direction flag of the processor";
const BOTH: &str = "the floating-point mode and the locale of the process";
/// The hint, for messages.
pub const HELP: &str = "it was put back; build the plugin without `-ffast-math`, and without calls of setlocale, fesetround, chdir, \
                        sigaction and the like";

#[cfg(unix)]
fn with_locale<T>(f: impl FnOnce(Option<&CStr>) -> T) -> T {
    // SAFETY: asks only. The text belongs to the system and is good until the next change, so it is not kept.
    unsafe {
        let text = libc::setlocale(libc::LC_ALL, std::ptr::null());
        f((!text.is_null()).then(|| CStr::from_ptr(text)))
    }
}
#[cfg(unix)]
fn set_locale(to: Option<&CStr>) {
    if let Some(to) = to {
        // SAFETY: a text that the same function gave.
        unsafe { libc::setlocale(libc::LC_ALL, to.as_ptr()) };
    }
}
#[cfg(not(unix))]
fn with_locale<T>(f: impl FnOnce(Option<&CStr>) -> T) -> T {
    f(None)
}
#[cfg(not(unix))]
fn set_locale(_: Option<&CStr>) {}

#[cfg(all(test, target_arch = "x86_64"))]
mod tests {
    use super::*;

    /// Flush to zero, denormals are zero: what a `-ffast-math` library sets (Intel SDM, volume 1, 10.2.3).
    const FAST: u64 = 0x8040;

    #[test]
    fn a_changed_mode_is_put_back() {
        let before = Mode::now();
        let ((), changed) = watched(|| register::write(before.0 | FAST));
        assert_eq!(changed, Some(MODE));
        assert_eq!(Mode::now(), before);
        let done = watched(|| std::hint::black_box(1.0f64) / std::hint::black_box(3.0));
        assert_eq!(done.1, None, "flags are no mode");
    }

    #[test]
    fn home_knows_the_old_unit_too() {
        let home = ProcessState::now();
        assert_eq!(home.restore(), None);
        register::write_old(home.old & !0x300);
        assert_eq!(home.restore().as_deref(), Some(MODE));
        assert_eq!(ProcessState::now(), home);
    }
}
