//! Loading of a plugin: opens the library and reads its descriptor.

use std::{
    ffi::{CString, c_void},
    path::{Path, PathBuf},
    sync::Arc,
};

use libloading::Library;
use tatu_errors::{Error, Result};
use tatu_plugin_api::abi::*;

use super::{
    SearchPath,
    declared::{Declared, Extension},
    drafts,
    protected_state::{self, ProcessState},
    search, tables, texts,
    watchdog::{CallWatch, PluginCall},
};
use crate::HostTables;

/// Maximum number of libraries beside a plugin that are linked for its copy.
const MAX_LIBRARIES_BESIDE: usize = 64;

/// Remarks on plugins that are loaded nevertheless.
#[derive(Default)]
pub struct LoadRemarks {
    /// Problems that make a part of a plugin unusable or need attention.
    pub warnings: Vec<Error>,
    /// Notes that require no action.
    pub notes: Vec<String>,
}

/// Opens a library and binds all its symbols. A missing symbol is thus a reason to reject the library, rather than the
/// cause of a crash when the symbol is first used.
fn open_library(file: &Path) -> Result<Library, libloading::Error> {
    #[cfg(unix)]
    {
        use libloading::os::unix::{Library as Unix, RTLD_LOCAL, RTLD_NOW};
        // SAFETY: loading a library runs its constructors, which may do anything; the user has chosen to trust it.
        unsafe { Unix::open(Some(file), RTLD_NOW | RTLD_LOCAL) }.map(Library::from)
    }
    #[cfg(not(unix))]
    // SAFETY: loading a library runs its constructors, which may do anything; the user has chosen to trust it.
    unsafe {
        Library::new(file)
    }
}

/// Returns the loader's own message, which is the source of libloading's error.
fn loader_message(e: &libloading::Error) -> String {
    std::error::Error::source(e).map_or(String::new(), |s| format!(": {s}"))
}

/// Opens the copy of a library. The libraries beside the original that it needs are linked, one after the other, as the
/// loader misses them.
fn open_copy(original: &Path, copy: &Path) -> Result<Library, libloading::Error> {
    // The loader remembers folders that do not exist, so these are linked first.
    search::link_assets(original, copy);
    let mut opened = open_library(copy);
    for _ in 0..MAX_LIBRARIES_BESIDE {
        match &opened {
            Err(e) if search::link_beside(original, copy, &loader_message(e)) => opened = open_library(copy),
            _ => break,
        }
    }
    opened
}

/// Reads the descriptor of a plugin's library, if it has one.
fn descriptor(library: Library) -> Option<Declared<'static, tatu_plugin_t>> {
    // SAFETY: the contract requires the symbol to be a constant of this type; it belongs to the library, which is never
    // unloaded.
    let raw = unsafe {
        let symbol = library.get::<*const tatu_plugin_t>(b"tatu_plugin\0").ok();
        let at = symbol.and_then(|s| s.try_as_raw_ptr()).unwrap_or(std::ptr::null_mut()).cast::<tatu_plugin_t>();
        Declared::at(at.cast_const())
    };
    // The library is never unloaded, because pointers into it have no lifetime.
    std::mem::forget(library);
    raw
}

/// Extracts the missing symbol from the loader's message: ".../libtatu_x.so: undefined symbol: twice".
fn undefined_symbol(reason: &str) -> Option<&str> {
    let rest = reason.split_once("undefined symbol: ")?.1;
    rest.split([',', ' ', '\n']).next().filter(|s| !s.is_empty())
}

/// A loaded and started plugin. It is never unloaded, because threads and thread-locals of the library may still be
/// alive.
pub struct LoadedPlugin {
    /// Id of the plugin, such as `org.example.gripper`.
    pub id: String,
    /// Name of the plugin for display; may be empty.
    pub name: String,
    /// Version of the plugin; may be empty.
    pub version: String,
    /// Licence of the plugin; may be empty.
    pub licence: String,
    /// Major and minor version of the ABI that the plugin was built against.
    pub abi: (u16, u16),
    /// Path of the plugin's library.
    pub path: PathBuf,
    /// The plugin's own pointer, set by its `init` and passed to its functions.
    pub me: *mut c_void,
    raw: tatu_plugin_t,
    /// The host tables that the plugin holds pointers to.
    _host: Arc<HostTables>,
    /// The watch that records the call of the plugin's shutdown function.
    watch: Arc<CallWatch>,
}

