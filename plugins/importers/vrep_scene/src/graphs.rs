//! Builds graphs and their streams, which are filled by scripts.

use std::collections::BTreeSet;

use tatu_plugin_api::safe::{Node, Result, Value};

use crate::{
    describe::map,
    read::{file::FileObject, others::Graph},
    report::ImportReport,
};

/// Builds a graph with the streams of the file, without recorded values.
pub fn graph(g: &Graph, o: &FileObject, node: Node<'_>, report: &mut ImportReport) -> Result {
    let mut names = BTreeSet::new();
    let streams: Vec<Value> = g
        .streams
        .iter()
        // Since 4.0, streams are created by scripts, which will create them again. Scripts refer to older streams by
        // name, so unnamed streams, and all but the first of those with the same name, are not accessible.
        .filter(|s| s.old && !s.name.is_empty() && names.insert(s.name.clone()))
        .map(|s| {
            let color = s.color.map(|x| if x.is_finite() { x.clamp(0.0, 1.0) } else { 0.0 });
            Value::Map(map! { "name": s.name.as_str(), "unit": s.unit.as_str(), "color": color })
        })
        .collect();
    if g.streams.iter().any(|s| s.old && s.object >= 0) {
        report.add(
            "without",
            "the streams of the graph, which the original fills automatically, are filled only by scripts",
            o,
        );
    }
    node.set("graph.explicit", g.explicit)?
        .set("graph.buffer", i64::from(g.buffer.clamp(1, 1_000_000)))?
        .set("graph.streams", Value::List(streams))
        .map(drop)
}
