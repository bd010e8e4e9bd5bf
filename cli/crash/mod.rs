//! Faults that end the process: a crash, or a plugin that calls `exit`. The plugin, its function and the instance are
//! named, and what was printed and traced so far is written.
//!
//! A crash stops one thread in a signal handler, where nearly nothing is allowed. So the handler only notes what it knows,
//! wakes a thread that waits for nothing else, and gives it some time; then the process ends by the same signal, for
//! shells, debuggers and core files. `blame` finds the words.
//!
//! Native stack overflow is seen because every thread of the program has another stack for signals: Rust's standard
//! library makes one for each thread that it starts. Threads that a plugin starts by other means have none; an overflow
//! there ends the program without a word. Nothing of this is done on other systems than Linux.

mod blame;

use std::{
    io::{self, IsTerminal},
    process::ExitCode,
    sync::{
        atomic::{
            AtomicBool, AtomicI32, AtomicPtr, AtomicUsize,
            Ordering::{Acquire, Relaxed, Release},
        },
        mpsc,
    },
    time::Duration,
};

use libc::{c_int, c_void};
use tatu_core::{
    errors::{Fault, FaultKind},
    plugins::{
        guard,
        watchdog::{Call, Stuck, Watch, here},
    },
};

use self::blame::Crash;
use crate::watchdog::{self, leave};

/// Faults of the processor, and `abort`; then signals that end a process mutely, which only a plugin or another process can have
/// asked for. Ctrl-C and SIGTERM have a handler of their own.
const SIGNALS: [c_int; 15] = [
    libc::SIGSEGV,
    libc::SIGBUS,
    libc::SIGFPE,
    libc::SIGILL,
    libc::SIGABRT,
    libc::SIGALRM,
    libc::SIGVTALRM,
    libc::SIGPROF,
    libc::SIGUSR1,
    libc::SIGUSR2,
    libc::SIGTRAP,
    libc::SIGSYS,
    libc::SIGXCPU,
    libc::SIGIO,
    libc::SIGSTKFLT,
];
/// The system reports an address with these.
const FAULTS: [c_int; 4] = [libc::SIGSEGV, libc::SIGBUS, libc::SIGFPE, libc::SIGILL];
/// Callers of the instruction that crashed, at most.
const FRAMES: usize = 24;
/// How long the handler waits for the words, in parts of this many.
const PARTS: u32 = 300;
const PART_NS: libc::c_long = 10_000_000;
/// How long the end of the process waits for one who has crashed.
const LONGEST: Duration = Duration::from_secs(4);
/// Bytes of a stack for signals where the thread has none.
const STACK: usize = 64 << 10;

/// The process that handlers were installed in: a child that a plugin forks inherits them, and dies by itself.
static PROCESS: AtomicI32 = AtomicI32::new(0);
/// The end of the pipe that the handler writes to.
static WAKE: AtomicI32 = AtomicI32::new(-1);
/// A thread has crashed, or a plugin has called `exit`: the rest is for it alone.
static TAKEN: AtomicBool = AtomicBool::new(false);
/// Everything has been reported.
static TOLD: AtomicBool = AtomicBool::new(false);

// What the handler notes.
static SIGNAL: AtomicI32 = AtomicI32::new(0);
static THREAD: AtomicI32 = AtomicI32::new(0);
/// The process that sent the signal, if another one did.
static SENDER: AtomicI32 = AtomicI32::new(0);
static AT: AtomicPtr<Watch> = AtomicPtr::new(std::ptr::null_mut());
/// The address that could not be accessed, the instruction, and the stack.
static ADDRESS: AtomicUsize = AtomicUsize::new(0);
static INSTRUCTION: AtomicUsize = AtomicUsize::new(0);
static STACK_AT: AtomicUsize = AtomicUsize::new(0);
/// The callers stand in `CALLERS`, as far as they were found.
static NOTED: AtomicBool = AtomicBool::new(false);
/// Where the thread was, and its callers.
static CALLERS: [AtomicUsize; FRAMES] = [const { AtomicUsize::new(0) }; FRAMES];