// SAFETY: the tables do not change after loading, and functions are called only on the threads that the header permits.
unsafe impl Send for LoadedPlugin {}
// SAFETY: the tables do not change after loading, and functions are called only on the threads that the header permits.
unsafe impl Sync for LoadedPlugin {}

impl LoadedPlugin {
    /// Opens and starts a plugin. Faults that do not prevent its use are added to `remarks`.
    ///
    /// If `search` has a folder for copies, the library is opened as a copy of the file; messages name the original.
    pub fn open(
        path: &Path,
        search: &SearchPath,
        host: &Arc<HostTables>,
        watch: &Arc<CallWatch>,
        remarks: &mut LoadRemarks,
    ) -> Result<Self> {
        let home = ProcessState::now();
        watch.replace_subject(&path.display().to_string());
        // The index is out of range, because the plugin has no index yet.
        let outside = watch.enter(PluginCall::Load, usize::MAX, 0);
        let opened = Self::open_watched(path, search, host, watch, remarks);
        protected_state::end_if_child();
        watch.leave(outside);
        watch.replace_subject("");
        if let Some(what) = home.restore() {
            let text = format!("the plugin {} changes {what} when it is loaded or started", path.display());
            remarks.warnings.push(Error::new("E321", text).help(protected_state::RESTORED_HELP));
        }
        opened
    }

    fn open_watched(
        path: &Path,
        search: &SearchPath,
        host: &Arc<HostTables>,
        watch: &Arc<CallWatch>,
        remarks: &mut LoadRemarks,
    ) -> Result<Self> {
        let fail = |text: String, help: &str| {
            Error::new("E301", format!("cannot load the plugin {}: {text}", path.display())).help(help)
        };
        let copy = search.copies.as_ref().map(|c| c.copy(path)).transpose();
        let copy = copy.map_err(|e| {
            fail(format!("it cannot be copied: {e}"), "free some disk space, or set TMPDIR to a folder on another disk")
        })?;
        let file = copy.as_deref().unwrap_or(path);
        super::library_file::check(file).map_err(|unfit| fail(unfit.text, unfit.help))?;
        let opened = if copy.is_some() { open_copy(path, file) } else { open_library(file) };
        let library = opened.map_err(|e| {
            let reason = loader_message(&e);
            match undefined_symbol(&reason) {
                Some(symbol) => fail(
                    format!("it uses the symbol `{symbol}`, which neither it nor a library that it links to defines"),
                    "link it with the library that has the symbol, or compile the file that defines it into it",
                ),
                None => {
                    fail(format!("{e}{reason}"), "rebuild it for this system, and install the libraries that it needs")
                }
            }
        })?;
        let raw = descriptor(library).ok_or_else(|| {
            fail(
                "it exports no `tatu_plugin`".into(),
                "a plugin exports a `tatu_plugin_t` of that name; in C++ include tatu.h before defining it",
            )
        })?;
        if raw.abi_major != TATU_ABI_MAJOR {
            let text = format!(
                "it was built for ABI {}.{}, but this host has {TATU_ABI_MAJOR}.{TATU_ABI_MINOR}",
                raw.abi_major, raw.abi_minor
            );
            return Err(fail(text, drafts::remedy(raw.abi_major > TATU_ABI_MAJOR)));
        }
        let needed = tables::required!(raw, tatu_plugin_t: id, extension);
        if let Some(lack) = tables::lacking(raw.size, &needed) {
            return Err(fail(format!("its descriptor `tatu_plugin` {lack}"), tables::HELP));
        }
        let id = raw.id().filter(|s| !s.is_empty()).ok_or_else(|| {
            fail("its id is empty".into(), "give `tatu_plugin.id` a name of your own, such as \"org.example.gripper\"")
        })?;
        if let Some(flaw) = texts::flaw(&id) {
            return Err(fail(
                format!("its id `{id}` {flaw}"),
                "give `tatu_plugin.id` a name such as \"org.example.gripper\"",
            ));
        }
        watch.replace_subject(&format!("{id} ({})", path.display()));
        let own = host.create_plugin_host(&id, search.is_of_program(path), needs_of(&raw), assets_of(path));
        Self::check_needs(&raw, host, path, remarks)
            .map_err(|unmet| fail(unmet.sentence(), drafts::remedy(unmet.newer_host)))?;
        let mut me = std::ptr::null_mut();
        let mut error = crate::border::ErrorSlot::new();
        host.clear_refused();
        if let Some(init) = raw.init {
            watch.enter(PluginCall::Init, usize::MAX, 0);
            // SAFETY: `init` belongs to the library, which is never unloaded; `own` is never freed, and the tables live
            // as long as `_host`. `me` and the error object live until the call has returned.
            let status = unsafe { init(own, &mut me, error.raw()) };
            let status = error.check_status(status, false);
            watch.enter(PluginCall::Extension, usize::MAX, 0);
            if status < 0 {
                let said = error.text();
                return Err(match host.refused_drafts().as_slice() {
                    [] => fail(
                        format!("its start ({} of `{id}`) failed: {said}", PluginCall::Init.text()),
                        "follow the message, or ask the author of the plugin; `tatu list plugins` tries it again",
                    ),
                    asked => fail(
                        format!(
                            "its start ({} of `{id}`) failed: {said}; it is {}",
                            PluginCall::Init.text(),
                            asked.iter().map(|d| d.text.as_str()).collect::<Vec<_>>().join("; ")
                        ),
                        drafts::remedy(asked.iter().any(|d| d.is_newer)),
                    ),
                });
            }
        }
        let loaded = LoadedPlugin {
            id,
            name: raw.name().unwrap_or_default(),
            version: raw.version().unwrap_or_default(),
            licence: raw.licence().unwrap_or_default(),
            abi: (raw.abi_major, raw.abi_minor),
            path: path.to_owned(),
            me,
            raw: *raw,
            _host: host.clone(),
            watch: watch.clone(),
        };
        loaded.check_layouts().map_err(|text| fail(text, drafts::remedy(false)))?;
        let (others, heard) =
            protected_state::capture_errors(|| drafts::other_drafts(|id| !loaded.extension::<u8>(id).is_null()));
        if let Some(said) = heard.first() {
            return Err(fail(
                format!("{} of `{}` {said}", PluginCall::Extension.text(), loaded.id),
                "ask the author of the plugin",
            ));
        }
        if others.is_empty() && drafts::EXTENSIONS.iter().all(|id| loaded.extension::<u8>(id).is_null()) {
            let text = format!("the plugin {} offers nothing{}", path.display(), drafts::misspelt(file));
            let help =
                "`tatu_plugin.extension` must return a table for at least one extension id, such as TATU_COMMAND";
            remarks.warnings.push(Error::new("E324", text).help(help));
        }
        for other in others {
            let text = format!("the plugin {} is {}: that part of it is not used", path.display(), other.text);
            remarks.warnings.push(Error::new("E320", text).help(drafts::remedy(other.is_newer)));
        }
        Ok(loaded)
    }

