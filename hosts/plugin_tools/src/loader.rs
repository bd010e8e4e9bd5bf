//! Finds the libraries and symbols that a library needs, as the Linux loader does (ld.so(8)), without loading them.

use std::{
    collections::{BTreeMap, BTreeSet, HashMap, HashSet},
    env,
    path::{Path, PathBuf},
    rc::Rc,
};

use tatu_core::plugins::assets_folder;
use tatu_plugin_api::safe::read_plain;

use super::{
    elf::{self, Elf, ElfKind},
    reason::{RejectReason, list_some},
};

/// Maximum size of a file that is read, in bytes.
const MAX_FILE_BYTES: u64 = 1 << 30;
/// The cache file that `ldconfig` writes.
const LDCONFIG_CACHE: &str = "/etc/ld.so.cache";
/// Maximum number of names in a message.
const MAX_LISTED_SYMBOLS: usize = 4;

/// A library that another library needs.
pub struct NeededLibrary {
    pub name: String,
    /// The library that needs it; `None` for the plugin itself.
    pub by: Option<PathBuf>,
    pub found: Option<PathBuf>,
}

/// Finds libraries; reads each file only once.
pub struct Loader {
    cached: HashMap<String, Vec<PathBuf>>,
    environment: Vec<PathBuf>,
    usual: Vec<PathBuf>,
    read: HashMap<PathBuf, Option<Rc<Elf>>>,
    /// The symbols that this program and its libraries export.
    program: Option<Rc<HashSet<String>>>,
}

impl Loader {
    pub fn new() -> Self {
        let bytes = read_plain(Path::new(LDCONFIG_CACHE), MAX_FILE_BYTES).unwrap_or_default();
        let mut cached: HashMap<String, Vec<PathBuf>> = HashMap::new();
        for (name, path) in parse_cache(&bytes) {
            cached.entry(name).or_default().push(path);
        }
        let environment = env::var_os("LD_LIBRARY_PATH").unwrap_or_default().to_string_lossy().into_owned();
        let environment = match environment.as_str() {
            "" => Vec::new(),
            // An empty name means the working folder.
            all => all.split([':', ';']).map(|f| PathBuf::from(if f.is_empty() { "." } else { f })).collect(),
        };
        let multi = format!("{}-linux-gnu", env::consts::ARCH);
        let usual = ["/lib", "/usr/lib"].map(PathBuf::from);
        let usual = usual.iter().flat_map(|f| [f.join(&multi), f.clone(), PathBuf::from(format!("{}64", f.display()))]);
        Loader { cached, environment, usual: usual.collect(), read: HashMap::new(), program: None }
    }

    /// Returns the contents of a file, or `None` if it is not a library that this program could load.
    pub fn elf(&mut self, file: &Path) -> Option<Rc<Elf>> {
        if let Some(known) = self.read.get(file) {
            return known.clone();
        }
        let fits = tatu_core::plugins::check_library(file).is_ok();
        let bytes = if fits { read_plain(file, MAX_FILE_BYTES).ok() } else { None };
        let read = bytes.and_then(|b| elf::read(&b)).map(Rc::new);
        self.read.insert(file.to_owned(), read.clone());
        read
    }

    /// Returns all libraries that a file needs, directly or indirectly, in the loader's order, and their contents.
    pub fn needs(&mut self, file: &Path, own: &Elf) -> (Vec<NeededLibrary>, Vec<Rc<Elf>>) {
        let (mut needs, mut libraries) = (Vec::new(), Vec::new());
        let mut known: BTreeSet<String> = BTreeSet::new();
        let rpath =
            |e: &Elf, file: &Path| if e.runpath.is_empty() { expand_variables(&e.rpath, file) } else { Vec::new() };
        let runpath = expand_variables(&own.runpath, file);
        // Each entry contains a library, the names of the libraries that it needs, its own folders, and the folders
        // that its dependencies inherit.
        let mut open = std::collections::VecDeque::from([(None, own.needed.clone(), runpath, rpath(own, file))]);
        while let Some((by, names, runpath, rpath)) = open.pop_front() {
            for name in names.into_iter().filter(|n| known.insert(n.clone())).collect::<Vec<_>>() {
                let found = self.find(&name, &runpath, &rpath);
                if let Some((path, library)) = &found {
                    let handed: Vec<PathBuf> = self::rpath_of(library, path).into_iter().chain(rpath.clone()).collect();
                    let runpath = expand_variables(&library.runpath, path);
                    open.push_back((Some(path.clone()), library.needed.clone(), runpath, handed));
                    libraries.push(library.clone());
                }
                needs.push(NeededLibrary { name, by: by.clone(), found: found.map(|(path, _)| path) });
            }
        }
        (needs, libraries)
    }

