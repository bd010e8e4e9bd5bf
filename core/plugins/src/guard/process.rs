//! State of the process that takes system calls to read: the working folder, signal actions, standard output
//! and error.

#[cfg(unix)]
pub use unix::State;

/// Nothing is checked on this system.
#[cfg(not(unix))]
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct State;

#[cfg(not(unix))]
impl State {
    pub fn now() -> Self {
        State
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

    /// Signals that the program, the loader or system libraries use.
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

    /// An open file or folder: device and number.
    type Identity = Option<(libc::dev_t, libc::ino_t)>;

    /// What the C library adds to the flags of an action that it sets.
    const SA_RESTORER: c_int = 0x0400_0000;

    /// How it was.
    #[derive(Debug, Clone)]
    pub struct State {
        kept: Arc<Kept>,
        folder: Identity,
        outputs: [Identity; OUTPUTS.len()],
        signals: Arc<[libc::sigaction; SIGNALS.len()]>,
    }

    impl PartialEq for State {
        fn eq(&self, other: &Self) -> bool {
            (self.folder, self.outputs) == (other.folder, other.outputs)
                && self.signals.iter().zip(other.signals.iter()).all(|(a, b)| same(a, b))
        }
    }
    impl Eq for State {}

    /// Folder and outputs, open: what is put back leads there. One for all states that are alike.
    #[derive(Debug)]
    struct Kept {
        ids: (Identity, [Identity; OUTPUTS.len()]),
        folder: Option<File>,
        outputs: [Option<File>; OUTPUTS.len()],
    }

    fn kept(ids: (Identity, [Identity; OUTPUTS.len()])) -> Arc<Kept> {
        static LAST: Mutex<Option<Arc<Kept>>> = Mutex::new(None);
        let mut last = LAST.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(kept) = last.as_ref().filter(|kept| kept.ids == ids) {
            return kept.clone();
        }
        let outputs = OUTPUTS.map(|(fd, _)| copy(fd));
        let kept = Arc::new(Kept { ids, folder: File::open(".").ok(), outputs });
        *last = Some(kept.clone());
        kept
    }

    /// A second descriptor of an open file.
    fn copy(fd: RawFd) -> Option<File> {
        // SAFETY: any number may be asked for; what comes back is ours.
        unsafe {
            let new = libc::fcntl(fd, libc::F_DUPFD_CLOEXEC, 3);
            (new >= 0).then(|| File::from_raw_fd(new))
        }
    }

    fn identity(ask: impl FnOnce(*mut libc::stat) -> c_int) -> Identity {
        // SAFETY: numbers, for which zero is a value.
        let mut about: libc::stat = unsafe { std::mem::zeroed() };
        (ask(&raw mut about) == 0).then_some((about.st_dev, about.st_ino))
    }
    fn folder() -> Identity {
        // SAFETY: a text that ends with 0, and room for the answer.
        identity(|about| unsafe { libc::stat(c".".as_ptr(), about) })
    }
    fn output(fd: RawFd) -> Identity {
        // SAFETY: room for the answer.
        identity(|about| unsafe { libc::fstat(fd, about) })
    }

    fn action(signal: c_int) -> libc::sigaction {
        // SAFETY: numbers and pointers, for which zero is a value; asks only.
        unsafe {
            let mut now: libc::sigaction = std::mem::zeroed();
            libc::sigaction(signal, std::ptr::null(), &raw mut now);
            now
        }
    }
    fn same(a: &libc::sigaction, b: &libc::sigaction) -> bool {
        (a.sa_sigaction, a.sa_flags & !SA_RESTORER) == (b.sa_sigaction, b.sa_flags & !SA_RESTORER)
    }

    impl State {
        /// As it is now.
        pub fn now() -> Self {
            let (folder, outputs) = (folder(), OUTPUTS.map(|(fd, _)| output(fd)));
            State {
                kept: kept((folder, outputs)),
                folder,
                outputs,
                signals: Arc::new(SIGNALS.map(|(signal, _)| action(signal))),
            }
        }

        /// Restores it; returns what had been changed, in words.
        pub fn restore(&self) -> Vec<String> {
            let mut out = Vec::new();
            if folder() != self.folder {
                if let Some(home) = &self.kept.folder {
                    // SAFETY: an open folder.
                    unsafe { libc::fchdir(home.as_raw_fd()) };
                }
                out.push("the working folder of the process".to_owned());
            }
            for (i, (fd, name)) in OUTPUTS.into_iter().enumerate() {
                if output(fd) != self.outputs[i] {
                    if let Some(own) = &self.kept.outputs[i] {
                        // SAFETY: an open file, under the number that it had.
                        unsafe { libc::dup2(own.as_raw_fd(), fd) };
                    }
                    out.push(format!("{name} (closed or exchanged)"));
                }
            }
            for (i, (signal, name)) in SIGNALS.into_iter().enumerate() {
                let was = &self.signals[i];
                if !same(&action(signal), was) {
                    // SAFETY: an action that the same function gave.
                    unsafe { libc::sigaction(signal, was, std::ptr::null_mut()) };
                    out.push(format!("what {name} does"));
                }
            }
            out
        }
    }
}