    fn check_needs(
        raw: &Declared<'_, tatu_plugin_t>,
        host: &HostTables,
        path: &Path,
        remarks: &mut LoadRemarks,
    ) -> Result<(), UnmetNeed> {
        for need in raw.needs() {
            let id = need.id().map(|id| texts::clean(&id.to_string_lossy()).into_owned());
            let Some(unmet) = find_unmet(id.as_deref(), &need, host) else { continue };
            if need.optional == 0 {
                return Err(unmet);
            }
            let UnmetNeed { what, why, .. } = unmet;
            remarks
                .notes
                .push(format!("the plugin {} can use {what}, {why}; the plugin runs without it", path.display()));
        }
        Ok(())
    }

    /// Compares the layouts of the frozen types, if the plugin is written in Rust and provides them.
    fn check_layouts(&self) -> Result<(), String> {
        let theirs: *const tatu_rust_layout = self.extension(TATU_RUST_LAYOUT);
        if theirs.is_null() {
            return Ok(());
        }
        // SAFETY: `theirs` is not null, and the contract requires the extension with this id to be such a table; it
        // belongs to the library, which is never unloaded.
        unsafe { compare_layouts(theirs) }.map(drop)
    }

    /// Returns the table of one of the plugin's extensions.
    pub(crate) fn declared<T: Extension>(&self) -> Option<Declared<'_, T>> {
        // SAFETY: the contract requires the answer for the id of an extension to be null or its table, which is valid
        // until the plugin is shut down; that requires an exclusive borrow of `self`.
        unsafe { Declared::at(self.extension(T::ID)) }
    }

    /// Returns the table of one of the plugin's extensions, or null.
    pub fn extension<T>(&self, id: &std::ffi::CStr) -> *const T {
        // SAFETY: `f` belongs to the library, which is never unloaded; `me` is the plugin's own pointer, and `id` is
        // NUL-terminated.
        self.raw.extension.map_or(std::ptr::null(), |f| unsafe { f(self.me, id.as_ptr()) }.cast())
    }
}

