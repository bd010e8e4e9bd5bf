//! Scripts of edited objects, and their files.

use std::path::Path;

use super::{super::value_text::quoted, diff::same_kind, tables::PatchWriter};
use crate::document::{NORMAL_PRIORITY, PRIORITIES, ScriptSpec, entry::SceneEntry};

impl PatchWriter<'_> {
    /// Writes the scripts of an object: to their existing files if only the source code differs and no other script
    /// uses the files, otherwise to new files.
    pub fn scripts(&mut self, entry: &SceneEntry, object: usize, scripts: &[ScriptSpec]) {
        let then = &self.edited.document.objects[object].scripts;
        let dialect = &self.edited.settings.dialect;
        let same = then.len() == scripts.len() && then.iter().zip(scripts).all(|(a, b)| same_kind(a, b, dialect));
        let changed: Vec<(&ScriptSpec, &ScriptSpec)> =
            then.iter().zip(scripts).filter(|(a, b)| a.text != b.text).collect();
        if same && entry.first == object && changed.iter().all(|(old, _)| self.own_file(entry, old).is_some()) {
            for (old, new) in changed {
                if let Some(file) = self.own_file(entry, old) {
                    self.out.files.push((file, new.text.clone()));
                    self.out.changes += 1;
                }
            }
            return;
        }
        let alias = self.edited.scene.get(self.edited.slots[object]).map_or(String::new(), |o| o.alias().to_owned());
        let list: Vec<String> = scripts.iter().map(|s| self.new_file(s, &alias)).collect();
        let (key, written) = match list.as_slice() {
            [one] => ("script", one.clone()),
            list => ("scripts", format!("[{}]", list.join(", "))),
        };
        if entry.first == object && !entry.is_placement {
            if let Some(table) = self.table(entry) {
                table.remove("script");
                table.remove("scripts");
            }
            if !list.is_empty() {
                self.put(entry, key, &written, false);
            }
            self.out.changes += 1;
        } else {
            self.put_set(object, key, &written);
        }
    }

    /// Returns the file of a script, relative to the scene file, if this entry refers to the file and no other script
    /// does.
    fn own_file(&mut self, entry: &SceneEntry, script: &ScriptSpec) -> Option<String> {
        let folder = self.edited.document.file.as_ref()?.parent()?.to_owned();
        let file = Path::new(&script.name).strip_prefix(&folder).ok()?.to_str()?.to_owned();
        let plain = Path::new(&file).components().all(|c| matches!(c, std::path::Component::Normal(_)));
        let users = self.edited.document.objects.iter().flat_map(|o| &o.scripts).filter(|s| s.name == script.name);
        let once = users.count() == 1 && self.edited.document.sources.has(Path::new(&script.name));
        let table = self.table(entry)?;
        let named = ["script", "scripts"].iter().any(|k| table.get(k).is_some_and(|i| i.to_string().contains(&file)));
        (plain && once && named).then_some(file)
    }

    /// Adds a file with a script; returns the TOML value by which the scene file refers to it.
    pub fn new_file(&mut self, script: &ScriptSpec, alias: &str) -> String {
        let language = &self.builder.registry.scripting.languages[script.language];
        let suffix = language.suffixes.first().map_or(".txt", String::as_str);
        let keep = |c: char| c.is_ascii_alphanumeric() || matches!(c, '_' | '-');
        let stem: String = alias.chars().map(|c| if keep(c) { c } else { '_' }).take(60).collect();
        let mut file = format!("{}/{stem}{suffix}", self.edited.folder);
        for n in 2.. {
            let used = |f: &str| self.out.files.iter().any(|(name, _)| name.eq_ignore_ascii_case(f));
            if !used(&file) && !self.edited.existing_files.contains(&file.to_lowercase()) {
                break;
            }
            file = format!("{}/{stem}_{n}{suffix}", self.edited.folder);
        }
        self.out.files.push((file.clone(), script.text.clone()));
        let mut parts = vec![format!("file = {}", quoted(&file))];
        let by_suffix = self.builder.registry.language(&file, &self.edited.document.settings.providers);
        if by_suffix.ok() != Some(script.language) {
            parts.push(format!("language = {}", quoted(&language.id)));
        }
        if !script.dialect.is_empty() && script.dialect != self.edited.settings.dialect {
            parts.push(format!("dialect = {}", quoted(&script.dialect)));
        }
        if script.kind != "child" {
            parts.push(format!("kind = {}", quoted(&script.kind)));
        }
        if script.priority != NORMAL_PRIORITY {
            parts.push(format!("priority = {}", quoted(PRIORITIES[usize::from(script.priority)])));
        }
        if script.side_by_side {
            parts.push("side_by_side = true".into());
        }
        match parts.as_slice() {
            [_] => quoted(&file),
            parts => format!("{{ {} }}", parts.join(", ")),
        }
    }
}
