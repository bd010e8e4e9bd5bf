//! Figures for human viewers: graphs over time, and drawings in space.
//!
//! - [`Figures`]: all graphs and drawings of a world;
//! - [`Drawing`]: items in space, attached to an object or to the world.
//!
//! Figures have no effect on objects. Graphs are cleared when a run starts and retain their contents when it stops;
//! streams and curves that a script added during a run are removed when the next one starts. Drawings are removed when
//! a run stops, unless they are persistent.

mod drawing;

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};
use tatu_plugin_api::abi::*;

pub use drawing::{Drawing, DrawingForm};

use tatu_errors::Refusal;
use tatu_scene::{ObjectVariant, Scene, graph::Graph};

/// Maximum number of drawings of a world; it limits memory if a script adds a drawing in each step.
const MAX_DRAWINGS: usize = 10_000;

/// All graphs and drawings of a world.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
pub struct Figures {
    /// Graphs, by handle of their object.
    pub graphs: BTreeMap<u64, Graph>,
    /// Drawings, by id.
    pub drawings: BTreeMap<i64, Drawing>,
    last_drawing: i64,
    /// Whether a run is in progress.
    running: bool,
}

impl Figures {
    /// Clears all graphs and recreates them from the scene, when a run starts, with the streams and curves that scripts
    /// added before.
    pub fn begin(&mut self, scene: &Scene) {
        self.running = true;
        let before = std::mem::take(&mut self.graphs);
        for (slot, o) in scene.slots() {
            if let ObjectVariant::Graph(spec) = &o.data {
                let id = scene.id(slot);
                let graph = match before.get(&id) {
                    Some(before) => Graph::restarted(spec, o.name(), before),
                    None => Graph::new(spec, o.name()),
                };
                self.graphs.insert(id, graph);
            }
        }
    }
    /// Removes drawings that are not persistent, when a run has stopped.
    pub fn end(&mut self) {
        self.running = false;
        self.graphs.values_mut().for_each(|graph| graph.adds_lasting = true);
        self.drawings.retain(|_, d| d.persistent);
    }
    /// Returns the recorded data of an object, which must be a graph.
    pub fn graph(&mut self, scene: &Scene, object: tatu_object) -> Result<&mut Graph, Refusal> {
        let slot = tatu_slot(object);
        match scene.get(slot).map(|o| (o, &o.data)) {
            Some((o, ObjectVariant::Graph(spec))) => {
                let adds_lasting = !self.running;
                Ok(self.graphs.entry(scene.id(slot)).or_insert_with(|| {
                    let mut graph = Graph::new(spec, o.name());
                    graph.adds_lasting = adds_lasting;
                    graph
                }))
            }
            _ => Err(Refusal(TATU_ERR_ARGUMENT, format!("object {slot} `{}` is not a graph", scene.path(slot)))),
        }
    }
    /// Returns the approximate memory used by all items, bytes.
    pub fn bytes(&self) -> u64 {
        self.drawings.values().map(|d| (d.items.len() * (8 * d.stride() + 32)) as u64).sum()
    }
    /// Adds a drawing and returns its id, counted from 1.
    pub fn draw(&mut self, drawing: Drawing) -> Result<i64, Refusal> {
        if self.drawings.len() >= MAX_DRAWINGS {
            return Err(Refusal(TATU_ERR_SPACE, format!("the world already has {MAX_DRAWINGS} drawings")));
        }
        self.last_drawing += 1;
        self.drawings.insert(self.last_drawing, drawing);
        Ok(self.last_drawing)
    }
    /// Removes drawings whose parents have been removed.
    pub fn remove_orphans(&mut self, scene: &Scene) {
        self.drawings.retain(|_, d| d.parent == 0 || scene.resolve(d.parent).is_ok());
    }
}
