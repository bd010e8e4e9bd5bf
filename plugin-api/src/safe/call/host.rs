//! The host and the tables of its services, which are looked up once, when the plugin starts.

use std::{
    ffi::{CStr, CString, c_char, c_void},
    path::Path,
};

use crate::abi::*;
use crate::safe::entry::panics;

/// The key of a property or of a field of a reading, interned by [`Host::prop`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Prop(pub tatu_prop);

/// The host with the tables of its services; cheap to copy, valid until the plugin's shutdown.
#[derive(Clone, Copy)]
pub struct Host {
    raw: *const tatu_host,
    pub(crate) scene: Option<&'static tatu_host_scene>,
    pub(crate) stand_ins: Option<&'static tatu_host_stand_ins>,
    pub(crate) readings: Option<&'static tatu_host_readings>,
    pub(crate) bodies: Option<&'static tatu_host_bodies>,
    pub(crate) commands: Option<&'static tatu_host_commands>,
    pub(crate) scripts: Option<&'static tatu_host_scripts>,
    pub(crate) signals: Option<&'static tatu_host_signals>,
    pub(crate) events: Option<&'static tatu_host_events>,
    pub(crate) session: Option<&'static tatu_host_session>,
    pub(crate) stage: Option<&'static tatu_host_stage>,
    pub(crate) log: Option<&'static tatu_host_log>,
    pub(crate) files: Option<&'static tatu_host_files>,
    pub(crate) figures: Option<&'static tatu_host_figures>,
    pub(crate) edits: Option<&'static tatu_host_edits>,
}

// SAFETY: the tables are immutable and live until shutdown; the header states which threads may call each function, and
// the wrappers adhere to it.
unsafe impl Send for Host {}
// SAFETY: the tables are immutable and live until shutdown, so shared access from several threads only reads them.
unsafe impl Sync for Host {}

impl Host {
    /// Looks up the tables of all services. Returns `None` if `raw` is null or the host has no function for this.
    ///
    /// # Safety
    /// `raw` must be null, or point to a host that lives until the plugin's shutdown.
    pub unsafe fn new(raw: *const tatu_host) -> Option<Self> {
        // SAFETY: the caller guarantees that `raw` is null or points to a host that lives until shutdown.
        let tables = Tables { raw, service: unsafe { raw.as_ref() }?.service? };
        let host = Host {
            raw,
            scene: tables.find(),
            stand_ins: tables.find(),
            readings: tables.find(),
            bodies: tables.find(),
            commands: tables.find(),
            scripts: tables.find(),
            signals: tables.find(),
            events: tables.find(),
            session: tables.find(),
            stage: tables.find(),
            log: tables.find(),
            files: tables.find(),
            figures: tables.find(),
            edits: tables.find(),
        };
        panics::set_panic_hook(host.logger());
        Some(host)
    }

    /// Returns a host without services, for tests: functions that use a service fail, and log messages are discarded.
    pub fn without_services() -> Self {
        Host {
            raw: std::ptr::null(),
            scene: None,
            stand_ins: None,
            readings: None,
            bodies: None,
            commands: None,
            scripts: None,
            signals: None,
            events: None,
            session: None,
            stage: None,
            log: None,
            files: None,
            figures: None,
            edits: None,
        }
    }

    /// Returns the folder of the plugin's assets, `tatu_NAME.assets` beside its library, if it exists. Read its files
    /// when the plugin starts, so that they cannot change during a run.
    pub fn assets(&self) -> Option<&'static Path> {
        // SAFETY: the host lives until the plugin's shutdown and begins with its size; the field is read only if it
        // lies within that size. Its text lives as long as the host.
        unsafe {
            let at = self.raw.as_ref().filter(|h| h.size as usize >= size_of::<tatu_host>())?.assets;
            (!at.is_null()).then(|| CStr::from_ptr(at).to_str().ok().map(Path::new)).flatten()
        }
    }
    /// Returns the host in the form of the ABI, for functions without a wrapper.
    pub fn raw(&self) -> *const tatu_host {
        self.raw
    }
    /// Returns the table of the service `commands`, for script languages, which use it in their inner loop.
    pub fn commands_table(&self) -> Option<&'static tatu_host_commands> {
        self.commands
    }
    /// Interns a key, such as "joint.position" or "proximity.distance".
    pub fn prop(&self, key: &str) -> Prop {
        let key = CString::new(key).unwrap_or_default();
        // SAFETY: `self.raw` is the host that the function belongs to, and `key` outlives the call.
        Prop(self.scene.and_then(|s| s.prop).map_or(0, |f| unsafe { f(self.raw, key.as_c_str().into()) }))
    }
    /// Writes a line to the log; `level` is one of `TATU_LOG_*`.
    pub fn log(&self, level: u32, text: &str) {
        self.write(std::ptr::null_mut(), level, text.as_bytes());
    }
    pub(crate) fn write(&self, world: *mut tatu_world, level: u32, text: &[u8]) {
        if let Some(write) = self.log.and_then(|l| l.write) {
            // SAFETY: `self.raw` is the host that the function belongs to; the world may be null, and the host
            // validates it.
            unsafe { write(self.raw, WorldRef::new(world), level, text.into()) };
        }
    }
    pub(crate) fn logger(&self) -> impl Fn(u32, &str) + Send + Sync + 'static {
        let host = *self;
        move |level, text| host.log(level, text)
    }
}

/// A table of host functions.
///
/// # Safety
/// The host must answer [`ID`](Self::ID) with null, or with a table that lives as long as the host, begins with its size
/// and, if it is large enough, is a table of this type.
unsafe trait HostTable: 'static {
    const ID: &'static CStr;
}

macro_rules! host_tables {
    ($($table:ty = $id:expr),*) => {
        $(
            // SAFETY: the header states this type of table for the id.
            unsafe impl HostTable for $table {
                const ID: &'static CStr = $id;
            }
        )*
    };
}
host_tables!(
    tatu_host_scene = TATU_HOST_SCENE,
    tatu_host_stand_ins = TATU_HOST_STAND_INS,
    tatu_host_readings = TATU_HOST_READINGS,
    tatu_host_bodies = TATU_HOST_BODIES,
    tatu_host_commands = TATU_HOST_COMMANDS,
    tatu_host_scripts = TATU_HOST_SCRIPTS,
    tatu_host_signals = TATU_HOST_SIGNALS,
    tatu_host_events = TATU_HOST_EVENTS,
    tatu_host_session = TATU_HOST_SESSION,
    tatu_host_stage = TATU_HOST_STAGE,
    tatu_host_log = TATU_HOST_LOG,
    tatu_host_files = TATU_HOST_FILES,
    tatu_host_figures = TATU_HOST_FIGURES,
    tatu_host_edits = TATU_HOST_EDITS
);

/// The function by which a host, which lives until shutdown, answers ids with tables.
struct Tables {
    raw: *const tatu_host,
    service: unsafe extern "C" fn(*const tatu_host, *const c_char) -> *const c_void,
}

impl Tables {
    /// Returns a table, unless the host has none or a smaller one.
    fn find<T: HostTable>(&self) -> Option<&'static T> {
        // SAFETY: `service` belongs to the host `raw`, which lives until shutdown, and the id is NUL-terminated. The
        // answer is null or begins with its size, and is a `T` if it is large enough.
        unsafe {
            let table = (self.service)(self.raw, T::ID.as_ptr());
            let size = *table.cast::<u32>().as_ref()?;
            (size as usize >= size_of::<T>()).then(|| &*table.cast::<T>())
        }
    }
}
