//! Pseudorandom trees and states, which are the same in every run.

use nalgebra::{Isometry3, Matrix3, Quaternion, Translation3, UnitQuaternion, Vector3};
use tatu_mechanisms::{Joint, Link, Tree, TreeState};

/// An xorshift64* generator of pseudorandom numbers.
pub struct TestRng(u64);

impl TestRng {
    pub fn new(seed: u64) -> Self {
        TestRng(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1)
    }
    fn next(&mut self) -> u64 {
        self.0 ^= self.0 >> 12;
        self.0 ^= self.0 << 25;
        self.0 ^= self.0 >> 27;
        self.0.wrapping_mul(0x2545_f491_4f6c_dd1d)
    }
    /// Returns a number that is uniformly distributed in a range.
    pub fn within(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * ((self.next() >> 11) as f64 / (1u64 << 53) as f64)
    }
    /// Returns an index below `count`.
    pub fn below(&mut self, count: usize) -> usize {
        (self.next() % count as u64) as usize
    }
    /// Returns a number of any magnitude and sign, sometimes 0, infinite or NaN.
    pub fn any(&mut self) -> f64 {
        let size = f64::from_bits((self.next() >> 1) & !(0x7ff << 52) | ((self.next() % 0x800) << 52));
        match self.below(12) {
            0 => 0.0,
            1 => f64::INFINITY,
            2 => f64::NAN,
            k if k % 2 == 0 => -size,
            _ => size,
        }
    }
    pub fn vector(&mut self, size: f64) -> Vector3<f64> {
        Vector3::new(self.within(-size, size), self.within(-size, size), self.within(-size, size))
    }
    fn turn(&mut self) -> UnitQuaternion<f64> {
        let [w, x, y, z] = [0; 4].map(|_| self.within(-1.0, 1.0));
        UnitQuaternion::from_quaternion(Quaternion::new(w + 0.01, x, y, z))
    }

    /// Returns a random tree of 1 to 14 links with joints of any type, some of them with an armature; the root may have
    /// no mass.
    pub fn tree(&mut self) -> Tree {
        let count = 1 + self.below(14);
        let mut links: Vec<Link> = vec![];
        for i in 0..count {
            let parent = (i > 0 && self.below(8) > 0).then(|| self.below(i));
            let axis = self.vector(1.0).normalize();
            let joint = match self.below(10) {
                0 => Joint::Fixed,
                1 | 2 => Joint::Prismatic(axis),
                3 => Joint::Spherical,
                4 if parent.is_none() => Joint::Free,
                _ => Joint::Revolute(axis),
            };
            let frame = Isometry3::from_parts(Translation3::from(self.vector(0.5)), self.turn());
            let mass = self.within(0.1, 5.0);
            // The inertia is that of three point masses, so it is valid for a rigid body.
            let mut inertia = Matrix3::zeros();
            for _ in 0..3 {
                let r = self.vector(0.2);
                inertia += (Matrix3::identity() * r.dot(&r) - r * r.transpose()) * (mass / 3.0);
            }
            let mut link = Link::new(parent, frame, joint, mass, self.vector(0.2), inertia);
            if self.below(3) == 0 {
                link.armature = self.within(0.0, 0.1);
            }
            links.push(link);
        }
        // Make the root massless if its joint has one degree of freedom and it carries another link.
        if count > 2 && links.iter().any(|l| l.parent == Some(0)) && links[0].joint.velocities() == 1 {
            (links[0].mass, links[0].inertia) = (0.0, Matrix3::zeros());
        }
        Tree::new(links).unwrap()
    }

    /// Returns a random state of a tree, with velocities from -`speed` to `speed`.
    pub fn state(&mut self, tree: &Tree, speed: f64) -> TreeState {
        let mut state = TreeState::new(tree);
        for x in &mut state.q {
            *x += self.within(-1.5, 1.5);
        }
        for (i, link) in tree.links().iter().enumerate() {
            let at = tree.offsets(i).unwrap().0 + link.joint.positions();
            if matches!(link.joint, Joint::Spherical | Joint::Free) {
                let q = self.turn();
                state.q[at - 4..at].copy_from_slice(&[q.w, q.i, q.j, q.k]);
            }
        }
        for v in &mut state.v {
            *v = self.within(-speed, speed);
        }
        state
    }
}
