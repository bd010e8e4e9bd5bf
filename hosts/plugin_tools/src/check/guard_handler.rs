//! Names the guard page at which the plugin under test has crashed.

/// The prefix of the line that reports an access to a guard page.
pub const GUARD_PREFIX: &str = "tatu-guard ";

/// Installs a handler that, on a crash at a guard page, sends the page's label to the parent before the program's own
/// crash report.
pub fn name_guard_pages() {
    #[cfg(unix)]
    handler::install_handlers();
}

#[cfg(unix)]
mod handler {
    use std::sync::OnceLock;

    use libc::{c_int, c_void, siginfo_t};
    use tatu_core::plugins::guarded_copy;

    static PREVIOUS_ACTIONS: OnceLock<[libc::sigaction; 2]> = OnceLock::new();
    const SIGNALS: [c_int; 2] = [libc::SIGSEGV, libc::SIGBUS];

    pub fn install_handlers() {
        // SAFETY: `sigaction` only reads and fills the given structures; the handler has the signature that SA_SIGINFO
        // requires, and calls only async-signal-safe functions.
        unsafe {
            let mut before: [libc::sigaction; 2] = std::mem::zeroed();
            let mut action: libc::sigaction = std::mem::zeroed();
            let handler: extern "C" fn(c_int, *mut siginfo_t, *mut c_void) = handle_signal;
            action.sa_sigaction = handler as usize;
            action.sa_flags = libc::SA_SIGINFO | libc::SA_ONSTACK;
            for (signal, old) in SIGNALS.into_iter().zip(&mut before) {
                libc::sigaction(signal, std::ptr::null(), old);
            }
            if PREVIOUS_ACTIONS.set(before).is_ok() {
                for signal in SIGNALS {
                    libc::sigaction(signal, &raw const action, std::ptr::null_mut());
                }
            }
        }
    }

    extern "C" fn handle_signal(signal: c_int, info: *mut siginfo_t, context: *mut c_void) {
        // SAFETY: the system passes a valid `info`; `write` is async-signal-safe; the previous handler has the
        // signature that its flags state.
        unsafe {
            if let Some((what, label)) = guarded_copy::blame((*info).si_addr().addr()) {
                let newline: &[u8] = b"\n";
                for part in [newline, super::GUARD_PREFIX.as_bytes(), what.as_bytes(), b" ", label.bytes(), newline] {
                    libc::write(super::super::finding::channel(), part.as_ptr().cast(), part.len());
                }
            }
            let before = PREVIOUS_ACTIONS.get().and_then(|all| all.get(usize::from(signal == libc::SIGBUS)));
            let of_program = before.filter(|b| b.sa_flags & libc::SA_SIGINFO != 0 && b.sa_sigaction > 1);
            match of_program {
                Some(b) => {
                    let handler: extern "C" fn(c_int, *mut siginfo_t, *mut c_void) =
                        std::mem::transmute(b.sa_sigaction);
                    handler(signal, info, context);
                }
                None => {
                    libc::signal(signal, libc::SIG_DFL);
                }
            }
        }
    }
}
