//! Drives of joints, and smooth position targets between scene steps. A target is usually set once per scene step,
//! which consists of several physics steps. If it were applied at once, the joint would jerk and shake the object in a
//! gripper. Targets are therefore control points of a uniform quadratic B-spline, whose acceleration is the second
//! difference of the targets. The spline lags by half a scene step, and a single target is reached after two scene
//! steps. Its rate is added to the speed of the drive, which would otherwise lag behind it by its time constant.
//! Targets are applied at once if a scene step is a single physics step, or if they are set between physics steps.

use tatu_physics::{JointDrive, PositionController, SETTLE_TIME};

use super::{mass::surface, state::Dynamics};
use crate::{
    notices::NoticeKind,
    object::{ControlMode, Joint, JointType, ObjectVariant, TargetSpline},
    tree::Scene,
};

/// The target of position control in a physics step.
#[derive(Clone, Copy)]
struct PositionTarget {
    /// Target position at the end of the physics step, rad or m. It is clamped to the limits, because a target beyond
    /// them would press the joint against the limit permanently and cause jitter.
    position: f64,
    /// Feed-forward velocity, rad/s or m/s, which is added to the velocity commanded for the position error, so that a
    /// joint does not lag behind a spline.
    lead: f64,
}

/// Returns the target of the physics step `part` of `steps`, each of length `step`, s.
fn target_of(j: &Joint, part: u32, steps: u32, step: f64) -> PositionTarget {
    let share = f64::from(part + 1) / f64::from(steps);
    let (low, high) = j.limits.unwrap_or((f64::NEG_INFINITY, f64::INFINITY));
    let wanted = j.course.map_or(j.target_position, |c| c.target(share));
    let position = wanted.max(low).min(high);
    let rate = j.course.map_or(0.0, |c| c.rate(share)) / (f64::from(steps) * step);
    // The position error already accounts for the motion within this physics step.
    let lead = if position == wanted { rate * (1.0 - step / SETTLE_TIME).max(0.0) } else { 0.0 };
    PositionTarget { position, lead }
}

/// Returns the drive of a geared joint, derived from the drive of its leader.
fn follower_drive(drive: JointDrive, factor: f64, offset: f64, limit: f64) -> JointDrive {
    match drive {
        JointDrive::Free => JointDrive::Free,
        JointDrive::Velocity { target, slip, .. } => {
            JointDrive::Velocity { target: factor * target, max_force: limit, slip }
        }
        JointDrive::Position { target, max_velocity, tracking, .. } => JointDrive::Position {
            target: factor * target + offset,
            max_force: limit,
            max_velocity: factor.abs() * max_velocity,
            tracking: tracking.map(|t| PositionController { velocity: factor * t.velocity, ..t }),
        },
        JointDrive::Force(_) => JointDrive::Force(limit),
    }
}

/// Returns a drive whose torque or force is multiplied by `share`.
fn scaled_drive(drive: JointDrive, share: f64) -> JointDrive {
    match drive {
        JointDrive::Velocity { target, max_force, slip } => {
            JointDrive::Velocity { target, max_force: share * max_force, slip }
        }
        JointDrive::Position { target, max_force, max_velocity, tracking } => {
            JointDrive::Position { target, max_force: share * max_force, max_velocity, tracking }
        }
        JointDrive::Force(force) => JointDrive::Force(share * force),
        JointDrive::Free => JointDrive::Free,
    }
}

/// Returns whether the targets of a joint are smoothed by a spline.
fn is_smooth(j: &Joint) -> bool {
    j.smooth_target && j.dynamic && j.control == ControlMode::Position && j.id.is_some()
}

/// Returns whether a motor controls velocity or position.
fn tracks_target(j: &Joint) -> bool {
    matches!(j.control, ControlMode::Velocity | ControlMode::Position)
}

/// Returns whether a joint has a target to reach, but a motor without torque or force.
fn lacks_motor_force(j: &Joint) -> bool {
    let moves = match j.control {
        ControlMode::Velocity => j.target_velocity != 0.0,
        ControlMode::Position => (j.target_position - j.position).abs() > 1e-6,
        _ => false,
    };
    // The engine couples a geared joint to its leader.
    let coupled = j.follow.geared && !j.follow.master.is_empty();
    j.dynamic && j.id.is_some() && j.max_force == 0.0 && moves && !coupled
}

fn no_torque_message(path: &str, j: &Joint) -> String {
    let (key, what) = match j.kind {
        JointType::Prismatic => ("max_force_n", "force"),
        _ => ("max_force_nm", "torque"),
    };
    format!("the target of the joint {path} has no effect, because its motor has no {what}: set `{key}` above 0")
}

