//! Problems: tables with things on them, and shelves, each with two configurations between which the arm shall move.

use nalgebra::{Isometry3, Rotation3, UnitQuaternion, Vector3};
use tatu_geometry::Form;
use tatu_kinematics::{IkTask, SearchSettings, find_configuration, random_configuration};
use tatu_planning::{
    Goal, PlanError, Problem, Random, Settings, StateSpace, Validity, plan,
    spheres::{Body, BodyChecker, SphereCache},
};

use crate::panda;

/// A box that stays: its centre and half of its edges, m, and the angle about z, rad.
#[derive(Debug, Clone, Copy)]
pub struct Block {
    pub center: [f64; 3],
    pub half: [f64; 3],
    pub yaw: f64,
}

/// A problem.
pub struct Task {
    pub name: &'static str,
    pub blocks: Vec<Block>,
    pub start: Vec<f64>,
    pub goal: Vec<f64>,
}

/// Distance by which obstacles are larger when the ends are chosen, so that they are also possible for models of the arm
/// that are a little larger, m.
const MARGIN: f64 = 0.025;
/// Attempts to find an end in a scene before another scene is made.
const ATTEMPTS: u64 = 60;

/// Returns the test of an arm among blocks that are larger by a margin, m.
pub fn checker(blocks: &[Block], margin: f64, cache: &mut SphereCache) -> BodyChecker {
    let mut bodies = panda::bodies();
    let links = bodies.len();
    let mut pairs = panda::SELF_PAIRS.to_vec();
    for block in blocks {
        let half = Vector3::from(block.half).add_scalar(margin);
        let pose = Isometry3::new(Vector3::from(block.center), Vector3::z() * block.yaw);
        // The base stands where it stands.
        pairs.extend((1..links).map(|link| [link, bodies.len()]));
        bodies.push(Body { frame: None, forms: vec![(pose, Form::Box { half })] });
    }
    BodyChecker::new(panda::frames(), &bodies, &pairs, cache)
}

/// Returns problems that follow from a seed; in each, something is on the straight way.
pub fn tasks(count: usize, seed: u64) -> Vec<Task> {
    let (space, mut random) = (panda::space(), Random::new(seed));
    let mut cache = SphereCache::default();
    let mut tasks = Vec::new();
    while tasks.len() < count {
        let shelves = tasks.len() % 2 == 1;
        let (blocks, poses) = if shelves { shelf(&mut random) } else { table(&mut random) };
        let mut wide = checker(&blocks, MARGIN, &mut cache);
        let ends: Vec<Vec<f64>> = poses.iter().filter_map(|pose| reach(pose, &mut wide, &mut random)).collect();
        let [start, goal] = &ends[..] else { continue };
        if !is_direct(&space, &blocks, start, goal, &mut cache) {
            let name = if shelves { "shelf" } else { "table" };
            tasks.push(Task { name, blocks, start: start.clone(), goal: goal.clone() });
        }
    }
    tasks
}

/// Returns whether the straight way is free: a search that may not do more than test it finds a path.
fn is_direct(space: &StateSpace, blocks: &[Block], start: &[f64], goal: &[f64], cache: &mut SphereCache) -> bool {
    let problem = Problem { space, start, goal: Goal::States(vec![goal.to_vec()]) };
    let settings = Settings { max_checks: 3, ..Settings::default() };
    let found = plan(problem, &settings, &mut checker(blocks, 0.0, cache), &mut |_| true);
    match found {
        Ok(_) => true,
        Err(PlanError::NotFound { .. }) => straight_is_free(space, start, goal, &mut checker(blocks, 0.0, cache)),
        Err(_) => true,
    }
}

fn straight_is_free(space: &StateSpace, start: &[f64], goal: &[f64], checker: &mut BodyChecker) -> bool {
    let motion = space.motion(start, goal);
    (0..=100).all(|i| checker.is_valid(&motion.at(f64::from(i) / 100.0)))
}

