//! Graphs: their streams, into which scripts write.

use std::collections::BTreeSet;

use tatu_plugin_api::safe::{Node, Result, Value};

use crate::{
    describe::map,
    read::{file::Object, others::Graph},
    report::Report,
};

/// A graph with the streams of the file; what it had recorded is dropped.
pub fn graph(g: &Graph, o: &Object, node: Node<'_>, report: &mut Report) -> Result {
    let mut names = BTreeSet::new();
    let streams: Vec<Value> = g
        .streams
        .iter()
        // Later versions had streams made by scripts, which make them again. Scripts name streams: of equal names the
        // first counts, and one without is out of their reach.
        .filter(|s| s.old && !s.name.is_empty() && names.insert(s.name.clone()))
        .map(|s| {
            let color = s.color.map(|x| if x.is_finite() { x.clamp(0.0, 1.0) } else { 0.0 });
            Value::Map(map! { "name": s.name.as_str(), "unit": s.unit.as_str(), "color": color })
        })
        .collect();
    if g.streams.iter().any(|s| s.old && s.object >= 0) {
        report.add("without", "streams that the original filled by itself: only scripts fill them here", o);
    }
    node.set("graph.explicit", g.explicit)?
        .set("graph.buffer", i64::from(g.buffer.clamp(1, 1_000_000)))?
        .set("graph.streams", Value::List(streams))
        .map(drop)
}
