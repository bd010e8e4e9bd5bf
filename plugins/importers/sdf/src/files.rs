//! Reads a file together with the models that it includes.
//!
//! `<include>` is replaced by the model of the other file, with the name, pose and flags that the include states. Lines are
//! counted through all files, so that one number tells the file and the line in it.

use std::collections::BTreeMap;

use tatu_importers_robots::{Element, FindingKind, Findings, is_true, shortened};
use tatu_plugin_api::safe::{Builder, Fail, Result};

use crate::xml::parse;

/// Maximum size of the text of all files, bytes.
pub const MAX_BYTES: usize = 1 << 25;
/// Maximum number of files.
const MAX_FILES: usize = 1000;
/// Maximum number of elements, with those of files that are included several times.
const MAX_ELEMENTS: usize = 1_000_000;
/// Maximum number of files that include each other.
const MAX_INCLUDES: usize = 16;
/// The latest version of the format that is known.
const LATEST: FormatVersion = (1, 12);

/// The models `sun` and `ground_plane`, for those who do not have them: a light from above, and an endless floor.
const STAND_INS: [(&str, &str); 2] = [
    (
        "sun",
        "<sdf version='1.9'><light name='sun' type='directional'><pose>0 0 10 0 0 0</pose>\
         <direction>-0.5 0.1 -0.9</direction><diffuse>0.8 0.8 0.8 1</diffuse></light></sdf>",
    ),
    (
        "ground_plane",
        "<sdf version='1.9'><model name='ground_plane'><static>true</static><link name='link'>\
         <collision name='collision'><geometry><plane><size>100 100</size></plane></geometry></collision>\
         <visual name='visual'><geometry><plane><size>100 100</size></plane></geometry></visual></link></model></sdf>",
    ),
];

/// Version of the format: major and minor number.
pub type FormatVersion = (u32, u32);

/// A file that has been read.
struct SourceFile {
    /// Its name, relative to the imported file or as a URI; empty for that file itself.
    name: String,
    /// Number of lines in the files before.
    before: u64,
    version: FormatVersion,
    root: Element,
}

/// The files that have been read, and where their lines are.
pub struct SourceFiles<'w, 'b> {
    builder: &'w Builder<'b>,
    files: Vec<SourceFile>,
    /// Numbers of files by their names.
    known: BTreeMap<String, usize>,
    bytes: usize,
    lines: u64,
    elements: usize,
}

impl<'w, 'b> SourceFiles<'w, 'b> {
    pub fn new(builder: &'w Builder<'b>) -> Self {
        SourceFiles { builder, files: Vec::new(), known: BTreeMap::new(), bytes: 0, lines: 0, elements: 0 }
    }

    /// Reads the imported file with all that it includes.
    pub fn read(&mut self, bytes: &[u8], findings: &Findings) -> Result<Element> {
        let main = self.add("", bytes)?;
        let mut root = self.files[main].root.clone();
        self.expand(&mut root, &mut vec![main], findings)?;
        Ok(root)
    }

    fn add(&mut self, name: &str, bytes: &[u8]) -> Result<usize> {
        self.bytes += bytes.len();
        if self.bytes > MAX_BYTES || self.files.len() >= MAX_FILES {
            let text = format!("the files have more than {MAX_BYTES} bytes of XML, or are more than {MAX_FILES}");
            return Err(Fail::argument(text).at(name, 1));
        }
        let before = self.lines;
        let number = self.files.len();
        // Lines of errors are found in the list of files.
        self.files.push(SourceFile { name: name.to_owned(), before, version: LATEST, root: Element::default() });
        self.lines += bytes.iter().filter(|b| **b == b'\n').count() as u64 + 1;
        let text = std::str::from_utf8(bytes).map_err(|e| {
            let line = bytes[..e.valid_up_to()].iter().filter(|b| **b == b'\n').count() as u64 + 1;
            Fail::argument("the file is not valid UTF-8 text").at("", before + line)
        })?;
        let root = parse(text, before)?;
        // Before version 1.3, the root had another name.
        if root.name != "sdf" && root.name != "gazebo" {
            return Err(root.fail(format!("the root element is <{}>; expected <sdf>", root.name)));
        }
        self.files[number].version = version(root.attribute("version"));
        self.files[number].root = root;
        self.known.insert(name.to_owned(), number);
        Ok(number)
    }

    /// Returns the name of the file and the line in it.
    pub fn origin(&self, line: u64) -> (&str, u64) {
        match self.file_of(line) {
            Some(file) if line > 0 => (&file.name, line - file.before),
            _ => ("", 0),
        }
    }

    fn file_of(&self, line: u64) -> Option<&SourceFile> {
        self.files[..self.files.partition_point(|file| file.before < line)].last()
    }

