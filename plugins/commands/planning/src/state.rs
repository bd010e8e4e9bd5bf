//! Tasks and state spaces of a world.

use std::{
    cell::{RefCell, RefMut},
    collections::BTreeMap,
};

use serde::{Deserialize, Serialize};
use tatu_kinematics_common::SceneProps;
use tatu_planning::spheres::SphereCache;
use tatu_plugin_api::{
    abi::{TATU_ERR_BUSY, TATU_ERR_SPACE, tatu_object},
    safe::{Call, Fail, Host, Prop, Result},
};

/// The plugin, with the properties of the scene that it reads.
pub struct Planning {
    /// Those of joints and chains.
    pub chains: SceneProps,
    pub parent: Prop,
    pub path: Prop,
    pub joint_type: Prop,
    pub joint_position: Prop,
    pub joint_limits: Prop,
    pub joint_cyclic: Prop,
    pub joint_lead: Prop,
    pub joint_follows: Prop,
    pub joint_follow_factor: Prop,
    pub joint_follow_offset: Prop,
    pub collide_as: Prop,
    pub collide_size: Prop,
    pub convex: Prop,
    pub respondable: Prop,
}

impl Planning {
    pub fn new(host: &Host) -> Self {
        Planning {
            chains: SceneProps::new(host),
            parent: host.prop("object.parent"),
            path: host.prop("object.path"),
            joint_type: host.prop("joint.type"),
            joint_position: host.prop("joint.position"),
            joint_limits: host.prop("joint.limits"),
            joint_cyclic: host.prop("joint.cyclic"),
            joint_lead: host.prop("joint.lead"),
            joint_follows: host.prop("joint.follows"),
            joint_follow_factor: host.prop("joint.follow_factor"),
            joint_follow_offset: host.prop("joint.follow_offset"),
            collide_as: host.prop("shape.collide_as"),
            collide_size: host.prop("shape.collide_size"),
            convex: host.prop("shape.convex"),
            respondable: host.prop("shape.respondable"),
        }
    }
}

/// A call of one of this plugin's commands.
pub type Ctx<'a> = Call<'a, Planning>;

/// Maximum number of tasks and spaces of a world. Scripts that create some in each step and never destroy them reach it.
const MAX_ENTRIES: usize = 10_000;

/// What a part of a state moves.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum SpaceKind {
    Position2,
    Pose2,
    Position3,
    Pose3,
    Joint,
    Dubins,
    CyclicJoint,
}

impl SpaceKind {
    /// In the order of the numbers of scripts.
    pub const ALL: [SpaceKind; 7] = [
        SpaceKind::Position2,
        SpaceKind::Pose2,
        SpaceKind::Position3,
        SpaceKind::Pose3,
        SpaceKind::Joint,
        SpaceKind::Dubins,
        SpaceKind::CyclicJoint,
    ];
    /// Returns the count of numbers in a state.
    pub fn dimension(self) -> usize {
        match self {
            SpaceKind::Position2 => 2,
            SpaceKind::Pose2 | SpaceKind::Position3 | SpaceKind::Dubins => 3,
            SpaceKind::Pose3 => 7,
            SpaceKind::Joint | SpaceKind::CyclicJoint => 1,
        }
    }
    /// Returns the count of bounds on each side.
    pub fn bounds(self) -> usize {
        match self {
            SpaceKind::Position2 | SpaceKind::Pose2 | SpaceKind::Dubins => 2,
            SpaceKind::Position3 | SpaceKind::Pose3 => 3,
            SpaceKind::Joint => 1,
            SpaceKind::CyclicJoint => 0,
        }
    }
    pub fn is_joint(self) -> bool {
        matches!(self, SpaceKind::Joint | SpaceKind::CyclicJoint)
    }
}

/// A state space of an object.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct ObjectSpace {
    pub kind: SpaceKind,
    pub object: tatu_object,
    pub low: Vec<f64>,
    pub high: Vec<f64>,
    pub weight: f64,
    /// The object relative to which poses are; `None`: the world.
    pub reference: Option<tatu_object>,
    /// Turning radius of a car, m, and whether it may drive backward.
    pub radius: f64,
    pub symmetric: bool,
}

/// A function of a script.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub enum Callback {
    Function(u64),
    Named { script: tatu_object, name: String },
}

/// A goal near a dummy.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct DummyGoal {
    pub moved: tatu_object,
    pub target: tatu_object,
    pub tolerance: f64,
    pub metric: [f64; 4],
}

/// A task.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
pub struct Task {
    pub name: String,
    pub spaces: Vec<ObjectSpace>,
    pub algorithm: i64,
    /// Handles of entities, two for each pair.
    pub pairs: Vec<[i64; 2]>,
    pub start: Vec<f64>,
    pub goals: Vec<Vec<f64>>,
    pub dummy_goal: Option<DummyGoal>,
    pub resolution: f64,
    pub validation: Option<Callback>,
    pub goal_callback: Option<Callback>,
    /// Count of numbers that the projection of a script has.
    pub projection: usize,
    pub path: Vec<Vec<f64>>,
    /// Whether the path reaches the goal, and otherwise its distance.
    pub exact: bool,
    pub distance: f64,
}

impl Task {
    pub fn dimension(&self) -> usize {
        self.spaces.iter().map(|s| s.kind.dimension()).sum()
    }
}

/// The state of a world.
#[derive(Default, Serialize, Deserialize)]
pub struct SavedState {
    pub tasks: BTreeMap<i64, Task>,
    pub spaces: BTreeMap<i64, ObjectSpace>,
    last: i64,
    /// Number of searches so far, which selects the random numbers of the next one.
    pub searches: u64,
    #[serde(skip)]
    pub spheres: SphereCache,
}

impl SavedState {
    fn next(&mut self) -> Result<i64> {
        if self.tasks.len() + self.spaces.len() >= MAX_ENTRIES {
            let text = format!("a world can have at most {MAX_ENTRIES} planning tasks and state spaces");
            return Err(Fail::with_code(TATU_ERR_SPACE, text).help("destroy those that are no longer needed"));
        }
        self.last += 1;
        Ok(self.last)
    }
    pub fn add_task(&mut self, task: Task) -> Result<i64> {
        let handle = self.next()?;
        self.tasks.insert(handle, task);
        Ok(handle)
    }
    pub fn add_space(&mut self, space: ObjectSpace) -> Result<i64> {
        let handle = self.next()?;
        self.spaces.insert(handle, space);
        Ok(handle)
    }
}

/// The tasks of a world. Commands borrow them while they do not call scripts.
#[derive(Default)]
pub struct PlanningState(RefCell<SavedState>);

impl PlanningState {
    pub fn borrow(&self) -> Result<RefMut<'_, SavedState>> {
        self.0
            .try_borrow_mut()
            .map_err(|_| Fail::with_code(TATU_ERR_BUSY, "another command is using the planning tasks"))
    }
}
