//! Packages: folders that a document refers to by name, as in `package://NAME/meshes/part.stl`.
//!
//! A package is a folder with a file `package.xml` that states its name; `model://NAME` is a folder with this name that
//! describes a model. A document may read the meshes and images of the packages that it names, wherever the program
//! runs, and the descriptions of models, but no other files in them; see decisions 0078 and 0079.

use std::{
    ffi::OsStr,
    fs,
    path::{Component, Path, PathBuf},
};

use tatu_plugin_api::safe::read_plain;

/// The file that makes a folder a package.
const MANIFEST: &str = "package.xml";
/// Maximum size of a manifest in bytes.
const MAX_MANIFEST_BYTES: u64 = 1 << 20;
/// How many folders are searched upward from a document, including its own.
const MAX_LEVELS: usize = 10;
/// Maximum depth of packages below a folder in which the user has packages.
const MAX_DEPTH: usize = 5;
/// Maximum number of entries that a search lists, in all folders together.
const MAX_ENTRIES: usize = 20_000;
/// Files that exclude a folder and those below it from the search.
const IGNORE_MARKS: [&str; 3] = ["CATKIN_IGNORE", "COLCON_IGNORE", "AMENT_IGNORE"];
/// Suffixes of the files that may be read from packages, without the dot: those of meshes, of the files that meshes
/// refer to, and of images.
const ASSET_SUFFIXES: [&str; 18] = [
    "obj", "mtl", "stl", "stlb", "ply", "dae", "gltf", "glb", "bin", "msh", "png", "jpg", "jpeg", "tga", "bmp", "gif",
    "tif", "tiff",
];

/// Suffixes of the descriptions that may be read from packages with a manifest, without the dot: texts that are parts of
/// the document.
const DESCRIPTION_SUFFIXES: [&str; 3] = ["xacro", "yaml", "yml"];

/// Suffixes of the descriptions that may be read from the folders of models, without the dot.
const MODEL_SUFFIXES: [&str; 2] = ["sdf", "config"];
/// The file that lists the descriptions of a model; it is optional.
const MODEL_MANIFEST: &str = "model.config";
/// Files one of which makes a folder one that a URI of a model can name.
const MODEL_MARKS: [&str; 3] = [MODEL_MANIFEST, "model.sdf", MANIFEST];
/// The folder in which collections keep their models.
const MODEL_COLLECTION: &str = "models";

/// How the folder that a URI names is found.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PackageScheme {
    /// `package://`: its manifest states the name.
    ByManifest,
    /// `model://`: it has the name, and describes a model.
    ByFolder,
}

/// The schemes of URIs that name packages.
const SCHEMES: [(&str, PackageScheme); 2] =
    [("package://", PackageScheme::ByManifest), ("model://", PackageScheme::ByFolder)];

/// A reference to a file of a package.
#[derive(Debug, PartialEq, Eq)]
pub struct PackageReference {
    /// How the package is found.
    pub scheme: PackageScheme,
    /// Name of the package.
    pub package: String,
    /// Path of the file in the package.
    pub file: PathBuf,
}

impl PackageReference {
    /// Parses a name of the form `package://NAME/FILE`, or with another of the schemes. Returns `None` for other names,
    /// and a sentence if the name is not allowed.
    pub fn parse(name: &str) -> Option<Result<Self, String>> {
        let (prefix, scheme) = SCHEMES.into_iter().find(|(prefix, _)| name.starts_with(prefix))?;
        let (package, file) = name[prefix.len()..].split_once('/').unwrap_or_default();
        let plain = |c: char| !c.is_control() && !matches!(c, '\\' | ':');
        if package.is_empty() || package.starts_with('.') || !package.chars().all(plain) {
            return Some(Err(format!("`{name}` does not name a package; expected `{prefix}NAME/FILE`")));
        }
        let outside = || format!("`{name}` is not a path in the package `{package}`");
        Some(match path_within(file).filter(|path| path.file_name().is_some()) {
            None => Err(outside()),
            Some(file) if !scheme.may_read(&file) => Err(format!(
                "`{name}` is neither a mesh nor an image nor a part of a description; other files of packages are not read"
            )),
            Some(file) => Ok(PackageReference { scheme, package: package.to_owned(), file }),
        })
    }

