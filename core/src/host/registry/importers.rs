//! Importers: what reads files of other formats into a document.

use std::{collections::BTreeMap, ffi::c_void, path::Path};

use tatu_plugin_api::abi::*;

use super::Registry;
use crate::{
    error::{Error, Result},
    host::{Declared, tables},
};

/// How much of a file an importer looks at to tell whether it is its own, bytes.
const HEAD: usize = 4096;

/// An importer.
pub struct Importer {
    /// Index of the plugin.
    pub plugin: usize,
    /// What scenes write.
    pub id: String,
    /// One sentence.
    pub text: String,
    /// Endings of file names, with their dot.
    pub suffixes: Vec<String>,
    /// Its parameters.
    pub params: Vec<Declared>,
    pub(crate) raw: tatu_importer,
}

/// The importer of a file, and what is to be told about the choice.
#[derive(Debug, PartialEq, Eq)]
pub struct Choice {
    /// Index of the importer.
    pub importer: usize,
    /// Others read it as well: which one was taken.
    pub note: Option<String>,
}

impl Importer {
    /// Whether a file's name ends with one of its suffixes.
    fn has_suffix(&self, file: &Path) -> bool {
        let name = file.file_name().map(|n| n.to_string_lossy().to_lowercase()).unwrap_or_default();
        self.suffixes.iter().any(|s| !s.is_empty() && name.ends_with(&s.to_lowercase()))
    }

    /// How sure it is that the file is its own, 0 to 100.
    fn sniff(&self, me: *mut c_void, head: &[u8]) -> u32 {
        let head = crate::calls::raw(head);
        // SAFETY: by the contract; the bytes live through the call.
        self.raw.sniff.map_or(0, |f| unsafe { f(me, head) }).min(100)
    }
}

impl Registry {
    pub(super) unsafe fn add_importers(&mut self, plugin: usize) {
        // SAFETY: as promised by the caller.
        unsafe {
            let Some(ext) = tables::read(self.plugins[plugin].extension::<tatu_ext_importer>(TATU_IMPORTER)) else {
                return;
            };
            for (_, raw) in tables::list(ext.importers) {
                let Some(id) = tables::text(raw.id) else { continue };
                if raw.load.is_none() {
                    self.refuse(plugin, format!("its importer `{id}` has no load"));
                    continue;
                }
                if let Some(other) = self.importers.iter().find(|i| i.id == id) {
                    let text = format!("its importer `{id}` is already offered by `{}`", self.plugins[other.plugin].id);
                    self.refuse(plugin, text);
                    continue;
                }
                self.importers.push(Importer {
                    plugin,
                    id,
                    text: tables::text(raw.text).unwrap_or_default(),
                    suffixes: tables::pointers(raw.suffixes).into_iter().filter_map(|s| tables::text(s)).collect(),
                    params: Declared::read_list(raw.params),
                    raw,
                });
            }
        }
    }

    /// An importer by id.
    pub fn importer(&self, id: &str) -> Result<usize> {
        self.importers.iter().position(|i| i.id == id).ok_or_else(|| {
            let known: Vec<_> = self.importers.iter().map(|i| i.id.as_str()).collect();
            self.unknown("E121", "importer", id, &known)
        })
    }

    /// Whoever reads a file: the surest by its first bytes; of equally sure ones the one that `[providers]` names for
    /// the suffix, then one with the file's suffix, then the one with the lowest id. If nobody is sure: by suffix.
    pub fn importer_of(&self, file: &Path, bytes: &[u8], providers: &BTreeMap<String, String>) -> Option<Choice> {
        let head = &bytes[..bytes.len().min(HEAD)];
        let of = |i: &Importer| (i.sniff(self.plugins[i.plugin].me, head), i.has_suffix(file));
        let all: Vec<(usize, u32, bool)> = self
            .importers
            .iter()
            .enumerate()
            .map(|(n, i)| (n, of(i)))
            .map(|(n, (sure, suffix))| (n, sure, suffix))
            .collect();
        let best = all.iter().map(|(_, sure, _)| *sure).max().unwrap_or(0);
        let mut tied: Vec<_> =
            all.into_iter().filter(|(_, sure, suffix)| *sure == best && (best > 0 || *suffix)).collect();
        let named = |n: usize| {
            let i = &self.importers[n];
            let wanted = i.suffixes.iter().find_map(|s| providers.get(s));
            wanted.is_some_and(|w| *w == i.id || *w == self.plugins[i.plugin].id)
        };
        tied.sort_by_key(|(n, _, suffix)| (!named(*n), !suffix, &self.importers[*n].id));
        let first = tied.first()?.0;
        // One that is named, or the only one with the suffix, needs no word.
        let alike = |(n, _, suffix): &(usize, u32, bool)| (named(*n), *suffix) == (named(first), tied[0].2);
        let ids: Vec<_> = tied.iter().filter(|t| alike(t)).map(|(n, _, _)| self.importers[*n].id.as_str()).collect();
        let note = (ids.len() > 1).then(|| {
            format!("the importers {} read it; `{}` is used, `importer = \"...\"` chooses", ids.join(", "), ids[0])
        });
        Some(Choice { importer: first, note })
    }

    /// Nobody reads a file.
    pub(crate) fn no_importer(&self, file: &Path) -> Error {
        let known: Vec<_> = self.importers.iter().map(|i| format!("{} ({})", i.id, i.suffixes.join(" "))).collect();
        let error = Error::new("E121", format!("no importer reads {}", file.display()));
        match known.is_empty() {
            true => error.expected("a plugin that offers an importer; none was found"),
            false => error.expected(format!("a file of {}", known.join(", "))),
        }
    }
}
