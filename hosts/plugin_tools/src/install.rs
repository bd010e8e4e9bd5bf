//! `tatu plugin install`: installs a plugin in the user's own folder, or removes it.

use std::{
    fs::{self, File},
    io,
    path::{Path, PathBuf},
    process::ExitCode,
};

use tatu_core::{
    document::SourceFiles,
    errors::{Error, Result},
    plugins::assets_folder,
};
use tatu_embed::search::{search_folders, user_folder};
use tempfile::{TempDir, TempPath};

use super::{
    answer::misnamed,
    archive, assets,
    examine::{CAN_READ_LIBRARIES, FileExaminer, FileReport},
    file,
    folders::{self, same_entry},
    names::{self, PluginQuery},
    probe,
    reason::{RejectReason, list_some},
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

fn unwritten(file: &Path, e: &io::Error) -> Error {
    Error::new("E105", format!("cannot write {}: {e}", file.display()))
        .help("check that the folder exists and is writable")
}

/// A library to be installed.
struct NewLibrary {
    file: PathBuf,
    /// The library's name in messages.
    shown: PathBuf,
    /// The temporary folder of an unpacked library, which is deleted when the value is dropped.
    _unpacked: Option<TempDir>,
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
    let plain = |file: PathBuf| NewLibrary { shown: file.clone(), file, _unpacked: None };
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
        (Some(one), 0) => Ok(NewLibrary { file: one.file, shown: source.to_owned(), _unpacked: Some(dir) }),
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

/// Copies a library into the folder, tests the copy, and renames it to its final name.
fn install_library(
    library: &NewLibrary,
    name: &str,
    force: bool,
    folder: &Path,
    examiner: &mut FileExaminer,
) -> Result<String> {
    let copy = staged_copy(&library.file, folder)?;
    // While the copy is tested, its assets must be beside it, in a folder named after the copy.
    let assets = StagedAssets::new(&library.file, &copy)?;
    let examined = examiner.examine(&copy);
    if let Some(reason) = examined.reason.clone().or_else(|| examined.offers_nothing()) {
        let reason = reason.renamed(&copy, &library.shown);
        // A library that can be loaded where it is finds something beside it that is not installed with it.
        let is_beside = reason.kind == "missing-library" && examiner.examine(&library.file).reason.is_none();
        let reason = if is_beside { beside_reason(&reason) } else { reason };
        return Err(refused(&library.shown, &reason));
    }
    let id = examined.id().unwrap_or_default();
    let target = folder.join(name);
    let old = replaceable(&examined, &id, &target, force, folder, examiner)?;
    assets.persist(&target)?;
    copy.persist(&target).map_err(|e| unwritten(&target, &e.error))?;
    let version = examined.version().unwrap_or_default();
    let text = match &old {
        Some((file, was)) => {
            if !same_entry(file, &target) {
                remove_files(file)?;
            }
            format!("replaced `{id}` {was} by {version}: {}", target.display())
        }
        None => format!("installed `{id}` {version}: {}", target.display()),
    };
    print_remarks(&examined, &target);
    if let Some(by) = hiding_file(&target, &id, examiner) {
        let text =
            format!("{} has the same id and is searched first, so the installed plugin is not used", by.display());
        report::warning(
            &Error::new("E302", text).help("remove that plugin, or remove its folder from TATU_PLUGIN_PATH"),
        );
    }
    Ok(text)
}

/// Returns the reason why a library is refused that needs another library beside it.
fn beside_reason(missing: &RejectReason) -> RejectReason {
    let text = missing.text.replace(", which is not found", "");
    RejectReason::new(
        missing.kind,
        format!("{text} beside it, but only the library of the plugin itself is installed"),
        "link that library statically, or install it where the loader finds it; until then, use the plugin where it is: \
         TATU_PLUGIN_PATH=FOLDER",
    )
}

/// The assets of a library that is being installed. They are removed when the value is dropped.
struct StagedAssets(Option<PathBuf>);

impl StagedAssets {
    /// Copies a library's folder of assets, if there is one, next to the staged copy of the library.
    fn new(library: &Path, staged: &Path) -> Result<Self> {
        let (Some(from), Some(to)) = (assets_folder(library), assets_folder(staged)) else {
            return Ok(StagedAssets(None));
        };
        if !from.is_dir() {
            return Ok(StagedAssets(None));
        }
        assets::replace(&from, &to).map_err(|e| unwritten(&to, &e))?;
        Ok(StagedAssets(Some(to)))
    }
    /// Moves the folder next to the installed library, replacing an older one.
    fn persist(mut self, target: &Path) -> Result {
        let Some(to) = assets_folder(target) else { return Ok(()) };
        let moved = assets::remove(&to).and_then(|()| match self.0.take() {
            Some(from) => fs::rename(from, &to),
            None => Ok(()),
        });
        moved.map_err(|e| unwritten(&to, &e))
    }
}

impl Drop for StagedAssets {
    fn drop(&mut self) {
        if let Some(folder) = self.0.take() {
            let _ = assets::remove(&folder);
        }
    }
}

/// Removes an installed library with its assets.
fn remove_files(library: &Path) -> Result {
    fs::remove_file(library).map_err(|e| unwritten(library, &e))?;
    let Some(folder) = assets_folder(library) else { return Ok(()) };
    assets::remove(&folder).map_err(|e| unwritten(&folder, &e))
}

/// Prints the remarks about a plugin that can be loaded.
fn print_remarks(examined: &FileReport, to: &Path) {
    // The remarks contain the temporary name under which the plugin was tested.
    let from = examined.file.display().to_string();
    for remark in examined.report.iter().flat_map(|r| &r.remarks) {
        let text = remark.text.replace(&from, &to.display().to_string());
        report::warn_text(&format!("[{}] {text} ({})", remark.code, remark.help));
    }
}

/// Copies a library into the folder under a name that is never opened, so that only a complete file gets the final
/// name.
fn staged_copy(file: &Path, folder: &Path) -> Result<TempPath> {
    make_folder(folder).map_err(|e| unwritten(folder, &e))?;
    let fail = |e: io::Error| unwritten(folder, &e);
    let copy = tempfile::Builder::new().prefix(".tatu-").suffix(std::env::consts::DLL_SUFFIX).tempfile_in(folder);
    let mut copy = copy.map_err(fail)?;
    let mut from = File::open(file).map_err(|e| {
        Error::new("E105", format!("cannot read {}: {e}", file.display())).help("check that it is readable")
    })?;
    io::copy(&mut from, copy.as_file_mut()).map_err(fail)?;
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        copy.as_file().set_permissions(fs::Permissions::from_mode(0o644)).map_err(fail)?;
    }
    copy.as_file().sync_all().map_err(fail)?;
    Ok(copy.into_temp_path())
}

/// Creates the folder, readable by all users.
fn make_folder(folder: &Path) -> io::Result<()> {
    if folder.is_dir() {
        return Ok(());
    }
    let mut builder = fs::DirBuilder::new();
    #[cfg(unix)]
    std::os::unix::fs::DirBuilderExt::mode(&mut builder, 0o755);
    builder.recursive(true).create(folder)
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
    remove_files(file)?;
    let id = examined.id().unwrap_or_else(|| id.to_owned());
    Ok(format!("removed `{id}` {}: {}", examined.version().unwrap_or_default(), file.display()))
}
