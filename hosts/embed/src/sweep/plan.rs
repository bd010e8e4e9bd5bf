//! Sweep files, which describe the jobs of a sweep.
//!
//! ```toml
//! scene = "room.toml"
//! seconds = 20
//! seeds = { first = 0, count = 100 }      # or a list
//! [grid]                                   # every combination
//! "/Robot.mass_kg" = [8, 9, 10]
//! [set]                                    # in all runs
//! "scene.dt_s" = 0.05
//! [metrics]
//! way = { object = "/Robot", field = "object.world_pose", index = 0, over = "way" }
//! ```

use std::{
    collections::BTreeMap,
    path::{Path, PathBuf},
};

use serde_json::Value;
use tatu_core::errors::{Error, Result};
use toml_edit::{DocumentMut, Item, TableLike};

use super::{Metric, SweepJob};
use crate::{
    pack::{self, is_pack},
    search::scene_file,
};

/// Maximum number of jobs of a sweep file.
const MAX_JOBS: usize = 100_000_000;

/// A sweep, as described by a file.
#[derive(Debug, Clone, PartialEq)]
pub struct SweepPlan {
    /// The scene file: a path relative to the folder of the sweep file or, if there is no such file, a scene that comes
    /// with the program.
    pub scene: PathBuf,
    /// Seeds; every combination of parameters is run with each seed. `None` stands for the scene's own seed.
    pub seeds: Vec<Option<u64>>,
    /// Parameters in the order of the file, each with its values; every combination of values is run.
    pub grid: Vec<(String, Vec<Value>)>,
    /// The duration, changes and metrics that all jobs have in common; its seed is `None`.
    pub common: SweepJob,
}

impl SweepPlan {
    /// Parses the text of the sweep file `file`.
    ///
    /// # Errors
    /// The text is not TOML, contains an unknown key or an invalid value, or describes too many jobs.
    pub fn parse(file: &Path, text: &str) -> Result<Self> {
        let wrong = |text: String| Error::new("E102", format!("{}: {text}", file.display()));
        let doc: DocumentMut = text.parse().map_err(|e: toml_edit::TomlError| {
            let before = e.span().and_then(|span| text.get(..span.start)).unwrap_or_default();
            wrong(format!("line {}: {}", before.matches('\n').count() + 1, e.message())).expected("a TOML file")
        })?;
        const KNOWN_KEYS: [&str; 6] = ["scene", "seconds", "seeds", "grid", "set", "metrics"];
        if let Some((key, _)) = doc.iter().find(|(k, _)| !KNOWN_KEYS.contains(k)) {
            let error = Error::new("E101", format!("{}: unknown key `{key}`", file.display()));
            return Err(error.expected(KNOWN_KEYS.join(", ")).nearest(key, KNOWN_KEYS));
        }
        let folder = file.parent().unwrap_or(Path::new(""));
        let scene = doc.get("scene").and_then(Item::as_str);
        let scene = scene
            .ok_or_else(|| wrong("`scene` is missing or not a string".into()).expected("the path of a scene file"))?;
        let seconds = doc.get("seconds").and_then(|s| s.as_float().or(s.as_integer().map(|i| i as f64)));
        let seconds =
            seconds.ok_or_else(|| wrong("`seconds` is missing or not a number".into()).expected("a number, s"))?;
        let table = |key: &str| match doc.get(key) {
            None => Ok(None),
            Some(item) => match item.as_table_like() {
                Some(table) => Ok(Some(table)),
                None => Err(wrong(format!("`{key}` is not a table")).expected(format!("[{key}]"))),
            },
        };
        let (mut grid, mut set, mut metrics) = (Vec::new(), BTreeMap::new(), BTreeMap::new());
        for (key, item) in table("grid")?.into_iter().flat_map(TableLike::iter) {
            match json(item) {
                Some(Value::Array(values)) if !values.is_empty() => grid.push((key.to_owned(), values)),
                _ => return Err(wrong(format!("`{key}` is not a list of values")).expected("at least one value")),
            }
        }
        for (key, item) in table("set")?.into_iter().flat_map(TableLike::iter) {
            let value = json(item)
                .ok_or_else(|| wrong(format!("`{key}` has a value that is not supported, such as a date")))?;
            set.insert(key.to_owned(), value);
        }
        for (key, item) in table("metrics")?.into_iter().flat_map(TableLike::iter) {
            let metric = json(item).map(serde_json::from_value::<Metric>);
            match metric {
                Some(Ok(metric)) => drop(metrics.insert(key.to_owned(), metric)),
                Some(Err(e)) => return Err(wrong(format!("metric `{key}`: {e}"))),
                None => {
                    return Err(wrong(format!(
                        "metric `{key}` contains a value that is not supported, such as a date"
                    )));
                }
            }
        }
        let seeds = match doc.get("seeds") {
            None => vec![None],
            Some(item) => seeds(item).ok_or_else(|| {
                wrong("`seeds` is invalid".into())
                    .expected("a list of integers, at least 0, or { first = 0, count = 100 }")
            })?,
        };
        let common = SweepJob { seed: None, set, seconds, metrics };
        common.check().map_err(|e| wrong(e.text).expected("0 to 3.2e8 s"))?;
        // A scene beside the sweep file has precedence over one that comes with the program.
        let beside = folder.join(scene);
        let named = scene_file(Path::new(scene))?;
        let scene = match beside.exists() {
            false if named.is_file() => named,
            true if is_pack(&beside) => pack::open(&beside)?,
            _ => beside,
        };
        let plan = SweepPlan { scene, seeds, grid, common };
        let count = plan.grid.iter().try_fold(plan.seeds.len(), |n, (_, values)| n.checked_mul(values.len()));
        match count.filter(|n| *n <= MAX_JOBS) {
            Some(_) => Ok(plan),
            None => Err(wrong("the sweep has too many jobs".into()).expected(format!("at most {MAX_JOBS}"))),
        }
    }

