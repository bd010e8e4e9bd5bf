//! Process state that requires system calls to read: the working folder, signal actions, standard output and standard
//! error.

#[cfg(unix)]
pub use unix::OsState;

/// An empty state: on this system, nothing is checked.
#[cfg(not(unix))]
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct OsState;

#[cfg(not(unix))]
impl OsState {
    pub fn now() -> Self {
        OsState
    }
    pub fn restore(&self) -> Vec<String> {
        Vec::new()
    }
}

#[cfg(unix)]
mod unix {
    use std::{
        fs::File,
        os::fd::BorrowedFd,
        sync::{Arc, Mutex, PoisonError},
    };

    use libc::c_int;
    use rustix::{
        fs::{Stat, fstat, stat},
        io::{Errno, fcntl_dupfd_cloexec},
        process::fchdir,
        stdio,
    };

    /// Signals used by the program, the loader or system libraries.
    const SIGNALS: [(c_int, &str); 15] = [
        (libc::SIGABRT, "SIGABRT"),
        (libc::SIGALRM, "SIGALRM"),
        (libc::SIGBUS, "SIGBUS"),
        (libc::SIGCHLD, "SIGCHLD"),
        (libc::SIGFPE, "SIGFPE"),
        (libc::SIGHUP, "SIGHUP"),
        (libc::SIGILL, "SIGILL"),
        (libc::SIGINT, "SIGINT"),
        (libc::SIGPIPE, "SIGPIPE"),
        (libc::SIGSEGV, "SIGSEGV"),
        (libc::SIGTERM, "SIGTERM"),
        (libc::SIGTRAP, "SIGTRAP"),
        (libc::SIGUSR1, "SIGUSR1"),
        (libc::SIGUSR2, "SIGUSR2"),
        (libc::SIGXFSZ, "SIGXFSZ"),
    ];

    /// An output of the process, and how to replace it by a duplicate of another file.
    struct Output {
        name: &'static str,
        fd: fn() -> BorrowedFd<'static>,
        replace: fn(&File) -> Result<(), Errno>,
    }
    const OUTPUTS: [Output; 2] = [
        Output { name: "standard output", fd: stdio::stdout, replace: |own| stdio::dup2_stdout(own) },
        Output { name: "standard error", fd: stdio::stderr, replace: |own| stdio::dup2_stderr(own) },
    ];

    /// Identity of an open file or folder: device and inode.
    type Identity = Option<(u64, u64)>;

    /// A flag that the C library adds to an action when it sets it.
    const SA_RESTORER: c_int = 0x0400_0000;

    /// A state of the process that is known to be good, for comparison and restoration.
    #[derive(Debug, Clone)]
    pub struct OsState {
        handles: Arc<OpenHandles>,
        folder: Identity,
        outputs: [Identity; OUTPUTS.len()],
        signals: Arc<[libc::sigaction; SIGNALS.len()]>,
    }

    impl PartialEq for OsState {
        fn eq(&self, other: &Self) -> bool {
            (self.folder, self.outputs) == (other.folder, other.outputs)
                && self.signals.iter().zip(other.signals.iter()).all(|(a, b)| same(a, b))
        }
    }
    impl Eq for OsState {}

    /// Open handles of the working folder and the outputs, used to restore them. Equal states share these handles.
    #[derive(Debug)]
    struct OpenHandles {
        ids: (Identity, [Identity; OUTPUTS.len()]),
        folder: Option<File>,
        outputs: [Option<File>; OUTPUTS.len()],
    }

    fn open_handles(ids: (Identity, [Identity; OUTPUTS.len()])) -> Arc<OpenHandles> {
        static LAST: Mutex<Option<Arc<OpenHandles>>> = Mutex::new(None);
        let mut last = LAST.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(kept) = last.as_ref().filter(|kept| kept.ids == ids) {
            return kept.clone();
        }
        let outputs = OUTPUTS.map(|output| fcntl_dupfd_cloexec((output.fd)(), 3).ok().map(File::from));
        let kept = Arc::new(OpenHandles { ids, folder: File::open(".").ok(), outputs });
        *last = Some(kept.clone());
        kept
    }

    #[allow(clippy::useless_conversion, reason = "the widths of these numbers depend on the system")]
    fn identity(about: Result<Stat, Errno>) -> Identity {
        about.ok().map(|about| (u64::try_from(about.st_dev).unwrap_or(0), u64::from(about.st_ino)))
    }
    fn folder() -> Identity {
        identity(stat("."))
    }
    fn identity_of(output: &Output) -> Identity {
        identity(fstat((output.fd)()))
    }

    fn action(signal: c_int) -> libc::sigaction {
        // SAFETY: `sigaction` is a plain struct, for which zeros are valid; with a null action the call only queries.
        unsafe {
            let mut now: libc::sigaction = std::mem::zeroed();
            libc::sigaction(signal, std::ptr::null(), &raw mut now);
            now
        }
    }
    fn same(a: &libc::sigaction, b: &libc::sigaction) -> bool {
        (a.sa_sigaction, a.sa_flags & !SA_RESTORER) == (b.sa_sigaction, b.sa_flags & !SA_RESTORER)
    }

    impl OsState {
        /// Captures the current state.
        pub fn now() -> Self {
            let (folder, outputs) = (folder(), OUTPUTS.map(|output| identity_of(&output)));
            OsState {
                handles: open_handles((folder, outputs)),
                folder,
                outputs,
                signals: Arc::new(SIGNALS.map(|(signal, _)| action(signal))),
            }
        }

        /// Restores the state; describes what had been changed.
        pub fn restore(&self) -> Vec<String> {
            let mut out = Vec::new();
            if folder() != self.folder {
                if let Some(home) = &self.handles.folder {
                    // This fails if the folder no longer exists. The plugin is reported in any case.
                    let _ = fchdir(home);
                }
                out.push("the working folder of the process".to_owned());
            }
            for (i, output) in OUTPUTS.iter().enumerate() {
                if identity_of(output) != self.outputs[i] {
                    if let Some(own) = &self.handles.outputs[i] {
                        // Even if the output cannot be restored, the change is reported.
                        let _ = (output.replace)(own);
                    }
                    out.push(format!("{} (closed or exchanged)", output.name));
                }
            }
            for (i, (signal, name)) in SIGNALS.into_iter().enumerate() {
                let was = &self.signals[i];
                if !same(&action(signal), was) {
                    // SAFETY: `was` points to an action that lives during the call and was returned by `sigaction` for
                    // this signal.
                    unsafe { libc::sigaction(signal, was, std::ptr::null_mut()) };
                    out.push(format!("the action of {name}"));
                }
            }
            out
        }
    }
}
