//! Joint trajectories that clients publish: each joint follows its waypoints by a target position for each step.

use std::collections::BTreeMap;

use serde_json::Value as Json;
use tatu_plugin_api::{
    abi::*,
    safe::{Fail, Result, Turn, Value},
};
use tatu_trajectories::{Interpolation, State, Waypoints};

use crate::robots::{Robot, ros_name};

/// Most points of a trajectory.
const MAX_POINTS: usize = 100_000;

/// Longest time from the present to the start of a trajectory, s. A stamp of a clock on the wall is later.
const MAX_DELAY_S: f64 = 1e6;

/// The motion of a joint.
struct JointMotion {
    /// The property that moves the joint.
    property: &'static str,
    /// Simulation time to which the times of the waypoints are relative, s.
    start: f64,
    waypoints: Waypoints,
}

/// The joints that follow a trajectory, by object id.
#[derive(Default)]
pub(crate) struct JointMotions(BTreeMap<tatu_object, JointMotion>);

impl JointMotions {
    /// Starts the trajectory of a message `trajectory_msgs/JointTrajectory` at simulation time `now`, s. It replaces
    /// those of its joints; without points these stop.
    pub(crate) fn follow(&mut self, turn: &Turn<'_>, robot: &Robot, now: f64, msg: &Json) -> Result {
        let names: Vec<&str> = list(msg, "joint_names").iter().map(|n| n.as_str().unwrap_or_default()).collect();
        let joints = names.iter().map(|name| joint(robot, name)).collect::<Result<Vec<_>>>()?;
        if let Some(i) = (1..names.len()).find(|i| joints[..*i].contains(&joints[*i])) {
            return Err(Fail::argument(format!("the joint `{}` is named twice", names[i])));
        }
        let points = list(msg, "points");
        if points.is_empty() {
            joints.iter().for_each(|id| drop(self.0.remove(id)));
            return Ok(());
        }
        if points.len() > MAX_POINTS {
            return Err(Fail::argument(format!(
                "the trajectory has {} points; the maximum is {MAX_POINTS}",
                points.len()
            )));
        }
        let interpolation = interpolation(points, names.len())?;
        let stamp = msg.get("header").and_then(|h| h.get("stamp")).map_or(0.0, seconds);
        let start = if stamp > 0.0 { stamp } else { now };
        if start > now + MAX_DELAY_S {
            return Err(Fail::argument(format!(
                "`header.stamp` is {:.0} s after the simulation time {now:.3} s; expected a simulation time, or 0 for now",
                start - now
            )));
        }
        let times: Vec<f64> = points.iter().map(|p| p.get("time_from_start").map_or(0.0, seconds)).collect();
        let mut motions = Vec::new();
        for (k, (id, name)) in joints.iter().zip(&names).enumerate() {
            let number = |point: &Json, key: &str| list(point, key).get(k).and_then(Json::as_f64).unwrap_or(0.0);
            let state = |point: &Json| State {
                position: number(point, "positions"),
                velocity: number(point, "velocities"),
                acceleration: number(point, "accelerations"),
            };
            let mut times = times.clone();
            let mut states: Vec<State> = points.iter().map(state).collect();
            if times.first().is_some_and(|t| start + t > now) {
                let at = |key: &str| turn.f64(*id, turn.host().prop(key));
                times.insert(0, now - start);
                states.insert(0, State::moving(at("joint.position")?, at("joint.velocity")?));
            }
            let waypoints = Waypoints::new(times, states, interpolation).ok_or_else(|| {
                Fail::argument("the trajectory is invalid: expected finite numbers, and `time_from_start` that ascends")
            })?;
            motions.push((*id, JointMotion { property: property(turn, *id, name)?, start, waypoints }));
        }
        self.0.extend(motions);
        Ok(())
    }

    /// Sets the targets of all moving joints for the step that begins at simulation time `now` and takes `dt`, s, by
    /// calling a command, so that the input log records them.
    pub(crate) fn advance(&mut self, turn: &Turn<'_>, now: f64, dt: f64) {
        self.0.retain(|id, motion| {
            let t = now + dt - motion.start;
            let target = motion.waypoints.at(t).position;
            let handle = Value::Int(i64::from(tatu_slot(*id)));
            // A joint that no longer exists needs no target.
            let set = turn.call("tatu.set", &[handle, Value::text(motion.property), Value::Float(target)], 0);
            set.is_ok() && t < motion.waypoints.end()
        });
    }