/// Returns the folder of assets beside a library: `tatu_lamp.assets` for `libtatu_lamp.so`.
pub fn assets_folder(library: &Path) -> Option<PathBuf> {
    let name = library.file_name()?.to_str()?;
    let stem = name.strip_prefix(std::env::consts::DLL_PREFIX).unwrap_or(name);
    let stem = stem.strip_suffix(std::env::consts::DLL_SUFFIX)?;
    Some(library.with_file_name(format!("{stem}.assets")))
}

/// Returns the absolute path of a plugin's folder of assets, for `tatu_host.assets`, or `None` if it does not exist.
fn assets_of(library: &Path) -> Option<CString> {
    let folder = assets_folder(library).filter(|f| f.is_dir())?;
    CString::new(std::path::absolute(folder).ok()?.into_os_string().into_encoded_bytes()).ok()
}

/// Returns the ids of the tables that a plugin needs, and the number of bytes of each.
fn needs_of(raw: &Declared<'_, tatu_plugin_t>) -> Vec<(CString, u32)> {
    raw.needs().iter().filter_map(|need| Some((need.id()?.to_owned(), need.bytes))).collect()
}

/// A need that this host does not meet, and why.
struct UnmetNeed {
    what: String,
    why: String,
    /// Whether a newer version of the program might meet the need.
    newer_host: bool,
}

impl UnmetNeed {
    fn sentence(&self) -> String {
        format!("it needs {}, {}", self.what, self.why)
    }
}

fn find_unmet(id: Option<&str>, need: &tatu_need, host: &HostTables) -> Option<UnmetNeed> {
    if need.minor > u32::from(TATU_ABI_MINOR) {
        let what = format!("minor version {} of the ABI", need.minor);
        let why = format!("but this host has {TATU_ABI_MINOR}: it is older than the plugin");
        return Some(UnmetNeed { what, why, newer_host: true });
    }
    let id = id?;
    let Some(table) = host.find(id) else {
        let other = drafts::other_draft(id);
        let newer_host = other.as_ref().is_some_and(|d| d.is_newer);
        let why = other.map_or_else(|| "which this host does not offer".into(), |d| d.text);
        return Some(UnmetNeed { what: format!("`{id}`"), why, newer_host });
    };
    let size = table.size();
    (need.bytes > size).then(|| UnmetNeed {
        what: format!("{} bytes of `{id}`", need.bytes),
        why: format!("but this host has {size}: it is older than the plugin"),
        newer_host: true,
    })
}

impl LoadedPlugin {
    /// Shuts the plugin down, at most once, and returns the errors. All instances have already been destroyed, because
    /// worlds own the registry, which owns the plugin.
    pub fn shut_down(&mut self) -> Vec<Error> {
        let Some(shutdown) = self.raw.shutdown.take() else { return Vec::new() };
        let home = ProcessState::now();
        // SAFETY: `shutdown` belongs to the library, which is never unloaded, and `self.me` is its own pointer. It is
        // called only once, because it was removed from the table.
        let run = || unsafe { shutdown(self.me) };
        self.watch.replace_subject(&format!("{} ({})", self.id, self.path.display()));
        let before = self.watch.enter(PluginCall::Shutdown, usize::MAX, 0);
        let ((), heard) = protected_state::capture_errors(run);
        self.watch.leave(before);
        self.watch.replace_subject("");
        let changed = home.restore().map(|what| format!("changed {what}"));
        let told = heard.into_iter().chain(changed);
        let whose = format!("the plugin `{}` ({})", self.id, self.path.display());
        told.map(|text| Error::new("E323", format!("{whose} {text} in {}", PluginCall::Shutdown.text()))).collect()
    }
}

impl Drop for LoadedPlugin {
    fn drop(&mut self) {
        self.shut_down();
    }
}
