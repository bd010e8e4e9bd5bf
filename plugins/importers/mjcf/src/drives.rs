//! Converts actuators and couplings of joints to the drives and gears of the scene.

use std::collections::BTreeMap;

use crate::{
    groups::BodyGroups,
    model::{Actuator, Equality, JointKind, Model, Tendon, Transmission},
    report::ImportReport,
};

/// Force of motors without a stated limit, N or N m.
const UNLIMITED: f64 = 1e9;

/// Maximum number of joints that follow each other.
const MAX_CHAIN: usize = 100;

/// Indices of a body and one of its joints.
pub type JointIndex = (usize, usize);

/// A joint that follows another: position = factor * leader's position + offset.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Gear {
    pub leader: JointIndex,
    pub factor: f64,
    pub offset: f64,
}

/// How a joint is driven.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Drive {
    Free,
    Force(f64),
    /// Velocity, with the speed lost per force.
    Velocity {
        target: f64,
        slip: f64,
        max_force: f64,
    },
    /// A spring towards a target.
    Spring {
        target: f64,
        stiffness: f64,
    },
    /// A servo without sag.
    Position {
        target: f64,
        max_force: f64,
    },
}

/// What acts on a joint besides its own spring and friction.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct JointDrive {
    pub drive: Drive,
    pub damping: f64,
}

/// The gears and drives of all joints.
#[derive(Default)]
pub struct Couplings {
    pub gears: BTreeMap<JointIndex, Gear>,
    /// Joints that are held at a position.
    pub held: BTreeMap<JointIndex, f64>,
    pub drives: BTreeMap<JointIndex, JointDrive>,
}

/// The positions of all joints by name.
pub fn joints_by_name(model: &Model) -> BTreeMap<&str, JointIndex> {
    let each = |(b, body): (usize, &'_ crate::model::Body)| -> Vec<(usize, usize)> {
        (0..body.joints.len()).map(|j| (b, j)).collect()
    };
    let all = model.bodies.iter().enumerate().flat_map(each);
    all.map(|(b, j)| (model.bodies[b].joints[j].name.as_str(), (b, j))).collect()
}

impl Couplings {
    /// Determines gears and drives. `controls` are the initial values of all actuators; with `holding`, position servos
    /// hold their targets under load.
    pub fn new(model: &Model, groups: &BodyGroups, controls: &[f64], holding: bool, report: &mut ImportReport) -> Self {
        let mut couplings = Couplings::default();
        let names = joints_by_name(model);
        let driven: Vec<JointIndex> = model
            .actuators
            .iter()
            .filter_map(|a| match &a.on {
                Transmission::Joint(joint) => names.get(joint.as_str()).copied(),
                Transmission::Tendon(_) => None,
            })
            .collect();
        for equality in &model.equalities {
            couplings.couple(model, &names, equality, &driven, report);
        }
        couplings.drive(model, groups, &names, (controls, holding), report);
        couplings
    }

    fn couple(
        &mut self,
        model: &Model,
        names: &BTreeMap<&str, JointIndex>,
        equality: &Equality,
        driven: &[JointIndex],
        report: &mut ImportReport,
    ) {
        let (first, second, [p0, p1, rest @ ..], place) = match equality {
            Equality::Joints { first, second, polynomial, place } => (first, second, polynomial, place),
            Equality::Tendons { first, second, polynomial, place } => {
                // A constant sum of two joint positions.
                let tendon = model.tendons.iter().find(|t| t.name == *first).map(|t| t.joints.as_slice());
                let Some([(one, a), (other, b)]) = tendon.filter(|_| second.is_none()) else {
                    return report
                        .warn(place, "equality constraints of tendons are omitted, unless a tendon has two joints");
                };
                let (Some(one), Some(other)) = (names.get(one.as_str()), names.get(other.as_str())) else { return };
                let ratio = if *a == 0.0 { 0.0 } else { -b / a };
                let at = |(b, j): JointIndex| model.bodies[b].joints[j].reference;
                // The length is that of the pose of the file, plus the constant.
                let length = a * at(*one) + b * at(*other) + polynomial[0];
                let offset = if *a == 0.0 { 0.0 } else { length / a };
                return self.gear((*one, *other), ratio, offset, driven, report, place);
            }
            _ => return,
        };
        if rest.iter().any(|x| *x != 0.0) {
            report.warn(place, "couplings of joints are linear here: higher terms of `polycoef` are omitted");
        }
        let Some(one) = names.get(first.as_str()).copied() else {
            return report
                .warn(place, format!("an equality constraint refers to the joint `{first}`, which does not exist"));
        };
        let joint = |(b, j): JointIndex| &model.bodies[b].joints[j];
        let Some(second) = second else {
            self.held.insert(one, joint(one).reference + p0);
            return;
        };
        let Some(other) = names.get(second.as_str()).copied() else {
            return report
                .warn(place, format!("an equality constraint refers to the joint `{second}`, which does not exist"));
        };
        let offset = joint(one).reference + p0 - p1 * joint(other).reference;
        if [one, other].iter().any(|j| joint(*j).kind == JointKind::Ball) {
            return report.warn(place, "couplings of ball joints are omitted");
        }
        self.gear((one, other), *p1, offset, driven, report, place);
    }

