//! Inverse kinematics groups of the scene. Before version 4.1, users created such groups in V-REP's editor; they are
//! stored in the scene file and solved in each step.
//!
//! The importer stores the groups as JSON in the scene's custom data, and each object's handle in the file in that
//! object's custom data. When a script first uses a group, all groups are copied to a separate environment.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};
use tatu_kinematics::{Constraints, FrameId, IkGroup, IkResult, IkTask, JointRole};
use tatu_kinematics_common::{SceneCopy, SceneProps};
use tatu_plugin_api::{
    abi::{tatu_object, tatu_slot},
    safe::{Fail, Result, ValueRef, World},
};

use crate::methods::{MAX_ITERATIONS, method, result_number};

/// Tags of the custom data that the importer stores with the scene and with its objects: a byte that marks the tag as
/// private, and a name.
const REGISTRATIONS_TAG: &[u8] = b"\x01registered";
const HANDLE_TAG: &[u8] = b"\x01handle";

/// Tag of the mode of a joint that a script has set, and first part of the tag by which a script decides whether a group
/// is solved only on request.
const JOINT_MODE_TAG: &[u8] = b"\x01joint mode";
const EXPLICIT_TAG: &[u8] = b"\x01explicit group ";
/// The joint mode of inverse kinematics.
const MODE_IK: f64 = 2.0;

/// Flags of groups in files. The meanings of `AFTER_FAILURE` and `AFTER_SUCCESS` are an assumption: in all examined
/// files, both flags are set and the group depends on no other.
const ENABLED: u8 = 1;
const RESTORES_POSITION: u8 = 2;
const RESTORES_ORIENTATION: u8 = 4;
const AFTER_FAILURE: u8 = 8;
const AFTER_SUCCESS: u8 = 16;
const RESPECTS_MAX_STEPS: u8 = 32;
const EXPLICIT: u8 = 64;

/// The part of the stored JSON that concerns inverse kinematics.
#[derive(Deserialize, Default)]
#[serde(default)]
struct RegistrationsText {
    ik_groups: Vec<GroupText>,
    ik_joints: Vec<i64>,
}
#[derive(Deserialize)]
#[serde(default)]
struct GroupText {
    handle: i64,
    elements: Vec<ElementText>,
    method: i64,
    max_iterations: u32,
    damping: f64,
    after: i64,
    flags: u8,
}
#[derive(Deserialize)]
#[serde(default)]
struct ElementText {
    tip: i64,
    target: i64,
    base: i64,
    axes: i64,
    constraints: u32,
    precision: [f64; 2],
    weights: [f64; 2],
    enabled: bool,
}

/// Defaults for scenes that were converted by a version of the importer that did not store these values. Without a
/// target, a group is not solved.
impl Default for GroupText {
    fn default() -> Self {
        GroupText {
            handle: -1,
            elements: Vec::new(),
            method: 0,
            max_iterations: 3,
            damping: 0.1,
            after: -1,
            flags: ENABLED,
        }
    }
}
impl Default for ElementText {
    fn default() -> Self {
        ElementText {
            tip: -1,
            target: -1,
            base: -1,
            axes: -1,
            constraints: 31,
            precision: [0.0005, 0.1 * std::f64::consts::PI / 180.0],
            weights: [1.0; 2],
            enabled: true,
        }
    }
}

/// A group of the scene, and the conditions under which it is solved.
#[derive(Serialize, Deserialize, Clone)]
pub struct SceneGroup {
    pub handle: i64,
    pub group: IkGroup,
    /// Whether the group is solved only at the request of a script.
    pub explicit: bool,
    /// The group on whose result this group depends, and whether this group is solved after its success and after its
    /// failure.
    after: Option<(i64, [bool; 2])>,
    /// The last result, as the number that represents it in scripts.
    pub result: i64,
}

/// The groups of a scene, in the order of the file.
#[derive(Serialize, Deserialize, Default, Clone)]
pub struct SceneGroups {
    pub copy: SceneCopy,
    pub groups: Vec<SceneGroup>,
    /// The last Jacobian of each group, by the handle of the group: its elements, which are listed joint by joint from
    /// tip to base, its numbers of rows and columns, and the manipulability.
    pub matrices: BTreeMap<i64, (Vec<f64>, [i64; 2], f64)>,
}

/// Returns the data stored under a tag in a map.
fn tagged<'a>(data: ValueRef<'a>, tag: &[u8]) -> Option<&'a [u8]> {
    data.map()?.iter().find(|[key, _]| key.as_bytes() == Some(tag)).and_then(|[_, value]| value.as_bytes())
}

