//! Whose fault a crash is, in words.

use std::{fs, path::Path};

use tatu_core::plugins::watchdog::{Call, Stuck};

use super::Crash;

/// What to do about a crash.
pub const HELP: &str =
    "what was printed and traced until then is written; run it in a debugger, or report it to the author";

/// How far from the stack a thread that overflows it has gone.
const NEAR: usize = 1 << 20;

/// The sentence about a crash.
pub fn of_crash(crash: &Crash) -> String {
    let signal = match crash.signal {
        libc::SIGSEGV => "SIGSEGV",
        libc::SIGBUS => "SIGBUS",
        libc::SIGFPE => "SIGFPE",
        libc::SIGILL => "SIGILL",
        _ => "SIGABRT",
    };
    if crash.sender != 0 && crash.sender != std::process::id().cast_signed() {
        let during = crash.call.as_ref().map_or(String::new(), |call| format!(", {}", place(call)));
        return format!("the program was ended from outside: process {} sent {signal}{during}", crash.sender);
    }
    let deep = crash.address != 0 && crash.address.abs_diff(crash.stack) < NEAR;
    let why = if deep { format!("{signal}, stack overflow") } else { signal.to_owned() };
    let place = match &crash.call {
        Some(call) => place(call),
        None => outside(&mapped_at(crash.instruction), crash.thread),
    };
    format!("the program crashed ({why}) {place}")
}

/// The sentence about a plugin that ended the program.
pub fn of_exit(call: Option<&Stuck>, thread: i32) -> String {
    let place = match call {
        Some(call) => place(call),
        None => format!("in the thread `{}`, which is of a plugin's own", name_of(thread)),
    };
    format!("exit() was called {place}: the program ends here")
}

/// The id of the plugin, where it has told one.
pub fn id(call: &Stuck) -> Option<String> {
    let known = call.call != Call::Load.text();
    known.then(|| call.plugin.split(" (").next().unwrap_or_default().to_owned())
}

/// "in `tatu_command.call` of plugin `org.me.fleet` for /box1"
fn place(call: &Stuck) -> String {
    let Stuck { plugin, object, others, call } = call;
    if *call == Call::Load.text() {
        return format!("while the library {plugin} was loaded, in one of its constructors");
    }
    // A plugin that has just been opened is told with its file.
    let (id, file) = plugin
        .split_once(" (")
        .map_or((plugin.as_str(), String::new()), |(id, f)| (id, format!(", {}", f.trim_end_matches(')'))));
    let whom = object.as_ref().map_or(String::new(), |o| format!(" for {o}"));
    let more = match others {
        0 => String::new(),
        n => format!(", the first of {} that are handled together", u64::from(*n) + 1),
    };
    format!("in `{call}` of plugin `{id}`{file}{whom}{more}")
}

/// Where a thread was that no call runs on, as far as the instruction tells.
fn outside(file: &str, thread: i32) -> String {
    let name = Path::new(file).file_name().map(|n| n.to_string_lossy()).unwrap_or_default();
    let own = std::env::current_exe().is_ok_and(|exe| exe == Path::new(file));
    // Only libraries of such names are opened as plugins; copies of them have a number before it.
    if !own && name.contains("tatu_") {
        return format!("in {file}, in the thread `{}` and outside of any call from the program", name_of(thread));
    }
    if !own && thread != std::process::id().cast_signed() {
        let name = name_of(thread);
        return format!("in the thread `{name}`, outside of any call into a plugin; plugins may have such threads");
    }
    "outside of any plugin: a fault of the program itself, unless a plugin has damaged its memory before".to_owned()
}

/// The file that is mapped at an address. The loader would know it, too, but may be locked by the thread that crashed.
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

/// What a thread of this process is called.
fn name_of(thread: i32) -> String {
    let name = fs::read_to_string(format!("/proc/self/task/{thread}/comm")).unwrap_or_default();
    if name.trim().is_empty() { thread.to_string() } else { name.trim().to_owned() }
}