    /// Returns an error with the place in its file.
    pub fn located(&self, error: Fail) -> Fail {
        match error.place() {
            Some(("", line)) => {
                let (file, line) = self.origin(line);
                error.at(file, line)
            }
            _ => error,
        }
    }

    /// Returns the version of the format in which an element is written.
    pub fn version(&self, element: &Element) -> FormatVersion {
        self.file_of(element.line).map_or(LATEST, |file| file.version)
    }

    /// Returns the path or URI of a file that an element names.
    pub fn path(&self, element: &Element, uri: &str) -> String {
        let own = self.file_of(element.line).map_or("", |file| file.name.as_str());
        let folder = own.rsplit_once('/').map_or("", |(folder, _)| folder);
        let uri = uri.trim().replace('\\', "/");
        if let Some(path) = of_server(&uri) {
            return path;
        }
        if uri.contains("://") { uri } else { join(folder, &uri) }
    }

    /// Replaces the includes in an element. `open` has the files that are being read.
    fn expand(&mut self, element: &mut Element, open: &mut Vec<usize>, findings: &Findings) -> Result {
        self.elements += element.children.len();
        if self.elements > MAX_ELEMENTS {
            return Err(element.fail(format!("the file and its includes have more than {MAX_ELEMENTS} elements")));
        }
        if !matches!(element.name.as_str(), "sdf" | "gazebo" | "world" | "model" | "population") {
            return Ok(());
        }
        for mut child in std::mem::take(&mut element.children) {
            if child.name != "include" {
                self.expand(&mut child, open, findings)?;
                element.children.push(child);
                continue;
            }
            let Some(uri) = child.text_of("uri").map(str::to_owned) else {
                return Err(child.fail("<include> has no <uri>"));
            };
            let found = match self.find(&child, &uri, findings)? {
                None => self.stand_in(&child, &uri, findings)?,
                found => found,
            };
            let Some(number) = found else {
                let text = format!("`{}` is left out: it was not found", shortened(&uri));
                findings.warn(FindingKind::Include, child.line, text);
                continue;
            };
            if open.contains(&number) {
                return Err(child.fail(format!("`{}` includes itself", shortened(&uri))));
            }
            if open.len() > MAX_INCLUDES {
                return Err(child.fail(format!("more than {MAX_INCLUDES} files include each other")));
            }
            open.push(number);
            let mut included = included(&self.files[number].root, &child, &uri)?;
            self.elements += count(&included);
            self.expand(&mut included, open, findings)?;
            open.pop();
            element.children.push(included);
        }
        Ok(())
    }

    /// Finds the file that an include names. Returns its number.
    fn find(&mut self, include: &Element, uri: &str, findings: &Findings) -> Result<Option<usize>> {
        let path = self.path(include, uri);
        let is_file = [".sdf", ".world", ".xml"].iter().any(|suffix| path.to_lowercase().ends_with(suffix));
        if is_file {
            return self.open(&path);
        }
        let folder = path.trim_end_matches('/');
        let names = match self.builder.file(&format!("{folder}/model.config")) {
            Some(config) => described(config).unwrap_or_else(|e| {
                let text = format!("`{}/model.config` cannot be read: {}", shortened(folder), e.text());
                findings.warn(FindingKind::Include, include.line, text);
                Vec::new()
            }),
            None => Vec::new(),
        };
        for name in names.iter().map(String::as_str).chain(["model.sdf"]) {
            if let Some(number) = self.open(&join(folder, name))? {
                return Ok(Some(number));
            }
        }
        Ok(None)
    }

    /// Returns the file that stands in for a model that nearly every world includes, and that Gazebo brings along.
    fn stand_in(&mut self, include: &Element, uri: &str, findings: &Findings) -> Result<Option<usize>> {
        let name = uri.trim_end_matches('/').rsplit('/').next().unwrap_or_default().to_lowercase().replace(' ', "_");
        let Some((_, text)) = STAND_INS.iter().find(|(own, _)| *own == name) else { return Ok(None) };
        findings.note(FindingKind::Include, include.line, format!("a simple model stands in for `{name}`"));
        match self.known.get(&name) {
            Some(number) => Ok(Some(*number)),
            None => self.add(&name, text.as_bytes()).map(Some),
        }
    }

    fn open(&mut self, path: &str) -> Result<Option<usize>> {
        if let Some(number) = self.known.get(path) {
            return Ok(Some(*number));
        }
        match self.builder.file(path) {
            Some(bytes) => self.add(path, bytes).map(Some),
            None => Ok(None),
        }
    }
}

fn count(element: &Element) -> usize {
    1 + element.children.iter().map(count).sum::<usize>()
}

