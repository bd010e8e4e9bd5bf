//! Observes the calls to the plugin under test: places arguments directly before guard pages, and checks results
//! against the rules of the ABI.

use std::{
    ffi::c_void,
    sync::{
        Mutex, PoisonError,
        atomic::{AtomicBool, AtomicU64, Ordering::Relaxed},
    },
    time::Instant,
};

use tatu_core::plugins::{CommandEntry, Inspector, SensorKind, guarded_copy::GuardedCopy};
use tatu_plugin_api::{abi::*, safe::ValueRef};

use super::finding;

/// The prefix of the line that reports an access to a guard page.
pub const GUARD_PREFIX: &str = "tatu-guard ";

/// Number of bytes of the stack that are overwritten to detect pointers into it.
const SCRIBBLE_BYTES: usize = 32 << 10;

/// Observes the calls into one plugin.
pub struct CallSpy {
    plugin: usize,
    state_bytes: u32,
    /// Whether arguments are copied to memory before guard pages.
    pub guards: AtomicBool,
    /// The change that is made to saved bytes before they are passed to `load`.
    pub damage: Mutex<StateDamage>,
    /// Whether `load` was called with saved bytes that are not empty.
    pub loaded: AtomicBool,
    /// Number of calls to commands, and their total duration, ns.
    pub calls: AtomicU64,
    pub nanoseconds: AtomicU64,
}

/// A change of the bytes that are passed to `load`.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum StateDamage {
    None,
    /// Replaces the version that the bytes were saved with.
    Version(u32),
    /// Truncates to this number of bytes, and changes the last one.
    First(usize),
}

impl CallSpy {
    pub fn new(plugin: usize, state_bytes: u32) -> Self {
        CallSpy {
            plugin,
            state_bytes,
            guards: AtomicBool::new(true),
            damage: Mutex::new(StateDamage::None),
            loaded: AtomicBool::new(false),
            calls: AtomicU64::new(0),
            nanoseconds: AtomicU64::new(0),
        }
    }

    fn check_call(&self, place: &str, frame: &tatu_call, status: tatu_status) {
        // SAFETY: the pointer is null or that of the host's error object for this call.
        let said = unsafe { frame.error.as_ref() }.map_or(TATU_OK, |e| e.code);
        if status >= 0 && said != TATU_OK {
            finding::error(place, format!("it sets an error in its error object, but returns {}", name(status)));
        }
        if status == TATU_ERR_PANIC {
            finding::error(place, "it panics: a panic was caught at the ABI");
        }
        if !frame.state.is_null() && self.state_bytes >= 8 {
            let words = self.state_bytes as usize / 8;
            // SAFETY: the state block of an instance of this plugin has `state_bytes` bytes and is aligned to 16.
            let words = unsafe { std::slice::from_raw_parts(frame.state.cast::<u64>(), words) };
            if let Some(at) = words.iter().position(|w| is_address(*w)) {
                let text = format!("its state block, which snapshots save, contains a pointer at byte {}", at * 8);
                finding::error(place, text);
            }
        }
    }
}

/// Returns the name of a status that is not an error.
fn name(status: tatu_status) -> &'static str {
    if status == TATU_WAIT { "TATU_WAIT" } else { "TATU_OK" }
}

impl Inspector for CallSpy {
    fn command(
        &self,
        command: &CommandEntry,
        frame: *mut tatu_call,
        run: &mut dyn FnMut(*mut tatu_call) -> tatu_status,
    ) -> tatu_status {
        if command.plugin != self.plugin {
            return run(frame);
        }
        let place = place(command);
        // SAFETY: `frame` is the host's frame for this call, whose arguments are valid during the call, and the plugin
        // has not been called yet.
        let (args, given) = unsafe { ((*frame).args, ValueRef::slice((*frame).args, (*frame).n_args as usize)) };
        let mut pages = GuardedPages::default();
        if self.guards.load(Relaxed) {
            finding::report_activity(&place, format!("called with ({})", list(given)));
            let moved = pages.arguments(command, given);
            // SAFETY: as above; the original arguments are restored below.
            unsafe { (*frame).args = moved };
        }
        let begin = Instant::now();
        let status = run(frame);
        self.nanoseconds.fetch_add(begin.elapsed().as_nanos() as u64, Relaxed);
        self.calls.fetch_add(1, Relaxed);
        // SAFETY: the frame is still valid, and the plugin has returned.
        unsafe {
            (*frame).args = args;
            self.check_call(&place, &*frame, status);
        }
        status
    }

    fn failed_without_reason(&self, command: &CommandEntry, status: tatu_status) {
        if command.plugin == self.plugin && status != TATU_ERR_PANIC {
            finding::error(
                &place(command),
                format!("it returns the status {status} without a message in its error object"),
            );
        }
    }

    fn after_beams(&self, kind: &SensorKind, beams: &tatu_beams) {
        if kind.plugin != self.plugin || beams.directions.is_null() || beams.form != TATU_BEAMS_RAYS {
            return;
        }
        let n = 3 * beams.count[0].min(1 << 20) as usize;
        // SAFETY: by the contract there are 3 values per ray; they are read before anything else is called.
        let before = unsafe { std::slice::from_raw_parts(beams.directions, n) }.to_vec();
        scribble();
        // SAFETY: by the contract the instance owns the values until `beams` is called again.
        let after = unsafe { std::slice::from_raw_parts(beams.directions, n) };
        if before.iter().zip(after).any(|(a, b)| a.to_bits() != b.to_bits()) {
            let text = "the `directions` from `beams` change after it has returned: they are on its stack, but must be \
                        owned by the instance";
            finding::error(&format!("sensor `{}`", kind.id), text);
        }
    }

