//! `--graphs DIR`: writes the recorded data of graphs as tables and pictures.

use std::{
    fmt::Write as _,
    fs,
    path::{Path, PathBuf},
};

use tatu_core::{Graph, World, errors::Error, state::write_atomically};

use crate::plot;

/// Writes `<graph>.csv` and `<graph>.png` for each graph. Returns the errors; one failure does not prevent the other
/// files from being written.
pub fn write(world: &World, dir: &Path) -> Vec<Error> {
    let failure = |path: &Path, why: String| {
        Error::new("E105", format!("cannot write {}: {why}", path.display()))
            .help("check that the folder exists and is writable")
    };
    let (figures, mut failed) = (world.figures(), Vec::new());
    if figures.graphs.is_empty() {
        tatu_terminal::report::note("--graphs writes nothing, because the scene has no object with `kind = \"graph\"`");
        return failed;
    }
    if let Err(e) = fs::create_dir_all(dir) {
        return vec![failure(dir, e.to_string())];
    }
    for graph in figures.graphs.values() {
        let file = |ending: &str| -> PathBuf { dir.join(format!("{}.{ending}", file_name(&graph.name))) };
        let (csv, png) = (file("csv"), file("png"));
        if let Err(e) = write_atomically(&csv, table(graph).as_bytes()) {
            failed.push(failure(&csv, e.to_string()));
        }
        if let Err(e) = plot::draw(graph, &png) {
            failed.push(failure(&png, e));
        }
    }
    failed
}

/// Returns a file name for a graph: characters that file systems do not accept are replaced.
fn file_name(name: &str) -> String {
    let keep = |c: char| if c.is_control() || "\\/:*?\"<>|".contains(c) { '_' } else { c };
    let name: String = name.chars().map(keep).collect();
    if name.trim_matches('.').is_empty() { "graph".into() } else { name }
}

/// Returns the header of a column, with its unit. Spreadsheets would take a text that begins like a formula as one,
/// which can read other files or run programs; an apostrophe before it makes it a text.
fn head(name: &str, unit: &str) -> String {
    let formula = if name.starts_with(['=', '+', '-', '@', '\t', '\r', '\n']) { "'" } else { "" };
    let text = if unit.is_empty() { format!("{formula}{name}") } else { format!("{formula}{name} [{unit}]") };
    if text.contains([',', '"', '\n', '\r']) { format!("\"{}\"", text.replace('"', "\"\"")) } else { text }
}

/// Builds the table: time, streams, then the coordinates of curves; one row per sample, with empty cells for missing
/// values.
fn table(graph: &Graph) -> String {
    let mut columns: Vec<(String, Vec<f64>)> = vec![("time [s]".into(), graph.times.iter().copied().collect())];
    for s in &graph.streams {
        columns.push((head(&s.spec.name, &s.spec.unit), s.values.iter().copied().collect()));
    }
    for c in &graph.curves {
        let points = graph.points(c);
        for (i, axis) in ["x", "y", "z"].iter().take(c.spec.axes.len()).enumerate() {
            let name = head(&format!("{}.{axis}", c.spec.name), &c.spec.unit);
            columns.push((name, points.iter().map(|p| p.get(i).copied().unwrap_or(f64::NAN)).collect()));
        }
    }
    let heads: Vec<&str> = columns.iter().map(|(h, _)| h.as_str()).collect();
    let mut out = heads.join(",") + "\n";
    for row in 0..columns.iter().map(|(_, c)| c.len()).max().unwrap_or(0) {
        for (i, (_, column)) in columns.iter().enumerate() {
            let comma = if i == 0 { "" } else { "," };
            let _ = match column.get(row).filter(|x| x.is_finite()) {
                Some(x) => write!(out, "{comma}{x}"),
                None => write!(out, "{comma}"),
            };
        }
        out.push('\n');
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn graph_file_names_and_headers_are_escaped() {
        assert_eq!(file_name("Graph#0"), "Graph#0");
        assert_eq!(file_name("a/b:c"), "a_b_c");
        assert_eq!(file_name(".."), "graph");
        assert_eq!(head("v", "m/s"), "v [m/s]");
        assert_eq!(head("a,\"b\"", ""), "\"a,\"\"b\"\"\"");
        for (name, text) in
            [("=1+1", "'=1+1"), ("+1", "'+1"), ("-v", "'-v"), ("@x", "'@x"), ("=a,b", "\"'=a,b\""), ("a=b", "a=b")]
        {
            assert_eq!(head(name, ""), text);
        }
    }
}