/// Begins to watch. What cannot be installed only leaves a crash without words.
pub fn listen() {
    let mut ends = [0; 2];
    // SAFETY: room for two numbers.
    if unsafe { libc::pipe2(ends.as_mut_ptr(), libc::O_CLOEXEC) } != 0 {
        return;
    }
    let [read, write] = ends;
    WAKE.store(write, Relaxed);
    PROCESS.store(std::process::id().cast_signed(), Relaxed);
    let (ready, waits) = mpsc::channel();
    let run = move || wait(read, &ready);
    // A thread that begins takes locks of the system's loader, which a crash in a constructor would hold.
    if std::thread::Builder::new().name("crashes".into()).spawn(run).is_err() || waits.recv().is_err() {
        return;
    }
    give_stack();
    // SAFETY: a structure of numbers and pointers, for which zero is a value; the handler has the type that SA_SIGINFO
    // tells, and does only what is allowed in one.
    unsafe {
        let mut action: libc::sigaction = std::mem::zeroed();
        let handler: extern "C" fn(c_int, *mut libc::siginfo_t, *mut c_void) = caught;
        action.sa_sigaction = handler as usize;
        // Looking for callers may crash, too: then this is entered again, and ends the process.
        action.sa_flags = libc::SA_SIGINFO | libc::SA_ONSTACK | libc::SA_NODEFER;
        libc::sigemptyset(&raw mut action.sa_mask);
        for signal in SIGNALS {
            let mut before: libc::sigaction = std::mem::zeroed();
            libc::sigaction(signal, std::ptr::null(), &raw mut before);
            // Signals that the parent process set to be ignored stay ignored.
            if before.sa_sigaction != libc::SIG_IGN {
                libc::sigaction(signal, &raw const action, std::ptr::null_mut());
            }
        }
        // Exceeding the file size limit should fail the write, not kill the process.
        libc::signal(libc::SIGXFSZ, libc::SIG_IGN);
        libc::atexit(exited);
        libc::pthread_atfork(None, Some(forked), Some(is_child));
        // The first call loads a library, which is not allowed in a signal handler.
        let mut one = [std::ptr::null_mut(); 1];
        backtrace(one.as_mut_ptr(), 1);
    }
}

unsafe extern "C" {
    /// Of the C library: the callers of this function.
    fn backtrace(frames: *mut *mut c_void, n: c_int) -> c_int;
}

/// A stack for signals for this thread, should the standard library have made none.
fn give_stack() {
    // SAFETY: asks for the present one, then hands over memory that is never freed.
    unsafe {
        let mut now: libc::stack_t = std::mem::zeroed();
        if libc::sigaltstack(std::ptr::null(), &raw mut now) == 0 && now.ss_flags & libc::SS_DISABLE != 0 {
            let room = Box::leak(vec![0_u8; STACK].into_boxed_slice());
            let new = libc::stack_t { ss_sp: room.as_mut_ptr().cast(), ss_flags: 0, ss_size: STACK };
            libc::sigaltstack(&raw const new, std::ptr::null_mut());
        }
    }
}

/// The handler. Only functions that POSIX allows in one, atomics, and a thread-local without a destructor.
extern "C" fn caught(signal: c_int, info: *mut libc::siginfo_t, context: *mut c_void) {
    // SAFETY: the system gives both, and these functions may be called here.
    unsafe {
        if libc::getpid() == PROCESS.load(Relaxed) {
            if !TAKEN.swap(true, Acquire) {
                note(signal, &*info, context);
                let (wake, byte) = (WAKE.load(Relaxed), 1_u8);
                if wake >= 0 {
                    libc::write(wake, (&raw const byte).cast(), 1);
                    note_callers();
                }
            }
            // Another thread that crashes meanwhile waits, too: the first one ends the process.
            let part = libc::timespec { tv_sec: 0, tv_nsec: PART_NS };
            for _ in 0..PARTS {
                if TOLD.load(Acquire) {
                    break;
                }
                libc::nanosleep(&raw const part, std::ptr::null_mut());
            }
        }
        // The signal is held back until this returns, and then ends the process where it crashed.
        libc::signal(signal, libc::SIG_DFL);
        libc::raise(signal);
    }
}