/// Reads the groups of the scene. Elements whose objects were removed are skipped.
pub fn read(world: &World<'_>, props: &SceneProps) -> Result<SceneGroups> {
    let Some(bytes) = tagged(world.get(0, props.scene_data)?, REGISTRATIONS_TAG) else {
        return Ok(SceneGroups::default());
    };
    let damaged = |e| Fail::argument(format!("the inverse kinematics groups stored in the scene are damaged: {e}"));
    let text: RegistrationsText = serde_json::from_slice(bytes).map_err(damaged)?;
    let mut objects: BTreeMap<i64, tatu_object> = BTreeMap::new();
    for id in world.list(0, 0, 0)? {
        let handle = tagged(world.get(id, props.object_data)?, HANDLE_TAG);
        let handle = handle.and_then(|text| std::str::from_utf8(text).ok()?.parse().ok());
        if let Some(handle) = handle {
            objects.entry(handle).or_insert(world.look(id)?.id);
        }
    }
    let mut all = SceneGroups::default();
    for group in &text.ik_groups {
        let tasks = group.elements.iter().filter_map(|e| task(world, props, &mut all.copy, &objects, e).transpose());
        let tasks = tasks.collect::<Result<Vec<_>>>()?;
        all.groups.push(scene_group(group, tasks));
    }
    let moved: Vec<tatu_object> = text.ik_joints.iter().filter_map(|handle| objects.get(handle).copied()).collect();
    fix_other_joints(&mut all.copy, &moved);
    Ok(all)
}

/// Fixes the joints that inverse kinematics does not move. Joints that depend on another joint continue to follow it.
fn fix_other_joints(copy: &mut SceneCopy, moved: &[tatu_object]) {
    for (frame, object) in &copy.objects {
        if let Some(joint) =
            copy.linkage.joint_mut(*frame).filter(|j| j.role == JointRole::Moved && !moved.contains(object))
        {
            joint.role = JointRole::Fixed;
        }
    }
}

/// Returns the number stored under a tag, as text.
fn tagged_number(data: ValueRef<'_>, tag: &[u8]) -> Option<f64> {
    std::str::from_utf8(tagged(data, tag)?).ok()?.parse().ok()
}

/// Copies the chain of an element; returns `None` if one of its objects no longer exists.
fn task(
    world: &World<'_>,
    props: &SceneProps,
    copy: &mut SceneCopy,
    objects: &BTreeMap<i64, tatu_object>,
    element: &ElementText,
) -> Result<Option<IkTask>> {
    let find = |handle: i64| objects.get(&handle).copied();
    let (Some(tip), Some(target)) = (find(element.tip), find(element.target)) else { return Ok(None) };
    let base = find(element.base);
    let Ok(tip) = copy.copy_chain(world, props, base, tip) else { return Ok(None) };
    let target = copy.copy_frame(world, props, target)?;
    let axes = find(element.axes).map(|object| copy.copy_frame(world, props, object)).transpose()?;
    let sound = |numbers: [f64; 2], default: [f64; 2]| {
        if numbers.iter().all(|x| x.is_finite() && *x >= 0.0) { numbers } else { default }
    };
    let task = IkTask::new(tip, target);
    Ok(Some(IkTask {
        base: base.and_then(|base| copy.copy_of(base)),
        axes,
        constraints: Constraints(element.constraints & 31),
        precision: sound(element.precision, task.precision),
        weights: sound(element.weights, task.weights),
        enabled: element.enabled,
        ..task
    }))
}

fn scene_group(text: &GroupText, tasks: Vec<IkTask>) -> SceneGroup {
    let has = |flag: u8| text.flags & flag != 0;
    let (method, damping) = method(text.method, text.damping);
    let group = IkGroup {
        tasks,
        method,
        damping,
        max_iterations: text.max_iterations.min(MAX_ITERATIONS),
        ignores_max_steps: !has(RESPECTS_MAX_STEPS),
        restores: [has(RESTORES_POSITION), has(RESTORES_ORIENTATION)],
        enabled: has(ENABLED),
        ..IkGroup::default()
    };
    let results = [has(AFTER_SUCCESS), has(AFTER_FAILURE)];
    let after = (text.after >= 0 && results != [false; 2]).then_some((text.after, results));
    SceneGroup { handle: text.handle, group, explicit: has(EXPLICIT), after, result: 0 }
}