    fn gear(
        &mut self,
        (mut one, mut other): (JointIndex, JointIndex),
        mut factor: f64,
        mut offset: f64,
        driven: &[JointIndex],
        report: &mut ImportReport,
        place: &crate::xml::Place,
    ) {
        // The leader is the joint with the actuator.
        if driven.contains(&one) && !driven.contains(&other) && factor != 0.0 && !self.gears.contains_key(&other) {
            (one, other) = (other, one);
            (factor, offset) = (1.0 / factor, -offset / factor);
        }
        let (mut above, mut length) = (Some(other), 0);
        while let Some(at) = above {
            length += 1;
            if at == one || length > MAX_CHAIN {
                return report.warn(place, "joints that follow each other in a circle are not coupled");
            }
            above = self.gears.get(&at).map(|g| g.leader);
        }
        if self.gears.insert(one, Gear { leader: other, factor, offset }).is_some() {
            report.warn(place, "a joint can follow only one other joint: the last coupling applies");
        }
    }

    /// Returns the joint that finally leads a joint, with factor and offset.
    fn leader(&self, mut joint: JointIndex) -> (JointIndex, f64, f64) {
        let (mut factor, mut offset) = (1.0, 0.0);
        while let Some(gear) = self.gears.get(&joint) {
            offset += factor * gear.offset;
            factor *= gear.factor;
            joint = gear.leader;
        }
        (joint, factor, offset)
    }

    /// Returns the joint on which an actuator acts, the length of the transmission per unit of its position, and the
    /// length at position 0.
    fn target(
        &self,
        model: &Model,
        (names, tendons): (&BTreeMap<&str, JointIndex>, &BTreeMap<&str, &Tendon>),
        actuator: &Actuator,
        report: &mut ImportReport,
    ) -> Option<(JointIndex, f64, f64)> {
        let missing = |what: &str, report: &mut ImportReport| {
            report.warn(&actuator.place, format!("an actuator refers to a {what} that does not exist or moves freely"));
            None
        };
        match &actuator.on {
            Transmission::Joint(name) if name.is_empty() => None,
            Transmission::Joint(name) => match names.get(name.as_str()) {
                Some(joint) if model.bodies[joint.0].joints[joint.1].kind == JointKind::Ball => {
                    report.warn(&actuator.place, "actuators of ball joints are omitted");
                    None
                }
                Some(joint) => Some((*joint, 1.0, 0.0)),
                None => missing("joint", report),
            },
            Transmission::Tendon(name) => {
                let Some(tendon) = tendons.get(name.as_str()) else {
                    report.warn(&actuator.place, "actuators of spatial tendons are omitted");
                    return None;
                };
                let mut found: Option<(JointIndex, f64, f64)> = None;
                for (joint, coefficient) in &tendon.joints {
                    let Some(joint) = names.get(joint.as_str()) else { return missing("joint", report) };
                    let (leader, factor, offset) = self.leader(*joint);
                    let (per, at) = (coefficient * factor, coefficient * offset);
                    found = match found {
                        None => Some((leader, per, at)),
                        Some((known, sum, base)) if known == leader => Some((leader, sum + per, base + at)),
                        Some(_) => {
                            report.warn(
                                &actuator.place,
                                "actuators of tendons are omitted, unless the tendon's joints are coupled to each other",
                            );
                            return None;
                        }
                    };
                }
                found
            }
        }
    }

