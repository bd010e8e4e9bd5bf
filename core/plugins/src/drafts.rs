//! Detection of extensions and services in a draft other than the host's, which are reported as such rather than as
//! unknown.

use std::{
    ffi::{CStr, CString},
    path::Path,
};

use tatu_plugin_api::{
    abi::*,
    safe::{MAX_FILE_BYTES, read_plain},
};

/// The extensions that the host requests from plugins.
pub const EXTENSIONS: [&CStr; 9] = [
    TATU_COMMAND,
    TATU_SENSOR,
    TATU_ACTUATOR,
    TATU_PART,
    TATU_MODEL,
    TATU_IMPORTER,
    TATU_SCRIPT,
    TATU_SERVICE,
    TATU_EVENT,
];
/// The services that the host offers.
pub const SERVICES: [&CStr; 14] = [
    TATU_HOST_SCENE,
    TATU_HOST_STAND_INS,
    TATU_HOST_READINGS,
    TATU_HOST_BODIES,
    TATU_HOST_COMMANDS,
    TATU_HOST_SCRIPTS,
    TATU_HOST_SIGNALS,
    TATU_HOST_EVENTS,
    TATU_HOST_SESSION,
    TATU_HOST_STAGE,
    TATU_HOST_LOG,
    TATU_HOST_FILES,
    TATU_HOST_FIGURES,
    TATU_HOST_EDITS,
];

/// Number of drafts newer than the host's for which plugins are queried, to report extensions that the host cannot use.
const MAX_DRAFTS_AHEAD: u32 = 8;

/// Splits "tatu.sensor/draft.4" into "tatu.sensor" and 4.
fn split(id: &str) -> Option<(&str, u32)> {
    let (name, draft) = id.split_once("/draft.")?;
    Some((name, draft.parse().ok()?))
}

/// A known extension or service in a draft that is not the host's.
#[derive(Debug, PartialEq, Eq)]
pub struct OtherDraft {
    /// A clause such as "built for draft 9 of `tatu.sensor`, but this host has draft 4".
    pub text: String,
    /// Whether the draft is newer than the host's.
    pub is_newer: bool,
}

/// Returns what to do about a plugin that was built for another version of the interface.
pub fn remedy(plugin_is_newer: bool) -> &'static str {
    match plugin_is_newer {
        true => "update this program (`tatu --version`), or use a version of the plugin that was built for it",
        false => "rebuild it against this release's plugin-api",
    }
}

/// Returns the difference if the id is that of a known extension or service in a different draft.
pub fn other_draft(id: &str) -> Option<OtherDraft> {
    let (name, draft) = split(id)?;
    let ours = EXTENSIONS.iter().chain(&SERVICES).filter_map(|c| split(c.to_str().ok()?)).find(|(n, _)| *n == name)?.1;
    let text = format!("built for draft {draft} of `{name}`, but this host has draft {ours}");
    (ours != draft).then_some(OtherDraft { text, is_newer: draft > ours })
}

/// Describes the extensions that a plugin offers in drafts other than the host's. `offers` returns whether the plugin
/// offers an id.
pub fn other_drafts(offers: impl Fn(&CStr) -> bool) -> Vec<OtherDraft> {
    let mut out = Vec::new();
    for id in EXTENSIONS.iter().filter(|id| !offers(id)) {
        let Some((name, ours)) = id.to_str().ok().and_then(split) else { continue };
        let others = (0..=ours + MAX_DRAFTS_AHEAD).filter(|d| *d != ours).map(|d| format!("{name}/draft.{d}"));
        let found = others.into_iter().find(|id| CString::new(id.as_str()).is_ok_and(|id| offers(&id)));
        out.extend(found.and_then(|id| other_draft(&id)));
    }
    out
}

/// Searches a library that declares no extensions for a misspelt extension id. Returns a clause for the error message
/// with the misspelt id and the nearest valid one, or an empty string.
pub fn misspelt(library: &Path) -> String {
    let Ok(bytes) = read_plain(library, MAX_FILE_BYTES) else { return String::new() };
    let known: Vec<&str> = EXTENSIONS.iter().chain(&SERVICES).filter_map(|id| id.to_str().ok()).collect();
    let texts = bytes.split(|b| *b == 0).filter_map(|t| std::str::from_utf8(t).ok());
    let wrong = |t: &&str| t.len() < 60 && t.contains("tatu") && t.contains("draft") && !known.contains(t);
    let found = texts.filter(wrong).find_map(|t| Some((t, tatu_errors::nearest(t, known.iter().copied())?)));
    found.map_or(String::new(), |(t, near)| {
        format!(": it uses the id `{t}`, which does not exist; did you mean `{near}`?")
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_id_of_the_header_is_listed() {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../plugin-api/include/tatu");
        let files = std::fs::read_dir(folder).unwrap().map(|e| e.unwrap().path()).filter(|p| p.is_file());
        let headers: String = files.map(|p| std::fs::read_to_string(p).unwrap()).collect();
        let ids = headers.lines().filter_map(|l| l.strip_prefix("#define TATU_")?.split_once(" \"tatu."));
        let mut theirs: Vec<String> = ids.map(|(_, id)| format!("tatu.{}", id.trim_end_matches('"'))).collect();
        let ours = EXTENSIONS.iter().chain(&SERVICES).map(|id| id.to_str().unwrap().to_owned());
        let mut ours: Vec<String> = ours.collect();
        ours.sort();
        theirs.sort();
        assert_eq!(ours, theirs);
    }

    #[test]
    fn other_drafts_of_known_ids_are_named() {
        let told = other_draft("tatu.sensor/draft.9").unwrap();
        assert_eq!(told.text, "built for draft 9 of `tatu.sensor`, but this host has draft 4");
        assert!(told.is_newer && !other_draft("tatu.sensor/draft.1").unwrap().is_newer);
        assert_eq!(other_draft("tatu.sensor/draft.4"), None);
        assert_eq!(other_draft("tatu.nonsense/draft.9"), None);
        let found = other_drafts(|id| id == c"tatu.command/draft.4" || id == c"tatu.script/draft.0");
        let texts: Vec<&str> = found.iter().map(|d| d.text.as_str()).collect();
        assert_eq!(texts, ["built for draft 0 of `tatu.script`, but this host has draft 4"]);
    }
}