    /// Returns the file that the loader uses for a name.
    fn find(&mut self, name: &str, runpath: &[PathBuf], rpath: &[PathBuf]) -> Option<(PathBuf, Rc<Elf>)> {
        let files: Vec<PathBuf> = if name.contains('/') {
            vec![PathBuf::from(name)]
        } else {
            // RPATH folders are used only if there are no RUNPATH folders.
            let older = if runpath.is_empty() { rpath } else { &[] };
            let folders = older.iter().chain(&self.environment).chain(runpath);
            let first = folders.map(|f| f.join(name));
            let cached = self.cached.get(name).into_iter().flatten().cloned();
            first.chain(cached).chain(self.usual.iter().map(|f| f.join(name))).collect()
        };
        files.into_iter().find_map(|f| {
            let read = self.elf(&f).filter(|e| e.sort == ElfKind::Library)?;
            Some((f, read))
        })
    }

    /// Returns whether this folder, a path without links, is one in which all libraries are searched.
    pub fn is_system_folder(&self, folder: &Path) -> bool {
        let cached = self.cached.values().flatten().filter_map(|f| f.parent());
        let all: BTreeSet<&Path> = cached.chain(self.usual.iter().map(PathBuf::as_path)).collect();
        all.iter().any(|f| f.canonicalize().is_ok_and(|f| f == folder))
    }

    /// Returns the symbols that this program and its libraries export, which the loader also considers.
    fn program_symbols(&mut self) -> Rc<HashSet<String>> {
        if let Some(known) = &self.program {
            return known.clone();
        }
        let mut names = HashSet::new();
        if let Some((exe, own)) = env::current_exe().ok().and_then(|exe| Some((exe.clone(), self.elf(&exe)?))) {
            let (_, libraries) = self.needs(&exe, &own);
            for library in libraries.iter().chain([&own]) {
                names.extend(library.exports.iter().cloned());
            }
        }
        self.program.insert(Rc::new(names)).clone()
    }

    /// Returns the reason that the loader would fail: a missing library, symbol version or symbol. Returns `None` if
    /// nothing is missing.
    pub fn missing_parts(
        &mut self,
        file: &Path,
        own: &Elf,
        needs: &[NeededLibrary],
        libraries: &[Rc<Elf>],
    ) -> Option<RejectReason> {
        if let Some(need) = needs.iter().find(|n| n.found.is_none()) {
            return Some(missing_library(file, need));
        }
        if let Some(reason) = missing_version(own, libraries) {
            return Some(reason);
        }
        let program = self.program_symbols();
        let is_there = |name: &&String| {
            program.contains(*name)
                || own.exports.contains(*name)
                || libraries.iter().any(|l| l.exports.contains(*name))
        };
        let missing: Vec<&String> = own.uses.iter().filter(|n| !is_there(n)).collect();
        (!missing.is_empty()).then(|| self.missing_symbols(&missing))
    }

    fn missing_symbols(&mut self, missing: &[&String]) -> RejectReason {
        let text = match missing {
            [one] => format!("it uses the symbol `{one}`, which neither it nor a library that it links to defines"),
            all => format!(
                "it uses {} symbols that neither it nor a library that it links to defines: {}",
                all.len(),
                list_some(all, MAX_LISTED_SYMBOLS)
            ),
        };
        let cpp = missing.iter().any(|n| n.starts_with("_Z") || n.starts_with("__cxa_") || n.starts_with("__gxx_"));
        // Libraries that authors often forget to link.
        let usual = [("libm.so.6", "-lm"), ("libz.so.1", "-lz"), ("libstdc++.so.6", "-lstdc++")];
        let option = usual.iter().find(|(library, _)| {
            let found = self.find(library, &[], &[]);
            found.is_some_and(|(_, l)| missing.iter().all(|n| l.exports.contains(*n)))
        });
        let help = match option {
            Some((library, "-lstdc++")) => {
                format!("{library} defines it: link with `c++` instead of `cc`, or add -lstdc++")
            }
            Some((library, option)) => format!("{library} defines it: link with {option}"),
            None if cpp => {
                "it is C++: link with `c++` instead of `cc`, together with the file or library that defines it".into()
            }
            None => {
                "link it with the library that defines the symbol, or compile the file that defines it into it".into()
            }
        };
        RejectReason::new("missing-symbol", text, help)
    }
}

fn rpath_of(library: &Elf, file: &Path) -> Vec<PathBuf> {
    if library.runpath.is_empty() { expand_variables(&library.rpath, file) } else { Vec::new() }
}

fn missing_library(file: &Path, need: &NeededLibrary) -> RejectReason {
    let text = match &need.by {
        None => format!("it needs the library {}, which is not found", need.name),
        Some(by) => format!("it needs {}, which needs the library {}, which is not found", by.display(), need.name),
    };
    let folder = file.parent().unwrap_or(Path::new("."));
    let assets = assets_folder(file).filter(|f| !need.name.contains('/') && f.join(&need.name).is_file());
    let help = if !need.name.contains('/') && folder.join(&need.name).is_file() {
        let folder = folder.display();
        format!(
            "it is in {folder}, which the loader does not search: link with `-Wl,-rpath,'$ORIGIN'`, \
             or set LD_LIBRARY_PATH={folder}"
        )
    } else if let Some(assets) = assets {
        let name = assets.file_name().unwrap_or_default().display();
        format!("it is in {name}, which the loader does not search: link with `-Wl,-rpath,'$ORIGIN/{name}'`")
    } else {
        format!(
            "install the package that contains it (find it with `apt-file search {}`), or link it statically; \
             `ldd {}` shows all libraries that are needed",
            need.name,
            file.display()
        )
    };
    RejectReason::new("missing-library", text, help)
}

