//! The part of a world that a step changes.

use std::cell::{Cell, RefCell};

use nalgebra::Vector3;
use tatu_physics::EngineSettings;
use tatu_scene::{Dynamics, Scene};

use crate::cell::{
    clock::Clock,
    phase::Phase,
    records::stores::{CustomDataSize, Signals},
};

/// The part of a world that a step changes and a snapshot contains: objects, engine, time, phase and signals.
pub(crate) struct SimulationState {
    pub scene: RefCell<Scene>,
    pub dynamics: RefCell<Dynamics>,
    pub clock: Clock,
    pub phase: Cell<Phase>,
    /// Requested changes of phase, as bits `1 << TATU_REQUEST_*`, which are carried out at the barrier or after a pass.
    pub requests: Cell<u32>,
    /// Whether the last pass has ended, after which the run is ended at the next barrier.
    pub last_pass_done: Cell<bool>,
    /// Whether a pass took place while the world was stopped.
    pub stopped_pass_done: Cell<bool>,
    pub signals: RefCell<Signals>,
    /// An upper bound of the size of the custom data.
    pub custom_data_size: CustomDataSize,
}

impl SimulationState {
    pub fn new(engine: EngineSettings, dt: f64, scene: Scene) -> Self {
        SimulationState {
            scene: RefCell::new(scene),
            dynamics: RefCell::new(Dynamics::new(engine)),
            clock: Clock::new(dt),
            phase: Cell::default(),
            requests: Cell::default(),
            last_pass_done: Cell::default(),
            stopped_pass_done: Cell::default(),
            signals: RefCell::default(),
            custom_data_size: CustomDataSize::default(),
        }
    }
    /// Returns the linear velocity of an object, m/s, and its angular velocity, rad/s, in the world frame: from the
    /// engine if the engine moves the object, otherwise from its motion in the last step.
    pub fn twist(&self, scene: &Scene, dynamics: &Dynamics, slot: u32) -> [f64; 6] {
        let Some(o) = scene.get(slot) else { return [0.0; 6] };
        if let Some(t) = o.shape().filter(|s| s.dynamic).and_then(|s| dynamics.twist(s)) {
            return [t.linear.x, t.linear.y, t.linear.z, t.angular.x, t.angular.y, t.angular.z];
        }
        self.twist_by_motion(scene, slot)
    }
    /// Returns the velocity of an object like [`twist`](Self::twist), but the linear velocity is that of the object's
    /// frame, also for dynamic shapes, whose centre of mass can move differently.
    pub fn frame_twist(&self, scene: &Scene, dynamics: &Dynamics, slot: u32) -> [f64; 6] {
        let [x, y, z, a, b, c] = self.twist(scene, dynamics, slot);
        let body = scene.get(slot).and_then(|o| o.shape()).filter(|s| s.dynamic && dynamics.twist(s).is_some());
        let Some(shape) = body else { return [x, y, z, a, b, c] };
        let arm = scene.world(slot).rotation * tatu_scene::centre_of_mass(shape);
        let v = Vector3::new(x, y, z) - Vector3::new(a, b, c).cross(&arm);
        [v.x, v.y, v.z, a, b, c]
    }
    /// Returns the velocity of an object like [`twist`](Self::twist), but always from its motion in the last step.
    pub fn twist_by_motion(&self, scene: &Scene, slot: u32) -> [f64; 6] {
        let (Some(_), Some(old)) = (scene.get(slot), scene.pose_at_barrier(slot)) else { return [0.0; 6] };
        let (now, dt) = (scene.world(slot), self.clock.dt.get());
        let v = (now.translation.vector - old.translation.vector) / dt;
        let w = (now.rotation * old.rotation.inverse()).scaled_axis() / dt;
        [v.x, v.y, v.z, w.x, w.y, w.z]
    }
}
