//! Reads the robots in `tests/data`, with MuJoCo's results in the same files.

use nalgebra::{Isometry3, Matrix3, Quaternion, Translation3, UnitQuaternion, Vector3};
use tatu_mechanisms::{Joint, Link, State, Tree};

/// The names of all robots.
pub const ALL: [&str; 7] = ["ur5", "xarm7", "solo12", "go1", "g1", "talos", "chain20"];

/// A robot, and MuJoCo's results for one state.
pub struct Robot {
    pub links: Vec<Link>,
    pub tree: Tree,
    pub state: State,
    pub mass: Vec<f64>,
    pub bias: Vec<f64>,
    pub acceleration: Vec<f64>,
}

/// Returns the gravity of all tests, m/s².
pub fn gravity() -> Vector3<f64> {
    Vector3::new(0.0, 0.0, -9.81)
}

/// Reads a robot; the format is described in the files.
pub fn load(name: &str) -> Robot {
    let path = format!("{}/tests/data/{name}.tree", env!("CARGO_MANIFEST_DIR"));
    let text = std::fs::read_to_string(&path).unwrap();
    let mut lines = text
        .lines()
        .filter(|l| !l.starts_with('#'))
        .map(|l| l.split_whitespace().map(|x| x.parse::<f64>().unwrap()).collect::<Vec<_>>());
    let mut next = || lines.next().unwrap();
    let count = next()[0] as usize;
    let links: Vec<Link> = (0..count).map(|_| link(&next())).collect();
    let tree = Tree::new(links.clone()).unwrap();
    let state = State { q: next(), v: next() };
    Robot { links, tree, state, mass: next(), bias: next(), acceleration: next() }
}

/// Reads a robot, and fixes its root in the world if it is free.
pub fn load_fixed(name: &str) -> Tree {
    let mut links = load(name).links;
    links[0].joint = Joint::Fixed;
    Tree::new(links).unwrap()
}

fn link(x: &[f64]) -> Link {
    let axis = Vector3::new(x[9], x[10], x[11]);
    let joint = match x[1] as i32 {
        0 => Joint::Free,
        2 => Joint::Prismatic(axis),
        3 => Joint::Revolute(axis),
        _ => Joint::Fixed,
    };
    let turned = UnitQuaternion::from_quaternion(Quaternion::new(x[5], x[6], x[7], x[8]));
    let frame = Isometry3::from_parts(Translation3::new(x[2], x[3], x[4]), turned);
    let inertia = Matrix3::new(x[19], x[22], x[23], x[22], x[20], x[24], x[23], x[24], x[21]);
    let parent = (x[0] >= 0.0).then_some(x[0] as usize);
    let mut link = Link::new(parent, frame, joint, x[15], Vector3::new(x[16], x[17], x[18]), inertia);
    link.armature = x[25];
    link
}