/// Parses a version such as `1.6`.
fn version(text: Option<&str>) -> FormatVersion {
    let numbers = |text: &str| {
        let (major, minor) = text.trim().split_once('.')?;
        let minor = minor.split('.').next()?;
        Some((major.parse().ok()?, minor.parse().ok()?))
    };
    text.and_then(numbers).unwrap_or(LATEST)
}

/// Returns the files that the description of a model lists, latest version first.
fn described(config: &[u8]) -> Result<Vec<String>> {
    let text = String::from_utf8_lossy(config);
    let root = parse(&text, 0)?;
    let file = |e: &Element| (version(e.attribute("version")), e.text.trim().to_owned());
    let mut files: Vec<_> = root.named("sdf").map(file).filter(|(v, name)| *v <= LATEST && !name.is_empty()).collect();
    files.sort_by_key(|(version, _)| std::cmp::Reverse(*version));
    Ok(files.into_iter().map(|(_, name)| name).collect())
}

/// Returns the URI of a model, or of a file of a model, on Gazebo's server as that of a local model:
/// `https://HOST/1.0/OWNER/models/NAME/tip/files/meshes/a.dae` is `model://NAME/meshes/a.dae`.
fn of_server(uri: &str) -> Option<String> {
    let path = uri.strip_prefix("https://").or_else(|| uri.strip_prefix("http://"))?;
    let (_, path) = path.split_once("/models/")?;
    let (name, rest) = path.split_once('/').unwrap_or((path, ""));
    let name = name.replace("%20", " ");
    Some(match rest.split_once("files/") {
        Some((_, file)) => format!("model://{name}/{file}"),
        None => format!("model://{name}"),
    })
}

/// Returns the model of an included file with what the include states.
fn included(root: &Element, include: &Element, uri: &str) -> Result<Element> {
    let is_entity = |e: &&Element| matches!(e.name.as_str(), "model" | "light" | "actor");
    let Some(entity) = root.children.iter().find(is_entity) else {
        let text = format!("`{}` contains no model that could be included", shortened(uri));
        return Err(include.fail(text));
    };
    let mut model = entity.clone();
    let mut set_attribute = |name: &str, value: &str| {
        model.attributes.retain(|(n, _)| n != name);
        model.attributes.push((name.to_owned(), value.to_owned()));
    };
    if let Some(name) = include.text_of("name") {
        set_attribute("name", name);
    }
    if let Some(frame) = include.text_of("placement_frame") {
        set_attribute("placement_frame", frame);
    }
    if include.attribute("merge").is_some_and(is_true) {
        set_attribute("merge", "true");
    }
    // The pose of the include replaces that of the model.
    for (key, is_one) in [("pose", true), ("static", true), ("plugin", false)] {
        let stated: Vec<Element> = include.named(key).cloned().collect();
        if is_one && !stated.is_empty() {
            model.children.retain(|c| c.name != key);
        }
        model.children.extend(stated);
    }
    Ok(model)
}

/// Returns the path of a file in a folder. Components `..` are resolved as far as possible.
pub fn join(folder: &str, name: &str) -> String {
    // The host resolves the components of a URI.
    if folder.contains("://") {
        return format!("{folder}/{}", name.trim_start_matches("./"));
    }
    if name.starts_with('/') {
        return name.to_owned();
    }
    let mut path: Vec<&str> = Vec::new();
    for part in folder.split('/').chain(name.split('/')) {
        match part {
            "" | "." => {}
            ".." if path.last().is_some_and(|p| *p != "..") => drop(path.pop()),
            part => path.push(part),
        }
    }
    let start = if folder.starts_with('/') { "/" } else { "" };
    format!("{start}{}", path.join("/"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_are_sought_relative_to_the_file_that_names_them() {
        assert_eq!(join("worlds", "../models/a.sdf"), "models/a.sdf");
        assert_eq!(join("model://robot", "meshes/../a.dae"), "model://robot/meshes/../a.dae");
        assert_eq!(of_server("https://fuel/1.0/Open/models/Pine%20Tree").as_deref(), Some("model://Pine Tree"));
        let file = of_server("https://fuel/1.0/Open/models/Tree/4/files/meshes/a.dae");
        assert_eq!(file.as_deref(), Some("model://Tree/meshes/a.dae"));
        assert_eq!(of_server("model://a"), None);
    }

    #[test]
    fn the_latest_described_version_is_first() {
        let config =
            b"<model><sdf version='1.4'>a.sdf</sdf><sdf version='1.10'>c.sdf</sdf><sdf version='1.6'>b.sdf</sdf>\
                       <sdf version='2.0'>d.sdf</sdf></model>";
        assert_eq!(described(config).unwrap(), ["c.sdf", "b.sdf", "a.sdf"]);
        assert_eq!([version(Some("1.6.2")), version(None)], [(1, 6), LATEST]);
    }
}
