//! The energy of random mechanisms: it never grows by more than drives and the removal of overlaps add.

use nalgebra::{Isometry3, Matrix3, Point3, Translation3, UnitQuaternion, Vector3};
use tatu_geometry::Form;

use super::*;
use crate::{JointDesc, JointDrive, JointForm, JointId, JointKind, PassiveForces};

/// Number of random mechanisms in the usual test and in the long one.
const SHORT_RUN_MECHANISMS: u64 = 12;
const LONG_RUN_MECHANISMS: u64 = 500;
/// Excess of the energy, relative to the energy turned over, that discretisation may cause.
const MAX_ENERGY_EXCESS: f64 = 0.01;

/// An xorshift64* generator of pseudorandom numbers.
struct TestRng(u64);

impl TestRng {
    fn new(seed: u64) -> Self {
        TestRng((seed + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1)
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
struct RandomMechanism {
    engine: Rapier,
    bodies: Vec<(BodyId, f64, Matrix3<f64>)>,
    joints: Vec<(JointId, bool)>,
}

/// Builds a mechanism of up to 12 boxes with masses of 0.013 to 26 kg, joints of all kinds with and without drives, on
/// a fixed base or free.
fn machine(random: &mut TestRng) -> RandomMechanism {
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
        let desc =
            BodyDesc { collision_mask: CollisionMask { mask, tree: 1 }, friction: random.within(0.0, 1.0), ..desc };
        let motion = if i == 0 && fixed_base { MotionType::Static } else { MotionType::Dynamic };
        let id = engine.add_body(&BodyDesc { motion, ..desc });
        poses.push((id, pose));
        if motion == MotionType::Dynamic {
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
                passive: PassiveForces::default(),
                geared: false,
            });
            joints.push((joint.unwrap(), kind != JointKind::Spherical && random.below(3) > 0));
        }
    }
    RandomMechanism { engine, bodies, joints }
}

impl RandomMechanism {
    fn energy(&self) -> f64 {
        let of = |(id, m, inertia): &(BodyId, f64, Matrix3<f64>)| {
            let (pose, twist) = (self.engine.pose(*id), self.engine.twist(*id));
            let spin = pose.rotation.inverse() * twist.angular;
            0.5 * m * twist.linear.norm_squared() + 0.5 * spin.dot(&(inertia * spin)) + m * G * pose.translation.z
        };
        self.bodies.iter().map(of).sum()
    }

