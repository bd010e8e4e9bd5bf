//! Tests of mechanisms that are solved as trees.

use crate::{kit::*, scenes::*};

/// Returns a scene in which a block on a slide pushes a box over the floor and retracts: the joint bears the friction
/// of the box, which then remains where the block left it.
fn pusher() -> String {
    let slide = placed([0.0, 0.0, 0.1], [0.0, 1.0, 0.0], std::f64::consts::FRAC_PI_2)
        + "\ntype = \"prismatic\"\ncontrol = \"velocity\"\nmax_force_n = 200.0\nlimits_m = [-1.0, 1.0]";
    floor(0.5)
        + &base([-1.0, 0.0, 0.1])
        + &joint("slide", "/base", &slide)
        + &body(
            "block",
            "/base/slide",
            "box",
            [0.1; 3],
            1.0,
            "respondable = true\nfriction = 0.0\nposition_m = [0, 0, 0]",
        )
        + &body("box", "", "box", [0.2; 3], 3.0, "respondable = true\nposition_m = [0.2, 0.0, 0.1]")
        + &watcher(
            "hand",
            "function sysCall_actuation()
                local t = sim.getSimulationTime()
                sim.setJointTargetVelocity(sim.getObject('/base/slide'), t < 2 and 0.1 or -0.1)
            end",
        )
}

#[test]
fn a_joint_reports_the_load_of_the_body_it_pushes() {
    let lines = watch_run(&pusher(), &["/base/slide", "/box"], 4.0);
    let at = |t: f64| lines.iter().find(|l| l.time() >= t - 1e-9).unwrap();
    // The block reaches the box after 0.05 m.
    near("free", of_joint(at(0.3), "/base/slide", "effort"), 0.0, 1e-9);
    near("pushing", of_joint(at(1.8), "/base/slide", "effort"), 0.5 * 3.0 * G, 1e-3);
    near("pushed", position(at(2.0), "/box")[0], 0.2 + 0.15, 1e-3);
    near(
        "position of the box after the block has retracted",
        position(at(4.0), "/box")[0],
        position(at(2.2), "/box")[0],
        1e-5,
    );
    near("effort without contact", of_joint(at(3.0), "/base/slide", "effort"), 0.0, 1e-9);
}

#[test]
fn contacts_of_a_tree_continue_from_a_snapshot() {
    for at in ["0.55", "1.0", "2.1"] {
        let place = scene_of(&pusher());
        let hash = |args: &[&str]| place.run(&[&["--seconds", "4"], args].concat()).good().json()["hash"].clone();
        let one = hash(&["--threads", "1"]);
        assert_eq!(one, hash(&["--threads", "2", "--snapshot-at", at, "some.state"]));
        assert_eq!(one, hash(&["--from", "some.state"]), "{at}");
    }
}

#[test]
fn several_trees_have_the_same_bits_on_any_number_of_threads() {
    let arm = |x: usize| format!("[[model]]\nmodel = \"ur5\"\nposition_m = [{}, 0, 0]\n", 2 * x);
    let arms: String = (0..6).map(arm).collect();
    let place = scene_of(&(floor(1.0) + &arms + "[[model]]\nmodel = \"quadruped\"\nposition_m = [0, 3, 0]\n"));
    let run = |args: &[&str]| place.run(&[&["--seconds", "1"], args].concat()).good().json()["hash"].clone();
    let one = run(&["--threads", "1"]);
    assert_eq!(one, run(&["--threads", "2"]));
    assert_eq!(one, run(&["--threads", "4"]));
}

#[test]
fn the_solver_of_a_mechanism_is_named_with_the_reason() {
    let link = body("link", "/base/j", "box", [0.1; 3], 1.0, "");
    let own = |solver: &str| base([0.0; 3]).replacen("alias", &format!("joint_solver = \"{solver}\"\nalias"), 1);
    let arm = |base: &str| base.to_owned() + &joint("j", "/base", "") + &link;
    let solver = |scene: &str| {
        let out = scene_of(scene).tatu(&["check", "scene.toml", "--json"]).good().json();
        out["mechanisms"]["/base"].as_str().unwrap().to_owned()
    };
    assert_eq!(solver(&arm(&base([0.0; 3]))), "tree: not a vehicle with centred wheels");
    let of_scene = "joint_solver = \"reduced\"\n".to_owned() + &arm(&base([0.0; 3]));
    assert_eq!(solver(&of_scene), "reduced: the scene's joint_solver");
    assert_eq!(solver(&arm(&own("tree"))), "tree: its own joint_solver");
    assert_eq!(solver(&arm(&own("reduced"))), "reduced: its own joint_solver");
    let closed = "[[object]]\nkind = \"dummy\"\nalias = \"a\"\nparent = \"/base\"\nlink = \"/base/j/link/b\"\n\
                  [[object]]\nkind = \"dummy\"\nalias = \"b\"\nparent = \"/base/j/link\"\nlink = \"/base/a\"\n";
    assert_eq!(solver(&(arm(&own("tree")) + closed)), "reduced: linked dummies close a loop");
    let screw = own("tree") + &joint("j", "/base", "lead_m = 0.01") + &link;
    assert_eq!(solver(&screw), "reduced: it has screws");
    let geared =
        joint("k", "/base", "follows = \":/j\"\ngeared = true") + &body("other", "/base/k", "box", [0.1; 3], 1.0, "");
    assert_eq!(solver(&(arm(&own("impulse")) + &geared)), "tree: gears couple its joints");
}

