//! Handles faults that end the process: a crash, or a plugin that calls `exit`. Reports the plugin, its function and
//! the object, and writes the output and trace so far.
//!
//! A crash is handled in a signal handler, which must call only async-signal-safe functions. Therefore the handler only
//! records data, wakes a dedicated thread, and waits for it for a limited time. Then the process ends by the same
//! signal, as shells and debuggers expect, and so that a core file is written. `blame` composes the message.
//!
//! Native stack overflow is detected because every thread of the program has an alternate signal stack: Rust's standard
//! library creates one for each thread that it starts. Threads started by plugins in other ways have none; an overflow
//! there ends the program without a report. Only Linux is supported.

mod blame;

use std::{
    io::{self, IsTerminal, PipeReader, Read},
    os::fd::IntoRawFd,
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

use self::blame::Crash;
use crate::{
    report::CRASH_HELP,
    stuck_run::{self, leave},
};
use libc::{c_int, c_void};
use tatu_core::{
    errors::{Fault, FaultKind},
    plugins::{
        protected_state,
        watchdog::{CallWatch, PluginCall, StuckCall, current_watch},
    },
};

/// Handled signals: processor faults and `abort`, followed by signals that end a process silently and that only a
/// plugin or another process can cause. Ctrl-C and SIGTERM have separate handlers.
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
/// Signals for which the system reports an address.
const ADDRESS_SIGNALS: [c_int; 4] = [libc::SIGSEGV, libc::SIGBUS, libc::SIGFPE, libc::SIGILL];
/// Maximum number of recorded callers of the crashed instruction.
const MAX_FRAMES: usize = 24;
/// Number and length (ns) of the intervals in which the handler waits for the report.
const WAIT_INTERVALS: u32 = 300;
const WAIT_INTERVAL_NS: libc::c_long = 10_000_000;
/// Maximum time for which a process that exits waits while a crash on another thread is reported.
const EXIT_TIMEOUT: Duration = Duration::from_secs(4);
/// Size of the alternate signal stack for a thread that has none, bytes.
const SIGNAL_STACK_BYTES: usize = 64 << 10;

/// The process in which handlers were installed: a forked child inherits them, but must not report.
static OWN_PROCESS: AtomicI32 = AtomicI32::new(0);
/// The write end of the pipe by which the handler wakes the reporting thread.
static WAKE_PIPE: AtomicI32 = AtomicI32::new(-1);
/// Set by the first thread that crashes or calls `exit`. Only this thread is reported.
static IS_CRASHING: AtomicBool = AtomicBool::new(false);
/// Set when the report is complete.
static REPORT_DONE: AtomicBool = AtomicBool::new(false);

// Data recorded by the handler.
static SIGNAL: AtomicI32 = AtomicI32::new(0);
static THREAD: AtomicI32 = AtomicI32::new(0);
/// Id of the process that sent the signal, or 0 if no other process did.
static SENDER: AtomicI32 = AtomicI32::new(0);
static CRASHED_WATCH: AtomicPtr<CallWatch> = AtomicPtr::new(std::ptr::null_mut());
/// The address that could not be accessed, the instruction pointer, and the stack pointer.
static ADDRESS: AtomicUsize = AtomicUsize::new(0);
static INSTRUCTION: AtomicUsize = AtomicUsize::new(0);
static STACK_POINTER: AtomicUsize = AtomicUsize::new(0);
/// Set when `CALLERS` is complete.
static CALLERS_DONE: AtomicBool = AtomicBool::new(false);
/// The crashed instruction and its callers.
static CALLERS: [AtomicUsize; MAX_FRAMES] = [const { AtomicUsize::new(0) }; MAX_FRAMES];

/// Returns the id of the calling thread. Safe in a signal handler. glibc provides `gettid` only since version 2.30.
fn thread_id() -> c_int {
    // SAFETY: the system call has no preconditions; thread numbers are as large as `c_int`.
    unsafe { libc::syscall(libc::SYS_gettid) as c_int }
}

/// Installs the handlers. If this fails, crashes are not reported, but the program runs normally.
pub fn install_handlers() {
    let Ok((read, write)) = io::pipe() else { return };
    // The handler may write at any time, so this end is never closed.
    WAKE_PIPE.store(write.into_raw_fd(), Relaxed);
    OWN_PROCESS.store(std::process::id().cast_signed(), Relaxed);
    let (ready, waits) = mpsc::channel();
    let run = move || wait_for_crash(read, &ready);
    // Wait until the thread runs: starting it requires locks of the loader, which a crashing constructor would hold.
    if std::thread::Builder::new().name("crashes".into()).spawn(run).is_err() || waits.recv().is_err() {
        return;
    }
    ensure_signal_stack();
    // SAFETY: `sigaction` is a structure of integers and pointers, for which zero is valid. The handler has the
    // signature that SA_SIGINFO requires and calls only async-signal-safe functions; the functions registered for exit
    // and fork are static.
    unsafe {
        let mut action: libc::sigaction = std::mem::zeroed();
        let handler: extern "C" fn(c_int, *mut libc::siginfo_t, *mut c_void) = handle_signal;
        action.sa_sigaction = handler as usize;
        // Finding the callers may crash as well: the handler is then entered again, and ends the process.
        action.sa_flags = libc::SA_SIGINFO | libc::SA_ONSTACK | libc::SA_NODEFER;
        libc::sigemptyset(&raw mut action.sa_mask);
        for signal in SIGNALS {
            let mut before: libc::sigaction = std::mem::zeroed();
            libc::sigaction(signal, std::ptr::null(), &raw mut before);
            // Signals that the parent process has set to be ignored remain ignored.
            if before.sa_sigaction != libc::SIG_IGN {
                libc::sigaction(signal, &raw const action, std::ptr::null_mut());
            }
        }
        // Exceeding the file size limit should fail the write, not kill the process.
        libc::signal(libc::SIGXFSZ, libc::SIG_IGN);
        libc::atexit(handle_exit);
        libc::pthread_atfork(None, Some(after_fork_in_parent), Some(after_fork_in_child));
        // The first call to `backtrace` loads a library, which is not allowed in a signal handler.
        let mut one = [std::ptr::null_mut(); 1];
        backtrace(one.as_mut_ptr(), 1);
    }
}

unsafe extern "C" {
    /// Function of the C library that stores the return addresses of the calling functions.
    fn backtrace(frames: *mut *mut c_void, n: c_int) -> c_int;
}

/// Creates an alternate signal stack for this thread, if the standard library has not done so.
fn ensure_signal_stack() {
    // SAFETY: the first call only reads into `now`; the new stack is leaked memory of the stated size, so it stays
    // valid.
    unsafe {
        let mut now: libc::stack_t = std::mem::zeroed();
        if libc::sigaltstack(std::ptr::null(), &raw mut now) == 0 && now.ss_flags & libc::SS_DISABLE != 0 {
            let room = Box::leak(vec![0_u8; SIGNAL_STACK_BYTES].into_boxed_slice());
            let new = libc::stack_t { ss_sp: room.as_mut_ptr().cast(), ss_flags: 0, ss_size: SIGNAL_STACK_BYTES };
            libc::sigaltstack(&raw const new, std::ptr::null_mut());
        }
    }
}

/// The signal handler. It uses only async-signal-safe functions, atomics, and a thread-local without a destructor.
extern "C" fn handle_signal(signal: c_int, info: *mut libc::siginfo_t, context: *mut c_void) {
    // SAFETY: the system passes a valid `info` and `context`; all functions called here are async-signal-safe.
    unsafe {
        if libc::getpid() == OWN_PROCESS.load(Relaxed) {
            if !IS_CRASHING.swap(true, Acquire) {
                record_crash(signal, &*info, context);
                let (wake, byte) = (WAKE_PIPE.load(Relaxed), 1_u8);
                if wake >= 0 {
                    libc::write(wake, (&raw const byte).cast(), 1);
                    record_callers();
                }
            }
            // If another thread crashes in the meantime, it waits here too: the first one ends the process.
            let part = libc::timespec { tv_sec: 0, tv_nsec: WAIT_INTERVAL_NS };
            for _ in 0..WAIT_INTERVALS {
                if REPORT_DONE.load(Acquire) {
                    break;
                }
                libc::nanosleep(&raw const part, std::ptr::null_mut());
            }
        }
        // With the default action, the signal ends the process as if there were no handler.
        libc::signal(signal, libc::SIG_DFL);
        libc::raise(signal);
    }
}

/// Records the data that is available only on this thread.
///
/// # Safety
/// `info` and `context` must be those that the system passed to the handler.
unsafe fn record_crash(signal: c_int, info: &libc::siginfo_t, context: *mut c_void) {
    SIGNAL.store(signal, Relaxed);
    CRASHED_WATCH.store(current_watch().cast_mut(), Relaxed);
    // SAFETY: `gettid` has no preconditions; the fields of `info` are read only for the signals and codes that define
    // them; `context` is a `ucontext_t` of this architecture, as SA_SIGINFO guarantees.
    unsafe {
        THREAD.store(thread_id(), Relaxed);
        if info.si_code <= 0 {
            // Sent by another process, whose id may not be visible here (`si_pid` is 0 then); `raise` and timers belong
            // to this process.
            let own = info.si_code == libc::SI_TIMER || info.si_pid() == libc::getpid();
            SENDER.store(if own { 0 } else { info.si_pid().max(1) }, Relaxed);
        } else if info.si_code > 0 && ADDRESS_SIGNALS.contains(&signal) {
            ADDRESS.store(info.si_addr() as usize, Relaxed);
        }
        let (instruction, stack) = registers(&(*context.cast::<libc::ucontext_t>()).uc_mcontext);
        INSTRUCTION.store(instruction, Relaxed);
        STACK_POINTER.store(stack, Relaxed);
    }
}

/// Records the callers. This is done after all other data was handed over, so that a crash here does not affect it.
///
/// # Safety
/// Must be called in the handler, after `record_crash`.
unsafe fn record_callers() {
    // SAFETY: the watch of this thread lives as long as the thread; `frames` has room for the FRAMES addresses that
    // `backtrace` may write.
    unsafe {
        let stack = STACK_POINTER.load(Relaxed);
        // After a stack overflow, or while a library is being loaded, `backtrace` could crash or block.
        let deep = ADDRESS.load(Relaxed).abs_diff(stack) < blame::MAX_OVERFLOW_DISTANCE && ADDRESS.load(Relaxed) != 0;
        let loads = current_watch().as_ref().is_some_and(|watch| watch.call() == Some(PluginCall::Load));
        if !deep && !loads {
            let mut frames = [std::ptr::null_mut(); MAX_FRAMES];
            let n = backtrace(frames.as_mut_ptr(), MAX_FRAMES as c_int).clamp(0, MAX_FRAMES as c_int) as usize;
            for (to, from) in CALLERS.iter().zip(&frames[..n]) {
                to.store(*from as usize, Relaxed);
            }
        }
    }
    CALLERS_DONE.store(true, Release);
}

/// Returns the instruction pointer and the stack pointer.
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

/// Waits for a crash and reports it; runs on the reporting thread.
fn wait_for_crash(mut read: PipeReader, ready: &mpsc::Sender<()>) {
    // All signals are blocked on this thread, so that signals from outside go to others, and a crash here ends the
    // process at once.
    // SAFETY: `all` is initialized by `sigfillset`.
    unsafe {
        let mut all: libc::sigset_t = std::mem::zeroed();
        libc::sigfillset(&raw mut all);
        libc::pthread_sigmask(libc::SIG_BLOCK, &raw const all, std::ptr::null_mut());
    }
    if ready.send(()).is_err() {
        return;
    }
    if read.read_exact(&mut [0]).is_err() {
        return report_closed_pipe(read);
    }
    let mut crash = Crash {
        signal: SIGNAL.load(Relaxed),
        thread: THREAD.load(Relaxed),
        sender: SENDER.load(Relaxed),
        address: ADDRESS.load(Relaxed),
        instruction: INSTRUCTION.load(Relaxed),
        stack: STACK_POINTER.load(Relaxed),
        call: running(CRASHED_WATCH.load(Relaxed)),
        callers: Vec::new(),
    };
    let mut fault = Fault::new(FaultKind::Crash, blame::crash_message(&crash));
    if crash.sender == 0 || crash.sender == OWN_PROCESS.load(Relaxed) {
        fault.help = Some(CRASH_HELP.to_owned());
    }
    report_fault(fault, crash.call.as_ref());
    // The report has been written. The rest may block or crash if the crashed thread holds a lock or has corrupted
    // memory, but then nothing essential is lost.
    for _ in 0..50 {
        if CALLERS_DONE.load(Acquire) {
            crash.callers = CALLERS.iter().map(|c| c.load(Relaxed)).take_while(|c| *c != 0).collect();
            break;
        }
        std::thread::sleep(Duration::from_millis(10));
    }
    for line in blame::frames(&crash) {
        write_line(&format!("  {line}\n"));
    }
    // SAFETY: the thread that runs the script is in the signal handler, so the script's state does not change.
    if let Some((file, line)) = crash.call.as_ref().and_then(|call| unsafe { call.script.current_position() }) {
        write_line(&format!("  called by the script at {file}:{line}\n"));
    }
    REPORT_DONE.store(true, Release);
}

/// Reports that the pipe was closed, which the program itself never does.
fn report_closed_pipe(read: PipeReader) {
    WAKE_PIPE.store(-1, Relaxed);
    // The number may already belong to another file, which must not be closed.
    std::mem::forget(read);
    let call = stuck_run::current().and_then(|run| run.watches.any_running());
    tatu_core::record_breach(blame::closed_files_message(call.as_ref()));
}

/// Returns the call that is running on the thread with this watch.
fn running(at: *const CallWatch) -> Option<StuckCall> {
    stuck_run::current()?.watches.running(at)
}

/// Reports a fault and returns the exit code. The error line is written first, since the rest, which writes all pending
/// output, may block on a lock of the crashed thread.
fn report_fault(mut fault: Fault, call: Option<&StuckCall>) -> i32 {
    if let Some(call) = call {
        (fault.plugin, fault.object) = (blame::id(call), call.object.clone());
    }
    let help = fault.help.as_ref().map_or(String::new(), |help| format!(" ({help})"));
    // A progress bar may be on the current line.
    let clear = if io::stderr().is_terminal() { "\r\x1b[K" } else { "" };
    let line = format!("{clear}error[{}]: {}{help}\n", fault.code, fault.message);
    write_line(&line);
    let code = stuck_run::current().map_or(2, |run| run.close(&fault));
    // Plugins in C may have buffered output.
    // SAFETY: a null pointer is valid and means all output streams of the C library.
    unsafe { libc::fflush(std::ptr::null_mut()) };
    code
}

/// Writes to standard error without the standard library, whose lock may be held.
fn write_line(line: &str) {
    // There is nowhere else to report that it fails.
    let _ = rustix::io::write(rustix::stdio::stderr(), line.as_bytes());
}

/// Called in the parent process after a fork. A fork during a plugin call is reported as the plugin's fault.
extern "C" fn after_fork_in_parent() {
    if let Some(call) = running(current_watch()) {
        write_line(&format!("warning: {}\n", blame::fork_message(&call)));
    }
}

/// Called in the child process after a fork. The child has a single thread and no world, and must not return from the
/// plugin call.
extern "C" fn after_fork_in_child() {
    protected_state::mark_as_child();
}

/// Ends the program, with a time limit for exit handlers of libraries. Such handlers cannot be cancelled, and no plugin
/// call is running to which they could be attributed.
pub fn limit_exit_time(code: ExitCode) -> ExitCode {
    let failed = code != ExitCode::SUCCESS;
    let late = move || {
        std::thread::sleep(EXIT_TIMEOUT);
        let text = format!(
            "the program has ended, but an exit handler (`atexit`, a destructor) of a plugin or of one of its \
             libraries has not returned for {} s",
            EXIT_TIMEOUT.as_secs()
        );
        write_line(&format!("error[{}]: {text}\n", Fault::new(FaultKind::Stuck, "").code));
        leave(if failed { 2 } else { 1 });
    };
    // If the thread cannot be started, there is no time limit.
    let _ = std::thread::Builder::new().name("ending".into()).spawn(late);
    code
}

/// Called when the process exits, on the thread that ends it. An exit during a plugin call is the plugin's fault.
extern "C" fn handle_exit() {
    let (process, thread) = (std::process::id().cast_signed(), thread_id());
    if process != OWN_PROCESS.load(Relaxed) {
        return;
    }
    let call = running(current_watch());
    // A regular exit of the program happens on its main thread.
    let in_order = call.is_none() && thread == process;
    let taken = if in_order { IS_CRASHING.load(Acquire) } else { IS_CRASHING.swap(true, Acquire) };
    if taken {
        // Another thread has crashed, and ends the process once its crash has been reported.
        std::thread::sleep(EXIT_TIMEOUT);
    }
    if in_order || taken {
        return;
    }
    let mut fault = Fault::new(FaultKind::Exit, blame::exit_message(call.as_ref(), thread));
    fault.help = Some("a plugin must return an error instead".into());
    leave(report_fault(fault, call.as_ref()));
}