    /// Returns the number of jobs.
    pub fn count(&self) -> usize {
        self.grid.iter().fold(self.seeds.len(), |n, (_, values)| n * values.len())
    }

    /// Returns a job by its index, from 0. Seeds vary fastest, then the last parameter of the grid.
    pub fn job(&self, number: usize) -> SweepJob {
        let mut job = self.common.clone();
        job.seed = self.seeds[number % self.seeds.len()];
        let mut rest = number / self.seeds.len();
        for (key, values) in self.grid.iter().rev() {
            job.set.insert(key.clone(), values[rest % values.len()].clone());
            rest /= values.len();
        }
        job
    }
}

fn seeds(item: &Item) -> Option<Vec<Option<u64>>> {
    if let Some(list) = item.as_array() {
        let all = list.iter().map(|v| v.as_integer().and_then(|i| u64::try_from(i).ok()).map(Some));
        return all.collect::<Option<Vec<_>>>().filter(|all| !all.is_empty());
    }
    let table = item.as_table_like()?;
    let number = |key: &str| table.get(key)?.as_integer().and_then(|i| u64::try_from(i).ok());
    let (first, count) = (number("first")?, number("count")?);
    let wanted = count > 0 && count <= MAX_JOBS as u64 && table.len() == 2;
    wanted.then(|| (first..first.checked_add(count).unwrap_or(first)).map(Some).collect())
}

/// Converts a TOML value to JSON. Returns `None` if JSON cannot represent it, such as a date.
fn json(item: &Item) -> Option<Value> {
    match item {
        Item::Value(v) => json_value(v),
        _ => table_json(item.as_table_like()?),
    }
}

fn table_json(table: &dyn TableLike) -> Option<Value> {
    table
        .iter()
        .map(|(k, v)| Some((k.to_owned(), json(v)?)))
        .collect::<Option<serde_json::Map<_, _>>>()
        .map(Value::Object)
}

fn json_value(value: &toml_edit::Value) -> Option<Value> {
    use toml_edit::Value as Toml;
    match value {
        Toml::String(s) => Some(Value::from(s.value().as_str())),
        Toml::Integer(i) => Some(Value::from(*i.value())),
        Toml::Float(x) => serde_json::Number::from_f64(*x.value()).map(Value::Number),
        Toml::Boolean(b) => Some(Value::from(*b.value())),
        Toml::Datetime(_) => None,
        Toml::Array(all) => all.iter().map(json_value).collect::<Option<Vec<_>>>().map(Value::Array),
        Toml::InlineTable(table) => table_json(table),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_grid_is_every_combination() {
        let text = "scene = 'a.toml'\nseconds = 2\nseeds = { first = 5, count = 2 }\n[grid]\n'/a.x' = [1, 2]\n'/a.y' = ['u', 'v', 'w']\n";
        let plan = SweepPlan::parse(Path::new("sweeps/s.toml"), text).unwrap();
        assert_eq!((plan.count(), plan.scene.as_path()), (12, Path::new("sweeps/a.toml")));
        let of = |n: usize| {
            let job = plan.job(n);
            (job.seed.unwrap(), job.set["/a.x"].to_string(), job.set["/a.y"].to_string())
        };
        assert_eq!(of(0), (5, "1".into(), "\"u\"".into()));
        assert_eq!(of(1), (6, "1".into(), "\"u\"".into()));
        assert_eq!(of(3), (6, "1".into(), "\"v\"".into()));
        assert_eq!(of(11), (6, "2".into(), "\"w\"".into()));
        let all: std::collections::BTreeSet<_> = (0..12).map(of).collect();
        assert_eq!(all.len(), 12);
    }

    #[test]
    fn errors_of_invalid_sweep_files_name_the_expectation() {
        let error = |text: &str| SweepPlan::parse(Path::new("s.toml"), text).unwrap_err().to_string();
        for (text, part) in [
            ("scene = 'a'\nseconds = 1\nseed = 3", "did you mean `seeds`?"),
            ("seconds = 1", "`scene` is missing"),
            ("scene = 'a'\nseconds = -1", "0 to 3.2e8 s"),
            ("scene = 'a'\nseconds = 1\nseeds = []", "a list of integers"),
            ("scene = 'a'\nseconds = 1\n[grid]\nx = 3", "`x` is not a list of values"),
            ("scene = 'a'\nseconds = 1\n[metrics]\nx = {object = '/a', field = 'b', over = 'maximum'}", "maximum"),
            ("scene = ", "expected"),
        ] {
            assert!(error(text).contains(part), "{}", error(text));
        }
    }
}
