//! Tests of the fast test of configurations against slow ones, on an arm among boxes.

#![allow(clippy::disallowed_methods, reason = "expected values in tests do not affect results")]

use nalgebra::{Isometry3, Point3, Vector3};
use tatu_geometry::Form;
use tatu_planning::{
    Random, Validity,
    spheres::{Body, BodyChecker, Confirm, FrameMotion, FrameTree, MovingFrame, SphereCache},
};

const RADIUS: f64 = 0.06;
const HALF: f64 = 0.2;

/// Three joints, each turned against the one before, with a capsule along x of its frame.
fn arm() -> (FrameTree, Vec<Body>) {
    let mut frames = FrameTree::default();
    let mut bodies = Vec::new();
    let along = Isometry3::new(Vector3::new(HALF, 0.0, 0.0), Vector3::y() * std::f64::consts::FRAC_PI_2);
    let mut parent = None;
    for number in 0..3 {
        let pose = Isometry3::new(Vector3::new(if number > 0 { 0.45 } else { 0.0 }, 0.0, 0.0), Vector3::x() * 1.3);
        let motion = FrameMotion::Turn { number, factor: 1.0, offset: 0.0, lead: 0.0 };
        parent = frames.add(MovingFrame { parent, pose, motion });
        bodies.push(Body { frame: parent, forms: vec![(along, Form::Capsule { radius: RADIUS, half_length: HALF })] });
    }
    (frames, bodies)
}

fn blocks(random: &mut Random) -> Vec<Body> {
    let mut block = || {
        let half = Vector3::from_fn(|_, _| random.between(0.03, 0.2));
        let place = Vector3::from_fn(|_, _| random.between(-1.0, 1.0));
        let pose = Isometry3::new(place, Vector3::from_fn(|_, _| random.between(-1.0, 1.0)));
        Body { frame: None, forms: vec![(pose, Form::Box { half })] }
    };
    (0..6).map(|_| block()).collect()
}

/// Distance of a box from a segment of 200 points.
fn distance(body: &Body, pose: &Isometry3<f64>) -> f64 {
    let (own, Form::Box { half }) = &body.forms[0] else { panic!("a box") };
    let points = (0..=200).map(|i| pose * Point3::new(2.0 * HALF * f64::from(i) / 200.0, 0.0, 0.0));
    let one = |p: Point3<f64>| (own.inverse() * p).coords.abs().zip_map(half, |a, h| (a - h).max(0.0)).norm();
    points.map(one).fold(f64::INFINITY, f64::min)
}

/// Tests capsules and boxes by points on the axis.
struct ByPoints {
    bodies: Vec<Body>,
    calls: usize,
}
impl Confirm for ByPoints {
    fn is_touching(&mut self, [a, b]: [usize; 2], poses: [&Isometry3<f64>; 2]) -> bool {
        self.calls += 1;
        let (link, block) = if a < 3 { (poses[0], b) } else { (poses[1], a) };
        distance(&self.bodies[block], link) <= RADIUS
    }
}

#[test]
fn spheres_never_miss_a_contact_and_confirmed_tests_are_exact() {
    let mut random = Random::new(12);
    let mut refused = [0; 3];
    for _ in 0..12 {
        let (frames, mut bodies) = arm();
        bodies.extend(blocks(&mut random));
        let pairs: Vec<[usize; 2]> = (0..3).flat_map(|link| (3..9).map(move |block| [block, link])).collect();
        let mut cache = SphereCache::default();
        let mut fast = BodyChecker::new(frames.clone(), &bodies, &pairs, &mut cache);
        let confirm = ByPoints { bodies: bodies.clone(), calls: 0 };
        let mut exact = BodyChecker::confirmed(frames.clone(), &bodies, &pairs, &mut cache, confirm);
        for _ in 0..60 {
            let states: Vec<f64> = (0..24).map(|_| random.between(-3.0, 3.0)).collect();
            let mut expected = Vec::new();
            for state in states.chunks(3) {
                let poses = frames.poses(state);
                let free = (0..3).all(|i| (3..9).all(|b| distance(&bodies[b], &poses[i]) > RADIUS));
                assert_eq!(exact.is_valid(state), free, "{state:?}");
                assert!(free || !fast.is_valid(state), "{state:?}");
                refused[0] += usize::from(!free);
                refused[1] += usize::from(!fast.is_valid(state));
                refused[2] += 1;
                expected.push(free);
            }
            assert_eq!(exact.are_valid(&states, 3), expected.iter().all(|free| *free));
            assert_eq!(exact.are_valid(&states[..15], 3), expected[..5].iter().all(|free| *free));
        }
    }
    // Spheres alone refuse a little more, and far from everything.
    let [exact, fast, all] = refused;
    assert!(exact > all / 20 && fast < all * 3 / 4 && (fast as f64) < 1.3 * exact as f64, "{refused:?}");
}

#[test]
fn touching_links_make_a_state_impossible() {
    let mut frames = FrameTree::default();
    let slide = |number| FrameMotion::Slide { number, factor: 1.0, offset: 0.0 };
    let here = Isometry3::identity();
    let first = frames.add(MovingFrame { parent: None, pose: here, motion: slide(0) });
    let second = frames.add(MovingFrame { parent: None, pose: here, motion: slide(1) });
    let ball = |frame| Body { frame, forms: vec![(here, Form::Sphere { radius: 0.5 })] };
    let bodies = [ball(first), ball(second), ball(None), ball(None)];
    let mut cache = SphereCache::default();
    let mut test = BodyChecker::new(frames.clone(), &bodies, &[[0, 1]], &mut cache);
    assert!(test.is_valid(&[0.0, 1.01]) && !test.is_valid(&[0.0, 0.99]));
    assert_eq!(test.touching(&[0.0, 0.5]), Some([0, 1]));
    struct Always;
    impl Confirm for Always {
        fn is_touching(&mut self, _: [usize; 2], _: [&Isometry3<f64>; 2]) -> bool {
            true
        }
    }
    let fixed_frames = frames.clone();
    let mut fixed = BodyChecker::confirmed(frames, &bodies, &[[2, 3]], &mut cache, Always);
    assert!(!fixed.is_valid(&[5.0, 9.0]) && fixed.touching(&[5.0, 9.0]) == Some([2, 3]));
    let wall = Form::Box { half: Vector3::repeat(1.0) };
    let bodies = [ball(first), Body { frame: None, forms: vec![(Isometry3::translation(0.0, 0.0, 3.0), wall)] }];
    let mut wide = BodyChecker::new(fixed_frames, &bodies, &[[0, 1]], &mut cache).with_margin(0.2);
    assert!(wide.is_valid(&[1.29, 0.0]) && !wide.is_valid(&[1.31, 0.0]));
    assert!(!test.is_valid(&[0.0]), "a state that is too short is not possible");
}
