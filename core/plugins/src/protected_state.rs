//! Thread and process state that plugins must leave unchanged.
//!
//! The thread state consists of the floating-point mode and the direction flag. After a library built with
//! `-ffast-math` has been loaded, all other code on that thread computes different results; with the direction flag
//! set, memory copies run backwards. The process state consists of the locale (with a decimal comma, numbers can no
//! longer be parsed), the working folder, signal actions, standard output and standard error.
//!
//! Changes are undone and the plugin is reported. Reading the mode is cheap, so it is checked around every outermost
//! call, and the direction flag around every call. Locale and x87 control word ([`ProcessState`]) are checked after
//! loading, after creating instances, and once per stage. State that requires system calls (`process`) is checked at
//! the same points, but only in one stage out of 64.

mod process;

use std::{
    cell::RefCell,
    ffi::{CStr, CString},
    sync::atomic::{AtomicBool, Ordering::Relaxed},
};

/// The floating-point mode of a thread: rounding, subnormal numbers and traps, without the flags of past operations.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct FloatMode(u64);

#[cfg(target_arch = "x86_64")]
mod register {
    use core::arch::asm;

    /// Mask of the mode; the six lowest bits are flags of past operations.
    pub const CONTROL: u64 = 0xFFC0;

    #[inline]
    pub fn read() -> u64 {
        let mut now = 0u32;
        // SAFETY: the instruction stores 4 bytes to `now` and has no other effect.
        unsafe { asm!("stmxcsr [{}]", in(reg) &raw mut now, options(nostack, preserves_flags)) };
        now.into()
    }
    pub fn write(mode: u64) {
        let mode = mode as u32;
        // SAFETY: `mode` lives until the instruction has read its 4 bytes; its value was read from the register, so no
        // reserved bit is set.
        unsafe { asm!("ldmxcsr [{}]", in(reg) &raw const mode, options(nostack, readonly, preserves_flags)) };
    }
    /// Returns the control word of the x87 floating-point unit, which C's `long double` uses.
    pub fn read_old() -> u16 {
        let mut now = 0u16;
        // SAFETY: the instruction stores 2 bytes to `now` and has no other effect.
        unsafe { asm!("fnstcw [{}]", in(reg) &raw mut now, options(nostack, preserves_flags)) };
        now
    }
    pub fn write_old(word: u16) {
        // SAFETY: `word` lives until the instruction has read its 2 bytes, and was read from the register.
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
        // SAFETY: the instruction reads a register that is accessible to every program.
        unsafe { asm!("mrs {}, fpcr", out(reg) now, options(nomem, nostack, preserves_flags)) };
        now
    }
    pub fn write(mode: u64) {
        // SAFETY: the instruction writes a value that was read from the same register.
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

/// Clears the processor's direction flag; returns whether it was set.
#[cfg(target_arch = "x86_64")]
#[inline]
pub fn clear_direction() -> bool {
    let flags: u64;
    // SAFETY: the instructions read the flags through the stack, which they leave unchanged, and clear the direction
    // flag, as compiled code expects.
    unsafe { core::arch::asm!("pushfq", "pop {}", "cld", out(reg) flags) };
    flags & 0x400 != 0
}
/// Returns `false`, because this processor has no direction flag.
#[cfg(not(target_arch = "x86_64"))]
#[inline]
pub fn clear_direction() -> bool {
    false
}

impl FloatMode {
    /// Returns the current mode of this thread.
    #[inline]
    pub fn now() -> Self {
        FloatMode(register::read() & register::CONTROL)
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
    /// Errors logged without a world during [`capture_errors`], for functions that cannot return an error.
    static CAPTURED_ERRORS: RefCell<Option<Vec<String>>> = const { RefCell::new(None) };
}

/// Calls a function without an error object, and returns the errors that were logged on this thread during the call.
/// The host reports them, with the name of the function.
pub fn capture_errors<T>(f: impl FnOnce() -> T) -> (T, Vec<String>) {
    let outer = CAPTURED_ERRORS.replace(Some(Vec::new()));
    let done = f();
    (done, CAPTURED_ERRORS.replace(outer).unwrap_or_default())
}
/// Records an error that a plugin logs; returns whether errors are being captured. The number is limited, in case a
/// plugin logs endlessly.
pub fn capture_error(text: &str) -> bool {
    CAPTURED_ERRORS.with_borrow_mut(|said| {
        let Some(said) = said else { return false };
        if said.len() < 64 {
            said.push(text.to_owned());
        }
        true
    })
}

/// Calls a plugin; returns which part of the thread state it changed, after restoring that state.
#[inline]
pub fn call_and_restore<T>(f: impl FnOnce() -> T) -> (T, Option<&'static str>) {
    let before = FloatMode::now();
    let done = f();
    let (turned, moved) = (clear_direction(), before.restore());
    end_if_child();
    let what = match (turned, moved) {
        (false, false) => None,
        (true, _) => Some(DIRECTION_TEXT),
        (false, true) => Some(MODE_TEXT),
    };
    (done, what)
}

/// Whether this process is a copy of the program that was created by a fork within a plugin's call.
static IS_CHILD: AtomicBool = AtomicBool::new(false);

/// Marks this process as a forked copy, which ends when the plugin's call returns.
pub fn mark_as_child() {
    IS_CHILD.store(true, Relaxed);
}

/// Ends the process after a plugin's call, if it is a forked copy.
#[inline]
pub fn end_if_child() {
    if IS_CHILD.load(Relaxed) {
        end_child();
    }
}

/// Ends a forked copy of the process. The copy has only one thread, so it would wait forever for the others, and it
/// could write to the program's files.
#[cold]
fn end_child() {
    #[cfg(unix)]
    // SAFETY: `_exit` does not return, and runs no handlers of this process.
    unsafe {
        libc::_exit(1)
    };
}

/// Sets this thread's floating-point mode to the default of a new process: rounding to nearest, subnormal numbers
/// enabled, traps disabled.
pub fn set_default_mode() {
    #[cfg(target_arch = "x86_64")]
    register::write(0x1f80);
    #[cfg(target_arch = "aarch64")]
    register::write(0);
}

/// Whether the process is shared with other code; see [`share_process`].
static IS_SHARED: AtomicBool = AtomicBool::new(false);

/// Declares that the process is shared with other code, such as an interpreter, which can change its locale, working
/// folder and signal handlers at any time. From then on, only the state of threads is checked and restored.
pub fn share_process() {
    IS_SHARED.store(true, Relaxed);
}

/// A state of a thread and of the process that is known to be good, for comparison and restoration.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ProcessState {
    mode: FloatMode,
    old: u16,
    locale: Option<CString>,
    process: process::OsState,
}

impl ProcessState {
    /// Captures the current state of this thread and of the process.
    pub fn now() -> Self {
        ProcessState {
            mode: FloatMode::now(),
            old: register::read_old(),
            locale: with_locale(|l| l.map(CStr::to_owned)),
            process: process::OsState::now(),
        }
    }
    /// Accepts the current process state, after the program itself has changed it.
    pub fn recapture_process(&mut self) {
        self.process = process::OsState::now();
    }
    /// Restores the state; describes what had been changed.
    pub fn restore(&self) -> Option<String> {
        let mut changed: Vec<String> = self.restore_quickly().map(str::to_owned).into_iter().collect();
        if !IS_SHARED.load(Relaxed) {
            changed.extend(self.process.restore());
        }
        (!changed.is_empty()).then(|| changed.join(" and "))
    }
    /// Like `restore`, but only for the parts that need no system call.
    pub fn restore_quickly(&self) -> Option<&'static str> {
        let mut changed = self.mode.restore();
        if register::read_old() != self.old {
            register::write_old(self.old);
            changed = true;
        }
        let moved = !IS_SHARED.load(Relaxed) && !with_locale(|l| l == self.locale.as_deref());
        if moved {
            set_locale(self.locale.as_deref());
        }
        match (changed, moved) {
            (true, true) => Some(MODE_AND_LOCALE_TEXT),
            (true, false) => Some(MODE_TEXT),
            (false, true) => Some("the locale of the process"),
            (false, false) => None,
        }
    }
}

/// Name of the floating-point mode, for messages about changes.
pub const MODE_TEXT: &str = "the floating-point mode";
/// Name of the direction flag, for messages about changes.
pub const DIRECTION_TEXT: &str = "the direction flag of the processor";
const MODE_AND_LOCALE_TEXT: &str = "the floating-point mode and the locale of the process";
/// The hint in messages about changed state.
pub const RESTORED_HELP: &str = "it was restored; build the plugin without `-ffast-math`, and without calls to setlocale, fesetround, chdir, \
                        sigaction and the like";

#[cfg(unix)]
fn with_locale<T>(f: impl FnOnce(Option<&CStr>) -> T) -> T {
    // SAFETY: a null argument only queries the locale. The returned text belongs to the C library and is valid until
    // the next change, so it is used only during `f`.
    unsafe {
        let text = libc::setlocale(libc::LC_ALL, std::ptr::null());
        f((!text.is_null()).then(|| CStr::from_ptr(text)))
    }
}
#[cfg(unix)]
fn set_locale(to: Option<&CStr>) {
    if let Some(to) = to {
        // SAFETY: `to` is NUL-terminated, and was returned by `setlocale`.
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

    /// The bits "flush to zero" and "denormals are zero", which `-ffast-math` libraries set (Intel SDM, volume 1,
    /// 10.2.3).
    const FAST_MATH_BITS: u64 = 0x8040;

    #[test]
    fn changed_floating_point_mode_is_restored() {
        let before = FloatMode::now();
        let ((), changed) = call_and_restore(|| register::write(before.0 | FAST_MATH_BITS));
        assert_eq!(changed, Some(MODE_TEXT));
        assert_eq!(FloatMode::now(), before);
        let done = call_and_restore(|| std::hint::black_box(1.0f64) / std::hint::black_box(3.0));
        assert_eq!(done.1, None, "flags are no mode");
    }

    #[test]
    fn changed_x87_control_word_is_restored() {
        let home = ProcessState::now();
        assert_eq!(home.restore(), None);
        register::write_old(home.old & !0x300);
        assert_eq!(home.restore().as_deref(), Some(MODE_TEXT));
        assert_eq!(ProcessState::now(), home);
    }
}