/// Keeps what only this thread knows.
///
/// # Safety
/// Both are what the system gave the handler.
unsafe fn note(signal: c_int, info: &libc::siginfo_t, context: *mut c_void) {
    SIGNAL.store(signal, Relaxed);
    AT.store(here().cast_mut(), Relaxed);
    // SAFETY: gettid has no conditions; the fields belong to these sorts of signals; the context is one of this
    // architecture.
    unsafe {
        THREAD.store(libc::gettid(), Relaxed);
        if info.si_code <= 0 {
            // Another process, whose number may lie beyond what this one can see; `raise` and timers are this one's.
            let own = info.si_code == libc::SI_TIMER || info.si_pid() == libc::getpid();
            SENDER.store(if own { 0 } else { info.si_pid().max(1) }, Relaxed);
        } else if info.si_code > 0 && FAULTS.contains(&signal) {
            ADDRESS.store(info.si_addr() as usize, Relaxed);
        }
        let (instruction, stack) = registers(&(*context.cast::<libc::ucontext_t>()).uc_mcontext);
        INSTRUCTION.store(instruction, Relaxed);
        STACK_AT.store(stack, Relaxed);
    }
}

/// Searches for the callers once the rest has been handed over: whatever happens here, that is reported.
///
/// # Safety
/// In the handler, after `note`.
unsafe fn note_callers() {
    // SAFETY: the watch of this thread is there as long as its call; room for as many addresses.
    unsafe {
        let stack = STACK_AT.load(Relaxed);
        // Where the stack is used up, and while a library is loaded, looking for callers could crash or wait for ever.
        let deep = ADDRESS.load(Relaxed).abs_diff(stack) < blame::NEAR && ADDRESS.load(Relaxed) != 0;
        let loads = here().as_ref().is_some_and(|watch| watch.call() == Some(Call::Load));
        if !deep && !loads {
            let mut frames = [std::ptr::null_mut(); FRAMES];
            let n = backtrace(frames.as_mut_ptr(), FRAMES as c_int).clamp(0, FRAMES as c_int) as usize;
            for (to, from) in CALLERS.iter().zip(&frames[..n]) {
                to.store(*from as usize, Relaxed);
            }
        }
    }
    NOTED.store(true, Release);
}

/// Where the thread was, and its stack.
#[cfg(target_arch = "x86_64")]
fn registers(of: &libc::mcontext_t) -> (usize, usize) {
    (of.gregs[libc::REG_RIP as usize] as usize, of.gregs[libc::REG_RSP as usize] as usize)
}
#[cfg(target_arch = "aarch64")]
fn registers(of: &libc::mcontext_t) -> (usize, usize) {
    (of.pc as usize, of.sp as usize)
}
#[cfg(not(any(target_arch = "x86_64", target_arch = "aarch64")))]
fn registers(_: &libc::mcontext_t) -> (usize, usize) {
    (0, 0)
}

/// Waits for a crash and reports it.
fn wait(read: c_int, ready: &mpsc::Sender<()>) {
    // A signal from outside goes to a thread that can wait for this one, and a crash here ends the process at once.
    // SAFETY: a set of numbers, filled before it is used; one byte has room in `byte`.
    unsafe {
        let mut all: libc::sigset_t = std::mem::zeroed();
        libc::sigfillset(&raw mut all);
        libc::pthread_sigmask(libc::SIG_BLOCK, &raw const all, std::ptr::null_mut());
        if ready.send(()).is_err() {
            return;
        }
        let mut byte = 0_u8;
        loop {
            match libc::read(read, (&raw mut byte).cast(), 1) {
                1 => break,
                n if n < 0 && io::Error::last_os_error().kind() == io::ErrorKind::Interrupted => {}
                _ => return tell_closed(),
            }
        }
    }
    let mut crash = Crash {
        signal: SIGNAL.load(Relaxed),
        thread: THREAD.load(Relaxed),
        sender: SENDER.load(Relaxed),
        address: ADDRESS.load(Relaxed),
        instruction: INSTRUCTION.load(Relaxed),
        stack: STACK_AT.load(Relaxed),
        call: running(AT.load(Relaxed)),
        callers: Vec::new(),
    };
    let mut fault = Fault::new(FaultKind::Crash, blame::of_crash(&crash));
    if crash.sender == 0 || crash.sender == PROCESS.load(Relaxed) {
        fault.help = Some(blame::HELP.to_owned());
    }
    tell(fault, crash.call.as_ref());
    // From here on nothing is lost if the thread that crashed holds a lock, or what is looked at is damaged.
    for _ in 0..50 {
        if NOTED.load(Acquire) {
            crash.callers = CALLERS.iter().map(|c| c.load(Relaxed)).take_while(|c| *c != 0).collect();
            break;
        }
        std::thread::sleep(Duration::from_millis(10));
    }
    for line in blame::frames(&crash) {
        write_line(&format!("  {line}\n"));
    }
    // SAFETY: the thread that runs the script stands in the handler.
    if let Some((file, line)) = crash.call.as_ref().and_then(|call| unsafe { call.script.ask() }) {
        write_line(&format!("  called by the script at {file}:{line}\n"));
    }
    TOLD.store(true, Release);
}

