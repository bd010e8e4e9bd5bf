//! Files as bytes, and points as texts.

use std::path::Path;

use serde_json::Value;
use tatu_core::errors::{Error, Result};
use tatu_plugin_api::safe::{MAX_FILE_BYTES, read_plain};

/// Formats points without needless digits.
pub fn round(points: f64) -> String {
    Value::from((points * 100.0).round() / 100.0).to_string().trim_end_matches(".0").to_owned()
}

/// Reads a file that the user has named.
pub fn read(path: &Path) -> Result<Vec<u8>> {
    read_plain(path, MAX_FILE_BYTES).map_err(|e| Error::new("E105", format!("cannot read {}: {e}", path.display())))
}
