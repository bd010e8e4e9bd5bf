//! The scene as beams see it: the forms of detectable shapes, followed as they move.

use nalgebra::Isometry3;

use crate::{
    beams::{BeamScene, Target},
    scene::{Scene, visible_parts},
};

/// Where a target comes from.
struct Place {
    slot: u32,
    pose: Isometry3<f64>,
    /// The part's colour, if not the shape's.
    color: Option<[f64; 3]>,
}

/// The detectable forms of a scene.
#[derive(Default)]
pub struct Targets {
    pub(crate) beams: BeamScene,
    /// For each target.
    places: Vec<Place>,
    built: u64,
}

impl Targets {
    /// Brings the targets up to the scene.
    pub fn follow(&mut self, scene: &Scene) {
        if self.built == scene.shape_version {
            let poses = self.places.iter().enumerate().filter_map(|(i, place)| {
                let world = scene.get(place.slot)?.world * place.pose;
                (world != self.beams.targets()[i].world_from_target).then_some((i, world))
            });
            let moved: Vec<_> = poses.collect();
            if !moved.is_empty() {
                self.beams.update_poses(moved);
            }
            for (i, place) in self.places.iter().enumerate() {
                let Some(shape) = scene.get(place.slot).and_then(|o| o.shape()) else { continue };
                let color = place.color.unwrap_or(shape.color).map(|x| x as f32);
                if self.beams.targets()[i].color != color {
                    self.beams.set_color(i, color);
                }
            }
            return;
        }
        self.built = scene.shape_version;
        self.places.clear();
        let mut targets = Vec::new();
        for slot in scene.tree(0) {
            let Some(o) = scene.get(slot) else { continue };
            let Some(shape) = o.shape().filter(|s| s.is_detectable()) else { continue };
            for part in visible_parts(shape) {
                self.places.push(Place { slot, pose: part.pose, color: part.color });
                targets.push(Target {
                    object: scene.id(slot),
                    group: scene.model_of(slot),
                    world_from_target: o.world * part.pose,
                    form: part.form,
                    color: part.color.unwrap_or(shape.color).map(|x| x as f32),
                });
            }
        }
        self.beams.set(targets);
    }
}
