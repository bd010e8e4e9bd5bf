//! Observes the calls to the plugin under test: places arguments directly before guard pages, and checks results
//! against the rules of the ABI.

use std::{
    cell::RefCell,
    collections::BTreeSet,
    sync::{
        Mutex, PoisonError,
        atomic::{AtomicBool, AtomicU64, Ordering::Relaxed},
    },
    time::{Duration, Instant},
};

use tatu_core::plugins::{
    ActuatorKind, CommandEntry, Inspector, SensorKind, guarded_copy::GuardedCopy, watchdog::PluginCall,
};
use tatu_plugin_api::{abi::*, safe::ValueRef};

use super::{
    actuator_probes::{self, ActuatorCall},
    argument_pages::{GuardedPages, list},
    batch_copy::{BatchCall, scribble},
    finding::{self, is_second_run},
    sensor_probes::{self, DeviceProbe},
    units::BeamNumbers,
};

/// Observes the calls into one plugin.
pub struct CallSpy {
    plugin: usize,
    state_bytes: u32,
    /// The byte that fills the stack before a command is called.
    stack_byte: u8,
    /// Whether arguments are copied to memory before guard pages.
    pub guards: AtomicBool,
    /// The change that is made to saved bytes before they are passed to `load`.
    pub damage: Mutex<StateDamage>,
    /// Whether `load` was called with saved bytes that are not empty.
    pub loaded: AtomicBool,
    /// Whether `save` wrote any bytes.
    pub saved: AtomicBool,
    /// How batches of devices are tested, and whether the state of the devices is in their state blocks.
    pub probe: Mutex<(DeviceProbe, bool)>,
    /// The beams that a sensor described last.
    pub beams: Mutex<BeamNumbers>,
    /// The calls of barriers.
    pub barriers: Mutex<BarrierCalls>,
    /// The commands that returned pointers to their own stack.
    pub dangling: Mutex<BTreeSet<String>>,
    /// Number of calls to commands, and their total duration, ns.
    pub calls: AtomicU64,
    pub nanoseconds: AtomicU64,
}

/// The calls of the barriers of services.
#[derive(Debug, Default)]
pub struct BarrierCalls {
    /// Number of calls that took longer than [`BLOCKING_THRESHOLD`], and the longest.
    pub slow: usize,
    pub longest: Duration,
    /// Number of calls, and of those that held the session.
    pub calls: usize,
    pub holds: usize,
    /// Number of calls in succession that held the session.
    held: usize,
}

/// Real time above which a barrier may block.
const BLOCKING_THRESHOLD: Duration = Duration::from_millis(100);
/// Size of the stack below a call in which the frames of the plugin are expected.
const MAX_CALL_STACK_BYTES: usize = 512 << 10;
/// Number of times that a service may hold the session before a step begins nevertheless.
const MAX_HOLDS: usize = 2;

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
            stack_byte: if is_second_run() { 0xa5 } else { 0x5a },
            guards: AtomicBool::new(true),
            damage: Mutex::new(StateDamage::None),
            loaded: AtomicBool::new(false),
            saved: AtomicBool::new(false),
            probe: Mutex::new((DeviceProbe::None, false)),
            beams: Mutex::default(),
            barriers: Mutex::default(),
            dangling: Mutex::default(),
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

