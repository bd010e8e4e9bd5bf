//! Detects changed files.

use std::{
    collections::BTreeMap,
    fs,
    path::{Path, PathBuf},
    time::{Duration, Instant, SystemTime},
};

use tatu_plugin_api::safe::{MAX_FILE_BYTES, read_plain};
use xxhash_rust::xxh3::xxh3_64;

/// Minimum time between two checks of the disk.
const MIN_CHECK_INTERVAL: Duration = Duration::from_millis(100);
/// A file that was written more recently than this may still be incomplete.
const SETTLE_TIME: Duration = Duration::from_millis(50);
/// An empty file that is more recent than this has probably just been created by a compiler or an editor, which will
/// write to it.
const EMPTY_SETTLE_TIME: Duration = Duration::from_secs(2);

/// The known state of a file.
#[derive(Default)]
struct WatchedFile {
    /// Modification time, and size in bytes.
    stamp: Option<(SystemTime, u64)>,
    /// Hash of its contents.
    content: Option<u64>,
}

/// Watched files, with their last known state.
pub(super) struct FileWatcher {
    files: BTreeMap<PathBuf, WatchedFile>,
    last_check: Option<Instant>,
}

fn stamp(file: &Path) -> Option<(SystemTime, u64)> {
    let meta = fs::metadata(file).ok()?;
    Some((meta.modified().ok()?, meta.len()))
}

impl FileWatcher {
    pub fn new() -> Self {
        FileWatcher { files: BTreeMap::new(), last_check: None }
    }

    /// Starts to watch a file. `content` is its contents, if they have been read already.
    pub fn watch(&mut self, file: &Path, content: Option<&[u8]>) {
        let known = self.files.entry(file.to_owned()).or_default();
        if let Some(bytes) = content {
            known.content = Some(xxh3_64(bytes));
        } else if known.content.is_none() {
            known.stamp = stamp(file);
            known.content = read_plain(file, MAX_FILE_BYTES).ok().map(|b| xxh3_64(&b));
        }
    }

    /// Returns the files whose contents have changed since the last check. Each change is reported once. Checks the
    /// disk at most ten times per second. A file that was removed is reported if it is created again with different
    /// contents.
    pub fn changed(&mut self) -> Vec<PathBuf> {
        if self.last_check.is_some_and(|l| l.elapsed() < MIN_CHECK_INTERVAL) {
            return Vec::new();
        }
        self.last_check = Some(Instant::now());
        let changed = self.files.iter_mut().filter_map(|(file, known)| has_changed(file, known).then_some(file));
        changed.cloned().collect()
    }
}

fn has_changed(file: &Path, known: &mut WatchedFile) -> bool {
    let Some(now) = stamp(file) else { return false };
    // A modification time in the future is not treated as recent.
    let settled = if now.1 == 0 { EMPTY_SETTLE_TIME } else { SETTLE_TIME };
    let fresh = now.0.elapsed().is_ok_and(|e| e < settled);
    if fresh || known.stamp == Some(now) {
        return false;
    }
    let Ok(bytes) = read_plain(file, MAX_FILE_BYTES) else { return false };
    known.stamp = Some(now);
    let content = xxh3_64(&bytes);
    known.content.replace(content).is_some_and(|old| old != content)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_different_contents_count_as_a_change() {
        let dir = tempfile::tempdir().unwrap();
        let file = dir.path().join("a.txt");
        let long_ago = |text: &str, seconds: u64| {
            fs::write(&file, text).unwrap();
            let time = SystemTime::now() - Duration::from_secs(seconds);
            fs::File::options().write(true).open(&file).unwrap().set_modified(time).unwrap();
        };
        let mut watcher = FileWatcher::new();
        let mut changed = || {
            watcher.watch(&file, None);
            watcher.last_check = None;
            watcher.changed()
        };
        long_ago("one", 50);
        assert!(changed().is_empty());
        long_ago("one", 40);
        assert!(changed().is_empty(), "written again with the same content");
        long_ago("two", 30);
        assert_eq!(changed(), [&*file]);
        assert!(changed().is_empty(), "reported once");
        fs::write(&file, "th").unwrap();
        assert!(changed().is_empty(), "still being written");
        long_ago("", 1);
        assert!(changed().is_empty(), "about to be written");
        long_ago("three", 20);
        assert_eq!(changed(), [&*file]);
        fs::remove_file(&file).unwrap();
        assert!(changed().is_empty());
        long_ago("four", 10);
        assert_eq!(changed(), [&*file]);
    }
}