    /// Returns whether the package can do without the file, so that its absence is no flaw.
    pub fn is_optional(&self) -> bool {
        self.scheme == PackageScheme::ByFolder && self.file == Path::new(MODEL_MANIFEST)
    }
}

impl PackageScheme {
    /// Returns whether a file of a package that is found in this way may be read.
    fn may_read(self, file: &Path) -> bool {
        let is_text = match self {
            PackageScheme::ByManifest => is_description(file),
            PackageScheme::ByFolder => is_model(file),
        };
        is_asset(file) || is_text
    }
}

/// Returns the relative path of a name without `.` and `..`, or `None` if it leads out of its folder or into a hidden
/// one.
fn path_within(name: &str) -> Option<PathBuf> {
    let mut path = PathBuf::new();
    for part in Path::new(name).components() {
        match part {
            Component::CurDir => {}
            Component::ParentDir if path.pop() => {}
            Component::Normal(part) if !is_hidden(part) => path.push(part),
            _ => return None,
        }
    }
    Some(path)
}

fn is_hidden(name: &OsStr) -> bool {
    name.as_encoded_bytes().starts_with(b".")
}

/// Returns whether the name of a file is that of a mesh or of an image.
pub fn is_asset(file: &Path) -> bool {
    ASSET_SUFFIXES.contains(&suffix(file).as_str())
}

/// Returns whether the name of a file is that of a part of a description.
pub fn is_description(file: &Path) -> bool {
    DESCRIPTION_SUFFIXES.contains(&suffix(file).as_str())
}

/// Returns whether the name of a file is that of a description of a model.
pub fn is_model(file: &Path) -> bool {
    MODEL_SUFFIXES.contains(&suffix(file).as_str())
}

/// Returns whether two files are both assets, both parts of descriptions, or both descriptions of models.
pub fn same_kind(a: &Path, b: &Path) -> bool {
    let kind = |file: &Path| (is_asset(file), is_description(file), is_model(file));
    kind(a) == kind(b)
}

/// Returns whether a part of a relative path is hidden.
pub fn enters_hidden(path: &Path) -> bool {
    path.iter().any(is_hidden)
}

fn suffix(file: &Path) -> String {
    file.extension().and_then(OsStr::to_str).unwrap_or_default().to_lowercase()
}

/// A package that was found.
#[derive(Debug, PartialEq, Eq)]
pub struct FoundPackage {
    /// Its folder.
    pub folder: PathBuf,
    /// The bytes of the manifest that names it; `None` if only the folder does.
    pub manifest: Option<Vec<u8>>,
}

/// Finds the package of a reference; `start` is the folder of the document, and must be absolute.
pub fn find(reference: &PackageReference, start: &Path, roots: &[PathBuf]) -> Option<FoundPackage> {
    match reference.scheme {
        PackageScheme::ByManifest => find_by_manifest(&reference.package, start, roots),
        PackageScheme::ByFolder => find_by_folder(&reference.package, start, roots),
    }
}

/// Finds the folder of a model by its name: upward from the folder of a document, each time that folder itself, one in
/// it, or one in its collection of models; then in `roots`. Of the latter, any folder with the name is taken.
fn find_by_folder(name: &str, start: &Path, roots: &[PathBuf]) -> Option<FoundPackage> {
    let found = |folder: PathBuf| FoundPackage { folder, manifest: None };
    let is_shown = |folder: &&Path| folder.file_name().is_none_or(|name| !is_hidden(name));
    let describes =
        |folder: &PathBuf| is_real_folder(folder) && MODEL_MARKS.iter().any(|mark| folder.join(mark).is_file());
    let inside = |folder: &Path| [folder.join(name), folder.join(MODEL_COLLECTION).join(name)];
    for folder in start.ancestors().take(MAX_LEVELS).filter(is_shown) {
        let own = Some(folder.to_owned()).filter(|folder| folder.file_name().is_some_and(|own| own == name));
        if let Some(folder) = own.into_iter().chain(inside(folder)).find(describes) {
            return Some(found(folder));
        }
    }
    let of_root = |root: &PathBuf| {
        let own = Some(root.clone()).filter(|root| root.file_name().is_some_and(|own| own == name));
        own.into_iter().chain(inside(root)).find(|folder| is_real_folder(folder))
    };
    roots.iter().find_map(of_root).map(found)
}