    fn before_load(&self, plugin: usize, bytes: &mut Vec<u8>, version: &mut u32) {
        if plugin != self.plugin {
            return;
        }
        self.loaded.fetch_or(!bytes.is_empty(), Relaxed);
        match *self.damage.lock().unwrap_or_else(PoisonError::into_inner) {
            StateDamage::None => {}
            StateDamage::Version(v) => *version = v,
            StateDamage::First(n) => {
                bytes.truncate(n);
                if let Some(last) = bytes.last_mut() {
                    *last ^= 0x55;
                }
            }
        }
    }
}

/// Returns the `place` of findings about a command.
pub fn place(command: &CommandEntry) -> String {
    format!("command `{}`", command.name())
}

/// Overwrites the stack below the caller's frame, where the frames of the previously called function were.
#[inline(never)]
fn scribble() {
    let mut room = [0u8; SCRIBBLE_BYTES];
    room.fill(0x5a);
    std::hint::black_box(&mut room);
}

/// Copies of arguments in memory before guard pages, for the duration of a call.
#[derive(Default)]
struct GuardedPages(Vec<GuardedCopy>);

impl GuardedPages {
    fn add_copy(&mut self, bytes: &[u8], label: &str) -> *const c_void {
        let guarded = GuardedCopy::new(bytes, label);
        let first = guarded.first().cast();
        self.0.push(guarded);
        first
    }

    fn arguments(&mut self, command: &CommandEntry, args: &[ValueRef<'_>]) -> *const tatu_value {
        let moved: Vec<tatu_value> = args
            .iter()
            .enumerate()
            .map(|(i, a)| {
                let key = command.params.get(i).map_or("", |p| p.key.as_str());
                self.value(*a, &format!("its argument {} `{key}`", i + 1), 0)
            })
            .collect();
        self.add_copy(bytes_of(&moved), "the array of its arguments, which does not contain omitted ones").cast()
    }

    /// Copies a value so that its spans end directly before guard pages. Spans that are empty, or nested more than 32
    /// levels deep, become null pointers.
    fn value(&mut self, v: ValueRef<'_>, label: &str, depth: u32) -> tatu_value {
        let mut out = v.raw();
        if !is_span(v.tag()) {
            return out;
        }
        let ptr = if v.is_empty() || depth > 32 {
            std::ptr::null()
        } else if let Some(items) = v.list() {
            let all: Vec<tatu_value> =
                items.iter().map(|e| self.value(*e, &format!("an element of {label}"), depth + 1)).collect();
            self.add_copy(bytes_of(&all), label)
        } else if let Some(pairs) = v.map() {
            let pair = |[key, value]: &[ValueRef<'_>; 2]| tatu_pair {
                key: self.value(*key, &format!("a key of {label}"), depth + 1),
                value: self.value(*value, &format!("an entry of {label}"), depth + 1),
            };
            let all: Vec<tatu_pair> = pairs.iter().map(pair).collect();
            self.add_copy(bytes_of(&all), label)
        } else {
            self.add_copy(v.span_bytes(), label)
        };
        out.u.s = tatu_span_t { ptr, len: v.len() as u64 };
        out
    }
}

fn bytes_of<T>(all: &[T]) -> &[u8] {
    // SAFETY: values and pairs of the ABI have no padding, and live as long as the slice.
    unsafe { std::slice::from_raw_parts(all.as_ptr().cast(), size_of_val(all)) }
}

fn is_span(tag: u32) -> bool {
    (TATU_TEXT..=TATU_MAP).contains(&tag)
}

/// Describes arguments for findings.
fn list(args: &[ValueRef<'_>]) -> String {
    let words: Vec<String> = args.iter().map(|v| shown(*v)).collect();
    words.join(", ")
}

fn shown(v: ValueRef<'_>) -> String {
    match (v.tag(), v.len()) {
        (TATU_NIL, _) => "nil".into(),
        (TATU_BOOL, _) => v.truthy().to_string(),
        (TATU_I64, _) => v.as_i64().unwrap_or_default().to_string(),
        (TATU_F64, _) => format!("{:?}", v.as_f64().unwrap_or_default()),
        (TATU_TEXT | TATU_BYTES, 0..=40) => format!("\"{}\"", v.as_bytes().unwrap_or_default().escape_ascii()),
        (TATU_TEXT | TATU_BYTES, n) => format!("a text of {n} bytes"),
        (TATU_LIST, n) => format!("a list of {n}"),
        (TATU_MAP, n) => format!("a map of {n}"),
        (TATU_FUNC, _) => "a function".into(),
        (TATU_OBJECT, _) => format!("object {}", tatu_slot(v.as_object().unwrap_or_default())),
        (_, n) => format!("an array of {n}"),
    }
}

/// Returns whether a word is the address of memory that is currently mapped in this process.
fn is_address(word: u64) -> bool {
    let user = 0x1_0000..1 << 47;
    if !user.contains(&word) {
        return false;
    }
    let Ok(maps) = std::fs::read_to_string("/proc/self/maps") else { return false };
    maps.lines().any(|line| {
        let range = line.split(' ').next().and_then(|r| r.split_once('-'));
        let parsed =
            range.and_then(|(a, b)| Some((u64::from_str_radix(a, 16).ok()?, u64::from_str_radix(b, 16).ok()?)));
        parsed.is_some_and(|(begin, end)| (begin..end).contains(&word))
    })
}

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
                    libc::write(super::finding::channel(), part.as_ptr().cast(), part.len());
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