impl CallSpy {
    /// Checks that no result points to the stack of the call, which has ended. It was below the address `end`, that of a
    /// variable of the caller.
    ///
    /// # Safety
    /// The results of the frame must be valid.
    unsafe fn check_results(&self, place: &str, frame: &tatu_call, end: usize) {
        let stack = end.saturating_sub(MAX_CALL_STACK_BYTES)..end;
        let n = frame.n_results.min(frame.results_cap);
        let dangling = (0..n as usize).find(|i| {
            // SAFETY: the caller guarantees that the results are valid; the tag states that the value is a span, and
            // nothing that it points to is read.
            let span = unsafe {
                let value = &*frame.results.add(*i);
                if (TATU_TEXT..=TATU_MAP).contains(&value.tag) { Some(value.u.s) } else { None }
            };
            span.is_some_and(|s| s.len > 0 && stack.contains(&(s.ptr as usize)))
        });
        if let Some(i) = dangling {
            let text = format!(
                "its result {} points to its own stack, which ends with the call: pass memory of the call \
                 (`tatu_copy_text`, `tatu_copy_floats`, `tatu_keep`) or of the instance",
                i + 1
            );
            finding::error(place, text);
            self.dangling.lock().unwrap_or_else(PoisonError::into_inner).insert(place.to_owned());
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
        // What a command reads from its stack before it writes there differs between the runs of `repeat`.
        scribble(self.stack_byte);
        let begin = Instant::now();
        let status = run(frame);
        self.nanoseconds.fetch_add(begin.elapsed().as_nanos() as u64, Relaxed);
        self.calls.fetch_add(1, Relaxed);
        // SAFETY: the frame is still valid, and the plugin has returned.
        unsafe {
            (*frame).args = args;
            self.check_call(&place, &*frame, status);
            self.check_results(&place, &*frame, std::hint::black_box(&raw const status) as usize);
        }
        status
    }

    fn breach(&self, command: &CommandEntry, text: &str) {
        if command.plugin == self.plugin && !text.starts_with("panicked") {
            finding::error(&place(command), format!("it {text}"));
        }
    }

    fn sensors(
        &self,
        kind: &SensorKind,
        call: PluginCall,
        batch: &mut tatu_sensor_batch,
        run: &mut dyn FnMut(&tatu_sensor_batch) -> tatu_status,
    ) -> tatu_status {
        let (probe, is_pure) = *self.probe.lock().unwrap_or_else(PoisonError::into_inner);
        if kind.plugin != self.plugin || call != PluginCall::Measure || probe == DeviceProbe::None {
            return run(batch);
        }
        sensor_probes::probe(probe, is_pure, &BatchCall { kind, batch, run: RefCell::new(run) })
    }

    fn actuators(
        &self,
        kind: &ActuatorKind,
        batch: &tatu_actuator_batch,
        run: &mut dyn FnMut(&tatu_actuator_batch) -> tatu_status,
    ) -> tatu_status {
        let (probe, is_pure) = *self.probe.lock().unwrap_or_else(PoisonError::into_inner);
        if kind.plugin != self.plugin || probe == DeviceProbe::None {
            return run(batch);
        }
        actuator_probes::probe(probe, is_pure, &ActuatorCall { kind, batch, run: RefCell::new(run) })
    }

    fn after_save(&self, plugin: usize, bytes: &[u8]) {
        if plugin == self.plugin {
            self.saved.fetch_or(!bytes.is_empty(), Relaxed);
        }
    }

    fn after_barrier(&self, plugin: usize, holds: bool, took: Duration) -> bool {
        if plugin != self.plugin {
            return holds;
        }
        let mut barriers = self.barriers.lock().unwrap_or_else(PoisonError::into_inner);
        barriers.calls += 1;
        barriers.slow += usize::from(took > BLOCKING_THRESHOLD);
        barriers.longest = barriers.longest.max(took);
        barriers.holds += usize::from(holds);
        barriers.held = if holds { barriers.held + 1 } else { 0 };
        if barriers.held > MAX_HOLDS {
            // No client comes to release the session.
            barriers.held = 0;
            return false;
        }
        holds
    }

    fn copy_of_source(&self, plugin: usize, bytes: &[u8]) -> Option<GuardedCopy> {
        (plugin == self.plugin && self.guards.load(Relaxed)).then(|| GuardedCopy::new(bytes, "the text that it reads"))
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
        if kind.plugin != self.plugin {
            return;
        }
        // SAFETY: the plugin has just filled the table.
        *self.beams.lock().unwrap_or_else(PoisonError::into_inner) = unsafe { BeamNumbers::of(beams) };
        if beams.directions.is_null() || beams.form != TATU_BEAMS_RAYS {
            return;
        }
        let n = 3 * beams.count[0].min(1 << 20) as usize;
        // SAFETY: by the contract there are 3 values per ray; they are read before anything else is called.
        let before = unsafe { std::slice::from_raw_parts(beams.directions, n) }.to_vec();
        scribble(0x5a);
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

/// Returns whether a word is the address of memory that is currently mapped in this process.
#[cfg(target_os = "linux")]
fn is_address(word: u64) -> bool {
    let user = 0x1_0000..1 << 47;
    if !user.contains(&word) {
        return false;
    }
    // SAFETY: `sysconf` has no pointer arguments; `mincore` only looks up the page, and writes one byte to `resident`.
    unsafe {
        let page = libc::sysconf(libc::_SC_PAGESIZE) as u64;
        let mut resident = 0u8;
        libc::mincore((word & !(page - 1)) as *mut libc::c_void, 1, &raw mut resident) == 0
    }
}
#[cfg(not(target_os = "linux"))]
fn is_address(_: u64) -> bool {
    false
}
