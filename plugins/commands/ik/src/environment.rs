//! Environments, which contain frames, joints and groups, and the state of a world.

use std::{
    cell::{RefCell, RefMut},
    collections::BTreeMap,
};

use serde::{Deserialize, Serialize};
use tatu_kinematics::{FrameId, IkGroup, LimitHit};
use tatu_kinematics_common::{SceneCopy, SceneProps};
use tatu_plugin_api::{
    abi::{TATU_ERR_BUSY, TATU_ERR_SPACE},
    safe::{Call, Fail, Result},
};

use crate::scene_groups::SceneGroups;

/// The plugin, with the properties of the scene that it reads and writes.
pub struct Ik {
    pub props: SceneProps,
}

/// Borrows the groups of the scene, which are read from the scene on first use.
pub fn scene_groups<'a>(c: &Ctx<'a>) -> Result<RefMut<'a, SceneGroups>> {
    let mut state = c.instance().borrow()?;
    if state.scene.is_none() {
        state.scene = Some(crate::scene_groups::read(&c.world(), &c.plugin().props)?);
    }
    RefMut::filter_map(state, |s| s.scene.as_mut())
        .map_err(|_| Fail::new("the inverse kinematics groups of the scene could not be read"))
}

/// A call of one of this plugin's commands.
pub type Ctx<'a> = Call<'a, Ik>;

/// Maximum number of environments of a world. Scripts that create an environment in each step and never erase it reach
/// this limit.
const MAX_ENVIRONMENTS: usize = 1000;
/// Maximum number of frames, groups and elements of an environment, in total.
const MAX_PARTS: usize = 10_000;

/// A group, and the handles of its elements.
#[derive(Default, Clone, Serialize, Deserialize)]
pub struct NamedGroup {
    pub name: String,
    pub group: IkGroup,
    /// The handle of each task.
    pub elements: Vec<i64>,
    /// The joints that the last calculation left at a limit.
    pub limit_hits: Vec<LimitHit>,
    /// The result of `simIK.computeJacobian` as called up to version 4.4: the elements of the Jacobian row by row, its
    /// numbers of rows and columns, and the manipulability.
    pub jacobian: Option<(Vec<f64>, [usize; 2], f64)>,
}

/// An environment: frames and joints that are independent of the scene, and groups that move them.
#[derive(Default, Clone, Serialize, Deserialize)]
pub struct Environment {
    pub copy: SceneCopy,
    pub names: BTreeMap<FrameId, String>,
    pub groups: BTreeMap<i64, NamedGroup>,
    /// For each joint, the distance from its limits within which a group avoids them, rad or m. Scripts can read these
    /// values; they have no other effect.
    pub margins: BTreeMap<FrameId, f64>,
    last: i64,
}

impl Environment {
    /// Returns a handle that has not been used in this environment.
    pub fn next_handle(&mut self) -> i64 {
        self.last += 1;
        self.last
    }
    /// Returns an error if the environment already contains the maximum number of frames, groups and elements.
    pub fn check_room(&self) -> Result {
        let parts = self.copy.linkage.ids().count() + self.groups.values().map(|g| 1 + g.elements.len()).sum::<usize>();
        if parts < MAX_PARTS {
            return Ok(());
        }
        Err(Fail::with_code(
            TATU_ERR_SPACE,
            format!("an environment can contain at most {MAX_PARTS} objects, groups and elements"),
        ))
    }
    /// Returns the group with this handle. Fails if there is none.
    pub fn group(&mut self, handle: i64) -> Result<&mut NamedGroup> {
        self.groups.get_mut(&handle).ok_or_else(|| Fail::argument(format!("there is no group with handle {handle}")))
    }
}

/// The environments of a world and the groups of its scene, as saved in snapshots.
#[derive(Default, Serialize, Deserialize)]
pub struct SavedState {
    pub environments: BTreeMap<i64, Environment>,
    last: i64,
    /// The groups of the scene; `None` until a script uses one of them.
    pub scene: Option<SceneGroups>,
    /// Number of searches so far, which is also the seed of the last one.
    pub searches: u64,
}

impl SavedState {
    /// Adds an environment, and returns its handle. Fails if there are too many.
    pub fn add(&mut self, environment: Environment) -> Result<i64> {
        if self.environments.len() >= MAX_ENVIRONMENTS {
            let text = format!("a world can have at most {MAX_ENVIRONMENTS} environments");
            return Err(Fail::with_code(TATU_ERR_SPACE, text).help("erase those that are no longer needed"));
        }
        self.last += 1;
        self.environments.insert(self.last, environment);
        Ok(self.last)
    }
    /// Returns the environment with this handle. Fails if there is none.
    pub fn environment(&mut self, handle: i64) -> Result<&mut Environment> {
        let found = self.environments.get_mut(&handle);
        found.ok_or_else(|| Fail::argument(format!("there is no environment with handle {handle}")))
    }
}

/// The state of a world. A command must not borrow it while it calls a function of a script, which may call another
/// command.
#[derive(Default)]
pub struct Environments(RefCell<SavedState>);

impl Environments {
    pub fn borrow(&self) -> Result<RefMut<'_, SavedState>> {
        self.0.try_borrow_mut().map_err(|_| Fail::with_code(TATU_ERR_BUSY, "another command is using the environments"))
    }
}

/// Borrows the environment whose handle is argument 1.
pub fn environment<'a>(c: &Ctx<'a>) -> Result<RefMut<'a, Environment>> {
    let handle = c.i64(0)?;
    let mut state = c.instance().borrow()?;
    state.environment(handle)?;
    RefMut::filter_map(state, |s| s.environments.get_mut(&handle))
        .map_err(|_| Fail::argument(format!("there is no environment with handle {handle}")))
}
