//! `tatu plugin list`: lists all plugin files in search order, and whether each is loaded.

use std::{
    collections::BTreeMap,
    path::{Path, PathBuf},
    process::ExitCode,
};

use serde_json::{Value, json};
use tatu_core::{document::SourceFiles, plugins::FolderOrigin};

use super::{
    answer::misnamed,
    beside,
    examine::FileExaminer,
    folders::{self, Folder, FolderState, same_entry, same_file},
    names, probe,
};
use tatu_embed::search::search_folders;
use tatu_terminal::{report, table};

#[derive(clap::Args)]
pub struct PluginListArgs {
    /// A scene whose plugin folders are searched too.
    #[arg(long, value_name = "FILE")]
    pub scene: Option<PathBuf>,
    /// `plugins`: load plugins from the folders that the scene names.
    #[arg(long, value_name = "WHAT", value_delimiter = ',', value_parser = ["plugins"])]
    pub allow: Vec<String>,
    /// Print a JSON array.
    #[arg(long)]
    pub json: bool,
    /// Seconds of real time after which a plugin that has not started is abandoned; 0: never.
    #[arg(long, value_name = "S", default_value_t = 10.0, value_parser = probe::limit)]
    pub watchdog: f64,
}

/// Prints the list. Each file is opened in a separate process.
pub fn list(args: &PluginListArgs) -> ExitCode {
    let folders = match search_folders(args.scene.as_deref(), &SourceFiles::default(), &args.allow) {
        Ok(all) => all,
        Err(e) => {
            report::error(&e);
            return ExitCode::from(2);
        }
    };
    let folders = folders::list_folders(&folders);
    for folder in folders.iter().filter(|f| matches!(f.source, FolderOrigin::Environment | FolderOrigin::Scene)) {
        if folder.state != FolderState::Present {
            report::note(&format!("{} ({}): {}", folder.path.display(), folder.origin(), folder.summary(&[])));
        }
    }
    let rows = rows(&folders, &mut FileExaminer::new(args.watchdog));
    if args.json {
        report::out!("{}", serde_json::to_string_pretty(&rows).unwrap_or_default());
    } else {
        let shown: Vec<Value> = rows.iter().map(display_row).collect();
        table(&shown, &["id", "version", "from", "file", "state"]);
    }
    ExitCode::SUCCESS
}

fn rows(folders: &[Folder], examiner: &mut FileExaminer) -> Vec<Value> {
    let mut rows = Vec::new();
    // Maps each id to the file that is loaded.
    let mut loaded: BTreeMap<String, PathBuf> = BTreeMap::new();
    for folder in folders {
        let mut needed = Vec::new();
        for file in &folder.candidates {
            rows.push(row(folder, file, &mut loaded, examiner));
            needed.extend(beside::libraries(&examiner.read(file), examiner));
        }
        // In a folder that the user names for plugins, a library with another name is most likely intended as a plugin,
        // unless a plugin needs it.
        if folder.source != FolderOrigin::Built {
            let is_needed = |f: &PathBuf| needed.iter().any(|n| same_entry(n, f));
            let is_library = |f: &&PathBuf| names::name(f).ends_with(std::env::consts::DLL_SUFFIX) && !is_needed(f);
            for file in folder.others.iter().filter(is_library) {
                let reason = misnamed(file);
                rows.push(json!({
                    "id": null, "version": null, "from": folder.origin_word(), "file": file.display().to_string(),
                    "state": "rejected", "hidden_by": null, "reason": reason.json(),
                }));
            }
        }
    }
    rows
}

fn row(folder: &Folder, file: &Path, loaded: &mut BTreeMap<String, PathBuf>, examiner: &mut FileExaminer) -> Value {
    let shown = file.display().to_string();
    if folder.state == FolderState::NotAllowed {
        return json!({
            "id": examiner.id(file), "version": null, "from": folder.origin_word(), "file": shown, "state": "not allowed",
            "hidden_by": null, "reason": null,
        });
    }
    let examined = examiner.examine(file);
    let id = examined.id();
    let first = id.as_ref().and_then(|id| loaded.get(id)).cloned();
    let (state, hidden_by) = match (&examined.reason, &first) {
        (Some(_), _) => ("rejected", None),
        (None, Some(first)) if same_file(first, file) => ("loaded", None),
        (None, Some(first)) => ("hidden", Some(first.display().to_string())),
        (None, None) => {
            if let Some(id) = &id {
                loaded.insert(id.clone(), file.to_owned());
            }
            ("loaded", None)
        }
    };
    let reason = examined.reason.clone().or_else(|| examined.offers_nothing());
    json!({
        "id": id, "version": examined.version(), "from": folder.origin_word(), "file": shown, "state": state,
        "hidden_by": hidden_by, "reason": reason.map(|r| r.json()),
    })
}

/// Returns a row for display, with the reason after the state.
fn display_row(row: &Value) -> Value {
    let mut row = row.clone();
    let why = row["reason"]["text"].as_str().map(str::to_owned);
    let state = match (row["state"].as_str().unwrap_or_default(), row["hidden_by"].as_str(), why) {
        ("hidden", Some(by), _) => format!("hidden by {by}"),
        (state, _, Some(why)) => format!("{state}: {why}"),
        ("not allowed", ..) => "not loaded without `--allow plugins`".to_owned(),
        (state, ..) => state.to_owned(),
    };
    row["state"] = json!(state);
    row
}
