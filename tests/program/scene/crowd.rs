//! Tests of many bodies at once: a wall does not collapse, and the number of other robots does not affect a robot.

use std::{collections::BTreeSet, sync::Arc};

use tatu_core::{World, document};

use crate::{
    kit::{FLOOR, TestFolder},
    state::restart::{registry, world},
};

const ROWS: usize = 20;
const COLUMNS: usize = 25;

/// Returns the positions of 500 bricks of 0.2 x 0.1 x 0.1 m that touch exactly. Odd rows are offset by a quarter brick.
fn bricks() -> Vec<[f64; 3]> {
    let at = |row: usize, column: usize| {
        let shift = if row % 2 == 1 { 0.05 } else { 0.0 };
        [(column as f64 - 12.0) * 0.2 + shift, 0.0, 0.05 + row as f64 * 0.1]
    };
    (0..ROWS).flat_map(|row| (0..COLUMNS).map(move |column| at(row, column))).collect()
}

/// No brick shifts sideways by more than 3 mm, and none sinks by more than 5 mm. With softer contacts the wall would
/// sink by 60 mm. The friction is 0.5.
#[test]
fn a_wall_of_500_bricks_is_stable() {
    let mut scene = format!("physics_dt_s = 0.005\n{FLOOR}")
        .replace("respondable = true\n", "respondable = true\nfriction = 0.70710678\n");
    for (i, [x, y, z]) in bricks().into_iter().enumerate() {
        scene += &format!(
            "[[object]]\nkind = \"shape\"\nalias = \"b{i}\"\nsize_m = [0.2, 0.1, 0.1]\nposition_m = [{x}, {y}, {z}]\n\
             mass_kg = 1.0\ndynamic = true\nrespondable = true\nfriction = 0.70710678\n"
        );
    }
    let place = TestFolder::scene(&scene);
    let world = world(&place.path().join("scene.toml"), &registry());
    world.start();
    for _ in 0..100 {
        world.step();
    }
    assert_eq!(world.faults(), []);
    for (i, [x, y, z]) in bricks().into_iter().enumerate() {
        let [nx, ny, nz, ..] = world.observe(&format!("/b{i}")).unwrap().pose;
        assert!((nx - x).abs() < 3e-3 && (ny - y).abs() < 3e-3, "brick {i} is shifted by {} {} m", nx - x, ny - y);
        assert!((nz - z).abs() < 5e-3, "brick {i} has sunk by {} m", z - nz);
    }
}

/// Creates a row of `n` robots, 10 m apart, each of which drives a different curve.
fn robots(n: usize) -> TestFolder {
    let mut scene = FLOOR.to_owned();
    for i in 0..n {
        scene += &format!(
            "[[model]]\nmodel = \"pioneer_p3dx\"\nalias = \"r{i}\"\nposition_m = [{}.0, 0.0, 0.0]\n[model.script]\n\
             text = '''\nfunction sysCall_init()\n\
             sim.setJointTargetVelocity(sim.getObject('./Pioneer_p3dx_leftMotor'), 3)\n\
             sim.setJointTargetVelocity(sim.getObject('./Pioneer_p3dx_rightMotor'), 2)\nend\n'''\n",
            10 * i
        );
    }
    TestFolder::scene(&scene)
}

/// Above 63 joints, the engine could solve those without a motor in parallel and in a different order.
#[test]
fn a_robot_moves_the_same_among_many() {
    let registry = registry();
    let hash = |n: usize| {
        let place = robots(n);
        let world: World = world(&place.path().join("scene.toml"), &registry);
        world.start();
        for _ in 0..20 {
            world.step();
        }
        let driven = world.observe("/r0").unwrap().pose[0];
        assert!(driven > 0.01, "the robot has driven only {driven} m");
        world.hash().subtree("/r0")
    };
    let alone = hash(1);
    for n in [2, 5, 70] {
        assert_eq!(hash(n), alone, "among {n}");
    }
}

/// Each part of a compound has its own friction: the ball slides on a slope on which the box would stick.
#[test]
fn parts_of_a_compound_have_their_own_friction() {
    let slope = |friction: &str| {
        let scene = format!(
            "gravity_m_s2 = [4.0, 0.0, -8.5]\n{FLOOR}[[object]]\nkind = \"shape\"\nalias = \"sledge\"\n\
             primitive = \"compound\"\nposition_m = [0.0, 0.0, 0.1]\ndynamic = true\nrespondable = true\nparts = [\n\
             {{ primitive = \"box\", size_m = [0.4, 0.2, 0.2]{friction} }},\n]\n"
        );
        let place = TestFolder::scene(&scene);
        let world = world(&place.path().join("scene.toml"), &registry());
        world.start();
        for _ in 0..20 {
            world.step();
        }
        world.observe("/sledge").unwrap().pose[0]
    };
    assert!(slope("").abs() < 1e-3, "the compound slides with friction 1: {}", slope(""));
    // Without friction the distance is a t^2 / 2, within the error of a first-order integrator.
    let slid = slope(", friction = 0.0");
    assert!((slid - 2.0).abs() < 0.05, "4 m/s^2 for 1 s: {slid} m");
}

/// Runs 700 noisy sonars among boxes, which are enough to be distributed over several threads.
#[test]
fn many_sensors_measure_the_same_on_any_number_of_threads() {
    let mut scene = String::from("seed = 5\n");
    for i in 0..700 {
        let (x, y) = (0.4 * f64::from(i % 30), 0.4 * f64::from(i / 30));
        scene += &format!(
            "[[object]]\nkind = \"sensor\"\nsensor = \"proximity\"\nalias = \"s{i}\"\nvolume = \"{}\"\nrange_m = 1.5\n\
             position_m = [{x}, {y}, 0.3]\norientation_deg = [90.0, {}.0, 0.0]\n\
             [object.noise.distance]\nsigma = 0.01\n\
             [[object]]\nkind = \"shape\"\nalias = \"b{i}\"\nsize_m = [0.05, 0.05, 0.6]\n\
             position_m = [{}, {}, 0.3]\n",
            if i % 3 == 0 { "cone" } else { "ray" },
            i % 360,
            x + 0.2,
            y + 0.15,
        );
    }
    let place = TestFolder::scene(&scene);
    let registry = registry();
    let measured = |threads: usize| {
        let file = place.path().join("scene.toml");
        let document = document::load(&file, &registry, &document::LoadOptions::default()).unwrap();
        let world = World::with_threads(Arc::new(document), registry.clone(), threads).unwrap();
        world.start();
        for _ in 0..3 {
            world.step();
        }
        assert_eq!(world.faults(), []);
        (0..700).map(|i| world.observe(&format!("/s{i}")).unwrap().reading).collect::<Vec<_>>()
    };
    let alone = measured(1);
    let different: BTreeSet<String> = alone.iter().map(|reading| format!("{reading:?}")).collect();
    assert!(different.len() > 300, "{} of 700 readings differ", different.len());
    for threads in 2..4 {
        assert!(measured(threads) == alone, "{threads} threads");
    }
}
