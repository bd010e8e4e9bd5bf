//! The host for tests, which opens worlds.

use std::{
    ffi::{CString, c_char},
    path::{Path, PathBuf},
};

use libloading::Library;
use tatu_plugin_api::{abi::*, safe::Fail};

use crate::{Error, Result, World, library};

/// A host for tests, with the plugins that its worlds load in addition to those of the program.
#[derive(Clone)]
pub struct Host {
    table: &'static tatu_test_host,
    file: PathBuf,
    plugins: Vec<PathBuf>,
    folder: Option<PathBuf>,
}

impl Host {
    /// Finds the host of an installation or a build of Tatu. These paths are tried in order:
    ///
    /// 1. the file that the environment variable `TATU_TESTHOST` specifies;
    /// 2. the library beside the program in the folder that `TATU_HOME` specifies;
    /// 3. the library beside the program `tatu` that is found in `PATH`.
    ///
    /// # Errors
    /// Fails if there is no host; the message explains how to provide one.
    pub fn find() -> Result<Self> {
        Self::open(&library::host_library()?)
    }

    /// Opens the host that a library contains.
    ///
    /// # Errors
    /// Fails if the library cannot be opened, is not a host, or is older than this crate.
    pub fn open(file: &Path) -> Result<Self> {
        // SAFETY: the library of the host has no initializers.
        let library = unsafe { Library::new(file) };
        let library = library.map_err(|e| Error::new(format!("cannot open {}: {e}", file.display())))?;
        // SAFETY: the contract guarantees that the symbol is a function of this type.
        let get = unsafe { library.get::<tatu_test_host_get_t>(b"tatu_test_host_get\0") };
        let get = get.map_err(|_| Error::new(format!("{} does not contain Tatu's host for tests", file.display())))?;
        // SAFETY: the function has no arguments, and returns a constant table or null.
        let table = unsafe { get().as_ref() };
        let table = table.filter(|t| t.size as usize >= size_of::<tatu_test_host>()).ok_or_else(|| {
            let text = format!("{} is older than this crate", file.display());
            Error::new(text + "\n  help: use the crate `tatu-plugin-testkit` of the same version of Tatu")
        })?;
        // The table is part of the library, which must therefore never be unloaded.
        std::mem::forget(library);
        Ok(Host { table, file: file.to_owned(), plugins: Vec::new(), folder: None })
    }

    /// Adds a plugin that the worlds of this host load: a library, or a folder of libraries. See
    /// [`plugin!`](crate::plugin).
    #[must_use]
    pub fn with_plugin(mut self, path: impl Into<PathBuf>) -> Self {
        self.plugins.push(path.into());
        self
    }

    /// Sets the folder to which file names in scenes are relative. The default is the working folder, which cargo sets
    /// to the folder of the package.
    #[must_use]
    pub fn with_files(mut self, folder: impl Into<PathBuf>) -> Self {
        self.folder = Some(folder.into());
        self
    }

    /// Returns the path of the host's library.
    pub fn file(&self) -> &Path {
        &self.file
    }

    /// Opens a scene, given as the text of a scene file, and starts it. The world belongs to the current thread.
    ///
    /// # Errors
    /// Fails if the scene has an error, or a plugin cannot be loaded.
    pub fn scene(&self, text: &str) -> Result<World> {
        let plugins = self.plugins.iter().map(|p| of_path(p)).collect::<Result<Vec<_>>>()?;
        let folder = self.folder.as_deref().map(of_path).transpose()?;
        let list: Vec<*const c_char> = plugins.iter().map(|p| p.as_ptr()).chain([std::ptr::null()]).collect();
        let setup = tatu_test_setup {
            size: size_of::<tatu_test_setup>() as u32,
            reserved: 0,
            scene: Lent::from(text).raw(),
            folder: folder.as_ref().map_or(std::ptr::null(), |f| f.as_ptr()),
            plugins: list.as_ptr(),
        };
        let open = self.table.open.ok_or_else(|| Error::from(Fail::unsupported("this host cannot open scenes")))?;
        // SAFETY: the texts of the table live during the call, and the list of plugins ends with null.
        let world = unsafe { open(&raw const setup) };
        match world.is_null() {
            // SAFETY: the table belongs to the host.
            true => Err(unsafe { World::last_error(self.table) }),
            // SAFETY: the world belongs to this table, and has just been opened on this thread.
            false => Ok(unsafe { World::new(self.table, world) }),
        }
    }
}

fn of_path(path: &Path) -> Result<CString> {
    let text = path.to_str().and_then(|text| CString::new(text).ok());
    text.ok_or_else(|| Error::new(format!("the path {} is not UTF-8", path.display())))
}
