//! The calls of functions of the C library that the rules forbid.

use std::{
    ffi::CStr,
    sync::{
        OnceLock,
        atomic::{AtomicUsize, Ordering::Relaxed},
    },
};

use libc::{c_char, c_int};
use tatu_core::plugins::watchdog::{self, PluginCall};

use super::super::finding;

/// What is wrong with a call of a function.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Rule {
    /// No call may start a process.
    Process,
    /// No call may change the settings of the process.
    Settings,
    /// No call on a thread of the host may sleep.
    Sleep,
    /// The same for functions that wait for files and sockets, whose argument with this index is a timeout: 0 does not
    /// wait.
    Poll(usize),
    /// No call on a thread of the host may use the random numbers of the C library, which all plugins share.
    Random,
    /// Measuring and acting must not depend on clocks, on the process or on files, and must not start threads.
    Clock,
    Identity,
    Thread,
    /// The same; in addition, importers and models read files only through their builder. The argument with this index
    /// is the name of the file.
    File(usize),
    Socket,
}

/// Arguments of a function, as far as they are integers or pointers in registers.
pub type Arguments = [usize; 6];

/// Index of the plugin under test in the registry, plus 1; 0 while no calls are reported.
pub static PLUGIN: AtomicUsize = AtomicUsize::new(0);
/// The folder of the plugin's assets.
pub static ASSETS: OnceLock<String> = OnceLock::new();

/// Returns the call of the plugin under test that runs on this thread.
pub fn running_call() -> Option<PluginCall> {
    let watch = watchdog::current_watch();
    if watch.is_null() {
        return None;
    }
    // SAFETY: the watch of a call exists at least until the call has returned, and this thread is within the call.
    let watch = unsafe { &*watch };
    (watch.plugin() + 1 == PLUGIN.load(Relaxed)).then(|| watch.call()).flatten()
}

/// Reports a call of a function by the plugin under test if a rule forbids it.
pub fn report(name: &str, rule: Rule, args: Arguments) {
    let Some(call) = running_call() else { return };
    use PluginCall as P;
    let is_parallel = matches!(call, P::Aim | P::Measure | P::Finish | P::Apply);
    let is_build = matches!(call, P::Import | P::Build | P::Sniff);
    let ends = matches!(call, P::Destroy | P::Stop | P::Shutdown | P::Last);
    let why = match rule {
        Rule::Process => "no call may start a process",
        Rule::Settings if is_query(name, args) => return,
        Rule::Settings => "this changes the process, which belongs to the host and to other plugins",
        Rule::Poll(timeout) if args[timeout] as c_int == 0 => return,
        Rule::Sleep | Rule::Poll(_) if ends || matches!(call, P::Start | P::ServiceFunc) => return,
        Rule::Sleep | Rule::Poll(_) => "no call may block or sleep",
        Rule::Random => {
            "all plugins share these numbers; use `random` of the batch, or compute them from `tatu_instance.seed`"
        }
        Rule::Clock if is_parallel => "readings and forces must not depend on a clock; use `time` of the batch",
        Rule::Identity if is_parallel => "readings and forces must not depend on the process or the computer",
        Rule::Thread if is_parallel => "this call runs on several threads already, and must not start others",
        Rule::Socket if is_parallel || is_build => "such a call may only read its inputs",
        Rule::File(at) => match forbidden_file(name, args, at, (is_parallel, is_build, call)) {
            Some(text) => return tell(call, name, &text),
            None => return,
        },
        Rule::Clock | Rule::Identity | Rule::Thread | Rule::Socket => return,
    };
    tell(call, name, why);
}

/// Reports a single allocation of this size.
pub fn report_allocation(name: &str, bytes: usize) {
    if let Some(call) = running_call() {
        let text = format!("it requests {bytes} bytes at once: sizes that a file or a caller states must be checked");
        tell(call, name, &text);
    }
}

fn tell(call: PluginCall, name: &str, why: &str) {
    let text = format!("`{}` calls `{name}`: {why}", call.text());
    finding::error(&finding::current_place(), text);
}

/// Returns whether a function that changes settings only reads them with these arguments.
fn is_query(name: &str, args: Arguments) -> bool {
    match name {
        "setlocale" | "sigprocmask" | "pthread_sigmask" => args[1] == 0,
        _ => false,
    }
}

/// Returns why a file must not be opened in a call, if it must not.
fn forbidden_file(
    name: &str,
    args: Arguments,
    at: usize,
    (is_parallel, is_build, call): (bool, bool, PluginCall),
) -> Option<String> {
    use PluginCall as P;
    // SAFETY: the plugin passes a valid string to the C library, which reads it as well.
    let path = unsafe { text_at(args[at]) };
    let is_setup = matches!(call, P::Create | P::Beams | P::Configure | P::Save | P::Restore);
    let writes = match name {
        "open" | "open64" => args[1] as c_int & (libc::O_WRONLY | libc::O_RDWR | libc::O_CREAT) != 0,
        "openat" | "openat64" => args[2] as c_int & (libc::O_WRONLY | libc::O_RDWR | libc::O_CREAT) != 0,
        // SAFETY: as above, for the mode.
        "fopen" | "fopen64" | "freopen" => unsafe { text_at(args[1]) }.contains(['w', 'a', '+']),
        "creat" | "remove" | "unlink" | "rename" | "mkdir" => true,
        _ => false,
    };
    let is_asset = ASSETS.get().is_some_and(|folder| path.starts_with(folder.as_str()));
    match () {
        () if is_parallel => Some(format!("the file `{path}` may differ between runs; read files in `init`")),
        () if is_build && !is_asset => Some(format!("the file `{path}` must be read by `tatu_builder.file`")),
        () if is_setup && writes => Some(format!("it changes the file `{path}`, but such a call has no side effects")),
        () if is_setup && (path.starts_with("/dev/") || path.starts_with("/proc/")) => {
            Some(format!("the contents of `{path}` differ between runs"))
        }
        () => None,
    }
}

/// Returns the string at an address, or an empty string for null.
///
/// # Safety
/// The address must be 0 or that of a NUL-terminated string.
unsafe fn text_at(address: usize) -> String {
    if address == 0 {
        return String::new();
    }
    // SAFETY: the caller guarantees the string.
    unsafe { CStr::from_ptr(address as *const c_char) }.to_string_lossy().into_owned()
}
