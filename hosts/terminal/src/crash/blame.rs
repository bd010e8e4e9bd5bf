//! Describes which plugin caused a crash.

use std::{ffi::CStr, fs, path::Path};

use tatu_core::plugins::watchdog::{PluginCall, StuckCall};

/// The data that the signal handler recorded.
pub struct Crash {
    pub signal: libc::c_int,
    pub thread: i32,
    pub sender: i32,
    pub address: usize,
    pub instruction: usize,
    pub stack: usize,
    /// The plugin call that was running on the thread.
    pub call: Option<StuckCall>,
    pub callers: Vec<usize>,
}

/// Maximum distance from the stack pointer, in bytes, at which a fault is reported as a stack overflow.
pub const MAX_OVERFLOW_DISTANCE: usize = 1 << 20;

/// Returns the message about a crash.
pub fn crash_message(crash: &Crash) -> String {
    let signal = match crash.signal {
        libc::SIGSEGV => "SIGSEGV",
        libc::SIGBUS => "SIGBUS",
        libc::SIGFPE => "SIGFPE",
        libc::SIGILL => "SIGILL",
        libc::SIGABRT => "SIGABRT",
        libc::SIGALRM => "SIGALRM",
        libc::SIGVTALRM => "SIGVTALRM",
        libc::SIGPROF => "SIGPROF",
        libc::SIGUSR1 => "SIGUSR1",
        libc::SIGUSR2 => "SIGUSR2",
        libc::SIGTRAP => "SIGTRAP",
        libc::SIGSYS => "SIGSYS",
        libc::SIGXCPU => "SIGXCPU",
        libc::SIGIO => "SIGIO",
        _ => "SIGSTKFLT",
    };
    if crash.sender != 0 && crash.sender != std::process::id().cast_signed() {
        let during = crash.call.as_ref().map_or(String::new(), |call| format!(", {}", place(call)));
        let who = if crash.sender == 1 { "another process".to_owned() } else { format!("process {}", crash.sender) };
        return format!("the program was ended from outside: {who} sent {signal}{during}");
    }
    if crash.signal == libc::SIGXCPU {
        return "the program has used up the processor time that the system allows (SIGXCPU, `ulimit -t`)".to_owned();
    }
    let timers = [libc::SIGALRM, libc::SIGVTALRM, libc::SIGPROF, libc::SIGIO];
    if timers.contains(&crash.signal) {
        let during = crash.call.as_ref().map_or("outside of any call into a plugin".to_owned(), place);
        return format!(
            "the program was ended by {signal}, which it does not use: a plugin requested it (setitimer, alarm, \
             timer_create or O_ASYNC), not necessarily the one that was running, {during}"
        );
    }
    let deep = crash.address != 0 && crash.address.abs_diff(crash.stack) < MAX_OVERFLOW_DISTANCE;
    let why = if deep { format!("{signal}, stack overflow") } else { signal.to_owned() };
    let place = match &crash.call {
        Some(call) => place(call),
        None => place_outside_calls(&mapped_at(crash.instruction), crash.thread),
    };
    format!("the program crashed ({why}) {place}")
}

/// Returns the message about a plugin that called `exit`.
pub fn exit_message(call: Option<&StuckCall>, thread: i32) -> String {
    let place = match call {
        Some(call) => place(call),
        None => format!("in the thread `{}`, which a plugin started", thread_name(thread)),
    };
    format!("exit() was called {place}: the program ends here")
}

/// Returns the message about a plugin that closed file descriptors of the program.
pub fn closed_files_message(call: Option<&StuckCall>) -> String {
    let place =
        call.map_or("by a thread that a plugin started, or by a plugin call that has returned".to_owned(), place);
    format!("file descriptors of the program were closed {place}: its output may be incomplete")
}

/// Returns the message about a plugin that forked the process.
pub fn fork_message(call: &StuckCall) -> String {
    format!(
        "the process was forked {}: the copy has no threads and must not return; a plugin must start other programs \
         by posix_spawn, or fork in a thread of its own",
        place(call)
    )
}

/// Describes the callers of the crashed instruction in at most six lines, starting with the first caller outside of
/// system libraries.
pub fn frames(crash: &Crash) -> Vec<String> {
    let own = std::env::current_exe().ok().and_then(|exe| Some(exe.file_name()?.to_string_lossy().into_owned()));
    let mut out = Vec::new();
    for (i, at) in crash.callers.iter().enumerate() {
        // A return address points to the instruction after the call.
        let Some((file, symbol)) = symbol_at(if i == 0 { *at } else { at - 1 }) else { continue };
        let name = Path::new(&file).file_name().map(|n| n.to_string_lossy().into_owned()).unwrap_or_default();
        if Some(&name) == own.as_ref() {
            // The program's own frames at the top belong to the handler and are skipped; those below a plugin's frames
            // end the list.
            if out.is_empty() { continue } else { break }
        }
        if out.is_empty() && !name.contains("tatu_") {
            continue;
        }
        out.push(format!("at {symbol} ({name})"));
        if out.len() == 6 {
            break;
        }
    }
    out
}

