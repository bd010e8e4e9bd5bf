//! Stores the recently shown scenes of the user, and pictures that the page has taken of them, for later runs.

use std::path::{Path, PathBuf};

use sha2::{Digest, Sha256};
use tatu_services_common::state::PrivateFolder;

use crate::gallery::{MAX_PICTURE_BYTES, can_be_opened, is_png};

/// Maximum number of stored scenes.
const MAX_SCENES: usize = 12;
/// Name of the file with the scenes: a JSON array of absolute paths, the most recent one first.
const LIST_FILE: &str = "recent.json";
/// Maximum size of that file, bytes.
const MAX_LIST_BYTES: u64 = 64 << 10;

/// The recent scenes of this user. The file is read again before each change, because other processes may change it,
/// too.
pub(crate) struct RecentScenes {
    /// The user's state folder; `None` if it is not available.
    folder: Option<PrivateFolder>,
    /// The scene that was passed to `add` last.
    last_added: PathBuf,
}

impl RecentScenes {
    /// Opens the list of the user who runs the program.
    pub(crate) fn of_user() -> RecentScenes {
        RecentScenes { folder: PrivateFolder::of_user().ok(), last_added: PathBuf::new() }
    }

    /// Moves a scene to the front of the list, and removes the oldest scenes if there are too many. Errors are ignored,
    /// because they do not affect the run.
    pub(crate) fn add(&mut self, scene: &Path) {
        let (Some(state), Ok(scene)) = (&self.folder, std::path::absolute(scene)) else { return };
        if self.last_added == scene || !can_be_opened(&scene) || scene.to_str().is_none() {
            return;
        }
        self.last_added.clone_from(&scene);
        let mut all = paths(state);
        if all.first() == Some(&scene) {
            return;
        }
        all.retain(|other| *other != scene);
        all.insert(0, scene);
        for old in all.split_off(MAX_SCENES.min(all.len())) {
            let _ = state.remove(&picture_file(&old));
        }
        let all: Vec<_> = all.iter().filter_map(|path| path.to_str()).collect();
        let _ = state.write(LIST_FILE, serde_json::json!(all).to_string().as_bytes());
    }

    /// Stores a picture of a scene if the scene is in the list. Returns false if `png` is not a PNG of at most 64 KiB.
    pub(crate) fn store_picture(&self, scene: &Path, png: &[u8]) -> bool {
        if png.len() as u64 > MAX_PICTURE_BYTES || !is_png(png) {
            return false;
        }
        if let (Some(state), Ok(scene)) = (&self.folder, std::path::absolute(scene))
            && paths(state).contains(&scene)
        {
            let _ = state.write(&picture_file(&scene), png);
        }
        true
    }

    /// Returns whether a scene is in the list.
    pub(crate) fn contains(&self, scene: &Path) -> bool {
        self.folder.as_ref().is_some_and(|state| paths(state).iter().any(|p| p == scene))
    }

    /// Returns all recent scenes with their pictures, the most recent one first.
    pub(crate) fn all(&self) -> Vec<(PathBuf, Option<Vec<u8>>)> {
        let Some(state) = &self.folder else { return Vec::new() };
        let all = paths(state).into_iter();
        all.map(|path| (path.clone(), state.read(&picture_file(&path), MAX_PICTURE_BYTES))).collect()
    }
}

/// Returns the stored paths; empty if the file is missing or damaged.
fn paths(state: &PrivateFolder) -> Vec<PathBuf> {
    let bytes = state.read(LIST_FILE, MAX_LIST_BYTES).unwrap_or_default();
    let all: Vec<PathBuf> = serde_json::from_slice(&bytes).unwrap_or_default();
    all.into_iter().filter(|path| path.is_absolute()).take(MAX_SCENES).collect()
}

/// Returns the name of the file for the picture of a scene, which contains a hash of the scene's path.
fn picture_file(scene: &Path) -> String {
    let sum = Sha256::digest(scene.as_os_str().as_encoded_bytes());
    let sum: String = sum.iter().take(8).map(|b| format!("{b:02x}")).collect();
    format!("recent-{sum}.png")
}

#[cfg(test)]
mod tests {
    use super::*;

    const PNG: &[u8] = b"\x89PNG\r\n\x1a\nrest";

    fn at(folder: &Path) -> RecentScenes {
        RecentScenes { folder: Some(PrivateFolder::at(folder.to_owned()).unwrap()), last_added: PathBuf::new() }
    }

    fn names(recent: &RecentScenes) -> Vec<String> {
        recent.all().iter().map(|(p, _)| p.file_stem().unwrap().to_string_lossy().into_owned()).collect()
    }

    #[test]
    fn recent_scenes_are_first_and_old_ones_are_removed() {
        let place = tempfile::tempdir().unwrap();
        let state = place.path().join("tatu");
        let mut recent = at(&state);
        let scene = |n: usize| place.path().join(format!("{n}.toml"));
        for n in 0..15 {
            recent.add(&scene(n));
        }
        assert!(recent.all().is_empty(), "these scenes do not exist");
        for n in 0..15 {
            std::fs::write(scene(n), "format = 1\n").unwrap();
            recent.add(&scene(n));
            assert!(recent.store_picture(&scene(n), PNG));
        }
        recent.add(&scene(7));
        recent.add(&scene(7));
        assert_eq!(names(&recent), ["7", "14", "13", "12", "11", "10", "9", "8", "6", "5", "4", "3"]);
        assert!(recent.all().iter().all(|(_, picture)| picture.as_deref() == Some(PNG)));
        assert!(recent.contains(&scene(3)) && !recent.contains(&scene(2)));
        assert_eq!(std::fs::read_dir(&state).unwrap().count(), 1 + MAX_SCENES, "pictures of old scenes go");
        // A picture of a scene that is not in the list is not stored.
        assert!(recent.store_picture(&scene(0), PNG));
        assert_eq!(std::fs::read_dir(&state).unwrap().count(), 1 + MAX_SCENES);
    }

    #[test]
    fn damaged_files_are_empty_lists() {
        let place = tempfile::tempdir().unwrap();
        let mut recent = at(&place.path().join("tatu"));
        let scene = place.path().join("a.toml");
        std::fs::write(&scene, "format = 1\n").unwrap();
        for text in ["", "[", "{}", "[1]", "[\"relative.toml\"]", "\u{1F916}"] {
            recent.folder.as_ref().unwrap().write(LIST_FILE, text.as_bytes()).unwrap();
            assert!(recent.all().is_empty(), "{text}");
            recent.last_added = PathBuf::new();
            recent.add(&scene);
            assert_eq!(names(&recent), ["a"], "{text}");
        }
    }

    #[test]
    fn pictures_are_small_pngs() {
        let place = tempfile::tempdir().unwrap();
        let recent = at(&place.path().join("tatu"));
        let large = [PNG, &vec![0; 64 << 10]].concat();
        assert!(!recent.store_picture(Path::new("x"), b"GIF89a") && !recent.store_picture(Path::new("x"), &large));
    }
}
