//! Gears of the joints of trees. A gear is substituted: a geared joint has no coordinate of its own, but follows that
//! of an independent joint of its tree, so it holds exactly and at no cost.
//!
//! If the bodies are not where a gear requires them, because they were created or moved there, the gap is part of the
//! gear's offset, and closes gradually.

use tatu_geometry::wrap_angle;

use super::{
    build::{read_state, shift_offset},
    records::{LinkGear, Mechanism},
    table::TreeJoints,
};
use crate::{
    Gear, JointId, JointKind,
    rapier::{bodies::Bodies, joints::table::Joints},
};

/// Time constant with which a gap closes, s, and maximum speed, rad/s or m/s: those with which a joint returns to its
/// limits.
const CLOSING_TIME_S: f64 = 0.1;
const MAX_CLOSING_SPEED: f64 = 1.0;
/// A gap below this is closed, rad or m.
const MIN_GAP: f64 = 1e-9;

impl TreeJoints {
    /// Replaces all gears between joints.
    pub fn set_gears(&mut self, gears: &[Gear]) {
        if self.gears != gears {
            self.gears = gears.to_vec();
            self.changed = true;
        }
    }

    /// Returns the gear of each link of a mechanism with these joints. Gears to joints of other mechanisms and those
    /// that close a cycle are ignored, as are those of joints without a single axis.
    pub(super) fn gears_of(&self, joints: &Joints, links: &[Option<JointId>]) -> Vec<Option<LinkGear>> {
        let mut found: Vec<Option<LinkGear>> = vec![None; links.len()];
        let link_of = |joint: JointId| {
            let link = links.iter().position(|link| *link == Some(joint))?;
            let kind = joints.get(joint)?.kind;
            matches!(kind, JointKind::Revolute | JointKind::Prismatic).then_some(link)
        };
        for gear in &self.gears {
            let (Some(link), Some(leader)) = (link_of(gear.joint), link_of(gear.leader)) else { continue };
            if independent_link(&found, leader) != link && gear.ratio.is_finite() && gear.offset.is_finite() {
                found[link] = Some(LinkGear { leader, ratio: gear.ratio, offset: gear.offset, gap: 0.0 });
            }
        }
        found
    }

    /// Joins lists of joints that gears connect.
    pub(super) fn join_geared(&self, mut lists: Vec<Vec<JointId>>) -> Vec<Vec<JointId>> {
        for gear in &self.gears {
            let list_of = |joint: JointId| lists.iter().position(|list| list.contains(&joint));
            let (Some(a), Some(b)) = (list_of(gear.joint), list_of(gear.leader)) else { continue };
            if a != b {
                let later = lists.remove(a.max(b));
                lists[a.min(b)].extend(later);
            }
        }
        lists
    }
}

/// Returns the link whose joint moves that of a link, through all gears in between.
pub(super) fn independent_link(gears: &[Option<LinkGear>], mut link: usize) -> usize {
    while let Some(gear) = gears[link] {
        link = gear.leader;
    }
    link
}

/// Sets the gaps of all gears of a mechanism from its bodies.
pub(super) fn read_gaps(mechanism: &mut Mechanism, bodies: &Bodies, joints: &Joints) {
    for link in 0..mechanism.gears.len() {
        let (mut ratio, mut offset, mut leader) = (1.0, 0.0, link);
        while let Some(gear) = mechanism.gears[leader] {
            offset += ratio * gear.offset;
            ratio *= gear.ratio;
            leader = gear.leader;
        }
        let record = mechanism.joints[link].and_then(|joint| joints.get(joint));
        let (Some(record), true) = (record, leader != link) else { continue };
        let (position, _) = read_state(mechanism, link, None, bodies, joints);
        let required = ratio * mechanism.q[mechanism.places[link].position] + offset;
        let gap = position.first().map_or(0.0, |position| position - required);
        let gap = if record.kind == JointKind::Revolute { wrap_angle(gap) } else { gap };
        if let Some(gear) = &mut mechanism.gears[link] {
            let before = std::mem::replace(&mut gear.gap, if gap.abs() < MIN_GAP { 0.0 } else { gap });
            let by = gear.gap - before;
            if let Some(built) = mechanism.built.as_mut().filter(|_| by != 0.0) {
                shift_offset(&mut built.tree, link, by);
                // The tree has changed, so what it did in the last step does not count.
                built.rest = None;
            }
        }
    }
}

/// Closes the gaps of a mechanism's gears by what a step of length `dt`, s, allows.
pub(super) fn close_gaps(mechanism: &mut Mechanism, dt: f64) {
    let Some(built) = &mut mechanism.built else { return };
    for (link, gear) in mechanism.gears.iter_mut().enumerate() {
        let Some(gear) = gear.as_mut().filter(|gear| gear.gap != 0.0) else { continue };
        let before = gear.gap;
        let most = MAX_CLOSING_SPEED * dt;
        gear.gap -= (gear.gap * (dt / CLOSING_TIME_S).min(1.0)).clamp(-most, most);
        if gear.gap.abs() < MIN_GAP {
            gear.gap = 0.0;
        }
        shift_offset(&mut built.tree, link, gear.gap - before);
        built.rest = None;
    }
}