/// Returns the first required version that the libraries of this system do not define, which means that the plugin was
/// built on a newer system.
fn missing_version(own: &Elf, libraries: &[Rc<Elf>]) -> Option<RejectReason> {
    let of = |name: &str| libraries.iter().find(|l| l.soname.as_deref() == Some(name));
    let (name, version, library) = own.needs_versions.iter().find_map(|(name, version)| {
        let library = of(name).filter(|l| !l.versions.is_empty() && !l.versions.contains(version))?;
        Some((name, version, library))
    })?;
    // Versions are compared numerically: GLIBC_2.36 is newer than GLIBC_2.4.
    let numbers = |v: &str| v.split(|c: char| !c.is_ascii_digit()).filter_map(|n| n.parse().ok()).collect::<Vec<u64>>();
    let family = version.split('_').next().unwrap_or_default();
    let newest = library.versions.iter().filter(|v| v.starts_with(family) && !v.ends_with("PRIVATE"));
    let newest = newest
        .max_by_key(|v| numbers(v))
        .map_or(String::new(), |v| format!(", but the newest version on this system is {v}"));
    let text = format!("it needs {version} of {name}{newest}");
    Some(RejectReason::new("old-library", text, "build it on this system or on an older one, or update this system"))
}

/// Replaces the variables, such as `$ORIGIN`, in the folders of a library.
fn expand_variables(folders: &[String], file: &Path) -> Vec<PathBuf> {
    let real = std::path::absolute(file).unwrap_or_else(|_| file.to_owned());
    let origin = real.parent().unwrap_or(Path::new("/")).display().to_string();
    let lib = format!("lib/{}-linux-gnu", env::consts::ARCH);
    let values = BTreeMap::from([("ORIGIN", origin.as_str()), ("LIB", &lib), ("PLATFORM", env::consts::ARCH)]);
    let fill = |folder: &String| {
        let filled = values.iter().fold(folder.clone(), |text, (name, value)| {
            text.replace(&format!("${{{name}}}"), value).replace(&format!("${name}"), value)
        });
        PathBuf::from(filled)
    };
    folders.iter().map(fill).collect()
}

/// Parses the names and paths in an `ldconfig` cache, in the format of glibc 2.2 and later.
fn parse_cache(bytes: &[u8]) -> Vec<(String, PathBuf)> {
    const MAGIC: &[u8] = b"glibc-ld.so.cache1.1";
    const HEADER_BYTES: usize = 48;
    const ENTRY_BYTES: usize = 24;
    // A cache in an older format may precede it; offsets are relative to the newer one.
    let Some(start) = bytes.windows(MAGIC.len()).position(|w| w == MAGIC) else { return Vec::new() };
    let all = &bytes[start..];
    let number = |at: usize| all.get(at..at + 4).and_then(|b| b.try_into().ok()).map(u32::from_ne_bytes);
    let text = |at: u32| {
        let rest = all.get(at as usize..)?;
        let end = rest.iter().position(|b| *b == 0)?;
        Some(String::from_utf8_lossy(&rest[..end]).into_owned())
    };
    let count = number(MAGIC.len()).unwrap_or(0) as usize;
    let places = (0..count).map(|i| HEADER_BYTES + i * ENTRY_BYTES).take_while(|at| at + ENTRY_BYTES <= all.len());
    places.filter_map(|at| Some((text(number(at + 4)?)?, PathBuf::from(text(number(at + 8)?)?)))).collect()
}

#[cfg(all(test, target_os = "linux", target_pointer_width = "64"))]
mod tests {
    use super::*;

    #[test]
    fn folder_variables_are_expanded() {
        let folders = ["$ORIGIN/../x", "${ORIGIN}", "/opt"].map(str::to_owned);
        let found = expand_variables(&folders, Path::new("/a/b/libtatu_x.so"));
        assert_eq!(found, ["/a/b/../x", "/a/b", "/opt"].map(PathBuf::from));
    }

    #[test]
    fn damaged_cache_has_no_entries() {
        assert!(parse_cache(b"").is_empty() && parse_cache(b"glibc-ld.so.cache1.1").is_empty());
        let mut long = b"glibc-ld.so.cache1.1".to_vec();
        long.extend([0xff; 100]);
        assert!(parse_cache(&long).is_empty());
    }

    #[test]
    fn own_program_has_all_libraries_and_symbols() {
        let exe = env::current_exe().unwrap();
        let mut loader = Loader::new();
        let own = loader.elf(&exe).unwrap();
        let (needs, libraries) = loader.needs(&exe, &own);
        assert!(needs.iter().any(|n| n.name.starts_with("libc.") && n.found.is_some()));
        assert_eq!(loader.missing_parts(&exe, &own, &needs, &libraries), None);
    }
}
