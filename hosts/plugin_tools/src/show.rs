//! Prints the result of `tatu plugin why` as text or JSON.

use std::path::Path;

use serde_json::{Value, json};

use super::{
    answer::SearchResult,
    examine::{CAN_READ_LIBRARIES, FileReport},
    folders::same_entry,
};
use tatu_terminal::report;

/// Prints the folders, then the files, and finally the verdict.
pub fn print(answer: &SearchResult) {
    report::out!("{} is searched for in these folders, in this order:", answer.what);
    for (i, folder) in answer.folders.iter().enumerate() {
        let found = found_in(answer, i);
        report::out!("  {}. {} ({}): {}", i + 1, folder.path.display(), folder.origin(), folder.summary(&found));
    }
    for (examined, hidden_by) in &answer.files {
        print_file(examined, hidden_by.as_deref());
    }
    report::out!("");
    match &answer.verdict {
        Ok(i) => {
            let (examined, _) = &answer.files[*i];
            let (id, version) = (examined.id().unwrap_or_default(), examined.version().unwrap_or_default());
            report::out!("It is loaded: `{id}` {version} from {}", examined.file.display());
        }
        Err((file, reason)) => {
            let what = file.as_ref().map_or(answer.what.clone(), |f| f.display().to_string());
            report::out!("{what} is not loaded: {reason}");
        }
    }
}

/// Returns the matching files in one of the folders.
fn found_in(answer: &SearchResult, folder: usize) -> Vec<&Path> {
    let folder = &answer.folders[folder];
    let all = answer.files.iter().map(|(e, _)| e.file.as_path());
    all.filter(|f| folder.candidates.iter().chain(&folder.others).any(|c| same_entry(c, f))).collect()
}

/// Prints what is known about a file, one property per line.
fn print_file(examined: &FileReport, hidden_by: Option<&Path>) {
    report::out!("\n{}", examined.file.display());
    let line = |word: &str, text: String| report::out!("  {word:<10} {text}");
    for to in &examined.links {
        line("links to", to.display().to_string());
    }
    if let Some(id) = examined.id() {
        line("id", format!("{id} {}", examined.version().unwrap_or_default()));
    }
    if let Some((major, minor)) = examined.abi() {
        let drafts: Vec<String> = examined.drafts.iter().map(|d| format!(", draft {d}")).collect();
        line("built for", format!("ABI {major}.{minor}{}", drafts.concat()));
    }
    // Indirect dependencies are shown only if they are missing.
    for (i, need) in examined.needs.iter().filter(|n| n.by.is_none() || n.found.is_none()).enumerate() {
        let found = need.found.as_ref().map_or("not found".to_owned(), |f| f.display().to_string());
        let by = need.by.as_ref().map_or(String::new(), |by| format!(", which {} needs", by.display()));
        line(if i == 0 { "needs" } else { "" }, format!("{}{by} ({found})", need.name));
    }
    if let Some(report) = &examined.report {
        let many = |n: usize| if n == 1 { "" } else { "s" };
        let offers: Vec<String> = report.offers.iter().map(|(kind, n)| format!("{n} {kind}{}", many(*n))).collect();
        line("offers", if offers.is_empty() { "nothing".into() } else { offers.join(", ") });
        for remark in &report.remarks {
            line("but", format!("[{}] {} ({})", remark.code, remark.text, remark.help));
        }
        for note in &report.notes {
            line("note", note.clone());
        }
    }
    if let Some(by) = hidden_by {
        line("hidden by", by.display().to_string());
    }
    if !CAN_READ_LIBRARIES {
        line("note", "on this system a library is not read before it is opened, in a separate process".into());
    }
}

/// Returns the result as JSON.
pub fn json(answer: &SearchResult) -> Value {
    let folders = answer.folders.iter().enumerate().map(|(i, f)| f.json(&found_in(answer, i)));
    let files = answer.files.iter().map(|(e, hidden_by)| e.json(hidden_by.as_deref()));
    let (file, reason) = match &answer.verdict {
        Ok(i) => (Some(&answer.files[*i].0.file), None),
        Err((file, reason)) => (file.as_ref(), Some(reason.json())),
    };
    json!({
        "what": answer.what,
        "folders": folders.collect::<Vec<_>>(),
        "files": files.collect::<Vec<_>>(),
        "loaded": answer.verdict.is_ok(),
        "file": file.map(|f| f.display().to_string()),
        "reason": reason,
    })
}