/// Finds a package by the name in its manifest: upward from the folder of a document, beside the package that contains
/// the document, then in and below `roots`.
fn find_by_manifest(package: &str, start: &Path, roots: &[PathBuf]) -> Option<FoundPackage> {
    let (mut enclosing, mut same_name) = (None, None);
    for folder in start.ancestors().take(MAX_LEVELS) {
        let Some(name) = folder.file_name().filter(|name| !is_hidden(name)) else { continue };
        match read_manifest(folder) {
            Some((named, bytes)) if named == package => {
                return Some(FoundPackage { folder: folder.to_owned(), manifest: Some(bytes) });
            }
            Some(_) => drop(enclosing.get_or_insert(folder)),
            None => {}
        }
        if name == package {
            same_name.get_or_insert(folder);
        }
    }
    // Some packages are referred to by the name of their folder, which differs from the one in the manifest.
    if let Some(folder) = same_name {
        return Some(FoundPackage { folder: folder.to_owned(), manifest: None });
    }
    let mut left = MAX_ENTRIES;
    let beside = enclosing.and_then(Path::parent).and_then(|above| find_below(package, above, 1, &mut left));
    let in_roots = || roots.iter().find_map(|root| find_below(package, root, MAX_DEPTH, &mut MAX_ENTRIES.clone()));
    beside.or_else(in_roots).or_else(|| roots.iter().find_map(|root| folder_named(package, root)))
}

/// Returns a folder that is named like a package, or that contains a folder with this name.
fn folder_named(package: &str, root: &Path) -> Option<FoundPackage> {
    let own = Some(root).filter(|root| root.file_name().is_some_and(|name| name == package));
    let folder = own.map(Path::to_owned).unwrap_or_else(|| root.join(package));
    is_real_folder(&folder).then_some(FoundPackage { folder, manifest: None })
}

/// Returns whether a path is a folder, and not a link to one.
fn is_real_folder(path: &Path) -> bool {
    fs::symlink_metadata(path).is_ok_and(|about| about.is_dir())
}

/// Returns the folders of packages that the user has given, for messages.
pub fn shown_roots(roots: &[PathBuf]) -> String {
    match roots {
        [] => "the folders of `--package-path`, of which there are none".to_owned(),
        roots => roots.iter().map(|root| root.display().to_string()).collect::<Vec<_>>().join(", "),
    }
}

/// Returns the folder of the package that contains a folder.
pub fn enclosing(start: &Path) -> Option<PathBuf> {
    let is_shown = |folder: &&Path| folder.file_name().is_some_and(|name| !is_hidden(name));
    let mut folders = start.ancestors().take(MAX_LEVELS).filter(is_shown);
    folders.find(|folder| read_manifest(folder).is_some()).map(Path::to_owned)
}

/// Searches a folder and those below it, down to `depth` levels, but not inside of packages. `left` is the number of
/// entries that may still be listed.
fn find_below(package: &str, folder: &Path, depth: usize, left: &mut usize) -> Option<FoundPackage> {
    if let Some((named, bytes)) = read_manifest(folder) {
        // The folder beside a document's package can be a package itself, and contain the one that is sought.
        if named == package {
            return Some(FoundPackage { folder: folder.to_owned(), manifest: Some(bytes) });
        }
        if depth != 1 {
            return None;
        }
    }
    if depth == 0 || IGNORE_MARKS.iter().any(|mark| folder.join(mark).exists()) {
        return None;
    }
    // The folder that has the package's name is the most likely one.
    let direct = folder.join(package);
    if let Some(found) = Some(&direct)
        .filter(|direct| is_real_folder(direct))
        .and_then(|d| read_manifest(d))
        .filter(|(named, _)| named == package)
    {
        return Some(FoundPackage { folder: direct, manifest: Some(found.1) });
    }
    for below in list_folders(folder, left) {
        if let Some(found) = find_below(package, &below, depth - 1, left) {
            return Some(found);
        }
    }
    None
}

