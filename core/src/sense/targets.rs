//! The scene as beams and images see it, followed as things move.

use nalgebra::Isometry3;

use crate::{
    beams::{BeamScene, Target},
    scene::{Object, Scene, Shape, visible_parts},
};

/// The forms of a scene that can be seen.
#[derive(Default)]
pub struct Targets {
    /// What is detectable.
    pub(crate) detectable: Seen,
    /// What is visible.
    pub(crate) visible: Seen,
}

/// Some of the scene's forms.
#[derive(Default)]
pub(crate) struct Seen {
    pub beams: BeamScene,
    /// Object of each target, and the target's place in it.
    places: Vec<(u32, Isometry3<f64>)>,
    /// The scene's versions of shapes and of looks that it was made of.
    built: (u64, u64),
}

impl Targets {
    /// Brings what is detectable up to the scene, or what is visible.
    pub fn follow(&mut self, scene: &Scene, visible: bool) {
        if visible {
            self.visible.follow(scene, |o, _| o.is_visible());
        } else {
            self.detectable.follow(scene, |_, s| s.is_detectable());
        }
    }

    /// What is visible, or detectable.
    pub(crate) fn beams(&self, visible: bool) -> &BeamScene {
        if visible { &self.visible.beams } else { &self.detectable.beams }
    }
}

impl Seen {
    fn follow(&mut self, scene: &Scene, wanted: impl Fn(&Object, &Shape) -> bool) {
        let version = (scene.shape_version, scene.seen_version);
        if self.built == version {
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
        self.built = version;
        self.places.clear();
        let mut targets = Vec::new();
        for slot in scene.tree(0) {
            let Some(o) = scene.get(slot) else { continue };
            let Some(shape) = o.shape().filter(|s| wanted(o, s)) else { continue };
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