/// Returns the target position. For a cyclic joint, this is the equivalent angle that is nearest to `from`, which makes
/// the joint take the shorter path.
fn nearest_target(j: &Joint, from: f64) -> f64 {
    let way = j.target_position - from;
    if j.kind == JointType::Revolute && j.limits.is_none() {
        return from + tatu_geometry::wrap_angle(way);
    }
    j.target_position
}

fn drive_of(j: &Joint, target: PositionTarget) -> Option<JointDrive> {
    // Without gains of its own, a drive has this gain, and no derivative or integral.
    let leading = PositionController { p: 1.0 / SETTLE_TIME, i: 0.0, d: 0.0, velocity: target.lead };
    Some(match j.control {
        ControlMode::Free | ControlMode::Spring => JointDrive::Free,
        ControlMode::Velocity => {
            JointDrive::Velocity { target: j.target_velocity, max_force: j.max_force.abs(), slip: j.slip }
        }
        ControlMode::Position => JointDrive::Position {
            target: target.position,
            max_force: j.max_force.abs(),
            max_velocity: j.max_velocity,
            tracking: match j.gains {
                Some([p, i, d]) => Some(PositionController { p, i, d, velocity: j.target_velocity }),
                None => (target.lead != 0.0).then_some(leading),
            },
        },
        ControlMode::Force => JointDrive::Force(j.max_force),
        // A script provides the drive in each engine step.
        ControlMode::Callback => return None,
    })
}

impl Dynamics {
    /// Converts targets set since the last advance to control points, if an advance consists of several physics steps.
    pub(super) fn update_splines(&mut self, scene: &mut Scene, steps: u32) {
        let mut slots = std::mem::take(&mut self.moving_targets);
        slots.extend(&self.drives);
        slots.sort_unstable();
        slots.dedup();
        for slot in slots {
            let Some(ObjectVariant::Joint(j)) = scene.get_mut(slot).map(|o| &mut o.data) else { continue };
            if steps < 2 || !is_smooth(j) {
                j.course = None;
                continue;
            }
            // When position control starts, the spline starts at the joint's current position.
            let course = j.course.unwrap_or(TargetSpline::at(j.position));
            let course = course.next(nearest_target(j, course.points[2]));
            j.course = Some(course);
            if course.is_moving() || course.direct {
                self.moving_targets.push(slot);
            }
        }
    }

    /// Passes the drives of joints to the engine before the physics step with index `part` of `steps`: drives that have
    /// changed, and those whose target is still moving.
    pub(super) fn apply_drives(&mut self, scene: &mut Scene, part: u32, steps: u32) {
        let mut drives = std::mem::take(&mut self.drives);
        for slot in drives.drain(..) {
            if let Some((shape, body)) = scene.get(slot).and_then(|o| o.shape()).and_then(|s| Some((s, s.body.0?))) {
                self.engine.set_surface(body, surface(scene, shape));
            }
            if let Some(o) = scene.get(slot)
                && let Some(j) = o.joint().filter(|j| lacks_motor_force(j))
                && self.notices.is_new(NoticeKind::NoTorque, o.uid)
            {
                self.notices.add(no_torque_message(&scene.path(slot), j));
            }
            let Some(ObjectVariant::Joint(j)) = scene.get_mut(slot).map(|o| &mut o.data) else { continue };
            if part > 0 && is_smooth(j) && j.course.is_none_or(|c| nearest_target(j, c.points[2]) != c.points[2]) {
                j.course = Some(TargetSpline { direct: true, ..TargetSpline::at(j.target_position) });
                self.moving_targets.push(slot);
            }
            self.apply_drive(j, part, steps);
        }
        self.drives = drives;
        for i in 0..self.moving_targets.len() {
            if let Some(j) = scene.get(self.moving_targets[i]).and_then(|o| o.joint()) {
                self.apply_drive(j, part, steps);
            }
        }
        self.share_drives(scene, part, steps);
    }

