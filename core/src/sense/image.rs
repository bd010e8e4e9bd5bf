//! Images of a batch: what each pixel of its sensors sees.

use nalgebra::{Isometry3, UnitQuaternion, Vector3};
use tatu_plugin_api::abi::*;

use super::plan::{BeamPlan, Image, View};
use crate::beams::{Beam, BeamScene, Volume};

/// Pixels of a batch, sensor after sensor, each with its lowest row first.
#[derive(Default)]
pub(super) struct Frames {
    /// Where each sensor's pixels begin, and at last where they end; empty while no sensor has any.
    pub first: Vec<u64>,
    pub depth: Vec<f32>,
    pub color: Vec<[u8; 3]>,
    pub cosine: Vec<f32>,
    pub object: Vec<tatu_object>,
    pixels: u64,
}

/// One sensor's look.
pub(super) struct Look<'a> {
    pub image: Image,
    pub plan: &'a BeamPlan,
    pub world_from_sensor: Isometry3<f64>,
    pub skip_group: Option<u32>,
    pub only_object: Option<u64>,
}

impl Frames {
    pub fn clear(&mut self) {
        self.first.clear();
        self.depth.clear();
        self.color.clear();
        self.cosine.clear();
        self.object.clear();
        self.pixels = 0;
        self.first.push(0);
    }

    /// A sensor without an image.
    pub fn skip(&mut self) {
        self.first.push(self.pixels);
    }

    /// Adds what a sensor sees, as far as `inputs` ask for it.
    pub fn add(&mut self, look: &Look<'_>, seen: &BeamScene, inputs: u32) {
        let Image { columns, rows, view } = look.image;
        for row in 0..rows {
            for column in 0..columns {
                let x = f64::from(columns) / 2.0 - (f64::from(column) + 0.5);
                let y = f64::from(row) + 0.5 - f64::from(rows) / 2.0;
                let (origin, direction) = match view {
                    View::Pinhole(angle) => {
                        let focal = f64::from(columns) / 2.0 / (angle / 2.0).tan();
                        (Vector3::zeros(), Vector3::new(x, y, focal).normalize())
                    }
                    View::Parallel(width) => {
                        let side = width / f64::from(columns);
                        (Vector3::new(x * side, y * side, 0.0), Vector3::z())
                    }
                };
                let turn = UnitQuaternion::rotation_between(&Vector3::z(), &direction).unwrap_or_default();
                let beam = Beam {
                    world_from_beam: look.world_from_sensor * Isometry3::from_parts(origin.into(), turn),
                    volume: Volume::Ray,
                    near: look.plan.near / direction.z,
                    far: look.plan.far / direction.z,
                    max_incidence: look.plan.max_incidence,
                    faces: look.plan.faces,
                    skip_group: look.skip_group,
                    only_object: look.only_object,
                };
                let hit = seen.cast_one(&beam);
                let cosine = -hit.normal.z;
                if inputs & TATU_IN_DISTANCE != 0 {
                    self.depth.push((hit.distance * direction.z) as f32);
                }
                if inputs & TATU_IN_COSINE != 0 {
                    self.cosine.push(cosine as f32);
                }
                if inputs & TATU_IN_OBJECT != 0 {
                    self.object.push(if hit.is_some() { hit.object } else { 0 });
                }
                if inputs & TATU_IN_COLOR != 0 {
                    self.color.push([(cosine.max(0.0) * 255.0) as u8; 3]);
                }
            }
        }
        self.pixels += u64::from(columns) * u64::from(rows);
        self.first.push(self.pixels);
    }
}