    /// Ends all motions.
    pub(crate) fn clear(&mut self) {
        self.0.clear();
    }
}

fn list<'a>(of: &'a Json, key: &str) -> &'a [Json] {
    of.get(key).and_then(Json::as_array).map_or(&[], Vec::as_slice)
}

/// Converts a time or duration of ROS 1 or ROS 2 to s.
fn seconds(time: &Json) -> f64 {
    let of = |keys: [&str; 2]| keys.iter().find_map(|key| time.get(key).and_then(Json::as_f64)).unwrap_or(0.0);
    of(["secs", "sec"]) + of(["nsecs", "nanosec"]) * 1e-9
}

fn joint(robot: &Robot, name: &str) -> Result<tatu_object> {
    let found = robot.joints.iter().find(|(_, own)| own == name || *own == ros_name(name));
    found.map(|(id, _)| *id).ok_or_else(|| {
        let known: Vec<&str> = robot.joints.iter().map(|(_, own)| own.as_str()).collect();
        Fail::missing(format!("{} has no joint `{name}`: expected one of {}", robot.name, known.join(", ")))
    })
}

/// Checks the numbers of each point, and returns what its velocities and accelerations permit.
fn interpolation(points: &[Json], joints: usize) -> Result<Interpolation> {
    let mut interpolation = Interpolation::Quintic;
    for (i, point) in points.iter().enumerate() {
        let count = |key: &str| -> Result<usize> {
            let numbers = list(point, key);
            if let Some(k) = numbers.iter().position(|x| x.as_f64().is_none()) {
                return Err(Fail::argument(format!("point {i} of the trajectory: {key}[{k}] is not a number")));
            }
            if !numbers.is_empty() && numbers.len() != joints || key == "positions" && numbers.len() != joints {
                return Err(Fail::argument(format!(
                    "point {i} of the trajectory has {} {key} for {joints} joints",
                    numbers.len()
                )));
            }
            Ok(numbers.len())
        };
        count("positions")?;
        interpolation = match (count("velocities")? > 0, count("accelerations")? > 0) {
            (true, true) => interpolation,
            (true, false) if interpolation != Interpolation::Linear => Interpolation::Cubic,
            _ => Interpolation::Linear,
        };
    }
    Ok(interpolation)
}

/// Returns the property that moves a joint, or an error if its motor does not control the position.
fn property(turn: &Turn<'_>, id: tatu_object, name: &str) -> Result<&'static str> {
    let text = |key: &str| -> Result<String> {
        Ok(turn.get(id, turn.host().prop(key))?.as_str().map(|s| s.into_owned()).unwrap_or_default())
    };
    if text("joint.mode")? != "dynamic" {
        return Ok("joint.position");
    }
    match text("joint.control")?.as_str() {
        "position" | "spring" => Ok("joint.target_position"),
        other => Err(Fail::unsupported(format!(
            "the joint `{name}` has the control mode `{other}`, but a trajectory needs `position`"
        ))
        .help("set `control = \"position\"` and `max_force` of the joint in the scene")),
    }
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    #[test]
    fn derivatives_of_the_points_select_the_interpolation() {
        let of = |points: Json| interpolation(points.as_array().unwrap(), 1);
        let point = json!({ "positions": [1.0], "velocities": [0.5], "accelerations": [0.1] });
        let slower = json!({ "positions": [1.0], "velocities": [0.5] });
        let plain = json!({ "positions": [1.0] });
        assert_eq!(of(json!([point])).unwrap(), Interpolation::Quintic);
        assert_eq!(of(json!([point, slower])).unwrap(), Interpolation::Cubic);
        assert_eq!(of(json!([slower, plain, slower])).unwrap(), Interpolation::Linear);
        let wrong = of(json!([{ "positions": [null] }])).unwrap_err();
        assert!(wrong.text().contains("positions[0] is not a number"), "{}", wrong.text());
        let short = of(json!([point, { "positions": [] }])).unwrap_err();
        assert!(short.text().contains("point 1 of the trajectory has 0 positions for 1 joints"), "{}", short.text());
    }

    #[test]
    fn times_of_both_versions_are_read() {
        assert_eq!(seconds(&json!({ "secs": 1, "nsecs": 500_000_000 })), 1.5);
        assert_eq!(seconds(&json!({ "sec": 2, "nanosec": 250_000_000 })), 2.25);
    }
}
