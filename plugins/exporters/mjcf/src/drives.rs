//! Actuators, and equations between joints.

use tatu_exporters_common::{
    Control, ExportReport, JointKind, JointProperties, Mechanisms, Tie, XmlWriter, number, numbers,
};

use crate::naming::Names;

/// Error of the position, rad or m, or of the velocity, rad/s or m/s, at which a servo exerts its full force.
const FULL_FORCE_ERROR: f64 = 0.02;
/// Time constant of position control without gains, s, as in a scene.
const SETTLING_S: f64 = 0.05;
/// Greatest gain of servos. Without it, motors without a bound would be stiffer than a step resolves.
const MAX_GAIN: f64 = 1e5;
/// Force from which on a motor has no bound.
const UNBOUND: f64 = 1e9;

/// An actuator.
pub struct Actuator {
    element: &'static str,
    attributes: Vec<(&'static str, String)>,
    /// Control in the pose of the scene.
    pub control: f64,
    /// Whether its force depends on the velocity, which MuJoCo should integrate implicitly.
    pub is_damped: bool,
}

/// The actuators of all joints in the order of bodies, and equations.
#[derive(Default)]
pub struct Drives {
    /// The actuators.
    pub actuators: Vec<Actuator>,
    equations: Vec<Vec<(&'static str, String)>>,
}

impl Drives {
    /// Determines actuators and equations. `order` lists bodies as they are written.
    pub fn new(
        all: &Mechanisms,
        order: &[usize],
        names: &Names,
        gains: &dyn Fn(usize) -> Option<f64>,
        report: &mut ExportReport,
    ) -> Self {
        let mut drives = Drives::default();
        for body in order {
            let Tie::Joint { item, joint, .. } = &all.bodies[*body].tie else { continue };
            let Some(name) = names.joints.get(item) else { continue };
            drives.equation(all, names, (name, joint), &all.items[*item].path, report);
            let follows = joint.follow.is_some_and(|f| f.is_geared);
            if follows && joint.has_motor() {
                report.lost("motors of geared joints that follow another one are left out", &all.items[*item].path);
            }
            let actuator = if follows { None } else { actuator(joint, gains(*item), &all.items[*item].path, report) };
            if let Some(mut actuator) = actuator {
                actuator.attributes.splice(0..0, [("name", name.clone()), ("joint", name.clone())]);
                drives.actuators.push(actuator);
            }
        }
        drives
    }

    fn equation(
        &mut self,
        all: &Mechanisms,
        names: &Names,
        (name, joint): (&str, &JointProperties),
        path: &str,
        report: &mut ExportReport,
    ) {
        if let Some([low, high]) = joint.limits.filter(|[low, high]| low == high && joint.follow.is_none()) {
            // MuJoCo refuses limits without a range.
            let held = (low + high) / 2.0;
            self.equations.push(vec![("joint1", name.to_owned()), ("polycoef", numbers([held, 0.0, 0.0, 0.0, 0.0]))]);
        }
        let Some(follow) = joint.follow else { return };
        let leader = all.item_of(follow.leader).and_then(|item| names.joints.get(&item));
        match leader {
            _ if joint.kind == JointKind::Spherical => {}
            None => report.lost("joints that follow a joint outside the export move by themselves", path),
            Some(leader) => {
                if !follow.is_geared {
                    report.lost("joints whose motor follows another joint are coupled to it", path);
                }
                let law = numbers([follow.offset, follow.factor, 0.0, 0.0, 0.0]);
                let equation = vec![("joint1", name.to_owned()), ("joint2", leader.clone()), ("polycoef", law)];
                self.equations.push(equation);
            }
        }
    }

    /// Writes equations between joints.
    pub fn write_equations(&self, xml: &mut XmlWriter) {
        self.equations.iter().for_each(|equation| xml.empty("joint", equation));
    }

    /// Returns whether there are equations.
    pub fn has_equations(&self) -> bool {
        !self.equations.is_empty()
    }

    /// Writes the actuators.
    pub fn write_actuators(&self, xml: &mut XmlWriter) {
        if self.actuators.is_empty() {
            return;
        }
        xml.begin("actuator", &[]);
        self.actuators.iter().for_each(|a| xml.empty(a.element, &a.attributes));
        xml.end();
    }
}

/// Returns the actuator of a joint. `gain` is its gain P, if it has gains, 1/s.
fn actuator(joint: &JointProperties, gain: Option<f64>, path: &str, report: &mut ExportReport) -> Option<Actuator> {
    let force = joint.max_force.abs();
    let mut attributes = Vec::new();
    let is_bound = force < UNBOUND;
    let (element, control, is_damped) = match joint.control {
        _ if !joint.is_dynamic => return None,
        _ if joint.kind == JointKind::Spherical => return None,
        Control::Spring => {
            attributes.push(("kp", number(joint.stiffness)));
            ("position", joint.targets[0], false)
        }
        Control::Force => ("motor", joint.max_force, false),
        Control::Free if force > 0.0 => {
            report.note("motors that are off can be driven by a force: their control is 0", path);
            ("motor", 0.0, false)
        }
        Control::Callback if force > 0.0 => ("motor", 0.0, false),
        Control::Velocity if force > 0.0 => {
            let kv = if joint.slip > 0.0 {
                1.0 / joint.slip
            } else {
                report.lost("velocity control becomes a servo that yields a little under load (`velocity`)", path);
                (force / FULL_FORCE_ERROR).min(MAX_GAIN)
            };
            attributes.push(("kv", number(kv)));
            ("velocity", joint.targets[1], true)
        }
        Control::Position if force > 0.0 => {
            report.lost("position control becomes a servo that yields a little under load (`position`)", path);
            let kp = (force / FULL_FORCE_ERROR).min(MAX_GAIN);
            let kv = gain.filter(|p| *p > 0.0).map_or(kp * SETTLING_S, |p| kp / p);
            attributes.extend([("kp", number(kp)), ("kv", number(kv))]);
            ("position", joint.targets[0], true)
        }
        _ => return None,
    };
    if is_bound && !matches!(joint.control, Control::Spring | Control::Force) {
        attributes.push(("forcerange", numbers([-force, force])));
    }
    Some(Actuator { element, attributes, control, is_damped })
}
