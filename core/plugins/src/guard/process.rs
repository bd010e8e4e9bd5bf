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
        os::fd::{AsRawFd, FromRawFd, RawFd},
        sync::{Arc, Mutex, PoisonError},
    };

    use libc::c_int;

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
    const OUTPUTS: [(RawFd, &str); 2] = [(1, "standard output"), (2, "standard error")];

    /// Identity of an open file or folder: device and inode.
    type Identity = Option<(libc::dev_t, libc::ino_t)>;

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
        let outputs = OUTPUTS.map(|(fd, _)| copy(fd));
        let kept = Arc::new(OpenHandles { ids, folder: File::open(".").ok(), outputs });
        *last = Some(kept.clone());
        kept
    }

    /// Duplicates a file descriptor.
    fn copy(fd: RawFd) -> Option<File> {
        // SAFETY: `fcntl` accepts any descriptor, and the new one is owned by nothing else.
        unsafe {
            let new = libc::fcntl(fd, libc::F_DUPFD_CLOEXEC, 3);
            (new >= 0).then(|| File::from_raw_fd(new))
        }
    }

    fn identity(ask: impl FnOnce(*mut libc::stat) -> c_int) -> Identity {
        // SAFETY: `stat` is a plain struct of numbers, for which zeros are valid.
        let mut about: libc::stat = unsafe { std::mem::zeroed() };
        (ask(&raw mut about) == 0).then_some((about.st_dev, about.st_ino))
    }
    fn folder() -> Identity {
        // SAFETY: the path is a NUL-terminated constant, and `about` points to a `stat` that lives during the call.
        identity(|about| unsafe { libc::stat(c".".as_ptr(), about) })
    }
    fn output(fd: RawFd) -> Identity {
        // SAFETY: `about` points to a `stat` that lives during the call; any descriptor is accepted.
        identity(|about| unsafe { libc::fstat(fd, about) })
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
            let (folder, outputs) = (folder(), OUTPUTS.map(|(fd, _)| output(fd)));
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
                    // SAFETY: `home` owns a descriptor of an open folder, which stays open during the call.
                    unsafe { libc::fchdir(home.as_raw_fd()) };
                }
                out.push("the working folder of the process".to_owned());
            }
            for (i, (fd, name)) in OUTPUTS.into_iter().enumerate() {
                if output(fd) != self.outputs[i] {
                    if let Some(own) = &self.handles.outputs[i] {
                        // SAFETY: `own` owns an open descriptor, which stays open during the call; `fd` is replaced by
                        // a duplicate of it.
                        unsafe { libc::dup2(own.as_raw_fd(), fd) };
                    }
                    out.push(format!("{name} (closed or exchanged)"));
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