/// Returns a possible configuration for a pose of the tool.
fn reach(pose: &Isometry3<f64>, checker: &mut BodyChecker, random: &mut Random) -> Option<Vec<f64>> {
    let (arm, joints, tip, target) = panda::linkage();
    let task = [IkTask::new(tip, target)];
    (0..ATTEMPTS).find_map(|n| {
        let mut arm = arm.clone();
        arm.set_pose(target, pose);
        random_configuration(&mut arm, &task, random.bits(), n);
        let settings = SearchSettings { max_restarts: 0, ..SearchSettings::default() };
        find_configuration(&mut arm, &task, &settings).ok()?;
        let state: Vec<f64> = joints.iter().map(|j| arm.position(*j)).collect();
        checker.is_valid(&state).then_some(state)
    })
}

/// A pose of the tool at a place, pointing along a direction, turned about it.
fn pointing(place: [f64; 3], direction: Vector3<f64>, turn: f64) -> Isometry3<f64> {
    let up = if direction.z.abs() > 0.9 { Vector3::x() } else { Vector3::z() };
    let rotation = Rotation3::face_towards(&direction, &up) * Rotation3::new(Vector3::z() * turn);
    Isometry3::from_parts(Vector3::from(place).into(), UnitQuaternion::from_rotation_matrix(&rotation))
}

/// A table before the arm with things on it; the tool is close above the table, on two sides of them.
fn table(random: &mut Random) -> (Vec<Block>, Vec<Isometry3<f64>>) {
    let top = random.between(-0.05, 0.25);
    let mut blocks = vec![Block { center: [0.65, 0.0, top - 0.02], half: [0.35, 0.7, 0.02], yaw: 0.0 }];
    for _ in 0..2 + random.index(4) {
        let half = [random.between(0.03, 0.08), random.between(0.03, 0.08), random.between(0.08, 0.22)];
        let center = [random.between(0.4, 0.75), random.between(-0.2, 0.2), top + half[2]];
        blocks.push(Block { center, half, yaw: random.between(-1.5, 1.5) });
    }
    let poses = [-1.0, 1.0].map(|side| {
        let place = [random.between(0.4, 0.65), side * random.between(0.25, 0.5), top + random.between(0.08, 0.2)];
        pointing(place, -Vector3::z(), random.between(-3.0, 3.0))
    });
    (blocks, poses.to_vec())
}

/// A shelf before the arm: sides, a back and three boards; the tool is in two compartments, pointing into them.
fn shelf(random: &mut Random) -> (Vec<Block>, Vec<Isometry3<f64>>) {
    let (front, width, depth, thick) = (random.between(0.5, 0.62), random.between(0.35, 0.45), 0.15, 0.01);
    let middle = front + depth;
    let low = random.between(0.05, 0.2);
    let gap = random.between(0.32, 0.4);
    let mut blocks = Vec::new();
    for board in 0..3 {
        let center = [middle, 0.0, low + gap * f64::from(board)];
        blocks.push(Block { center, half: [depth, width, thick], yaw: 0.0 });
    }
    let height = 0.5 * (2.0 * gap);
    for side in [-1.0, 0.0, 1.0] {
        let center = [middle, side * width, low + height];
        blocks.push(Block { center, half: [depth, thick, height], yaw: 0.0 });
    }
    blocks.push(Block { center: [middle + depth, 0.0, low + height], half: [thick, width, height], yaw: 0.0 });
    let first = random.index(4);
    let second = (first + 1 + random.index(3)) % 4;
    let poses = [first, second].map(|compartment| {
        let (row, column) = (compartment / 2, compartment % 2);
        let y = (column as f64 - 0.5) * width;
        let z = low + gap * (row as f64 + random.between(0.4, 0.6));
        let direction = Vector3::new(1.0, random.between(-0.15, 0.15), random.between(-0.25, 0.05)).normalize();
        pointing([front + random.between(0.0, 0.08), y, z], direction, random.between(-0.4, 0.4))
    });
    (blocks, poses.to_vec())
}
