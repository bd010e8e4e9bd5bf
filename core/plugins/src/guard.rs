//! What every plugin must leave as it found it: floating-point mode and locale.
//!
//! The mode belongs to a thread: after a library built with `-ffast-math` has been loaded, everything else on that
//! thread computes other results. The locale belongs to the process: with a decimal comma no number can be read any
//! more. Both are restored and the plugin is named. The mode is a read of one register and is looked at around
//! every outermost call; the rest ([`ProcessState`]) after loading, after making instances, and once per stage.

use std::{
    cell::RefCell,
    ffi::{CStr, CString},
};

/// The floating-point mode of this thread: rounding, subnormal numbers, traps; not the flags of past operations.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Mode(u64);

#[cfg(target_arch = "x86_64")]
mod register {
    use core::arch::asm;

    /// The six lowest bits tell of past operations.
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
    /// The control word of the old floating-point unit, which `long double` in C uses.
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

impl Mode {
    /// The mode of this thread now.
    #[inline]
    pub fn now() -> Self {
        Mode(register::read() & register::CONTROL)
    }
    /// Goes back to this mode; whether it had been left.
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
    /// Errors that are logged without a world during [`capture_errors`]: how functions that cannot fail tell that they did.
    static SAID: RefCell<Option<Vec<String>>> = const { RefCell::new(None) };
}

/// Calls a function that has no error object, and gives the errors that were logged on this thread meanwhile: the host
/// tells them, with the name of the function.
pub fn capture_errors<T>(f: impl FnOnce() -> T) -> (T, Vec<String>) {
    let outer = SAID.replace(Some(Vec::new()));
    let done = f();
    (done, SAID.replace(outer).unwrap_or_default())
}
/// Notes an error that a plugin logs; whether somebody hears it. A plugin that logs for ever must not fill the memory.
pub fn say(text: &str) -> bool {
    SAID.with_borrow_mut(|said| {
        let Some(said) = said else { return false };
        if said.len() < 64 {
            said.push(text.to_owned());
        }
        true
    })
}

/// Calls a plugin; whether it left another floating-point mode behind, which has been restored then.
#[inline]
pub fn watched<T>(f: impl FnOnce() -> T) -> (T, bool) {
    let before = Mode::now();
    let done = f();
    (done, before.restore())
}

/// Mode and locale at a time when all was well.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ProcessState {
    mode: Mode,
    old: u16,
    locale: Option<CString>,
}

impl ProcessState {
    /// As it is now.
    pub fn now() -> Self {
        ProcessState { mode: Mode::now(), old: register::read_old(), locale: with_locale(|l| l.map(CStr::to_owned)) }
    }
    /// Goes back to it; what had been changed, in words.
    pub fn restore(&self) -> Option<&'static str> {
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
const BOTH: &str = "the floating-point mode and the locale of the process";
/// What to do about it, for messages.
pub const HELP: &str =
    "it was put back; build the plugin without `-ffast-math`, and without calls of setlocale, fesetround and the like";

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
        assert!(changed);
        assert_eq!(Mode::now(), before);
        assert!(!watched(|| std::hint::black_box(1.0f64) / std::hint::black_box(3.0)).1, "flags are no mode");
    }

    #[test]
    fn home_knows_the_old_unit_too() {
        let home = ProcessState::now();
        assert_eq!(home.restore(), None);
        register::write_old(home.old & !0x300);
        assert_eq!(home.restore(), Some(MODE));
        assert_eq!(ProcessState::now(), home);
    }
}