/// Returns the folders in a folder that are not hidden, in the order of their names. Links are not followed, since they
/// can lead back.
fn list_folders(folder: &Path, left: &mut usize) -> Vec<PathBuf> {
    let entries = fs::read_dir(folder).into_iter().flatten().flatten().take(*left);
    let entries: Vec<_> = entries.collect();
    *left -= entries.len();
    let is_folder = |e: &fs::DirEntry| e.file_type().is_ok_and(|t| t.is_dir()) && !is_hidden(&e.file_name());
    let mut folders: Vec<PathBuf> = entries.iter().filter(|e| is_folder(e)).map(fs::DirEntry::path).collect();
    folders.sort();
    folders
}

/// Returns the name that the manifest of a folder states, and the manifest.
fn read_manifest(folder: &Path) -> Option<(String, Vec<u8>)> {
    let file = folder.join(MANIFEST);
    // The manifest is stored in input logs, so it must not be a link to another file.
    fs::symlink_metadata(&file).ok().filter(|about| about.is_file())?;
    let bytes = read_plain(&file, MAX_MANIFEST_BYTES).ok()?;
    Some((manifest_name(&bytes)?, bytes))
}

/// Returns the path of the manifest of a package.
pub fn manifest_path(folder: &Path) -> PathBuf {
    folder.join(MANIFEST)
}

/// Returns the text of the first element `<name>` of a manifest.
fn manifest_name(manifest: &[u8]) -> Option<String> {
    let text = String::from_utf8_lossy(manifest);
    let mut rest = &*text;
    loop {
        let (comment, name) = (rest.find("<!--"), rest.find("<name>")?);
        match comment.filter(|comment| *comment < name) {
            Some(comment) => rest = &rest[comment + rest[comment..].find("-->")?..],
            None => {
                let text = &rest[name + "<name>".len()..];
                return Some(text[..text.find('<')?].trim().to_owned());
            }
        }
    }
}

/// Returns the path of a file of a package among stored files, which were read where [`find`] found the package. `stored`
/// yields them in ascending order of their paths.
pub fn find_stored<'a>(
    reference: &PackageReference,
    stored: impl Iterator<Item = (&'a Path, &'a [u8])> + Clone,
) -> Option<PathBuf> {
    // A file can have been found although the case of letters differs.
    let folded = |path: &Path| path.to_string_lossy().to_lowercase();
    let as_stored = |file: &Path| {
        let wanted = folded(file);
        stored.clone().map(|(path, _)| path).find(|path| folded(path) == wanted).map(Path::to_owned)
    };
    let manifests = stored.clone().filter(|(path, _)| path.file_name() == Some(OsStr::new(MANIFEST)));
    let named = manifests.filter(|(_, bytes)| manifest_name(bytes).as_deref() == Some(&*reference.package));
    let mut files = named.filter_map(|(path, _)| as_stored(&path.parent()?.join(&reference.file)));
    // A folder without a manifest was found by its name.
    let end = format!("/{}", folded(&Path::new(&reference.package).join(&reference.file)));
    let by_name = || stored.clone().map(|(path, _)| path.to_owned()).find(|path| folded(path).ends_with(&end));
    files.next().or_else(by_name)
}

/// A file of a package, as it is on disk.
#[derive(Debug, PartialEq, Eq)]
pub enum PackageEntry {
    /// It exists under its name.
    Exact,
    /// It does not exist, but one at this path in the package does, which differs only in the case of letters.
    OtherCase(PathBuf),
    /// It does not exist. The file at this path in the package has the same file name.
    Missing(Option<PathBuf>),
}