impl SceneGroup {
    /// Creates a group for a script; `options` are those of `sim.createIkGroup`.
    pub fn created(handle: i64, options: i64, (number, iterations, damping): (i64, f64, f64)) -> Self {
        let has = |flag: i64| options & flag != 0;
        let (method, damping) = method(number, damping);
        let group = IkGroup {
            method,
            damping,
            max_iterations: (iterations as u32).min(MAX_ITERATIONS),
            ignores_max_steps: !has(16),
            keeps_limits: has(2),
            restores: [has(4), has(8)],
            enabled: !has(1),
            ..IkGroup::default()
        };
        SceneGroup { handle, group, explicit: has(32), after: None, result: 0 }
    }
}

impl SceneGroups {
    /// Returns the group with this handle. Fails if there is none.
    pub fn group(&mut self, handle: i64) -> Result<&mut SceneGroup> {
        let found = self.groups.iter_mut().find(|g| g.handle == handle);
        found.ok_or_else(|| Fail::argument(format!("there is no inverse kinematics group with handle {handle}")))
    }

    /// Solves groups one after the other, and moves their joints in the scene. Returns the number of groups solved.
    pub fn handle(&mut self, world: &World<'_>, props: &SceneProps, handles: &[i64]) -> Result<i64> {
        let targets: Vec<FrameId> = self.groups.iter().flat_map(|g| &g.group.tasks).map(|t| t.target).collect();
        self.copy.take_from_scene(world, props, &targets)?;
        self.take_joint_modes(world, props);
        let mut performed = 0;
        for i in (0..self.groups.len()).filter(|i| handles.contains(&self.groups[*i].handle)).collect::<Vec<_>>() {
            let result = if self.is_due(i) {
                let group = &self.groups[i].group;
                tatu_kinematics::solve(&mut self.copy.linkage, &[group]).result
            } else {
                IkResult::NotPerformed
            };
            self.groups[i].result = result_number(result);
            performed += i64::from(result != IkResult::NotPerformed);
        }
        let tasks: Vec<IkTask> = self
            .groups
            .iter()
            .filter(|g| handles.contains(&g.handle) && g.result != 0)
            .flat_map(|g| g.group.tasks.clone())
            .collect();
        self.copy.give_to_scene(world, props, &self.copy.joints_of(&tasks))?;
        Ok(performed)
    }

    /// Applies the joint modes that scripts have set since the file was read.
    fn take_joint_modes(&mut self, world: &World<'_>, props: &SceneProps) {
        for (frame, object) in &self.copy.objects {
            let Some(joint) = self.copy.linkage.joint_mut(*frame) else { continue };
            let is_free = matches!(joint.role, JointRole::Moved | JointRole::Fixed);
            // A joint that no longer exists keeps its role.
            let mode = world.get(*object, props.object_data).ok().and_then(|data| tagged_number(data, JOINT_MODE_TAG));
            if let Some(mode) = mode.filter(|_| is_free) {
                joint.role = if mode == MODE_IK { JointRole::Moved } else { JointRole::Fixed };
            }
        }
    }

    /// Returns the handles of the groups that are solved without a request.
    pub fn automatic(&self, world: &World<'_>, props: &SceneProps) -> Result<Vec<i64>> {
        let data = world.get(0, props.scene_data)?;
        let is_explicit = |group: &&SceneGroup| {
            let tag = [EXPLICIT_TAG, group.handle.to_string().as_bytes()].concat();
            tagged_number(data, &tag).map_or(group.explicit, |x| x != 0.0)
        };
        Ok(self.groups.iter().filter(|group| !is_explicit(group)).map(|group| group.handle).collect())
    }

    /// Returns whether group `i` must be solved, given the result of the group on which it depends.
    fn is_due(&self, i: usize) -> bool {
        let Some((after, [on_success, on_failure])) = self.groups[i].after else { return true };
        match self.groups.iter().find(|g| g.handle == after).map(|g| g.result) {
            Some(1) => on_success,
            Some(2) => on_failure,
            _ => false,
        }
    }
}

/// Returns the copies of the joints whose handles in the scene are `objects`.
pub fn joints(groups: &SceneGroups, objects: &[f64]) -> Result<Vec<FrameId>> {
    let find = |object: &f64| {
        let of_handle = |(copy, id): (&FrameId, &tatu_object)| (f64::from(tatu_slot(*id)) == *object).then_some(*copy);
        let copy = groups.copy.objects.iter().find_map(of_handle);
        let copy = copy.filter(|copy| groups.copy.linkage.joint(*copy).is_some());
        copy.ok_or_else(|| Fail::argument(format!("object {object} is not a joint of an inverse kinematics group")))
    };
    objects.iter().map(find).collect()
}
