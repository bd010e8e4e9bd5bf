//! The table of trees.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};
use tatu_mechanisms::ContactSide;

use super::{
    placed::Detection,
    records::{CrowdedMechanism, Mechanism, PairNormal, WarmStartImpulse},
};
use crate::{BodyId, Gear, rapier::contacts::TreeContact};

/// The mechanisms that are solved as trees.
#[derive(Default, Serialize, Deserialize)]
pub(crate) struct TreeJoints {
    /// Mechanisms, including adopted bodies.
    pub mechanisms: Vec<Mechanism>,
    /// Mechanism and link of each body of a mechanism that is not frozen; derived from `mechanisms`.
    #[serde(skip)]
    pub links: BTreeMap<BodyId, ContactSide>,
    /// Gears between joints of any form, as set by `set_gears`.
    pub gears: Vec<Gear>,
    /// Whether `mechanisms` must be rebuilt.
    pub changed: bool,
    /// Free bodies that trees have adopted, with the time for which they have been out of reach of any tree, s.
    pub adopted: BTreeMap<BodyId, f64>,
    /// Mechanisms that are in reduced form while they are in a crowd.
    pub crowded: Vec<CrowdedMechanism>,
    /// The contacts of this step, if they were found here instead of by rapier: see [`super::detect`].
    #[serde(skip)]
    pub detection: Option<Detection>,
    /// Normals of the pairs that were tested in the last step, sorted by pair; empty if rapier tested them.
    pub last_normals: Vec<PairNormal>,
    /// Impulses of contacts in the last step, sorted by key.
    pub warm_start: Vec<WarmStartImpulse>,
    /// Forces of contacts in the last step.
    pub touches: Vec<TreeContact>,
}
