//! `tatu plugin install`: installs a plugin in the user's own folder, or removes it.

use std::{
    fs::{self, File},
    io::{self, Read},
    path::{Path, PathBuf},
    process::ExitCode,
};

use tatu_core::{
    document::SourceFiles,
    errors::{Error, Result},
    plugins::assets_folder,
};
use tatu_embed::search::{search_folders, user_folder};
use tempfile::TempDir;

use super::{
    answer::misnamed,
    archive, assets, beside,
    examine::{CAN_READ_LIBRARIES, FileExaminer, FileReport},
    file,
    folders::{self, same_entry},
    names::{self, PluginQuery},
    probe,
    reason::{RejectReason, list_some},
    staged::{StagedPlugin, unwritten},
};
use tatu_terminal::report;

#[derive(clap::Args)]
#[command(after_help = EXAMPLES)]
pub struct InstallArgs {
    /// A library, the folder of a built project, or an archive that contains a library (.tar, .tar.gz, .zip).
    #[arg(value_name = "FILE|FOLDER|ARCHIVE", required_unless_present = "remove", conflicts_with = "remove")]
    pub source: Option<PathBuf>,
    /// Replace an installed plugin with the same id, whichever version is higher.
    #[arg(long)]
    pub force: bool,
    /// Remove the installed plugin with this id.
    #[arg(long, value_name = "ID", conflicts_with = "force")]
    pub remove: Option<String>,
    /// Seconds of real time after which a plugin that has not started is abandoned; 0: never.
    #[arg(long, value_name = "S", default_value_t = 10.0, value_parser = probe::limit)]
    pub watchdog: f64,
}

const EXAMPLES: &str = "Examples:
  tatu plugin install build/libtatu_hello.so
  tatu plugin install .                          the library in build/, here, or in target/release/
  tatu plugin install hello-1.0.0.tar.gz --force
  tatu plugin install --remove org.example.hello

A plugin is tested before it is installed. Nothing is downloaded.
Exit code 0: done; 2: nothing was changed.";

/// Subfolders of a project that may contain its library.
const LIBRARY_FOLDERS: [&str; 4] = ["build", "", "target/release", "target/debug"];

/// Installs or removes a plugin; the exit code is 2 if nothing was changed.
pub fn install(args: &InstallArgs) -> ExitCode {
    let Some(folder) = user_folder() else {
        let error = Error::new(
            "E330",
            "there is no folder for your plugins, because the environment does not name a home folder",
        );
        let variable = if cfg!(windows) { "APPDATA" } else { "HOME" };
        report::error(&error.help(format!("set {variable} to an absolute path")));
        return ExitCode::from(2);
    };
    let mut examiner = FileExaminer::new(args.watchdog);
    let done = match (&args.remove, &args.source) {
        (Some(id), _) => remove(id, &folder, &mut examiner),
        (None, source) => install_from(source.as_deref().unwrap_or(Path::new(".")), args.force, &folder, &mut examiner),
    };
    match done {
        Ok(text) => {
            report::out!("{text}");
            ExitCode::SUCCESS
        }
        Err(e) => {
            report::error(&e);
            ExitCode::from(2)
        }
    }
}

fn refused(what: &Path, reason: &RejectReason) -> Error {
    Error::new("E330", format!("cannot install {}: {}", what.display(), reason.text)).help(reason.help.clone())
}

/// A library to be installed.
struct NewLibrary {
    file: PathBuf,
    /// The library's name in messages.
    shown: PathBuf,
    /// The temporary folder of an unpacked library, which is deleted when the value is dropped.
    unpacked: Option<TempDir>,
}

impl NewLibrary {
    /// Returns a reason in terms of what the user gave.
    fn explained(&self, reason: RejectReason) -> RejectReason {
        let mut reason = reason.renamed(&self.file, &self.shown);
        if self.unpacked.is_some() && reason.kind == "missing-library" {
            reason.help = format!(
                "if it is in the archive: unpack the archive, and install the plugin from there, since only the \
                 library of the plugin itself is taken from an archive; otherwise {}",
                reason.help
            );
        }
        reason
    }
}

