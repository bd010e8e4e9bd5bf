//! `tatu export`: writes a robot or a scene as a file of another format, with its meshes beside it, and reports what the
//! format does not hold.
//!
//! The file is written by the command `export.SUFFIX` of a plugin, which returns the text of the file, further files and
//! the report; this module writes them.

use std::{
    fmt::Write as _,
    path::{Component, Path, PathBuf},
    process::ExitCode,
};

use tatu_core::{
    World,
    document::SourceFiles,
    errors::{Error, Fault},
    plugins::Registry,
    state::write_atomically,
};
use tatu_plugin_api::safe::Value;
use tatu_terminal::{Watchdog, report};

use crate::args::ExportArgs;

/// What precedes the suffix in the name of an exporter's command.
const COMMANDS: &str = "export.";
/// Number of objects that a line of the report lists.
const MAX_LISTED: usize = 5;

/// Exports a scene; the exit code is 0 if the file was written, otherwise 2.
pub fn export(args: &ExportArgs) -> ExitCode {
    match exported(args) {
        Ok(()) => ExitCode::SUCCESS,
        Err(e) => {
            report::error(&e);
            ExitCode::from(2)
        }
    }
}

fn exported(args: &ExportArgs) -> Result<(), Error> {
    let watchdog = Watchdog::start(args.watchdog, false);
    let sources = SourceFiles::default();
    // The id of a model is no file.
    let file = Some(args.scene.as_path()).filter(|file| file.exists());
    let registry = super::registry(file, &sources, &args.changes, &watchdog)?;
    let command = exporter_of(&args.output, &registry)?;
    let options = args.changes.options(&[])?;
    let scene = scene_of(&args.scene, &registry, &options.sources);
    let world = World::new(super::load(&scene, &options, &registry)?, registry)?;
    watchdog.world(&world, false);
    let object = args.object.as_deref().map(|path| find(&world, path)).transpose()?.unwrap_or_default();
    let name = args.output.file_stem().map(|stem| stem.to_string_lossy().into_owned()).unwrap_or_default();
    let results = world.call(&command, &[object, Value::from(name)]).map_err(|fault| failed(*fault, &args.scene))?;
    let exported = ExportedFiles::read(&results, &args.output).map_err(|why| {
        Error::new("E127", format!("the command `{command}` broke its contract: {why}"))
            .expected("a text, a map of further files, and a report: see `docs/plugin-authors/exporters.md`")
    })?;
    report::out!("{}", exported.text(&args.output).trim_end());
    let lost = exported.report.iter().filter(|entry| entry.is_lost).count();
    if args.strict && lost > 0 {
        return Err(Error::new("E123", format!("{lost} kind(s) of parts were changed or left out, see above"))
            .help("without `--strict`, the rest is exported"));
    }
    exported.write(args.overwrite)?;
    report::out!("written: {}", args.output.display());
    Ok(())
}

/// Returns the command that writes files with the suffix of `output`.
fn exporter_of(output: &Path, registry: &Registry) -> Result<String, Error> {
    let suffix = output.extension().map(|e| e.to_string_lossy().to_lowercase()).unwrap_or_default();
    let name = format!("{COMMANDS}{suffix}");
    if !suffix.is_empty() && registry.command(&name).is_some() {
        return Ok(name);
    }
    let names = registry.command_offers.commands.iter().flat_map(|command| &command.names);
    let mut known: Vec<String> =
        names.filter_map(|n| n.name.strip_prefix(COMMANDS)).map(|suffix| format!(".{suffix}")).collect();
    known.sort();
    let error = Error::new("E127", format!("no exporter writes {}", output.display()));
    let error = match known.is_empty() {
        true => error.expected("a plugin that offers an exporter; none was found"),
        false => error.expected(format!("a name that ends with one of: {}", known.join(", "))),
    };
    Err(if suffix == "toml" { error.help("`tatu convert` writes scene files") } else { error })
}

/// Returns the file of the scene to export. A model that is named by its id is placed in a scene of its own.
fn scene_of(scene: &Path, registry: &Registry, sources: &SourceFiles) -> PathBuf {
    let is_model =
        |id: &&str| registry.model_offers.models.iter().any(|m| m.id == *id) || registry.find_model(id).is_some();
    let id = scene.to_str().filter(|_| !scene.exists()).filter(is_model);
    let Some(id) = id else { return scene.to_owned() };
    let file = PathBuf::from(format!("{id}.toml"));
    sources.add_file(&file, format!("format = 1\n[[model]]\nmodel = {id:?}\n").into_bytes());
    file
}

/// Returns the object at a path as an argument of the command.
fn find(world: &World, path: &str) -> Result<Value, Error> {
    let found = world.with_scene(|scene, _| scene.find(0, path).map(|slot| scene.id(slot)));
    found.map(Value::Object).ok_or_else(|| {
        let error = Error::new("E110", format!("there is no object `{path}`")).expected("the path of an object");
        match world.nearest(path) {
            Some(near) => error.help(format!("did you mean `{near}`?")),
            None => error,
        }
    })
}

fn failed(fault: Fault, scene: &Path) -> Error {
    let error = Error::new("E127", format!("cannot export {}: {}", scene.display(), fault.message));
    match fault.help {
        Some(help) => error.help(help),
        None => error,
    }
}

/// A line of the report of an exporter.
struct ReportEntry {
    is_lost: bool,
    text: String,
    objects: Vec<String>,
}

/// The files that an exporter made, and its report.
struct ExportedFiles {
    files: Vec<(PathBuf, Vec<u8>)>,
    report: Vec<ReportEntry>,
}

