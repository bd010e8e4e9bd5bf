//! Lists the scenes that the page offers: recent scenes, those in the working folder and its subfolders `scenes` and
//! `models`, and those that come with the program.

use std::{
    collections::BTreeSet,
    io::Read,
    path::{Component, Path, PathBuf},
};

use base64::{Engine, engine::general_purpose::STANDARD};
use tatu_plugin_api::safe::{folders_beside, open_plain, program_file, read_plain};

use crate::protocol::{GallerySection, SceneFile, ToPage};

/// Maximum number of scenes in the working folder, and in each folder that is searched.
const MAX_FILES: usize = 500;
/// Maximum depth of a folder search; 1 is the folder itself.
const MAX_DEPTH: usize = 3;
/// Maximum size of a scene file, bytes; the first comment of a larger file is not read.
const MAX_SCENE_BYTES: u64 = 256 << 20;
/// Number of bytes at the beginning of a scene file that are searched for its first comment.
const MAX_COMMENT_BYTES: u64 = 4 << 10;
/// Maximum size of the PNG picture of a scene, bytes.
pub(crate) const MAX_PICTURE_BYTES: u64 = 64 << 10;
/// Maximum size of the PNG picture of a model, bytes.
const MAX_MODEL_PICTURE_BYTES: u64 = 256 << 10;
/// Name of the picture in the folder of a model.
const MODEL_PICTURE: &str = "picture.png";
/// Name of a folder with scenes, in the working folder and beside the program.
const SCENES_FOLDER: &str = "scenes";
/// Name of a folder with models and their demos, in the working folder and beside the program.
const MODELS_FOLDER: &str = "models";
/// Name of the scene file that demonstrates a model.
const DEMO_FILE: &str = "demo.toml";
/// Prefix of the sentence in a scene's first comment that suggests what to try.
const TRY_PREFIX: &str = "Try:";

/// Returns the list of scenes for the page. `recent` contains the recent scenes, the latest one first, each with an
/// optional picture that replaces the scene's own picture.
pub(crate) fn list(recent: &[(PathBuf, Option<Vec<u8>>)]) -> ToPage {
    let program = program_folders();
    let mut out: Vec<SceneFile> = Vec::new();
    for (path, picture) in recent.iter().filter(|(path, _)| can_be_opened(path)) {
        out.push(gallery_entry(GallerySection::Recent, path, &path.to_string_lossy(), picture.as_deref()));
    }
    let known: BTreeSet<PathBuf> = program.iter().filter_map(|folder| folder.canonicalize().ok()).collect();
    for path in working_scenes(&known) {
        let name = path.strip_prefix(".").unwrap_or(&path);
        out.push(gallery_entry(GallerySection::Own, name, &name.to_string_lossy(), None));
    }
    for path in
        program.iter().flat_map(|folder| find_scenes(folder, &BTreeSet::new())).filter(|p| is_shown_program_scene(p))
    {
        out.push(gallery_entry(GallerySection::Program, &path, &path.to_string_lossy(), None));
    }
    let folder = std::env::current_dir().ok();
    let folder = folder.as_deref().and_then(Path::file_name).map(|name| name.to_string_lossy().into_owned());
    ToPage::Files { files: out, folder: folder.unwrap_or_default() }
}

/// Returns whether a file is a scene that comes with the program. The page may open such a scene even if scripts may
/// not read its folder.
pub(crate) fn comes_with_program(path: &Path) -> bool {
    path.components().all(|part| part != Component::ParentDir)
        && program_folders().iter().any(|folder| path.starts_with(folder))
        && is_scene(path)
        && is_shown_program_scene(path)
}

/// Returns the PNG picture of a model, which is beside the description of the model; `None` if there is none.
pub(crate) fn model_picture(model: &str) -> Option<Vec<u8>> {
    if model.is_empty() || model.starts_with('.') || model.contains(['/', '\\', ':']) {
        return None;
    }
    let folders = [PathBuf::from(MODELS_FOLDER)].into_iter().chain(program_folders());
    let mut files = folders.map(|folder| folder.join(model).join(MODEL_PICTURE));
    let file = files.find(|file| file.is_file() && !links_outside(file))?;
    read_plain(&file, MAX_MODEL_PICTURE_BYTES).ok().filter(|bytes| is_png(bytes))
}

/// Returns whether a path is a regular file with the extension of a scene or model.
pub(crate) fn is_scene(path: &Path) -> bool {
    path.is_file()
        && matches!(
            path.extension().and_then(|e| e.to_str()),
            Some("ttt" | "ttm" | "urdf" | "xacro" | "sdf" | "world" | "mjcf" | "toml")
        )
}

