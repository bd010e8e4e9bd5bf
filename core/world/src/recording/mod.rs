//! Records samples in graphs. `source`: the values of a world that a stream can record.

mod source;

pub(crate) use source::warn_of_invalid_streams;
use tatu_errors::Refusal;
use tatu_plugin_api::abi::*;
use tatu_scene::ObjectVariant;

use crate::{cell::WorldCell, recording::source::number};

fn busy() -> Refusal {
    Refusal(TATU_ERR_BUSY, "the running call uses the graphs; record the sample after that call has returned".into())
}

/// Records a sample in each graph that is not recorded explicitly, at the end of a step. Returns the number of these
/// graphs.
pub(crate) fn record_due(world: &WorldCell, time: f64) -> Result<usize, Refusal> {
    let due: Vec<tatu_object> = {
        let scene = world.state.scene.try_borrow().map_err(|_| busy())?;
        let figures = world.devices.figures.try_borrow().map_err(|_| busy())?;
        let is_due = |object: &u64| {
            let slot = scene.resolve(*object).ok();
            matches!(slot.and_then(|s| scene.get(s)).map(|o| &o.data), Some(ObjectVariant::Graph(g)) if !g.explicit)
        };
        figures.graphs.keys().copied().filter(is_due).collect()
    };
    for graph in &due {
        record(world, *graph, time)?;
    }
    Ok(due.len())
}

/// Records a sample of the current world in a graph, at `time`, s.
pub(crate) fn record(world: &WorldCell, object: tatu_object, time: f64) -> Result<(), Refusal> {
    let scene = world.state.scene.try_borrow().map_err(|_| busy())?;
    let mut figures = world.devices.figures.try_borrow_mut().map_err(|_| busy())?;
    let slot = tatu_slot(object);
    let graph = figures.graph(&scene, object)?;
    let numbers: Vec<Option<f64>> = (graph.streams.iter_mut())
        .map(|s| match s.spec.of.is_empty() {
            true => s.given.take(),
            false => number(world, &scene, slot, &s.spec.of, &s.spec.data),
        })
        .collect();
    graph.add_sample(time, &numbers);
    Ok(())
}