    /// Drives geared joints together with their leaders. The engine couples each pair by a single constraint, whose
    /// error increases with the force that it transmits. If both joints have motors, the follower's motor is therefore
    /// given the targets of the leader's, multiplied by the gear ratio. A follower without a motor is driven by a share
    /// of the force of the leader's motor.
    fn share_drives(&mut self, scene: &Scene, part: u32, steps: u32) {
        for (slot, leader) in &self.couplings.geared {
            let joint = |slot: u32| scene.get(slot).and_then(|o| o.joint());
            let (Some(j), Some(l)) = (joint(*slot), joint(*leader)) else { continue };
            let (Some(id), Some(leader_id), Some(drive)) =
                (j.id, l.id, drive_of(l, target_of(l, part, steps, self.step)))
            else {
                continue;
            };
            let factor = j.follow.factor;
            if let Some(share) = self.share_of(scene, *slot, *leader) {
                let limit = match drive {
                    JointDrive::Velocity { max_force, .. } | JointDrive::Position { max_force, .. } => {
                        max_force / factor.abs()
                    }
                    JointDrive::Force(force) => force / factor,
                    JointDrive::Free => 0.0,
                };
                self.engine.drive(leader_id, scaled_drive(drive, share));
                self.engine.drive(id, follower_drive(drive, factor, j.follow.offset, share * limit));
            } else if tracks_target(l) && tracks_target(j) {
                self.engine.drive(id, follower_drive(drive, factor, j.follow.offset, j.max_force.abs()));
            }
        }
    }

    /// Returns the share of the leader's motor force that acts on a follower without a motor, or `None` if it is not
    /// shared.
    fn share_of(&self, scene: &Scene, slot: u32, leader: u32) -> Option<f64> {
        let joint = |slot: u32| scene.get(slot).and_then(|o| o.joint());
        let is_free = |slot: u32| joint(slot).is_some_and(|j| j.control == ControlMode::Free && j.follow.factor != 0.0);
        let (l, follows) = (joint(leader)?, self.couplings.geared.iter().any(|(slot, _)| *slot == leader));
        let motor = tracks_target(l) || l.control == ControlMode::Force;
        // The speed of a motor with slip depends on its full load, so its force is not shared.
        let yields = l.slip != 0.0 || l.passive.no_load_speed != 0.0;
        let others = self.couplings.geared.iter().filter(|(slot, l)| *l == leader && is_free(*slot)).count();
        (motor && !yields && !follows && is_free(slot)).then(|| 1.0 / (others + 1) as f64)
    }

    /// Adds the shares of motor force that acted on followers to the efforts of their leaders.
    pub(super) fn sum_efforts(&mut self, scene: &mut Scene) {
        for (slot, leader) in &self.couplings.geared {
            if self.share_of(scene, *slot, *leader).is_none() {
                continue;
            }
            let Some(ObjectVariant::Joint(j)) = scene.get_mut(*slot).map(|o| &mut o.data) else { continue };
            let more = j.follow.factor * std::mem::take(&mut j.effort);
            if let Some(ObjectVariant::Joint(l)) = scene.get_mut(*leader).map(|o| &mut o.data) {
                l.effort += more;
            }
        }
    }

    fn apply_drive(&mut self, j: &Joint, part: u32, steps: u32) {
        let Some(id) = j.id else { return };
        let target = target_of(j, part, steps, self.step);
        if let Some(drive) = drive_of(j, target) {
            self.engine.drive(id, drive);
            let rest = if j.control == ControlMode::Spring { j.target_position } else { j.passive.rest };
            self.engine.set_rest(id, rest);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn single_target_is_reached_after_two_steps_without_a_jump() {
        let mut course = TargetSpline::at(0.0);
        let mut way = vec![0.0];
        for target in [1.0, 1.0, 1.0] {
            course = course.next(target);
            way.extend((1..=10).map(|n| course.target(f64::from(n) / 10.0)));
        }
        assert_eq!((way[10], way[20], way[30]), (0.5, 1.0, 1.0));
        assert!(!course.is_moving());
        // The second difference of the targets is 1 per step, and each step consists of ten parts.
        let bend = way.windows(3).map(|w| (w[2] - 2.0 * w[1] + w[0]).abs()).fold(0.0, f64::max);
        assert!((bend - 0.01).abs() < 1e-12, "{bend}");
    }

    #[test]
    fn target_set_between_physics_steps_applies_at_once() {
        let course = TargetSpline { direct: true, ..TargetSpline::at(1.0) }.next(3.0);
        assert_eq!((course.target(0.1), course.is_moving()), (3.0, false));
    }

    #[test]
    fn cyclic_joint_rotates_the_shorter_way() {
        let j = Joint { target_position: -3.0, ..Joint::default() };
        assert!((nearest_target(&j, 3.0) - (std::f64::consts::TAU - 3.0)).abs() < 1e-12);
        let limited = Joint { limits: Some((-3.1, 3.1)), ..j };
        assert_eq!(nearest_target(&limited, 3.0), -3.0);
    }
}