/// Installs a plugin from a file, folder or archive; returns a message about what was done.
fn install_from(source: &Path, force: bool, folder: &Path, examiner: &mut FileExaminer) -> Result<String> {
    let library = library(source)?;
    let name = names::name(&library.file);
    if let Some(reason) = file::links(&library.file).1.or_else(|| file::rejection(&library.file)) {
        return Err(refused(&library.shown, &reason));
    }
    if !names::is_plugin_name(&library.file) {
        return Err(refused(&library.shown, &misnamed(&library.file)));
    }
    let was_there = folder.is_dir();
    let done = install_library(&library, &name, force, folder, examiner);
    if done.is_err() && !was_there {
        // This fails if another process has put a file into the folder in the meantime.
        let _ = fs::remove_dir(folder);
    }
    done
}

/// Finds the library that a file, folder or archive contains.
fn library(source: &Path) -> Result<NewLibrary> {
    let plain = |file: PathBuf| NewLibrary { shown: file.clone(), file, unpacked: None };
    let fail = |text: String, help: &str| Err(refused(source, &RejectReason::new("no-library", text, help)));
    if source.is_dir() {
        let right = |place: &str| {
            let entries = fs::read_dir(source.join(place)).into_iter().flatten();
            let mut all: Vec<PathBuf> = entries.filter_map(|e| e.ok().map(|e| e.path())).collect();
            all.retain(|f| names::is_plugin_name(f));
            all.sort();
            all
        };
        let found = LIBRARY_FOLDERS.iter().map(|p| right(p)).find(|all| !all.is_empty()).unwrap_or_default();
        return match <[PathBuf; 1]>::try_from(found) {
            Ok([one]) => Ok(plain(one)),
            Err(all) if all.is_empty() => {
                let text =
                    format!("there is no {} in it, nor in build/, target/release/ or target/debug/", names::form());
                fail(text, "build the plugin first, or name its library")
            }
            Err(all) => {
                let shown: Vec<String> = all.iter().map(|f| f.display().to_string()).collect();
                fail(
                    format!("it contains {} plugins: {}", all.len(), list_some(&shown, 4)),
                    "name the library to install",
                )
            }
        };
    }
    let Some(format) = source.is_file().then(|| archive::format(source)).flatten() else {
        return Ok(plain(source.to_owned()));
    };
    let dir = TempDir::with_prefix("tatu-").map_err(|e| unwritten(&std::env::temp_dir(), &e))?;
    let mut all = archive::unpack(source, format, dir.path()).map_err(|reason| refused(source, &reason))?;
    match (all.pop(), all.len()) {
        (Some(one), 0) => Ok(NewLibrary { file: one.file, shown: source.to_owned(), unpacked: Some(dir) }),
        (None, _) => {
            let text = format!("there is no {} in it", names::form());
            fail(
                text,
                "an archive must contain a built library; build the plugin first if the archive contains its sources",
            )
        }
        (Some(last), _) => {
            all.push(last);
            let shown: Vec<&str> = all.iter().map(|u| u.name.as_str()).collect();
            let text = format!("it contains {} plugins: {}", all.len(), list_some(&shown, 4));
            fail(text, "unpack it, and install one of the libraries")
        }
    }
}