/// Looks for a file of a package.
pub fn look_up(folder: &Path, file: &Path) -> PackageEntry {
    if folder.join(file).exists() {
        return PackageEntry::Exact;
    }
    let mut left = MAX_ENTRIES;
    let mut found = PathBuf::new();
    for part in file.components() {
        let part = part.as_os_str();
        let exact = found.join(part);
        if folder.join(&exact).exists() {
            found = exact;
            continue;
        }
        let Some(other) = same_letters(&folder.join(&found), part, &mut left) else {
            return PackageEntry::Missing(find_file(folder, file.file_name().unwrap_or_default()));
        };
        found.push(other);
    }
    PackageEntry::OtherCase(found)
}

/// Returns the first entry of a folder, by name, that differs from `name` only in the case of letters.
fn same_letters(folder: &Path, name: &OsStr, left: &mut usize) -> Option<std::ffi::OsString> {
    let entries: Vec<_> = fs::read_dir(folder).into_iter().flatten().flatten().take(*left).collect();
    *left -= entries.len();
    let name = name.to_string_lossy().to_lowercase();
    let mut same: Vec<_> =
        entries.iter().map(fs::DirEntry::file_name).filter(|e| e.to_string_lossy().to_lowercase() == name).collect();
    same.sort();
    same.into_iter().next()
}

