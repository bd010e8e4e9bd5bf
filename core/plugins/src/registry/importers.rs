//! Importers, which read files of other formats into a document.

use std::{collections::BTreeMap, path::Path};

use tatu_errors::{Error, Result};
use tatu_plugin_api::abi::*;

use super::{
    Registry,
    types::{Importer, ImporterChoice},
};
use crate::{ParameterSpec, tables, watchdog::PluginCall};

/// Size of the head of a file by which an importer decides whether it can read it, bytes.
const HEAD_BYTES: usize = 4096;

impl Registry {
    pub(super) fn add_importers(&mut self, plugin: usize) {
        let loaded = self.plugins[plugin].clone();
        let Some(ext) = loaded.declared::<tatu_ext_importer>() else { return };
        self.check_extension(plugin, TATU_IMPORTER, ext.size, &tables::required!(ext, tatu_ext_importer: importers));
        for raw in ext.importers() {
            let needed = tables::required!(raw, tatu_importer: id, load);
            let Some(id) = self.checked_id(plugin, "importer", raw.id(), raw.size, &needed) else { continue };
            let claimed: Vec<usize> = self.importers.iter().filter(|i| i.id == id).map(|i| i.plugin).collect();
            if !self.claim_id(plugin, "importer", &id, &claimed) {
                continue;
            }
            let suffixes = self.suffixes(plugin, &format!("importer `{id}`"), raw.suffixes());
            self.importers.push(Importer {
                plugin,
                id,
                text: raw.text().unwrap_or_default(),
                suffixes,
                params: ParameterSpec::read_list(&raw.params()),
                raw: *raw,
            });
        }
    }

    /// Returns the index of an importer by id.
    pub fn importer(&self, id: &str, providers: &BTreeMap<String, String>) -> Result<usize> {
        let of_id = self.importers.iter().enumerate().filter(|(_, i)| i.id == id);
        let claims: Vec<_> = of_id.map(|(n, i)| (n, i.plugin)).collect();
        self.choose("importer", id, &claims, providers)?.ok_or_else(|| {
            let known: Vec<_> = self.importers.iter().map(|i| i.id.as_str()).collect();
            self.unknown("E121", "importer", id, &known)
        })
    }

    /// Chooses the importer of a file, which is the one with the greatest confidence in the file's first bytes. If
    /// several are equally confident, one that `[providers]` selects for the suffix is preferred, then one with the
    /// file's suffix, then the one with the lowest id. If none is confident, only importers with the file's suffix are
    /// considered. Returns `None` if no importer is left.
    pub fn importer_of(
        &self,
        file: &Path,
        bytes: &[u8],
        providers: &BTreeMap<String, String>,
    ) -> Result<Option<ImporterChoice>> {
        let head = &bytes[..bytes.len().min(HEAD_BYTES)];
        let mut all: Vec<(usize, u32, bool)> = Vec::new();
        let mut failed: Vec<Error> = Vec::new();
        for (n, i) in self.importers.iter().enumerate() {
            match self.confidence(i, file, head) {
                Ok(sure) => all.push((n, sure, i.has_suffix(file))),
                Err(e) => failed.push(e),
            }
        }
        let best = all.iter().map(|(_, sure, _)| *sure).max().unwrap_or(0);
        let mut tied: Vec<_> =
            all.into_iter().filter(|(_, sure, suffix)| *sure == best && (best > 0 || *suffix)).collect();
        let named = |n: usize| {
            let i = &self.importers[n];
            let wanted = i.suffixes.iter().find_map(|s| providers.get(s));
            wanted.is_some_and(|w| *w == i.id || *w == self.plugins[i.plugin].id)
        };
        tied.sort_by_key(|(n, _, suffix)| (!named(*n), !suffix, &self.importers[*n].id));
        let Some(first) = tied.first().map(|t| t.0) else { return failed.into_iter().next().map_or(Ok(None), Err) };
        // No note is needed if `[providers]` selects the importer, or if it is the only one with the suffix.
        let alike = |(n, _, suffix): &(usize, u32, bool)| (named(*n), *suffix) == (named(first), tied[0].2);
        let ids: Vec<_> = tied.iter().filter(|t| alike(t)).map(|(n, _, _)| self.importers[*n].id.as_str()).collect();
        let tie = (ids.len() > 1).then(|| {
            format!(
                "the importers {} can read the file; `{}` is used; set `importer` to choose another",
                ids.join(", "),
                ids[0]
            )
        });
        // A failed check is only noted, and thus does not prevent the import of unrelated files.
        let notes = failed.into_iter().map(|e| e.text).chain(tie).collect();
        Ok(Some(ImporterChoice { importer: first, notes }))
    }

    /// Returns the confidence of an importer that it can read a file which begins with these bytes, without checks of
    /// the call.
    pub fn sniff(&self, importer: &Importer, head: &[u8]) -> u32 {
        importer.sniff(&self.plugins[importer.plugin], head)
    }

    fn confidence(&self, importer: &Importer, file: &Path, head: &[u8]) -> Result<u32> {
        let plugin = &self.plugins[importer.plugin];
        let subject = format!("the import of {}", file.display());
        let sure = self.call_plugin(importer.plugin, PluginCall::Sniff, &subject, || importer.sniff(plugin, head))?;
        if sure <= 100 {
            return Ok(sure);
        }
        let broke =
            format!("plugin `{}` broke the contract: it returned {sure} in {}", plugin.id, PluginCall::Sniff.text());
        Err(Error::new("E111", format!("{subject}: {broke}")).expected("a confidence from 0 to 100"))
    }

    /// Returns the error for a file that no importer reads.
    pub fn no_importer(&self, file: &Path) -> Error {
        let known: Vec<_> = self.importers.iter().map(|i| format!("{} ({})", i.id, i.suffixes.join(" "))).collect();
        let error = Error::new("E121", format!("no importer reads {}", file.display()));
        match known.is_empty() {
            true => error.expected("a plugin that offers an importer; none was found"),
            false => error.expected(format!("a file that one of these importers reads: {}", known.join(", "))),
        }
    }
}
