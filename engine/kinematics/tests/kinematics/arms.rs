//! Arms whose positions are known, and helpers.

use std::f64::consts::{FRAC_PI_2, PI};

use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};
use tatu_kinematics::*;

/// A joint of an arm: its frame in that of the joint before it.
pub struct Arm {
    pub linkage: Linkage,
    pub joints: Vec<FrameId>,
    pub tip: FrameId,
    pub target: FrameId,
}

impl Arm {
    pub fn new(frames: &[Isometry3<f64>], flange: Isometry3<f64>) -> Self {
        let mut linkage = Linkage::default();
        let mut joints = Vec::new();
        for frame in frames {
            joints.push(linkage.add_joint(joints.last().copied(), *frame, JointType::Revolute));
        }
        let tip = linkage.add_frame(joints.last().copied(), flange);
        let target = linkage.add_frame(None, Isometry3::identity());
        Arm { linkage, joints, tip, target }
    }
    /// Links of these lengths that turn about z.
    pub fn planar(lengths: &[f64]) -> Self {
        let place = |x: f64| Isometry3::translation(x, 0.0, 0.0);
        let frames: Vec<_> = [0.0].iter().chain(&lengths[..lengths.len() - 1]).map(|x| place(*x)).collect();
        Arm::new(&frames, place(lengths[lengths.len() - 1]))
    }
    pub fn ur5() -> Self {
        let frame = |x: f64, y: f64, z: f64, alpha: f64| {
            Isometry3::from_parts(Translation3::new(x, y, z), UnitQuaternion::from_euler_angles(alpha, 0.0, 0.0))
        };
        // In the standard convention, joint i + 1 is at Rz(q) Tz(d) Tx(a) Rx(alpha) of joint i.
        let table = [
            (0.089159, 0.0, FRAC_PI_2),
            (0.0, -0.425, 0.0),
            (0.0, -0.39225, 0.0),
            (0.10915, 0.0, FRAC_PI_2),
            (0.09465, 0.0, -FRAC_PI_2),
            (0.0823, 0.0, 0.0),
        ];
        let steps: Vec<_> = table.iter().map(|(d, a, alpha)| frame(*a, 0.0, *d, *alpha)).collect();
        let frames: Vec<_> = [Isometry3::identity()].iter().chain(&steps[..5]).copied().collect();
        let mut arm = Arm::new(&frames, steps[5]);
        for (i, joint) in arm.joints.iter().enumerate() {
            let bound = if i == 2 { PI } else { 2.0 * PI };
            arm.linkage.joint_mut(*joint).unwrap().limits = Some([-bound, bound]);
        }
        arm
    }
    pub fn panda() -> Self {
        let frame = |a: f64, d: f64, alpha: f64| {
            // In the modified convention, joint i + 1 is at Rx(alpha) Tx(a) Tz(d) of joint i.
            let turn = UnitQuaternion::from_euler_angles(alpha, 0.0, 0.0);
            Isometry3::from_parts(
                Translation3::from(Vector3::new(a, 0.0, 0.0) + turn * Vector3::new(0.0, 0.0, d)),
                turn,
            )
        };
        let table = [
            (0.0, 0.333, 0.0),
            (0.0, 0.0, -FRAC_PI_2),
            (0.0, 0.316, FRAC_PI_2),
            (0.0825, 0.0, FRAC_PI_2),
            (-0.0825, 0.384, -FRAC_PI_2),
            (0.0, 0.0, FRAC_PI_2),
            (0.088, 0.0, FRAC_PI_2),
        ];
        let frames: Vec<_> = table.iter().map(|(a, d, alpha)| frame(*a, *d, *alpha)).collect();
        let mut arm = Arm::new(&frames, Isometry3::translation(0.0, 0.0, 0.107));
        let limits = [
            [-2.8973, 2.8973],
            [-1.7628, 1.7628],
            [-2.8973, 2.8973],
            [-3.0718, -0.0698],
            [-2.8973, 2.8973],
            [-0.0175, 3.7525],
            [-2.8973, 2.8973],
        ];
        for (joint, limits) in arm.joints.iter().zip(limits) {
            arm.linkage.joint_mut(*joint).unwrap().limits = Some(limits);
        }
        arm
    }
    /// The LBR iiwa 14 with seven joints, by its Denavit-Hartenberg table and the limits of its data sheet.
    pub fn iiwa() -> Self {
        let frame = |d: f64, alpha: f64| {
            let turn = UnitQuaternion::from_euler_angles(alpha, 0.0, 0.0);
            Isometry3::from_parts(Translation3::from(turn * Vector3::new(0.0, 0.0, d)), turn)
        };
        let table = [
            (0.36, 0.0),
            (0.0, -FRAC_PI_2),
            (0.42, FRAC_PI_2),
            (0.0, FRAC_PI_2),
            (0.4, -FRAC_PI_2),
            (0.0, -FRAC_PI_2),
            (0.0, FRAC_PI_2),
        ];
        let frames: Vec<_> = table.iter().map(|(d, alpha)| frame(*d, *alpha)).collect();
        let mut arm = Arm::new(&frames, Isometry3::translation(0.0, 0.0, 0.126));
        for (joint, degrees) in arm.joints.iter().zip([170.0_f64, 120.0, 170.0, 120.0, 170.0, 120.0, 175.0]) {
            let bound = degrees.to_radians();
            arm.linkage.joint_mut(*joint).unwrap().limits = Some([-bound, bound]);
        }
        arm
    }
    pub fn set(&mut self, q: &[f64]) {
        for (joint, q) in self.joints.iter().zip(q) {
            self.linkage.set_position(*joint, *q);
        }
    }
    pub fn q(&self) -> Vec<f64> {
        self.joints.iter().map(|j| self.linkage.position(*j)).collect()
    }
    pub fn task(&self, constraints: Constraints) -> IkTask {
        IkTask { constraints, ..IkTask::new(self.tip, self.target) }
    }
    pub fn group(&self, method: IkMethod, damping: f64, max_iterations: u32) -> IkGroup {
        let tasks = vec![self.task(Constraints::X | Constraints::Y)];
        IkGroup { tasks, method, damping, max_iterations, ..IkGroup::default() }
    }
    pub fn aim(&mut self, x: f64, y: f64) {
        self.linkage.set_pose(self.target, &Isometry3::translation(x, y, 0.0));
    }
    /// The distances of the tip from the target after each of the first iterations.
    pub fn distances(&mut self, method: IkMethod, damping: f64, n: usize) -> Vec<f64> {
        let group = self.group(method, damping, 1);
        let mut all = vec![group.tasks[0].error(&self.linkage).distance()];
        for _ in 0..n {
            all.push(solve(&mut self.linkage, &[&group]).precision[0]);
        }
        all
    }
}

pub fn near(found: &[f64], expected: &[f64], within: f64) {
    let all = found.len() == expected.len() && found.iter().zip(expected).all(|(a, b)| (a - b).abs() <= within);
    assert!(all, "found {found:?}, expected {expected:?}");
}

pub fn unit(state: &mut u64) -> f64 {
    *state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
    (*state >> 11) as f64 / (1u64 << 53) as f64
}