/// Copies a plugin into a temporary folder, tests the copy, moves it to its place, and tests it there.
fn install_library(
    library: &NewLibrary,
    name: &str,
    force: bool,
    folder: &Path,
    examiner: &mut FileExaminer,
) -> Result<String> {
    let refuse = |reason: RejectReason| Err(refused(&library.shown, &library.explained(reason)));
    let here = examiner.read(&library.file);
    let libraries = beside::libraries(&here, examiner);
    if let Some(reason) = here.reason.clone().or_else(|| libraries.iter().find_map(|f| beside::rejection(f))) {
        return refuse(reason);
    }
    let staged = StagedPlugin::new(&library.file, &libraries, folder)?;
    let examined = examiner.examine(staged.library());
    let source = library.file.parent().unwrap_or(Path::new("."));
    if let Some(reason) = examined.reason.clone().or_else(|| examined.offers_nothing()) {
        let reason = beside::lost(&here, &examined).unwrap_or(reason);
        return refuse(reason.renamed(staged.library(), &library.file).renamed(staged.folder(), source));
    }
    let id = examined.id().unwrap_or_default();
    let target = folder.join(name);
    let old = replaceable(&examined, &id, &target, force, folder, examiner)?;
    check_shared(&libraries, old.as_ref(), force, folder, examiner)?;
    let was_needed = old.as_ref().map(|(file, _)| examiner.read(file)).map(|e| beside::libraries(&e, examiner));
    let placed = staged.place()?;
    // A path that is relative to the plugin may lead elsewhere from here. What was read before has changed.
    *examiner = examiner.anew();
    let examined = examiner.examine(&target);
    if let Some(reason) = examined.reason.clone().or_else(|| examined.offers_nothing()) {
        let reason = beside::lost(&here, &examined).unwrap_or(reason);
        return refuse(reason.renamed(&target, &library.file));
    }
    placed.keep();
    let version = examined.version().unwrap_or_default();
    let text = match &old {
        Some((file, was)) => {
            if !same_entry(file, &target) {
                remove_files(file)?;
            }
            remove_unneeded(&was_needed.unwrap_or_default(), folder, examiner)?;
            format!("replaced `{id}` {was} by {version}: {}", target.display())
        }
        None => format!("installed `{id}` {version}: {}", target.display()),
    };
    let with: Vec<String> = libraries.iter().map(|f| names::name(f)).collect();
    let text = if with.is_empty() { text } else { format!("{text}, with {}", with.join(", ")) };
    print_remarks(&examined);
    if let Some(by) = hiding_file(&target, &id, examiner) {
        let text =
            format!("{} has the same id and is searched first, so the installed plugin is not used", by.display());
        report::warning(
            &Error::new("E302", text).help("remove that plugin, or remove its folder from TATU_PLUGIN_PATH"),
        );
    }
    Ok(text)
}

/// Fails if a library of a plugin would replace a different file that another plugin needs, or that no plugin needs.
fn check_shared(
    libraries: &[PathBuf],
    old: Option<&(PathBuf, String)>,
    force: bool,
    folder: &Path,
    examiner: &mut FileExaminer,
) -> Result {
    let others = installed(folder, examiner);
    for library in libraries {
        let there = folder.join(names::name(library));
        if there.symlink_metadata().is_err() || same_contents(library, &there) {
            continue;
        }
        let needs = |e: &FileReport| beside::libraries(e, examiner).iter().any(|f| same_entry(f, &there));
        let mut needing = others.iter().filter(|(f, e)| old.is_none_or(|(old, _)| f != old) && needs(e));
        let error = |text: &str, help: &str| {
            Err(Error::new("E331", format!("{} already exists: {text}", there.display())).help(help))
        };
        match needing.next() {
            Some((file, other)) => {
                let other = other.id().unwrap_or_else(|| names::name(file));
                let text = format!("the plugin `{other}` needs it, and its contents differ");
                return error(&text, "give your library another name, or link it statically");
            }
            None if force => {}
            None => return error("its contents differ, and no other plugin needs it", "`--force` replaces it"),
        }
    }
    Ok(())
}

/// Returns whether two files have the same contents.
fn same_contents(one: &Path, other: &Path) -> bool {
    let length = |f: &Path| fs::metadata(f).ok().map(|m| m.len());
    if length(one) != length(other) {
        return false;
    }
    let read = |f: &Path| File::open(f).map(io::BufReader::new).map(|f| f.bytes());
    let (Ok(one), Ok(other)) = (read(one), read(other)) else { return false };
    let (mut one, mut other) = (one.map(Result::ok), other.map(Result::ok));
    loop {
        match (one.next(), other.next()) {
            (None, None) => return true,
            (Some(Some(a)), Some(Some(b))) if a == b => {}
            _ => return false,
        }
    }
}

/// Removes an installed library with its assets.
fn remove_files(library: &Path) -> Result {
    fs::remove_file(library).map_err(|e| unwritten(library, &e))?;
    let Some(folder) = assets_folder(library) else { return Ok(()) };
    assets::remove(&folder).map_err(|e| unwritten(&folder, &e))
}

/// Removes those of the libraries that no installed plugin needs.
fn remove_unneeded(libraries: &[PathBuf], folder: &Path, examiner: &mut FileExaminer) -> Result {
    let needed: Vec<PathBuf> =
        installed(folder, examiner).iter().flat_map(|(_, e)| beside::libraries(e, examiner)).collect();
    for library in libraries.iter().filter(|f| !needed.iter().any(|n| same_entry(n, f))) {
        fs::remove_file(library).map_err(|e| unwritten(library, &e))?;
    }
    Ok(())
}

