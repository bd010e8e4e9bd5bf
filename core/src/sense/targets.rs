//! The scene as beams see it: the forms of detectable shapes, followed as they move.

use nalgebra::Isometry3;

use crate::{
    beams::{BeamScene, Target},
    scene::{Scene, visible_parts},
};

/// The detectable forms of a scene.
#[derive(Default)]
pub struct Targets {
    pub(crate) beams: BeamScene,
    /// Object of each target, and the target's place in it.
    places: Vec<(u32, Isometry3<f64>)>,
    built: u64,
}

impl Targets {
    /// Brings the targets up to the scene.
    pub fn follow(&mut self, scene: &Scene) {
        if self.built == scene.shape_version {
            let poses = self.places.iter().enumerate().filter_map(|(i, (slot, pose))| {
                let world = scene.get(*slot)?.world * pose;
                (world != self.beams.targets()[i].world_from_target).then_some((i, world))
            });
            let moved: Vec<_> = poses.collect();
            if !moved.is_empty() {
                self.beams.update_poses(moved);
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
                self.places.push((slot, part.pose));
                targets.push(Target {
                    object: scene.id(slot),
                    group: scene.model_of(slot),
                    world_from_target: o.world * part.pose,
                    form: part.form,
                });
            }
        }
        self.beams.set(targets);
    }
}