/// Returns whether a path is a regular file that can be opened: a scene, or a model of MuJoCo, which shares its extension
/// with many other files and is therefore not listed.
pub(crate) fn can_be_opened(path: &Path) -> bool {
    is_scene(path) || path.is_file() && path.extension().is_some_and(|e| e == "xml")
}

/// Returns whether a file that comes with the program is shown as a scene. Of a model's files, only the demo is shown.
fn is_shown_program_scene(path: &Path) -> bool {
    let mut above = path.ancestors().skip(2);
    above.next().and_then(Path::file_name).is_none_or(|name| name != MODELS_FOLDER) || path.ends_with(DEMO_FILE)
}

/// Returns the existing folders of scenes and models that come with the program.
fn program_folders() -> Vec<PathBuf> {
    let Some(program) = program_file() else { return Vec::new() };
    let both = [SCENES_FOLDER, MODELS_FOLDER].iter().flat_map(|name| folders_beside(&program, name));
    both.filter(|folder| folder.is_dir()).collect()
}

/// Returns the scenes of the working folder and of its subfolders `scenes` and `models`; folders in `known` are
/// skipped.
fn working_scenes(known: &BTreeSet<PathBuf>) -> Vec<PathBuf> {
    let here = visible_entries(Path::new("."));
    // `.toml` files in the working folder itself are omitted, because they are often not scenes.
    let mut out: Vec<PathBuf> =
        here.into_iter().filter(|p| is_scene(p) && p.extension().is_some_and(|e| e != "toml")).collect();
    for name in [SCENES_FOLDER, MODELS_FOLDER] {
        out.extend(find_scenes(&Path::new(".").join(name), known));
    }
    out.truncate(MAX_FILES);
    out
}

/// Returns the scenes in a folder and its subfolders; folders in `known` are skipped.
fn find_scenes(folder: &Path, known: &BTreeSet<PathBuf>) -> Vec<PathBuf> {
    let mut out = Vec::new();
    let mut open = vec![(folder.to_owned(), 1)];
    while let Some((folder, depth)) = open.pop() {
        // Symbolic links are skipped, because a link to a parent folder would list scenes several times.
        if folder.is_symlink() || folder.canonicalize().is_ok_and(|real| known.contains(&real)) {
            continue;
        }
        for path in visible_entries(&folder) {
            if path.is_dir() && depth < MAX_DEPTH {
                open.push((path, depth + 1));
            } else if is_scene(&path) && out.len() < MAX_FILES {
                out.push(path);
            }
        }
    }
    out
}

/// Returns the entries of a folder that are not hidden, sorted by path; empty if the folder cannot be read.
fn visible_entries(folder: &Path) -> Vec<PathBuf> {
    let entries = std::fs::read_dir(folder).into_iter().flatten().flatten().map(|e| e.path());
    let is_visible = |p: &PathBuf| p.file_name().is_some_and(|n| !n.to_string_lossy().starts_with('.'));
    let mut entries: Vec<_> = entries.filter(|p| is_visible(p) && !links_outside(p)).collect();
    entries.sort();
    entries
}

/// Returns whether a path is a link to a place outside its folder. Scenes are distributed with links, which must not
/// make the page show other files.
fn links_outside(path: &Path) -> bool {
    let folder =
        || path.parent().map(|p| if p.as_os_str().is_empty() { Path::new(".") } else { p })?.canonicalize().ok();
    path.is_symlink() && !path.canonicalize().is_ok_and(|real| folder().is_some_and(|folder| real.starts_with(folder)))
}

/// Returns the gallery entry of the scene at `path`. The page opens the scene by `file`; `picture` replaces the picture
/// beside the scene file.
fn gallery_entry(section: GallerySection, path: &Path, file: &str, picture: Option<&[u8]>) -> SceneFile {
    let comment = comment_of(path);
    let beside = path.with_extension("png");
    let beside = || if links_outside(&beside) { None } else { read_plain(&beside, MAX_PICTURE_BYTES).ok() };
    let picture = picture.map(<[u8]>::to_vec).or_else(beside);
    let picture = picture.filter(|bytes| is_png(bytes)).map(|bytes| STANDARD.encode(bytes));
    SceneFile { section, file: file.to_owned(), about: comment.about, to_try: comment.to_try, picture }
}

/// Returns whether bytes begin with the PNG signature.
pub(crate) fn is_png(bytes: &[u8]) -> bool {
    bytes.starts_with(b"\x89PNG\r\n\x1a\n")
}

