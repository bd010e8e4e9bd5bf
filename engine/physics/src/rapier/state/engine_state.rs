//! The complete state of the engine, as snapshots contain it.

use serde::{Deserialize, Serialize};

use crate::rapier::{
    bodies::Bodies,
    contacts::Contacts,
    joints::{JointForms, Joints},
};

/// All that determines the further course of the bodies.
#[derive(Serialize, Deserialize)]
pub(crate) struct EngineState {
    /// Bodies, with rapier's world.
    pub bodies: Bodies,
    /// Rules and states of contacts, in addition to those of rapier.
    pub contacts: Contacts,
    /// Joints of all forms.
    pub joints: Joints,
    /// Solvers of the forms of joints.
    pub forms: JointForms,
}

impl EngineState {
    /// Returns a state without bodies.
    pub fn new() -> Self {
        EngineState {
            bodies: Bodies::new(),
            contacts: Contacts::default(),
            joints: Joints::default(),
            forms: JointForms::default(),
        }
    }
}
