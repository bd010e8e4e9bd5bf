//! Stores the recently shown scenes of the user, and pictures that the page has taken of them, for later runs.

use std::path::{Path, PathBuf};

use sha2::{Digest, Sha256};
use tatu_services_common::state::State;

use crate::gallery::{MOST_PICTURE, is_png, is_scene};

/// Maximum number of stored scenes.
const MOST: usize = 12;
/// Name of the file with the scenes: a JSON array of absolute paths, the most recent one first.
const FILE: &str = "recent.json";
/// Maximum size of that file, bytes.
const MOST_BYTES: u64 = 64 << 10;

/// The recent scenes of this user. The file is read again before each change, because other processes may change it,
/// too.
pub(crate) struct Recent {
    /// The user's state folder; `None` if it is not available.
    state: Option<State>,
    /// The scene that was passed to `shown` last.
    last: PathBuf,
}

impl Recent {
    /// Opens the list of the user who runs the program.
    pub(crate) fn of_user() -> Recent {
        Recent { state: State::of_user().ok(), last: PathBuf::new() }
    }

    /// Moves a scene to the front of the list, and removes the oldest scenes if there are too many. Errors are ignored,
    /// because they do not affect the run.
    pub(crate) fn shown(&mut self, scene: &Path) {
        let (Some(state), Ok(scene)) = (&self.state, std::path::absolute(scene)) else { return };
        if self.last == scene || !is_scene(&scene) || scene.to_str().is_none() {
            return;
        }
        self.last.clone_from(&scene);
        let mut all = paths(state);
        if all.first() == Some(&scene) {
            return;
        }
        all.retain(|other| *other != scene);
        all.insert(0, scene);
        for old in all.split_off(MOST.min(all.len())) {
            let _ = state.remove(&picture_of(&old));
        }
        let all: Vec<_> = all.iter().filter_map(|path| path.to_str()).collect();
        let _ = state.write(FILE, serde_json::json!(all).to_string().as_bytes());
    }

    /// Stores a picture of a scene if the scene is in the list. Returns false if `png` is not a PNG of at most 64 KiB.
    pub(crate) fn picture(&self, scene: &Path, png: &[u8]) -> bool {
        if png.len() as u64 > MOST_PICTURE || !is_png(png) {
            return false;
        }
        if let (Some(state), Ok(scene)) = (&self.state, std::path::absolute(scene))
            && paths(state).contains(&scene)
        {
            let _ = state.write(&picture_of(&scene), png);
        }
        true
    }

    /// Returns whether a scene is in the list.
    pub(crate) fn contains(&self, scene: &Path) -> bool {
        self.state.as_ref().is_some_and(|state| paths(state).iter().any(|p| p == scene))
    }

    /// Returns all recent scenes with their pictures, the most recent one first.
    pub(crate) fn all(&self) -> Vec<(PathBuf, Option<Vec<u8>>)> {
        let Some(state) = &self.state else { return Vec::new() };
        let all = paths(state).into_iter();
        all.map(|path| (path.clone(), state.read(&picture_of(&path), MOST_PICTURE))).collect()
    }
}

/// Returns the stored paths; empty if the file is missing or damaged.
fn paths(state: &State) -> Vec<PathBuf> {
    let bytes = state.read(FILE, MOST_BYTES).unwrap_or_default();
    let all: Vec<PathBuf> = serde_json::from_slice(&bytes).unwrap_or_default();
    all.into_iter().filter(|path| path.is_absolute()).take(MOST).collect()
}

/// Returns the name of the file for the picture of a scene, which contains a hash of the scene's path.
fn picture_of(scene: &Path) -> String {
    let sum = Sha256::digest(scene.as_os_str().as_encoded_bytes());
    let sum: String = sum.iter().take(8).map(|b| format!("{b:02x}")).collect();
    format!("recent-{sum}.png")
}

#[cfg(test)]
mod tests {
    use super::*;

    const PNG: &[u8] = b"\x89PNG\r\n\x1a\nrest";

    fn at(folder: &Path) -> Recent {
        Recent { state: Some(State::at(folder.to_owned()).unwrap()), last: PathBuf::new() }
    }

    fn names(recent: &Recent) -> Vec<String> {
        recent.all().iter().map(|(p, _)| p.file_stem().unwrap().to_string_lossy().into_owned()).collect()
    }

    #[test]
    fn the_last_scenes_come_first_and_old_ones_go() {
        let place = tempfile::tempdir().unwrap();
        let state = place.path().join("tatu");
        let mut recent = at(&state);
        let scene = |n: usize| place.path().join(format!("{n}.toml"));
        for n in 0..15 {
            recent.shown(&scene(n));
        }
        assert!(recent.all().is_empty(), "these scenes do not exist");
        for n in 0..15 {
            std::fs::write(scene(n), "format = 1\n").unwrap();
            recent.shown(&scene(n));
            assert!(recent.picture(&scene(n), PNG));
        }
        recent.shown(&scene(7));
        recent.shown(&scene(7));
        assert_eq!(names(&recent), ["7", "14", "13", "12", "11", "10", "9", "8", "6", "5", "4", "3"]);
        assert!(recent.all().iter().all(|(_, picture)| picture.as_deref() == Some(PNG)));
        assert!(recent.contains(&scene(3)) && !recent.contains(&scene(2)));
        assert_eq!(std::fs::read_dir(&state).unwrap().count(), 1 + MOST, "pictures of old scenes go");
        // A picture of a scene that is not in the list is not stored.
        assert!(recent.picture(&scene(0), PNG));
        assert_eq!(std::fs::read_dir(&state).unwrap().count(), 1 + MOST);
    }

    #[test]
    fn damaged_files_are_empty_lists() {
        let place = tempfile::tempdir().unwrap();
        let mut recent = at(&place.path().join("tatu"));
        let scene = place.path().join("a.toml");
        std::fs::write(&scene, "format = 1\n").unwrap();
        for text in ["", "[", "{}", "[1]", "[\"relative.toml\"]", "\u{1F916}"] {
            recent.state.as_ref().unwrap().write(FILE, text.as_bytes()).unwrap();
            assert!(recent.all().is_empty(), "{text}");
            recent.last = PathBuf::new();
            recent.shown(&scene);
            assert_eq!(names(&recent), ["a"], "{text}");
        }
    }

    #[test]
    fn pictures_are_small_pngs() {
        let place = tempfile::tempdir().unwrap();
        let recent = at(&place.path().join("tatu"));
        let large = [PNG, &vec![0; 64 << 10]].concat();
        assert!(!recent.picture(Path::new("x"), b"GIF89a") && !recent.picture(Path::new("x"), &large));
    }
}