/// Prints the remarks about a plugin that can be loaded.
fn print_remarks(examined: &FileReport) {
    for remark in examined.report.iter().flat_map(|r| &r.remarks) {
        report::warn_text(&format!("[{}] {} ({})", remark.code, remark.text, remark.help));
    }
}

/// Returns the installed file that a new one replaces, with its version, or `None` if there is none. Fails if a file
/// must not be replaced.
fn replaceable(
    new: &FileReport,
    id: &str,
    target: &Path,
    force: bool,
    folder: &Path,
    examiner: &mut FileExaminer,
) -> Result<Option<(PathBuf, String)>> {
    let all = installed(folder, examiner);
    let old = all.iter().find(|(_, other)| other.id().as_deref() == Some(id));
    let in_the_way = all.iter().find(|(f, other)| same_entry(f, target) && other.id().as_deref() != Some(id));
    let version = |e: &FileReport| e.version().unwrap_or_default();
    if let Some((file, other)) = in_the_way {
        let error = |text: String| Error::new("E331", format!("{} already exists: {text}", file.display()));
        return match other.id() {
            Some(other) => Err(error(format!("it is the plugin `{other}`"))
                .help(format!("rename your library, or remove that plugin: `tatu plugin install --remove {other}`"))),
            None if force => Ok(old.map(|(f, e)| (f.clone(), version(e)))),
            None => Err(error("it is not a plugin that can be loaded".into()).help("`--force` replaces it")),
        };
    }
    match old {
        Some((file, old)) if !force => {
            let text = format!(
                "`{id}` is installed already: version {} as {}, and this is version {}",
                version(old),
                file.display(),
                version(new)
            );
            Err(Error::new("E331", text).help("`--force` replaces it"))
        }
        old => Ok(old.map(|(f, e)| (f.clone(), version(e)))),
    }
}

/// Returns the installed plugins. Libraries are loaded only on systems whose library format this program cannot parse.
fn installed(folder: &Path, examiner: &mut FileExaminer) -> Vec<(PathBuf, FileReport)> {
    let entries = fs::read_dir(folder).into_iter().flatten();
    let mut files: Vec<PathBuf> = entries.filter_map(|e| e.ok().map(|e| e.path())).collect();
    files.retain(|f| names::is_plugin_name(f));
    files.sort();
    let look = |f: PathBuf| {
        let examined = if CAN_READ_LIBRARIES { examiner.read(&f) } else { examiner.examine(&f) };
        (f, examined)
    };
    files.into_iter().map(look).collect()
}

/// Returns the file that hides an installed file when no scene is given.
fn hiding_file(target: &Path, id: &str, examiner: &mut FileExaminer) -> Option<PathBuf> {
    let folders = folders::list_folders(&search_folders(None, &SourceFiles::default(), &[]).ok()?);
    examiner.hidden_by(target, id, &folders)
}

/// Removes an installed plugin by its id, or by its name if its id cannot be read; returns a message about what was
/// done.
fn remove(id: &str, folder: &Path, examiner: &mut FileExaminer) -> Result<String> {
    let all = installed(folder, examiner);
    let wanted = PluginQuery::new(id);
    let by_id = all.iter().find(|(_, e)| e.id().as_deref() == Some(id));
    let by_name = || all.iter().find(|(f, _)| !PluginQuery::is_id(id) && wanted.matches(f));
    let Some((file, examined)) = by_id.or_else(by_name) else {
        let text = format!("no plugin with the id `{id}` is installed in {}", folder.display());
        let ids: Vec<String> = all.iter().filter_map(|(_, e)| e.id()).collect();
        let error = Error::new("E332", text).nearest(id, ids.iter().map(String::as_str));
        let has_help = error.help.is_some();
        return Err(if has_help { error } else { error.help("`tatu plugin list` shows what is installed") });
    };
    let libraries = beside::libraries(examined, examiner);
    remove_files(file)?;
    remove_unneeded(&libraries, folder, examiner)?;
    let id = examined.id().unwrap_or_else(|| id.to_owned());
    Ok(format!("removed `{id}` {}: {}", examined.version().unwrap_or_default(), file.display()))
}