    fn drive(
        &mut self,
        model: &Model,
        groups: &BodyGroups,
        names: &BTreeMap<&str, JointIndex>,
        (controls, holding): (&[f64], bool),
        report: &mut ImportReport,
    ) {
        let tendons: BTreeMap<&str, &Tendon> = model.tendons.iter().map(|t| (t.name.as_str(), t)).collect();
        let mut sums: BTreeMap<JointIndex, LinearLaw> = BTreeMap::new();
        for (i, actuator) in model.actuators.iter().enumerate() {
            let Some((joint, per, at)) = self.target(model, (names, &tendons), actuator, report) else { continue };
            let gear = actuator.gear * per;
            let [b0, b1, mut b2] = actuator.bias;
            if let Some(ratio) = actuator.damping_ratio.filter(|_| gear != 0.0) {
                let inertia = groups.inertia_at(joint.0, &model.bodies[joint.0].joints[joint.1]) / (gear * gear);
                b2 = -2.0 * ratio * (actuator.gain.max(0.0) * inertia).sqrt();
            }
            let mut control = controls.get(i).copied().unwrap_or(0.0);
            if let Some([low, high]) = actuator.control_range {
                control = control.clamp(low, high);
            }
            let law = sums.entry(joint).or_default();
            law.count += 1;
            law.has_control |= actuator.gain != 0.0;
            law.force += gear * (actuator.gain * control + b0 + b1 * actuator.gear * at);
            law.stiffness += -b1 * gear * gear;
            law.damping += -b2 * gear * gear;
            let bound = actuator.force_range.map(|[low, high]| gear.abs() * low.abs().max(high.abs()));
            law.bound = law.bound.max(bound.unwrap_or(UNLIMITED));
            if law.count == 2 {
                report.note(&actuator.place, "several actuators act on one joint: their laws are added");
            }
            let own = &model.bodies[joint.0].joints[joint.1];
            if (bound.is_some() || own.max_force.is_some()) && b1 != 0.0 && !holding {
                report.note(
                    &actuator.place,
                    "`forcerange` and `actuatorfrcrange` of position servos are omitted, because springs have no bound: see the parameter \
                     `servos`",
                );
            }
        }
        for (joint, law) in sums {
            let own = &model.bodies[joint.0].joints[joint.1];
            let bound = own.max_force.map_or(law.bound, |most| law.bound.min(most));
            self.drives.insert(joint, LinearLaw { bound, ..law }.drive(own, holding));
        }
    }
}

/// The sum of the forces on a joint: force - stiffness * position - damping * velocity.
#[derive(Default)]
struct LinearLaw {
    force: f64,
    stiffness: f64,
    damping: f64,
    bound: f64,
    has_control: bool,
    count: usize,
}

impl LinearLaw {
    fn drive(&self, joint: &crate::model::Joint, holding: bool) -> JointDrive {
        let damping = self.damping.max(0.0);
        if self.stiffness > 0.0 && holding {
            let target = self.force / self.stiffness;
            return JointDrive { drive: Drive::Position { target, max_force: self.bound }, damping: 0.0 };
        }
        if self.stiffness > 0.0 {
            // One spring has the effect of the joint's own and that of the servo.
            let stiffness = self.stiffness + joint.stiffness;
            let target = (self.force + joint.stiffness * joint.rest) / stiffness;
            return JointDrive { drive: Drive::Spring { target, stiffness }, damping };
        }
        if damping > 0.0 && self.has_control {
            let drive = Drive::Velocity { target: self.force / damping, slip: 1.0 / damping, max_force: self.bound };
            return JointDrive { drive, damping: 0.0 };
        }
        let drive = if self.has_control || self.force != 0.0 {
            Drive::Force(self.force.clamp(-self.bound, self.bound))
        } else {
            Drive::Free
        };
        JointDrive { drive, damping }
    }
}
