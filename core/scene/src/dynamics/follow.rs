//! Joints that follow others: gears, linkages and cams. The position of the follower is a function of the leader's
//! position, or its speed is a multiple of the leader's.
//!
//! A follower is driven by its own motor, with its own force limit, towards the position that results from the leader's
//! at the end of the last step; there is no reaction on the leader. A geared joint and its leader are coupled in the
//! engine.

use crate::{
    object::{ControlMode, ObjectVariant},
    tree::Scene,
};

/// Returns all followers with their leaders, as pairs of slots, in ascending order of followers.
pub(super) fn followers(scene: &Scene) -> Vec<(u32, u32)> {
    let named = scene.slots().filter_map(|(slot, o)| {
        let master = o.joint().map(|j| j.follow.master.as_str()).filter(|m| !m.is_empty())?;
        find_leader(scene, slot, master).map(|leader| (slot, leader))
    });
    named.collect()
}

/// Returns the first joint, other than the follower, that a path denotes. Other objects with the same alias, such as the
/// links of a robot, are passed over.
fn find_leader(scene: &Scene, slot: u32, path: &str) -> Option<u32> {
    let is_leader = |found: u32| found != slot && scene.get(found).is_some_and(|o| o.joint().is_some());
    let first = scene.find(slot, path)?;
    if is_leader(first) || path.ends_with(']') {
        return Some(first).filter(|found| is_leader(*found));
    }
    let others = (1..).map_while(|n| scene.find(slot, &format!("{path}[{n}]")));
    others.take_while(|found| *found != first).find(|found| is_leader(*found))
}

impl Scene {
    /// Returns the joint that a joint follows, or `None` if it follows none.
    pub fn leader(&self, slot: u32) -> Option<u32> {
        let path = self.get(slot)?.joint().map(|j| j.follow.master.as_str()).filter(|path| !path.is_empty())?;
        find_leader(self, slot, path)
    }

    /// Returns the path of each joint whose leader does not exist or is not another joint, with the path that it
    /// specifies for the leader.
    pub fn dangling_followers(&self) -> Vec<(String, String)> {
        let found = followers(self);
        let lost = self.slots().filter_map(|(slot, o)| {
            let master = o.joint().map(|j| &j.follow.master).filter(|m| !m.is_empty())?;
            let is_lost = !found.iter().any(|(s, _)| *s == slot);
            is_lost.then(|| (self.path(slot), master.clone()))
        });
        lost.collect()
    }
}

/// Returns the geared joints with their leaders, as pairs of slots.
pub(crate) fn geared(scene: &Scene) -> Vec<(u32, u32)> {
    let is_geared = |slot: u32| scene.get(slot).and_then(|o| o.joint()).is_some_and(|j| j.follow.geared && j.dynamic);
    followers(scene)
        .into_iter()
        .filter(|(slot, leader)| {
            is_geared(*slot) && scene.get(*leader).and_then(|o| o.joint()).is_some_and(|j| j.dynamic)
        })
        .collect()
}

/// Sets the targets of dynamic followers and the positions of kinematic ones. Joints whose target has changed are added
/// to `drives`.
pub(super) fn update(scene: &mut Scene, followers: &[(u32, u32)], drives: &mut Vec<u32>) {
    for (slot, master) in followers {
        let Some(m) = scene.get(*master).and_then(|o| o.joint()) else { continue };
        // A joint without a counterpart in the engine has no measured velocity, so its target velocity is used.
        let (position, velocity) = (m.position, if m.id.is_some() { m.velocity } else { m.target_velocity });
        let Some(ObjectVariant::Joint(j)) = scene.get_mut(*slot).map(|o| &mut o.data) else { continue };
        // Geared joints have no targets, because the engine couples them to their leaders.
        if j.follow.geared && j.dynamic {
            continue;
        }
        let position = j.follow.position(position);
        if !j.dynamic {
            j.velocity = j.follow.factor * velocity;
            if j.position != position {
                j.position = position;
                scene.refresh(*slot);
            }
            continue;
        }
        let (place, wanted) = match j.control {
            ControlMode::Position => (&mut j.target_position, position),
            ControlMode::Velocity => (&mut j.target_velocity, j.follow.factor * velocity),
            ControlMode::Free | ControlMode::Force | ControlMode::Callback | ControlMode::Spring => continue,
        };
        if std::mem::replace(place, wanted) != wanted {
            drives.push(*slot);
        }
    }
}
