//! The functions that replace those of the C library, and their installation.

use std::{
    ffi::CString,
    path::Path,
    sync::atomic::{AtomicUsize, Ordering::Relaxed},
};

use libc::c_void;

use super::{
    allocations, clocks, redirect,
    rules::{ASSETS, PLUGIN, Rule, report},
};

type Function = extern "C" fn(usize, usize, usize, usize, usize, usize) -> usize;

macro_rules! watched {
    ($($name:ident: $rule:expr,)*) => {
        /// The watched functions whose arguments and results are integers and pointers.
        #[allow(non_camel_case_types, clippy::upper_case_acronyms, reason = "these are names of C functions")]
        #[repr(usize)]
        enum Watched { $($name),* }
        const WATCHED: &[(&str, Rule, Function)] = &[$((stringify!($name), $rule, relay::<{ Watched::$name as usize }>)),*];
    };
}

watched! {
    fork: Rule::Process, vfork: Rule::Process, posix_spawn: Rule::Process, posix_spawnp: Rule::Process,
    system: Rule::Process, popen: Rule::Process, execv: Rule::Process, execve: Rule::Process, execvp: Rule::Process,
    daemon: Rule::Process,
    setenv: Rule::Settings, putenv: Rule::Settings, unsetenv: Rule::Settings, clearenv: Rule::Settings,
    umask: Rule::Settings, chdir: Rule::Settings, fchdir: Rule::Settings, chroot: Rule::Settings,
    setlocale: Rule::Settings, signal: Rule::Settings, sigprocmask: Rule::Settings, pthread_sigmask: Rule::Settings,
    alarm: Rule::Settings, setitimer: Rule::Settings, setrlimit: Rule::Settings, setrlimit64: Rule::Settings,
    nice: Rule::Settings, setpriority: Rule::Settings, sched_setaffinity: Rule::Settings,
    sched_setscheduler: Rule::Settings, setuid: Rule::Settings, setgid: Rule::Settings, mallopt: Rule::Settings,
    mlockall: Rule::Settings, feenableexcept: Rule::Settings,
    sleep: Rule::Sleep, usleep: Rule::Sleep, nanosleep: Rule::Sleep, clock_nanosleep: Rule::Sleep,
    thrd_sleep: Rule::Sleep, pause: Rule::Sleep, sigwait: Rule::Sleep, getchar: Rule::Sleep,
    poll: Rule::Poll(2), epoll_wait: Rule::Poll(3),
    rand: Rule::Random, srand: Rule::Random, random: Rule::Random, srandom: Rule::Random, lrand48: Rule::Random,
    mrand48: Rule::Random, srand48: Rule::Random, arc4random: Rule::Random, arc4random_uniform: Rule::Random,
    times: Rule::Clock, getrusage: Rule::Clock, localtime: Rule::Clock, localtime_r: Rule::Clock,
    getpid: Rule::Identity, getppid: Rule::Identity, gettid: Rule::Identity, getuid: Rule::Identity,
    gethostname: Rule::Identity, uname: Rule::Identity, getlogin: Rule::Identity, getenv: Rule::Identity,
    secure_getenv: Rule::Identity, getcwd: Rule::Identity, sched_getcpu: Rule::Identity,
    sysinfo: Rule::Identity, get_nprocs: Rule::Identity, getloadavg: Rule::Identity,
    pthread_create: Rule::Thread, thrd_create: Rule::Thread,
    open: Rule::File(0), open64: Rule::File(0), openat: Rule::File(1), openat64: Rule::File(1), creat: Rule::File(0),
    fopen: Rule::File(0), fopen64: Rule::File(0), freopen: Rule::File(0), opendir: Rule::File(0), stat: Rule::File(0),
    access: Rule::File(0), remove: Rule::File(0), unlink: Rule::File(0), rename: Rule::File(0), mkdir: Rule::File(0),
    socket: Rule::Socket, connect: Rule::Socket, getaddrinfo: Rule::Socket,
}

/// Addresses of the original functions, in the order of [`WATCHED`].
static ORIGINALS: [AtomicUsize; WATCHED.len()] = [const { AtomicUsize::new(0) }; WATCHED.len()];
/// Reports a call of the function with this index in [`WATCHED`] if a rule forbids it, and calls the original.
extern "C" fn relay<const N: usize>(a: usize, b: usize, c: usize, d: usize, e: usize, f: usize) -> usize {
    let (name, rule, _) = WATCHED[N];
    report(name, rule, [a, b, c, d, e, f]);
    match name {
        // A child process would run the rest of the test a second time.
        "fork" | "vfork" | "daemon" => {
            // SAFETY: the location of `errno` is valid on every thread.
            unsafe { *libc::__errno_location() = libc::EAGAIN };
            usize::MAX
        }
        _ => {
            // SAFETY: the address is that of the C library's function, stored before the plugin could call this one. It
            // gets the arguments of the plugin's call; those that it does not have are ignored by the calling
            // convention.
            let original: Function = unsafe { std::mem::transmute(ORIGINALS[N].load(Relaxed)) };
            original(a, b, c, d, e, f)
        }
    }
}

/// The functions with results in floating-point registers.
extern "C" fn drand48() -> f64 {
    report("drand48", Rule::Random, [0; 6]);
    // SAFETY: the function has no arguments and no preconditions.
    unsafe { libc::drand48() }
}

/// The base names of the libraries that are loaded now, by which those that a plugin needs can be recognized later.
pub struct LoadedBefore(Vec<String>);

impl LoadedBefore {
    /// Lists the libraries that are loaded now.
    pub fn now() -> Self {
        LoadedBefore(redirect::loaded_libraries().into_iter().map(|l| l.name).collect())
    }
}

/// Begins to watch a plugin with this index, whose library has this base name. `assets` is the path of its assets.
pub fn watch(plugin: usize, library: &str, before: &LoadedBefore, assets: &Path) {
    let original = |name: &str| {
        let name = CString::new(name).ok()?;
        // SAFETY: `dlsym` only reads the name.
        let at = unsafe { libc::dlsym(libc::RTLD_DEFAULT, name.as_ptr()) };
        (!at.is_null()).then_some(at.addr())
    };
    let mut doubles: Vec<(&str, *const c_void)> = Vec::new();
    for (i, (name, _, function)) in WATCHED.iter().enumerate() {
        if let Some(at) = original(name) {
            ORIGINALS[i].store(at, Relaxed);
            doubles.push((name, *function as *const c_void));
        }
    }
    doubles.push(("drand48", drand48 as *const c_void));
    doubles.extend(clocks::doubles());
    let memory = allocations::doubles();
    doubles.extend(memory);
    let _ = ASSETS.set(assets.display().to_string());
    PLUGIN.store(plugin + 1, Relaxed);
    for loaded in redirect::loaded_libraries() {
        // Plugins of the program are watched only if they are under test.
        let is_new = !before.0.contains(&loaded.name) && !loaded.name.contains("tatu_");
        if is_new || loaded.name.contains(library) {
            redirect::redirect(&loaded, &doubles);
        } else if loaded.name.starts_with("libstdc++") {
            // Templates that are compiled into the plugin release memory that this library has allocated, and vice
            // versa.
            redirect::redirect(&loaded, &memory);
        }
    }
}