/// The quadruped walks straight ahead and remains upright.
#[test]
fn legs_walk() {
    let scene = floor(1.0) + "[[model]]\nmodel = \"quadruped\"\n";
    let lines = watch_run(&scene, &["/go1"], 8.0);
    let end = position(&lines[lines.len() - 1], "/go1");
    println!("{end:?}");
    assert!(end[0] > 1.0 && end[1].abs() < 0.1 && end[2] > 0.25);
}

/// Rolling friction that a script sets for a ball of a mechanism takes effect: the engine then solves the mechanism.
#[test]
fn a_surface_may_become_special_in_a_run() {
    let start = starts([1.0, 0.0, 0.0], [0.0, 10.0, 0.0]);
    let ball = format!("position_m = [0.0, 0.0, 0.1]\nrespondable = true\n{start}");
    let scene = floor(1.0)
        + &body("b", "", "sphere", [0.2; 3], 1.0, &ball)
        + &joint("j", "/b", "dry_friction_nm = 1.0")
        + &body("core", "/b/j", "sphere", [0.02; 3], 0.01, &start)
        + &watcher(
            "hand",
            "function sysCall_actuation()
                if sim.getSimulationTime() > 0.99 then
                    tatu.set(sim.getObject('/b'), 'shape.rolling_friction', 0.002)
                end
            end",
        );
    let lines = watch_run(&scene, &["/b"], 3.0);
    let before = lines.iter().find(|l| l.time() >= 1.0 - 1e-9).unwrap();
    let end = &lines[lines.len() - 1];
    near("speed without rolling friction", speed(before, "/b"), 1.0, 0.01);
    near("speed with rolling friction", speed(end, "/b"), 1.0 - 0.002 / 0.1 * G * 5.0 / 7.0 * (end.time() - 1.0), 0.02);
}

/// Returns a heavy rail on the floor and a drawer that rests on it, 1 mm deep in it. The drawer slides on a joint that
/// is tilted by an angle, degrees.
fn drawer_on_rail(friction: f64, tilt: f64) -> String {
    format!(
        "dt_s = 0.005\n{}\
         [[object]]\nkind = \"shape\"\nalias = \"rail\"\nprimitive = \"box\"\nsize_m = [1, 0.3, 0.02]\n\
         position_m = [0, 0, 0.01]\nmass_kg = 20.0\ndynamic = true\nrespondable = true\nfriction = {friction:?}\n\
         [[object]]\nkind = \"joint\"\nalias = \"slide\"\nparent = \"rail\"\ntype = \"prismatic\"\ncontrol = \"free\"\n\
         orientation_deg = [0, {:?}, 0]\n\
         [[object]]\nkind = \"shape\"\nalias = \"drawer\"\nparent = \"/rail/slide\"\nprimitive = \"box\"\n\
         size_m = [0.3, 0.3, 0.1]\nworld_pose = [0, 0, 0.069, 0, 0, 0, 1]\nmass_kg = 2.0\ndynamic = true\n\
         respondable = true\nfriction = {friction:?}\n",
        floor(1.0),
        90.0 + tilt
    )
}

/// The joint holds the drawer across its axis, so the load of the rail is undetermined: it carries the drawer's weight.
#[test]
fn drawer_on_its_rail_is_held_by_friction() {
    let moved = |friction: f64, tilt: f64, seconds: f64| {
        let lines = watch_run(&drawer_on_rail(friction, tilt), &["/rail/slide/drawer"], seconds);
        let x = |l: &TraceLine| position(l, "/rail/slide/drawer")[0];
        x(lines.last().unwrap()) - x(&lines[0])
    };
    assert!(moved(0.5, 0.02, 10.0).abs() < 1e-8);
    // Without friction, it slides by g t^2 sin(tilt) / 2.
    near("slid", moved(0.0, 0.02, 2.0), 0.5 * 9.81 * 0.02f64.to_radians().sin() * 4.0, 1e-4);
}