fn bytes_of(value: &Value) -> Option<&[u8]> {
    match value {
        Value::Text(bytes) | Value::Bytes(bytes) => Some(bytes),
        _ => None,
    }
}

fn text_of(value: &Value) -> Option<String> {
    bytes_of(value).map(|bytes| String::from_utf8_lossy(bytes).into_owned())
}

/// Returns the entries of a map. An empty one may be a list.
fn entries_of(value: Option<&Value>) -> Option<&[(Value, Value)]> {
    match value {
        Some(Value::Map(entries)) => Some(entries),
        Some(Value::List(list)) if list.is_empty() => Some(&[]),
        None | Some(Value::Nil) => Some(&[]),
        _ => None,
    }
}

impl ExportedFiles {
    /// Reads the results of the command; `output` is the file to write. The error says what is wrong with them.
    fn read(results: &[Value], output: &Path) -> Result<Self, String> {
        let main = results.first().and_then(bytes_of).ok_or("its first result is not a text")?;
        let folder = output.parent().unwrap_or(Path::new(""));
        let mut files = Vec::new();
        for (name, content) in entries_of(results.get(1)).ok_or("its second result is not a map")? {
            let name = text_of(name).ok_or("a file has no name")?;
            let content = bytes_of(content).ok_or_else(|| format!("the file `{name}` is not a text"))?;
            let is_beneath = Path::new(&name).components().all(|part| matches!(part, Component::Normal(_)));
            if !is_beneath || name.is_empty() {
                return Err(format!("the file `{name}` would not be beneath the folder of the exported file"));
            }
            files.push((folder.join(name), content.to_vec()));
        }
        // The file itself is written last, so that it is never without its meshes.
        files.push((output.to_owned(), main.to_vec()));
        let list = match results.get(2) {
            Some(Value::List(list)) => list.as_slice(),
            None | Some(Value::Nil) => &[],
            Some(Value::Map(entries)) if entries.is_empty() => &[],
            _ => return Err("its third result is not a list".to_owned()),
        };
        let report = list.iter().map(|entry| entry_of(entry).ok_or("an entry of its report has no text"));
        Ok(ExportedFiles { files, report: report.collect::<Result<_, _>>()? })
    }

    fn text(&self, output: &Path) -> String {
        let mut text = format!("{}\n", output.display());
        let others = self.files.len() - 1;
        if others > 0 {
            let _ = writeln!(text, "  {others} file{} beside it", if others == 1 { "" } else { "s" });
        }
        for lost in [false, true] {
            for entry in self.report.iter().filter(|entry| entry.is_lost == lost) {
                let title = if lost { "changed or left out" } else { "note" };
                let _ = write!(text, "  {title}: {}", entry.text);
                let listed: Vec<&str> = entry.objects.iter().take(MAX_LISTED).map(String::as_str).collect();
                if !listed.is_empty() {
                    let _ = write!(text, ": {}", listed.join(", "));
                }
                let more = entry.objects.len() - listed.len();
                let _ = if more > 0 { writeln!(text, " and {more} more") } else { writeln!(text) };
            }
        }
        text
    }

    /// Returns a file to be written, or a folder beneath that of the exported file, that is a link.
    fn link(&self) -> Option<&Path> {
        let folder = self.files.last()?.0.parent()?;
        let mut paths = self.files.iter().flat_map(|(file, _)| file.ancestors().take_while(move |at| *at != folder));
        paths.find(|path| path.is_symlink())
    }

    /// Writes all files. Existing ones with another content are replaced only on request, and nothing is written if there
    /// is one: exports of one robot in two formats can share a folder, and with it the meshes.
    fn write(&self, overwrite: bool) -> Result<(), Error> {
        let is_foreign = |(path, content): &&(PathBuf, Vec<u8>)| {
            std::fs::symlink_metadata(path).is_ok_and(|found| {
                !found.is_file()
                    || found.len() != content.len() as u64
                    || std::fs::read(path).ok().as_ref() != Some(content)
            })
        };
        if let Some((path, _)) = self.files.iter().find(is_foreign).filter(|_| !overwrite) {
            return Err(Error::new("E105", format!("{} exists", path.display()))
                .expected("names of files that do not exist, or have the same content")
                .help("choose another folder, or add `--overwrite`"));
        }
        if let Some(link) = self.link() {
            return Err(Error::new("E105", format!("{} is a link", link.display()))
                .expected("files and folders, since what a link points to could be anywhere")
                .help("choose another folder, or remove the link"));
        }
        for (path, content) in &self.files {
            let refused = |e: std::io::Error| Error::new("E105", format!("cannot write {}: {e}", path.display()));
            if let Some(folder) = path.parent().filter(|folder| !folder.as_os_str().is_empty()) {
                std::fs::create_dir_all(folder).map_err(refused)?;
            }
            write_atomically(path, content).map_err(refused)?;
        }
        Ok(())
    }
}

fn entry_of(value: &Value) -> Option<ReportEntry> {
    let Value::Map(entries) = value else { return None };
    let get = |key: &str| entries.iter().find(|(k, _)| bytes_of(k) == Some(key.as_bytes())).map(|(_, v)| v);
    let objects = match get("objects") {
        Some(Value::List(list)) => list.iter().filter_map(text_of).collect(),
        _ => Vec::new(),
    };
    Some(ReportEntry { is_lost: get("lost") == Some(&Value::Bool(true)), text: text_of(get("text")?)?, objects })
}
