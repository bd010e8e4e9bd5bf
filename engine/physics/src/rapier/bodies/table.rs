//! The table of bodies: rapier's world, and what the engine records about each body in it.

use std::collections::BTreeMap;

use nalgebra::Vector3;
use rapier3d::{
    dynamics::{IntegrationParameters, RigidBody, RigidBodyHandle, SpringCoefficients},
    math::Pose,
    pipeline::PhysicsWorld,
};
use serde::{Deserialize, Serialize};

use super::record::{AppliedForces, Backlog, BodyRecord, PreviousState, Substeps};
use crate::{
    BodyId, EngineSettings, MotionType, convert,
    rapier::tuning::{CONTACT_SOFTNESS, MAX_CONTACT_FREQUENCY_SHARE, STATIC_CONTACT_SOFTNESS},
};

/// All bodies, with the rapier world that contains them.
#[derive(Serialize, Deserialize)]
pub(crate) struct Bodies {
    pub world: PhysicsWorld,
    /// Bodies by id; `None` for removed bodies.
    pub records: Vec<Option<BodyRecord>>,
    /// Kinematic bodies that are moving: start and end pose.
    pub moving: BTreeMap<BodyId, (Pose, Pose)>,
    /// Bodies whose pose, velocity or joints were changed from outside since the last step.
    pub moved: Vec<BodyId>,
    /// Bodies that have been frozen since the last call to `quarantined`.
    pub frozen: Vec<BodyId>,
    /// Poses and velocities before the last step, by body id.
    pub previous: Vec<Option<PreviousState>>,
    /// Free bodies whose spin has been advanced by half of the current step.
    #[serde(skip)]
    pub spinning: Vec<RigidBodyHandle>,
    /// Whether bodies at rest can sleep.
    pub sleep: bool,
    /// Changes that rapier has not processed yet, because it was not called.
    pub backlog: Backlog,
    pub substeps: Substeps,
    pub forces: AppliedForces,
}

impl Bodies {
    /// Returns a world without bodies and with rapier's own settings, which [`Bodies::configure`] replaces.
    pub fn new() -> Self {
        let world =
            PhysicsWorld { integration_parameters: IntegrationParameters::default(), ..PhysicsWorld::default() };
        Bodies {
            world,
            records: Vec::new(),
            moving: BTreeMap::new(),
            moved: Vec::new(),
            frozen: Vec::new(),
            previous: Vec::new(),
            spinning: Vec::new(),
            sleep: false,
            backlog: Backlog::default(),
            substeps: Substeps::default(),
            forces: AppliedForces::default(),
        }
    }

    /// Applies the engine's settings to rapier's world.
    pub fn configure(&mut self, settings: &EngineSettings) {
        let gravity = convert::vector(&settings.gravity);
        if gravity != self.world.gravity {
            self.world.gravity = gravity;
            self.world.wake_up_all(true);
        }
        let numbers = &mut self.world.integration_parameters;
        numbers.dt = settings.step;
        self.substeps.usual = settings.substeps.max(1) as usize;
        numbers.num_solver_iterations = self.substeps.usual;
        // Contacts that are too stiff for the sub-step make stacks rock.
        let rate = 1.0 / self.substep();
        let spring = |usual: (f64, f64), share| {
            let (frequency, damping) = settings.contact_spring.map_or(usual, |[f, d]| (f, d));
            SpringCoefficients::new(frequency.min(share * rate), damping)
        };
        let numbers = &mut self.world.integration_parameters;
        numbers.contact_softness = spring(CONTACT_SOFTNESS, MAX_CONTACT_FREQUENCY_SHARE);
        numbers.static_contact_softness = spring(STATIC_CONTACT_SOFTNESS, 2.0 * MAX_CONTACT_FREQUENCY_SHARE);
        if self.sleep != settings.sleep {
            self.sleep = settings.sleep;
            self.apply_sleep_setting();
        }
    }

    pub fn record(&self, body: BodyId) -> Option<&BodyRecord> {
        self.records.get(body.0 as usize)?.as_ref()
    }

    pub fn record_mut(&mut self, body: BodyId) -> Option<&mut BodyRecord> {
        self.records.get_mut(body.0 as usize)?.as_mut()
    }

    /// Returns rapier's body.
    pub fn body(&self, body: BodyId) -> Option<&RigidBody> {
        self.world.bodies.get(self.record(body)?.handle)
    }

    /// Returns rapier's handle of a dynamic body, or `None` for other bodies.
    pub fn dynamic_handle(&self, body: BodyId) -> Option<RigidBodyHandle> {
        self.record(body).filter(|r| r.motion == MotionType::Dynamic).map(|r| r.handle)
    }

    pub fn is_dynamic(&self, body: BodyId) -> bool {
        self.dynamic_handle(body).is_some()
    }

    /// Returns whether there are bodies that rapier moves by forces.
    pub fn any_free(&self) -> bool {
        self.records.iter().flatten().any(|r| r.motion == MotionType::Dynamic && !r.in_tree)
    }

    /// Returns the pose of rapier's body.
    pub fn position(&self, body: BodyId) -> Pose {
        self.record(body).map_or(Pose::IDENTITY, |r| *self.world.bodies[r.handle].position())
    }

    /// Freezes a body at its current pose; [`Engine::quarantined`](crate::Engine::quarantined) reports it.
    pub fn freeze(&mut self, body: BodyId) {
        let Some(&BodyRecord { handle, .. }) = self.record(body) else {
            return;
        };
        if self.world.bodies[handle].is_enabled() {
            self.world.bodies[handle].set_enabled(false);
            self.frozen.push(body);
        }
    }

    /// Records the bodies that rapier has just frozen.
    pub fn collect_frozen(&mut self) {
        if self.world.quarantine().is_empty() {
            return;
        }
        let world = &self.world;
        let ids = world.quarantine().bodies().iter().filter_map(|h| world.bodies.get(*h));
        self.frozen.extend(ids.map(|body| BodyId(body.user_data as u32)));
    }
}

pub(crate) fn is_finite(v: &Vector3<f64>) -> bool {
    v.iter().all(|x| x.is_finite())
}