/// Returns the file that contains an address, and the nearest exported symbol with its distance, or the offset in the
/// file.
fn symbol_at(address: usize) -> Option<(String, String)> {
    // SAFETY: `dladdr` accepts any address. It fills `about` if it succeeds, which is checked; the strings that it
    // points to belong to the library and remain valid, because libraries are never closed.
    unsafe {
        let mut about: libc::Dl_info = std::mem::zeroed();
        if libc::dladdr(address as *const libc::c_void, &raw mut about) == 0 || about.dli_fname.is_null() {
            return None;
        }
        let file = CStr::from_ptr(about.dli_fname).to_string_lossy().into_owned();
        let symbol = match about.dli_sname.is_null() {
            true => format!("+{:#x}", address - about.dli_fbase as usize),
            false => {
                let name = CStr::from_ptr(about.dli_sname).to_string_lossy();
                format!("{name}+{:#x}", address - about.dli_saddr as usize)
            }
        };
        Some((file, symbol))
    }
}

/// Returns the id of the plugin, if it is known.
pub fn id(call: &StuckCall) -> Option<String> {
    let known = call.call != PluginCall::Load.text();
    known.then(|| call.plugin.split(" (").next().unwrap_or_default().to_owned())
}

/// Describes a call, such as "in `tatu_command.call` of plugin `org.me.fleet` for /box1".
fn place(call: &StuckCall) -> String {
    let StuckCall { plugin, object, others, call, command, .. } = call;
    if *call == PluginCall::Load.text() {
        return format!("while the library {plugin} was loaded, in one of its constructors");
    }
    // The id of a plugin that was just opened is not yet known, only its file.
    let (id, file) = plugin
        .split_once(" (")
        .map_or((plugin.as_str(), String::new()), |(id, f)| (id, format!(", {}", f.trim_end_matches(')'))));
    let whom = object.as_ref().map_or(String::new(), |o| format!(" for {o}"));
    let more = match others {
        0 => String::new(),
        n => format!(", the first of a batch of {}", u64::from(*n) + 1),
    };
    let what = command.as_ref().map_or(String::new(), |name| format!(" (`{name}`)"));
    format!("in `{call}`{what} of plugin `{id}`{file}{whom}{more}")
}

/// Describes the location of a crash outside of plugin calls, derived from the file that contains the instruction.
fn place_outside_calls(file: &str, thread: i32) -> String {
    let name = Path::new(file).file_name().map(|n| n.to_string_lossy()).unwrap_or_default();
    let own = std::env::current_exe().is_ok_and(|exe| exe == Path::new(file));
    // Only libraries with such names are opened as plugins; their copies have a number as prefix.
    if !own && name.contains("tatu_") {
        return format!("in {file}, in the thread `{}` and outside of any call from the program", thread_name(thread));
    }
    if !own && name.contains("test_") {
        return format!("in {name}, the library of the test");
    }
    if !own && thread != std::process::id().cast_signed() {
        let name = thread_name(thread);
        return format!("in the thread `{name}`, outside of any call into a plugin; the thread may belong to a plugin");
    }
    "outside of any plugin: this is a fault of the program itself, unless a plugin has corrupted its memory".to_owned()
}

/// Returns the file that is mapped at an address. `dladdr` could block on the loader's lock, which the crashed thread
/// may hold.
fn mapped_at(address: usize) -> String {
    let maps = fs::read_to_string("/proc/self/maps").unwrap_or_default();
    let holds = |line: &&str| {
        let (from, to) = line.split(' ').next()?.split_once('-')?;
        let (from, to) = (usize::from_str_radix(from, 16).ok()?, usize::from_str_radix(to, 16).ok()?);
        Some((from..to).contains(&address))
    };
    let line = maps.lines().find(|l| holds(l) == Some(true)).unwrap_or_default();
    line.find('/').map_or(String::new(), |at| line[at..].to_owned())
}

/// Returns the name of a thread of this process.
fn thread_name(thread: i32) -> String {
    let name = fs::read_to_string(format!("/proc/self/task/{thread}/comm")).unwrap_or_default();
    if name.trim().is_empty() { thread.to_string() } else { name.trim().to_owned() }
}