/// The pipe is gone, which the program never closes.
fn tell_closed() {
    WAKE.store(-1, Relaxed);
    let call = watchdog::current().and_then(|run| run.watches.any_running());
    tatu_core::breach(blame::of_closed(call.as_ref()));
}

/// The call that runs on the thread with this watch.
fn running(at: *const Watch) -> Option<Stuck> {
    watchdog::current()?.watches.running(at)
}

/// Writes the line first, since anything else may wait for what the crashed thread holds; then all that was held back.
/// The exit code for it.
fn tell(mut fault: Fault, call: Option<&Stuck>) -> i32 {
    if let Some(call) = call {
        (fault.plugin, fault.object) = (blame::id(call), call.object.clone());
    }
    let help = fault.help.as_ref().map_or(String::new(), |help| format!(" ({help})"));
    // A progress bar may stand in the line.
    let clear = if io::stderr().is_terminal() { "\r\x1b[K" } else { "" };
    let line = format!("{clear}error[{}]: {}{help}\n", fault.code, fault.message);
    write_line(&line);
    let code = watchdog::current().map_or(2, |run| run.close(&fault));
    // What plugins in C printed.
    // SAFETY: null stands for all files of the C library.
    unsafe { libc::fflush(std::ptr::null_mut()) };
    code
}

/// Not through the standard library, whose lock may be held.
fn write_line(line: &str) {
    // SAFETY: so many bytes of the line.
    unsafe { libc::write(libc::STDERR_FILENO, line.as_ptr().cast(), line.len()) };
}

/// After a fork, in the process that goes on: within a plugin's call that is the plugin's fault.
extern "C" fn forked() {
    if let Some(call) = running(here()) {
        write_line(&format!("warning: {}\n", blame::of_fork(&call)));
    }
}

/// After a fork, in the copy: it has one thread and no world of its own, and must not come back from the plugin's call.
extern "C" fn is_child() {
    guard::this_is_a_child();
}

/// The program ends: what libraries left to be done then must not hold it for ever. There is no way to take it back, and no
/// call that could be named.
pub fn end(code: ExitCode) -> ExitCode {
    let failed = code != ExitCode::SUCCESS;
    let late = move || {
        std::thread::sleep(LONGEST);
        let text = format!(
            "the program has ended, but an exit handler (`atexit`, a destructor) of a plugin or of one of its \
             libraries has not returned for {} s",
            LONGEST.as_secs()
        );
        write_line(&format!("error[{}]: {text}\n", Fault::new(FaultKind::Stuck, "").code));
        leave(if failed { 2 } else { 1 });
    };
    // Without a thread for it nobody watches.
    let _ = std::thread::Builder::new().name("ending".into()).spawn(late);
    code
}

/// At the end of the process, on the thread that ends it: from within a plugin's call that is the plugin's fault.
extern "C" fn exited() {
    // SAFETY: these have no conditions.
    let (process, thread) = unsafe { (libc::getpid(), libc::gettid()) };
    if process != PROCESS.load(Relaxed) {
        return;
    }
    let call = running(here());
    // The program ends on its first thread.
    let in_order = call.is_none() && thread == process;
    let taken = if in_order { TAKEN.load(Acquire) } else { TAKEN.swap(true, Acquire) };
    if taken {
        // Another thread has crashed, and ends the process as soon as that is reported.
        std::thread::sleep(LONGEST);
    }
    if in_order || taken {
        return;
    }
    let mut fault = Fault::new(FaultKind::Exit, blame::of_exit(call.as_ref(), thread));
    fault.help = Some("a plugin must return an error instead".into());
    leave(tell(fault, call.as_ref()));
}