/// Returns the path in a package of the first file with a name, whatever the case of its letters.
fn find_file(package: &Path, name: &OsStr) -> Option<PathBuf> {
    let mut left = MAX_ENTRIES;
    let mut open = vec![PathBuf::new()];
    while let Some(folder) = open.pop() {
        let here = package.join(&folder);
        if let Some(found) = same_letters(&here, name, &mut left).filter(|n| here.join(n).is_file()) {
            return Some(folder.join(found));
        }
        if folder.components().count() < MAX_LEVELS {
            let below = list_folders(&here, &mut left);
            open.extend(below.iter().rev().filter_map(|f| f.strip_prefix(package).ok().map(Path::to_owned)));
        }
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parsed(name: &str) -> Option<PackageReference> {
        PackageReference::parse(name).and_then(Result::ok)
    }

    #[test]
    fn only_meshes_and_images_inside_of_packages_are_named() {
        let good = parsed("package://a_demo/meshes/../visual/./part.STL").unwrap();
        assert_eq!((good.package.as_str(), good.file.as_path()), ("a_demo", Path::new("visual/part.STL")));
        assert_eq!(PackageReference::parse("meshes/part.stl"), None);
        for name in [
            "package://.ssh/id_rsa",
            "package://.ssh/id_rsa.png",
            "package://a/../b.stl",
            "package://a/.git/b.stl",
            "package://a//etc/b.stl/../../c.stl",
            "package://a/b.txt",
            "package://a/package.xml",
            "package://a",
            "package:///b.stl",
            "package://a:b/c.stl",
            "package://../b.stl",
        ] {
            assert!(matches!(PackageReference::parse(name), Some(Err(_))), "{name}");
        }
    }

    #[test]
    fn models_are_named_by_their_folders() {
        let good = parsed("model://cart/meshes/../model.SDF").unwrap();
        assert_eq!(
            (good.scheme, good.package.as_str(), good.file.as_path()),
            (PackageScheme::ByFolder, "cart", Path::new("model.SDF"))
        );
        assert!(parsed("model://cart/model.config").is_some_and(|r| r.is_optional()) && !good.is_optional());
        for name in ["model://cart/robot.xacro", "model://cart/run.sh", "package://cart/model.sdf", "model://.a/b.sdf"]
        {
            assert!(matches!(PackageReference::parse(name), Some(Err(_))), "{name}");
        }
        assert!(!same_kind(Path::new("a.sdf"), Path::new("a.txt")));
    }

    #[test]
    fn models_are_found_upward_beside_and_in_collections() {
        let place = tempfile::tempdir().unwrap();
        let at = |path: &str| place.path().join(path);
        for file in [
            "src/worlds/w.sdf",
            "src/models/cart/model.sdf",
            "src/worlds/near/model.config",
            "src/plain/a.stl",
            "src/.hid/models/secret/model.sdf",
            "far/tree/a.sdf",
            "src/models/cart/parts/x.sdf",
        ] {
            fs::create_dir_all(at(file).parent().unwrap()).unwrap();
            fs::write(at(file), "").unwrap();
        }
        let found =
            |name: &str, start: &str, roots: &[PathBuf]| find_by_folder(name, &at(start), roots).map(|f| f.folder);
        assert_eq!(found("cart", "src/worlds", &[]), Some(at("src/models/cart")));
        assert_eq!(found("cart", "src/models/cart/parts", &[]), Some(at("src/models/cart")));
        assert_eq!(found("near", "src/worlds", &[]), Some(at("src/worlds/near")));
        // A folder above the file that describes no model is none; one that the user names is.
        assert_eq!([found("plain", "src/worlds", &[]), found("secret", "src/worlds", &[])], [None, None]);
        assert_eq!(found("tree", "src/worlds", &[at("far")]), Some(at("far/tree")));
        assert_eq!(found("tree", "src/worlds", &[at("far/tree")]), Some(at("far/tree")));
    }

    #[test]
    fn a_manifest_states_its_name() {
        let name = |text: &str| manifest_name(text.as_bytes());
        assert_eq!(name("<package><name> a_b </name></package>").as_deref(), Some("a_b"));
        assert_eq!(name("<!-- <name>x</name> --><package>\n<name>y</name>").as_deref(), Some("y"));
        assert_eq!(name("<package><version>1</version></package>"), None);
        assert_eq!(name("<!-- <name>x</name>"), None);
        assert_eq!(name("<name>x"), None);
    }

    #[test]
    fn packages_are_found_upward_and_beside_but_not_in_hidden_folders() {
        let place = tempfile::tempdir().unwrap();
        let at = |path: &str| place.path().join(path);
        let write = |path: &str, text: &str| {
            fs::create_dir_all(at(path).parent().unwrap()).unwrap();
            fs::write(at(path), text).unwrap();
        };
        write("src/robot/package.xml", "<name>robot_description</name>");
        write("src/robot/urdf/x/robot.urdf", "");
        write("src/robot/Meshes/Part.stl", "");
        write("src/other/package.xml", "<name>other_meshes</name>");
        write("src/.hidden/package.xml", "<name>hidden</name>");
        write("far/deep/down/package.xml", "<name>far_meshes</name>");
        let start = at("src/robot/urdf/x");
        let found = |name: &str, roots: &[PathBuf]| find_by_manifest(name, &start, roots).map(|f| f.folder);
        assert_eq!(found("robot_description", &[]), Some(at("src/robot")));
        assert_eq!(found("other_meshes", &[]), Some(at("src/other")));
        assert_eq!(found("urdf", &[]), Some(at("src/robot/urdf")));
        assert_eq!(found("robot", &[]), Some(at("src/robot")));
        assert_eq!(found("hidden", &[]), None);
        assert_eq!(found("far_meshes", &[]), None);
        assert_eq!(found("far_meshes", &[at("far")]), Some(at("far/deep/down")));
        assert_eq!(found("deep", &[at("far")]), Some(at("far/deep")));
        assert_eq!(found("far", &[at("far")]), Some(at("far")));
        assert_eq!(enclosing(&start), Some(at("src/robot")));
        assert_eq!(look_up(&at("src/robot"), Path::new("Meshes/Part.stl")), PackageEntry::Exact);
        let other = PackageEntry::OtherCase("Meshes/Part.stl".into());
        assert_eq!(look_up(&at("src/robot"), Path::new("meshes/part.STL")), other);
        let near = PackageEntry::Missing(Some("Meshes/Part.stl".into()));
        assert_eq!(look_up(&at("src/robot"), Path::new("visual/part.stl")), near);
    }
}
