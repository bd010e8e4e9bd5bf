//! What joints are driven by, and how position targets are followed between scene steps.
//!
//! A target comes once a scene step, which consists of several physics steps. Followed as it comes it would jump, and shake
//! what a gripper holds. Targets are therefore control points of a uniform quadratic B-spline: acceleration is their second
//! difference. It lags by half a scene step, and a lone target is reached after two. Where a scene step is one physics step,
//! and where targets come between physics steps, they are taken as they come.

use serde::{Deserialize, Serialize};
use tatu_physics::{Drive, Tracking};

use super::{Control, Data, Dynamics, Joint, JointType, Scene, dynamics::surface};

/// The way of a position target.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Course {
    /// The targets of the last three scene steps, rad or m, the newest one last.
    pub points: [f64; 3],
    /// Whether a target came between physics steps.
    pub direct: bool,
}

impl Course {
    fn at(target: f64) -> Self {
        Course { points: [target; 3], direct: false }
    }

    /// With the next scene step.
    fn next(self, target: f64) -> Self {
        let [_, a, b] = self.points;
        if self.direct { Course::at(target) } else { Course { points: [a, b, target], direct: false } }
    }

    /// Whether it is not yet where it leads to.
    pub fn under_way(&self) -> bool {
        let [a, b, c] = self.points;
        a != b || b != c
    }

    /// The target when a share of the scene step has passed.
    fn target(&self, share: f64) -> f64 {
        let [a, b, c] = self.points;
        let rest = 1.0 - share;
        b + 0.5 * (rest * rest * (a - b) + share * share * (c - b))
    }
}

/// Whether the targets of a joint are control points of a spline.
fn is_smooth(j: &Joint) -> bool {
    j.smooth_target && j.dynamic && j.control == Control::Position && j.id.is_some()
}

/// The target as a number that goes on from an earlier one: a joint without end takes the shorter way round.
fn near(j: &Joint, from: f64) -> f64 {
    let way = j.target_position - from;
    if j.kind == JointType::Revolute && j.limits.is_none() {
        return from + nalgebra::wrap(way, -std::f64::consts::PI, std::f64::consts::PI);
    }
    j.target_position
}

fn drive_of(j: &Joint, target: f64) -> Option<Drive> {
    Some(match j.control {
        Control::Free | Control::Spring => Drive::Free,
        Control::Velocity => Drive::Velocity { target: j.target_velocity, max_force: j.max_force.abs(), slip: j.slip },
        Control::Position => Drive::Position {
            target,
            max_force: j.max_force.abs(),
            max_velocity: j.max_velocity.abs(),
            tracking: j.gains.map(|[p, i, d]| Tracking { p, i, d, velocity: j.target_velocity }),
        },
        Control::Force => Drive::Force(j.max_force),
        // A script answers for it in each engine step.
        Control::Callback => return None,
    })
}

impl Dynamics {
    /// Targets that came since the last advance become control points, if an advance is several physics steps.
    pub(super) fn plot_courses(&mut self, scene: &mut Scene, steps: u32) {
        let mut slots = std::mem::take(&mut self.courses);
        slots.extend(&self.drives);
        slots.sort_unstable();
        slots.dedup();
        for slot in slots {
            let Some(Data::Joint(j)) = scene.get_mut(slot).map(|o| &mut o.data) else { continue };
            if steps < 2 || !is_smooth(j) {
                j.course = None;
                continue;
            }
            // What begins to hold a target goes there from where it is.
            let course = j.course.unwrap_or(Course::at(j.position));
            let course = course.next(near(j, course.points[2]));
            j.course = Some(course);
            if course.under_way() || course.direct {
                self.courses.push(slot);
            }
        }
    }

    /// Tells the engine what drives joints in the `part`-th of `steps` physics steps: of those whose drive changed, and of
    /// those whose target is under way.
    pub(super) fn apply_drives(&mut self, scene: &mut Scene, part: u32, steps: u32) {
        let mut drives = std::mem::take(&mut self.drives);
        for slot in drives.drain(..) {
            if let Some((shape, body)) = scene.get(slot).and_then(|o| o.shape()).and_then(|s| Some((s, s.body.0?))) {
                self.engine.set_surface(body, surface(scene, shape));
            }
            let Some(Data::Joint(j)) = scene.get_mut(slot).map(|o| &mut o.data) else { continue };
            if part > 0 && is_smooth(j) && j.course.is_none_or(|c| near(j, c.points[2]) != c.points[2]) {
                j.course = Some(Course { direct: true, ..Course::at(j.target_position) });
                self.courses.push(slot);
            }
            self.apply_drive(j, part, steps);
        }
        self.drives = drives;
        for i in 0..self.courses.len() {
            if let Some(j) = scene.get(self.courses[i]).and_then(|o| o.joint()) {
                self.apply_drive(j, part, steps);
            }
        }
    }

    fn apply_drive(&mut self, j: &Joint, part: u32, steps: u32) {
        let Some(id) = j.id else { return };
        let share = f64::from(part + 1) / f64::from(steps);
        let (low, high) = j.limits.unwrap_or((f64::NEG_INFINITY, f64::INFINITY));
        // Beyond its limits it would press against them for ever, and dither.
        let target = j.course.map_or(j.target_position, |c| c.target(share)).max(low).min(high);
        if let Some(drive) = drive_of(j, target) {
            self.engine.drive(id, drive);
            let rest = if j.control == Control::Spring { j.target_position } else { j.passive.rest };
            self.engine.set_rest(id, rest);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_lone_target_is_reached_after_two_steps_without_a_jump() {
        let mut course = Course::at(0.0);
        let mut way = vec![0.0];
        for target in [1.0, 1.0, 1.0] {
            course = course.next(target);
            way.extend((1..=10).map(|n| course.target(f64::from(n) / 10.0)));
        }
        assert_eq!((way[10], way[20], way[30]), (0.5, 1.0, 1.0));
        assert!(!course.under_way());
        // Its second difference is that of the targets, 1 for a step, shared among ten parts.
        let bend = way.windows(3).map(|w| (w[2] - 2.0 * w[1] + w[0]).abs()).fold(0.0, f64::max);
        assert!((bend - 0.01).abs() < 1e-12, "{bend}");
    }

    #[test]
    fn a_target_between_physics_steps_is_taken_as_it_comes() {
        let course = Course { direct: true, ..Course::at(1.0) }.next(3.0);
        assert_eq!((course.target(0.1), course.under_way()), (3.0, false));
    }

    #[test]
    fn a_joint_without_end_takes_the_shorter_way() {
        let j = Joint { target_position: -3.0, ..Joint::default() };
        assert!((near(&j, 3.0) - (std::f64::consts::TAU - 3.0)).abs() < 1e-12);
        let limited = Joint { limits: Some((-3.1, 3.1)), ..j };
        assert_eq!(near(&limited, 3.0), -3.0);
    }
}
