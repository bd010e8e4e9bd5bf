//! Environments and their parts.

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

/// Returns the groups of the scene, with the rest of the state.
pub fn scene_groups<'a>(c: &Ctx<'a>) -> Result<RefMut<'a, SceneGroups>> {
    let mut state = c.instance().borrow()?;
    if state.scene.is_none() {
        state.scene = Some(crate::scene_groups::read(&c.world(), &c.plugin().props)?);
    }
    RefMut::filter_map(state, |s| s.scene.as_mut()).map_err(|_| Fail::new("the groups of the scene were not read"))
}

/// A call of one of this plugin's commands.
pub type Ctx<'a> = Call<'a, Ik>;

/// Maximum number of environments of a world, and of frames, groups and elements of an environment. Scripts that create
/// an environment in each step and never erase it reach the first.
const MAX_ENVIRONMENTS: usize = 1000;
const MAX_PARTS: usize = 10_000;

/// A group, and the handles of its elements.
#[derive(Default, Clone, Serialize, Deserialize)]
pub struct NamedGroup {
    pub name: String,
    pub group: IkGroup,
    /// The handle of each task.
    pub elements: Vec<i64>,
    /// The frames of the last calculation's joints at a limit.
    pub limit_hits: Vec<LimitHit>,
    /// The Jacobian that `simIK.computeJacobian` of version 4.2 has computed, and the manipulability.
    pub jacobian: Option<(Vec<f64>, [usize; 2], f64)>,
}

/// An environment.
#[derive(Default, Clone, Serialize, Deserialize)]
pub struct Environment {
    pub copy: SceneCopy,
    pub names: BTreeMap<FrameId, String>,
    pub groups: BTreeMap<i64, NamedGroup>,
    /// Distance from a limit within which a group avoids it, rad or m; stored for scripts that read it.
    pub margins: BTreeMap<FrameId, f64>,
    last: i64,
}

impl Environment {
    /// Returns a handle that has not been used in this environment.
    pub fn next_handle(&mut self) -> i64 {
        self.last += 1;
        self.last
    }
    /// Checks that another frame, group or element may be created.
    pub fn check_room(&self) -> Result {
        let parts = self.copy.linkage.ids().count() + self.groups.values().map(|g| 1 + g.elements.len()).sum::<usize>();
        if parts < MAX_PARTS {
            return Ok(());
        }
        Err(Fail::with_code(TATU_ERR_SPACE, format!("an environment can have at most {MAX_PARTS} objects and groups")))
    }
    /// Returns the group with this handle.
    pub fn group(&mut self, handle: i64) -> Result<&mut NamedGroup> {
        self.groups.get_mut(&handle).ok_or_else(|| Fail::argument(format!("there is no group with handle {handle}")))
    }
}

/// The state of a world.
#[derive(Default, Serialize, Deserialize)]
pub struct SavedState {
    pub environments: BTreeMap<i64, Environment>,
    last: i64,
    /// The groups of the scene, once a script has used one.
    pub scene: Option<SceneGroups>,
    /// Number of searches so far, which selects the random numbers of the next one.
    pub searches: u64,
}

impl SavedState {
    /// Adds an environment, and returns its handle.
    pub fn add(&mut self, environment: Environment) -> Result<i64> {
        if self.environments.len() >= MAX_ENVIRONMENTS {
            let text = format!("a world can have at most {MAX_ENVIRONMENTS} environments");
            return Err(Fail::with_code(TATU_ERR_SPACE, text).help("erase those that are no longer needed"));
        }
        self.last += 1;
        self.environments.insert(self.last, environment);
        Ok(self.last)
    }
    /// Returns the environment with this handle.
    pub fn environment(&mut self, handle: i64) -> Result<&mut Environment> {
        let found = self.environments.get_mut(&handle);
        found.ok_or_else(|| Fail::argument(format!("there is no environment with handle {handle}")))
    }
}

/// The environments of a world. Commands borrow them while they do not call scripts.
#[derive(Default)]
pub struct Environments(RefCell<SavedState>);

impl Environments {
    pub fn borrow(&self) -> Result<RefMut<'_, SavedState>> {
        self.0.try_borrow_mut().map_err(|_| Fail::with_code(TATU_ERR_BUSY, "another command is using the environments"))
    }
}

/// Borrows the environment that argument 1 names.
pub fn environment<'a>(c: &Ctx<'a>) -> Result<RefMut<'a, Environment>> {
    let handle = c.i64(0)?;
    let mut state = c.instance().borrow()?;
    state.environment(handle)?;
    RefMut::filter_map(state, |s| s.environments.get_mut(&handle))
        .map_err(|_| Fail::argument(format!("there is no environment with handle {handle}")))
}
