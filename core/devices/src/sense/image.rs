//! Renders the images of the sensors of a batch.

use ::tatu_beams::{BeamScene, GridCast, GridImage, ImageLighting, ImageOutputs};
use tatu_plugin_api::abi::*;

use super::{cast::SensorView, plan::BeamPlan};

/// The pixels of a batch, sensor by sensor, each with its lowest row first.
#[derive(Default)]
pub(super) struct BatchImages {
    /// For each sensor, the index of its first pixel; the last entry is the total number of pixels.
    pub first: Vec<u64>,
    pub depth: Vec<f32>,
    pub color: Vec<[u8; 3]>,
    pub cosine: Vec<f32>,
    pub object: Vec<tatu_object>,
    image: GridImage,
}

impl BatchImages {
    pub fn clear(&mut self) {
        self.first.clear();
        self.first.push(0);
        self.depth.clear();
        self.color.clear();
        self.cosine.clear();
        self.object.clear();
    }

    /// Adds a sensor's image with the channels that `inputs` (`TATU_IN_*` flags) requests. A sensor without an image
    /// has no pixels.
    pub fn add(&mut self, plan: &BeamPlan, look: SensorView, seen: &BeamScene, inputs: u32, pool: &rayon::ThreadPool) {
        let begin = self.first.last().copied().unwrap_or(0);
        let Some(grid) = &plan.image else {
            return self.first.push(begin);
        };
        self.first.push(begin + u64::from(grid.columns) * u64::from(grid.rows));
        let asked = |flag: u32| inputs & flag & !plan.without != 0;
        let cast = GridCast {
            grid,
            world_from_sensor: look.world_from_sensor,
            faces: plan.faces,
            skip_group: look.skip_group,
            only_object: look.only_object,
            outputs: ImageOutputs {
                color: asked(TATU_IN_COLOR),
                cosine: asked(TATU_IN_COSINE),
                object: asked(TATU_IN_OBJECT),
                ..ImageOutputs::DEPTH
            },
            light: &ImageLighting::default(),
        };
        pool.install(|| seen.render(&cast, &mut self.image));
        append_pixels(&mut self.depth, &mut self.image.depth);
        append_pixels(&mut self.color, &mut self.image.color);
        append_pixels(&mut self.cosine, &mut self.image.cosine);
        append_pixels(&mut self.object, &mut self.image.object);
        // Channels that the sensor does not need are filled with zeros, so that a pixel has the same index in all
        // channels.
        let end = self.first.last().copied().unwrap_or(0) as usize;
        let lacks = |flag: u32| inputs & plan.without & flag != 0;
        if lacks(TATU_IN_COLOR) {
            self.color.resize(end, [0; 3]);
        }
        if lacks(TATU_IN_COSINE) {
            self.cosine.resize(end, 0.0);
        }
        if lacks(TATU_IN_OBJECT) {
            self.object.resize(end, 0);
        }
    }
}

/// Appends the pixels of an image. Those of the first image of a batch are swapped in without copying.
fn append_pixels<T: Copy>(to: &mut Vec<T>, from: &mut Vec<T>) {
    if to.is_empty() {
        std::mem::swap(to, from);
    } else {
        to.extend_from_slice(from);
    }
}