/// Returns the complete lines at the beginning of a scene file, or `None` if they cannot be read or are not UTF-8.
fn read_beginning(scene: &Path) -> Option<String> {
    let mut bytes = Vec::new();
    open_plain(scene, MAX_SCENE_BYTES).ok()?.take(MAX_COMMENT_BYTES).read_to_end(&mut bytes).ok()?;
    // The last line may be cut off.
    let whole = bytes.iter().rposition(|b| *b == b'\n').map_or(bytes.len(), |end| end + 1);
    std::str::from_utf8(&bytes[..whole]).ok().map(str::to_owned)
}

/// Returns the comment at the beginning of a scene file, which is empty if the file cannot be read.
pub(crate) fn comment_of(scene: &Path) -> SceneComment {
    read_beginning(scene).map(|text| SceneComment::read(&text)).unwrap_or_default()
}

/// The comment at the beginning of a scene file.
#[derive(Debug, Default, PartialEq)]
pub(crate) struct SceneComment {
    /// The description of the scene: the first paragraph up to `Try:`.
    pub(crate) about: String,
    /// The suggestion of what to try: the text from `Try:` to the end of its paragraph.
    pub(crate) to_try: String,
}

impl SceneComment {
    /// Parses the comment at the beginning of a scene file's text.
    fn read(text: &str) -> SceneComment {
        let lines: Vec<&str> =
            text.lines().take_while(|l| l.starts_with('#')).map(|l| l.trim_start_matches('#').trim()).collect();
        let mut out = SceneComment::default();
        for (n, paragraph) in lines.split(|l| l.is_empty()).enumerate() {
            let at = paragraph.iter().position(|l| l.starts_with(TRY_PREFIX)).unwrap_or(paragraph.len());
            if n == 0 {
                out.about = paragraph[..at].join(" ");
            }
            if at < paragraph.len() && out.to_try.is_empty() {
                out.to_try = paragraph[at..].join(" ")[TRY_PREFIX.len()..].trim().to_owned();
            }
        }
        out
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[cfg(unix)]
    #[test]
    fn links_out_of_their_folder_are_not_shown() {
        let place = tempfile::tempdir().unwrap();
        let (folder, png) = (place.path().join("scenes"), b"\x89PNG\r\n\x1a\nsecret");
        std::fs::create_dir(&folder).unwrap();
        std::fs::write(place.path().join("secret.png"), png).unwrap();
        std::fs::write(place.path().join("secret.toml"), "# Secret.\n").unwrap();
        std::fs::write(folder.join("own.toml"), "format = 1\n").unwrap();
        std::os::unix::fs::symlink("../secret.png", folder.join("own.png")).unwrap();
        std::os::unix::fs::symlink("../secret.toml", folder.join("link.toml")).unwrap();
        std::os::unix::fs::symlink("own.toml", folder.join("again.toml")).unwrap();
        assert_eq!(find_scenes(&folder, &BTreeSet::new()), ["again.toml", "own.toml"].map(|name| folder.join(name)));
        assert_eq!(gallery_entry(GallerySection::Own, &folder.join("own.toml"), "own.toml", None).picture, None);
    }

    #[test]
    fn scene_comments_are_split_into_description_and_suggestion() {
        let read = |text: &str| {
            let SceneComment { about, to_try } = SceneComment::read(text);
            (about, to_try)
        };
        let both = |about: &str, to_try: &str| (about.to_owned(), to_try.to_owned());
        assert_eq!(read("# A ball\n# rolls.\nformat = 1\n"), both("A ball rolls.", ""));
        assert_eq!(read("# A ball.\n# Try: push\n# it.\n#\n# What to try:\n"), both("A ball.", "push it."));
        assert_eq!(read("# A ball.\n#\n# Try: push it.\n# Try: or not.\n"), both("A ball.", "push it. Try: or not."));
        assert_eq!(read("#Try: push it.\n"), both("", "push it."));
        assert_eq!(read("format = 1\n# Try: push it.\n"), both("", ""));
        assert_eq!(read(""), both("", ""));
    }

    #[test]
    fn every_program_scene_has_a_description_and_a_suggestion() {
        let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../..");
        let scenes: Vec<_> =
            ["scenes", "models"].iter().flat_map(|name| find_scenes(&root.join(name), &BTreeSet::new())).collect();
        let scenes: Vec<_> = scenes.into_iter().filter(|p| is_shown_program_scene(p)).collect();
        assert!(scenes.len() > 15 && !scenes.iter().any(|p| p.ends_with("model.toml")), "{scenes:?}");
        for scene in scenes {
            let comment = SceneComment::read(&read_beginning(&scene).unwrap());
            assert!(!comment.about.is_empty() && !comment.to_try.is_empty(), "{}: {comment:?}", scene.display());
        }
    }
}
