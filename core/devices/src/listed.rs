//! The targets of sensors and actuators: objects that a scene lists for a device, whose poses and twists are inputs of
//! its kind.

use nalgebra::Isometry3;
use tatu_physics::Engine;
use tatu_plugin_api::abi::{tatu_object, tatu_slot};
use tatu_scene::{Dynamics, Scene, pose_to_array};

use crate::mount::{Mount, MountMotion};

/// Finds the objects at paths relative to an object. A path that leads to no object becomes 0.
pub(crate) fn find_all(scene: &Scene, from: u32, paths: &[String]) -> impl Iterator<Item = tatu_object> {
    paths.iter().map(move |path| scene.find(from, path).map_or(0, |slot| scene.id(slot)))
}

/// The targets of a batch, as columns for the plugin.
#[derive(Default)]
pub(crate) struct TargetColumns {
    /// For each device, the index of its first target; the last entry is the total number of targets.
    pub first: Vec<u64>,
    pub object: Vec<tatu_object>,
    pub pose: Vec<[f64; 7]>,
    pub twist: Vec<[f64; 6]>,
}

impl TargetColumns {
    pub fn clear(&mut self) {
        self.first.clear();
        self.object.clear();
        self.pose.clear();
        self.twist.clear();
    }
    /// Marks the beginning of a device's targets or, after the last device, the end.
    pub fn begin(&mut self) {
        self.first.push(self.object.len() as u64);
    }
    /// Adds a target; `None` stands for an object that does not exist.
    pub fn push(&mut self, target: Option<(tatu_object, &Isometry3<f64>, [f64; 6])>) {
        let (object, pose, twist) = match target {
            Some((object, pose, twist)) => (object, pose_to_array(pose), twist),
            None => (0, [f64::NAN; 7], [f64::NAN; 6]),
        };
        self.object.push(object);
        self.pose.push(pose);
        self.twist.push(twist);
    }
    /// Adds a target with its pose in the scene, if it still exists.
    pub fn push_from_scene(&mut self, scene: &Scene, object: tatu_object, twist: &dyn Fn(u32) -> [f64; 6]) {
        let slot = tatu_slot(object);
        let exists = object != 0 && scene.id(slot) == object;
        self.push(exists.then(|| (object, scene.world(slot), twist(slot))).as_ref().map(|(o, p, t)| (*o, p, *t)));
    }
}

/// A target during an advance of the engine.
pub(crate) struct EngineTarget {
    pub object: tatu_object,
    /// The attachment of the target to a body.
    mount: Mount,
}

impl EngineTarget {
    /// Attaches a target to its body; returns `None` if the object does not exist. The engine must be in sync with the
    /// scene. `twist` returns the velocity of an object that no body carries.
    pub fn new(
        scene: &Scene,
        dynamics: &Dynamics,
        object: tatu_object,
        twist: impl Fn(u32) -> [f64; 6],
    ) -> Option<Self> {
        let slot = tatu_slot(object);
        (object != 0 && scene.id(slot) == object)
            .then(|| EngineTarget { object, mount: Mount::at_or_above(scene, dynamics, slot, twist) })
    }
    /// Returns the attachment of the target to a body.
    pub fn mount(&self) -> &Mount {
        &self.mount
    }
    /// Returns the current pose and velocity of the target.
    pub fn motion(&self, engine: &dyn Engine) -> MountMotion {
        self.mount.motion(engine)
    }
}