    /// Runs for some seconds with drives whose targets jump; returns the greatest excess of the energy over its
    /// greatest value so far plus the work of the drives, relative to the energy that has been turned over.
    fn run(&mut self, random: &mut TestRng, seconds: f64) -> f64 {
        let mass: f64 = self.bodies.iter().map(|b| b.1).sum();
        let (mut allowed, mut worst) = (self.energy(), 0.0f64);
        let mut turned_over = mass * G;
        for step in 0..(seconds / 0.005) as usize {
            if step % 100 == 0 {
                for i in 0..self.joints.len() {
                    let (joint, driven) = self.joints[i];
                    if driven {
                        let (target, max_force) = (random.within(-1.5, 1.5), 2000.0);
                        let drive = match random.below(3) {
                            0 => JointDrive::Velocity { target: 3.0 * target, max_force, slip: 0.0 },
                            _ => JointDrive::Position { target, max_force, max_velocity: 10.0, tracking: None },
                        };
                        self.engine.drive(joint, drive);
                    }
                }
            }
            self.engine.advance(1);
            let built = self.engine.state.forms.trees.mechanisms.iter().filter_map(|m| m.built.as_ref());
            let work: f64 = built.map(|b| b.work).sum();
            turned_over += work.abs();
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

/// Checks the mechanisms of the seeds in a range for 10 s each; at most a number of them may exceed the bound.
fn check(seeds: std::ops::Range<u64>, most: usize) {
    let mut failed = Vec::new();
    for seed in seeds.clone() {
        let mut random = TestRng::new(seed);
        let mut machine = machine(&mut random);
        let excess = machine.run(&mut random, 10.0);
        if excess > MAX_ENERGY_EXCESS || excess.is_nan() {
            println!("tree {seed}: {} links, excess {excess:.2e}", machine.bodies.len());
            failed.push(seed);
        }
    }
    assert!(failed.len() <= most, "{} of {seeds:?}: {failed:?}", failed.len());
}

#[test]
fn random_trees_gain_no_energy() {
    check(0..SHORT_RUN_MECHANISMS, 0);
}

/// Tree 284 still gains energy: see the limits in `docs/mechanisms.md`.
#[test]
#[ignore = "takes about ten minutes: .ci/run --long"]
fn one_of_500_random_trees_gains_energy() {
    check(SHORT_RUN_MECHANISMS..LONG_RUN_MECHANISMS, 1);
}

impl RandomMechanism {
    fn new() -> Self {
        let mut engine = engine(0.005);
        floor(&mut engine);
        RandomMechanism { engine, bodies: Vec::new(), joints: Vec::new() }
    }

    fn add(&mut self, at: [f64; 3], half: [f64; 3], m: f64, motion: MotionType) -> (BodyId, Isometry3<f64>) {
        let pose = Isometry3::translation(at[0], at[1], at[2]);
        let half = Vector3::from(half);
        let inertia = half.map(|x| x * x);
        let inertia = Vector3::new(inertia.y + inertia.z, inertia.x + inertia.z, inertia.x + inertia.y) * (m / 3.0);
        let mass = MassProps { mass: m, com: Point3::origin(), inertia: Matrix3::from_diagonal(&inertia) };
        let desc = body(pose, mass, part(Form::Box { half }));
        // Links of one mechanism do not collide with each other.
        let respond = CollisionMask { mask: 0xff00, tree: 1 };
        let id = self.engine.add_body(&BodyDesc { motion, collision_mask: respond, ..desc });
        if motion == MotionType::Dynamic {
            self.bodies.push((id, m, mass.inertia));
        }
        (id, pose)
    }

    /// Adds a revolute joint at a point, about an axis: 0 for x, 1 for y, 2 for z.
    fn join(
        &mut self,
        (a, pose_a): (BodyId, Isometry3<f64>),
        (b, pose_b): (BodyId, Isometry3<f64>),
        at: [f64; 3],
        axis: usize,
        driven: bool,
    ) {
        let half_turn = std::f64::consts::FRAC_PI_2;
        let turn = match axis {
            0 => UnitQuaternion::from_euler_angles(0.0, half_turn, 0.0),
            1 => UnitQuaternion::from_euler_angles(-half_turn, 0.0, 0.0),
            _ => UnitQuaternion::identity(),
        };
        let frame = Isometry3::from_parts(Translation3::new(at[0], at[1], at[2]), turn);
        let joint = self.engine.add_joint(&JointDesc {
            a,
            b,
            frame_in_a: pose_a.inverse() * frame,
            frame_in_b: pose_b.inverse() * frame,
            kind: JointKind::Revolute,
            limits: Some((-2.8, 2.8)),
            position: 0.0,
            form: JointForm::Tree,
            passive: PassiveForces::default(),
            geared: false,
        });
        self.joints.push((joint.unwrap(), driven));
    }
}

/// An industrial arm whose wrist weighs less than a thousandth of its base, under position control of up to 2000 N m,
/// with a pad that hits the floor.
#[test]
fn arm_with_a_wrist_of_grams_gains_no_energy() {
    let mut arm = RandomMechanism::new();
    let base = arm.add([0.0, 0.0, 0.35], [0.1, 0.1, 0.1], 30.0, MotionType::Static);
    let mut parent = base;
    // Mass, length and axis of each link, as of an ABB IRB 140 with its smallest parts: estimates from its size.
    let links = [(26.0, 0.1, 2), (19.0, 0.36, 1), (13.0, 0.1, 1), (5.0, 0.28, 0), (0.9, 0.065, 1), (0.018, 0.02, 0)];
    let mut x = 0.0;
    for (m, length, axis) in links {
        let link = arm.add([x + 0.5 * length, 0.0, 0.5], [0.5 * length, 0.04, 0.04], m, MotionType::Dynamic);
        arm.join(parent, link, [x, 0.0, 0.5], axis, true);
        (parent, x) = (link, x + length);
    }
    let pad = arm.add([x + 0.01, 0.0, 0.5], [0.01, 0.03, 0.03], 0.05, MotionType::Dynamic);
    arm.join(parent, pad, [x, 0.0, 0.5], 1, false);
    let excess = arm.run(&mut TestRng::new(7), 10.0);
    assert!(excess < MAX_ENERGY_EXCESS, "{excess:e}");
}

/// A humanoid's upper body with 49 joints without friction or drives, whose fingers weigh 1.6 g, that collapses onto
/// the floor.
#[test]
fn fingers_of_grams_on_free_joints_gain_no_energy() {
    let mut body = RandomMechanism::new();
    let torso = body.add([0.0, 0.0, 0.6], [0.1, 0.15, 0.3], 20.0, MotionType::Dynamic);
    let head = body.add([0.0, 0.0, 1.0], [0.08, 0.08, 0.1], 3.0, MotionType::Dynamic);
    body.join(torso, head, [0.0, 0.0, 0.9], 1, false);
    for side in [-1.0, 1.0] {
        let mut parent = torso;
        let mut y = 0.2 * side;
        for (m, length, axis) in [(2.0, 0.25, 0), (1.2, 0.22, 1), (0.4, 0.05, 2), (0.3, 0.08, 0)] {
            let link =
                body.add([0.0, y + 0.5 * side * length, 0.85], [0.03, 0.5 * length, 0.02], m, MotionType::Dynamic);
            body.join(parent, link, [0.0, y, 0.85], axis, false);
            (parent, y) = (link, y + side * length);
        }
        let palm = parent;
        for finger in 0..5 {
            let (x, mut y, mut parent) = (0.02 * f64::from(finger) - 0.04, y, palm);
            for _ in 0..4 {
                let link = body.add([x, y + 0.01 * side, 0.85], [0.006, 0.01, 0.006], 0.0016, MotionType::Dynamic);
                body.join(parent, link, [x, y, 0.85], 0, false);
                (parent, y) = (link, y + 0.02 * side);
            }
        }
    }
    assert_eq!(body.joints.len(), 49);
    let excess = body.run(&mut TestRng::new(1), 10.0);
    assert!(excess < MAX_ENERGY_EXCESS, "{excess:e}");
}
