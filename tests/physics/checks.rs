//! Tests of the warnings of `tatu check` about mechanics.

use crate::{kit::*, scenes::*};

fn check_warnings(scene: &str) -> String {
    TestFolder::scene(scene).tatu(&["check", "scene.toml"]).good().err
}

#[test]
fn sound_scenes_cause_no_warnings() {
    let file = root().join("scenes/course/manta_keyboard_statusbar.toml");
    let err = TestFolder::new().tatu(&["check", file.to_str().unwrap()]).good().err;
    assert!(!err.contains("warning"), "{err}");
    let robots = "[[model]]\nmodel = \"pioneer_p3dx\"\n[[model]]\nmodel = \"pioneer_p3dx\"\n";
    let err = check_warnings(&format!("{}{robots}", floor(1.0)));
    assert!(!err.contains("warning"), "{err}");
    // One warning lists all bodies that it concerns.
    let flat = |alias: &str| body(alias, "", "box", [0.1; 3], 1.0, "inertia_kg_m2 = [0.001, 0.001, 0.01]");
    let err = check_warnings(&format!("{}{}", flat("b"), flat("c")));
    assert_eq!(err.matches("warning").count(), err.matches("no body has moments of inertia").count(), "{err}");
}

#[test]
fn an_impossible_inertia_is_reported() {
    let err = check_warnings(&body("b", "", "box", [0.1; 3], 1.0, "inertia_kg_m2 = [0.001, 0.001, 0.01]"));
    assert!(err.contains("`/b`: no body has moments of inertia of 1.000e-3, 1.000e-3 and 1.000e-2 kg m^2"), "{err}");
    assert!(err.contains("a homogeneous body of its size and mass has 1.667e-3"), "{err}");
    let err = check_warnings(&body("b", "", "box", [0.1; 3], 1.0, "inertia_kg_m2 = [0.001, 0.001, 0.0]"));
    assert!(err.contains("must be above 0"), "{err}");
}

#[test]
fn a_heavy_body_on_a_light_one_is_reported() {
    let chain = |mass: f64| {
        body("a", "", "box", [0.1; 3], mass, "") + &joint("j", "/a", "") + &body("b", "/a/j", "box", [0.1; 3], 1e-3, "")
    };
    assert!(check_warnings(&chain(2.0)).contains("`/a/j` connects bodies of 2.000e0 kg and 1.000e-3 kg"));
    assert!(!check_warnings(&chain(0.5)).contains("connects bodies"));
}

#[test]
fn a_gripper_that_is_too_weak_is_reported() {
    let finger = |side: f64, force: f64| {
        let name = if side < 0.0 { "left" } else { "right" };
        let frame = placed([0.0, 0.0, 0.5], [1.0, 0.0, 0.0], -std::f64::consts::FRAC_PI_2 * side.signum());
        joint(name, "/palm", &format!("{frame}\ntype = \"prismatic\"\ncontrol = \"force\"\nmax_force_n = {force:?}"))
            + &body(
                &format!("{name}_pad"),
                &format!("/palm/{name}"),
                "box",
                [0.05, 0.02, 0.05],
                0.1,
                &format!("world_pose = [0, {}, 0.4, 0, 0, 0, 1]\nrespondable = true\nfriction = 0.5", 0.04 * side),
            )
    };
    let palm = "[[object]]\nkind = \"shape\"\nalias = \"palm\"\nposition_m = [0, 0, 0.5]\n";
    let held = body("o", "", "box", [0.05; 3], 1.0, "position_m = [0, 0, 0.4]\nrespondable = true\nfriction = 0.6");
    let err = check_warnings(&(palm.to_owned() + &finger(-1.0, 10.0) + &finger(1.0, 10.0) + &held));
    assert!(
        err.contains("cannot hold `/o`: 10 N from both sides yield 6.000 N of friction, but its weight is 9.810 N"),
        "{err}"
    );
    let err = check_warnings(&(palm.to_owned() + &finger(-1.0, 20.0) + &finger(1.0, 20.0) + &held));
    assert!(!err.contains("cannot hold"), "{err}");
}

#[test]
fn steps_that_are_too_coarse_are_reported() {
    let err = check_warnings("physics_dt_s = 0.05\nphysics_substeps = 4\n");
    assert!(err.contains("physics steps of 0.05 s in 4 sub-steps are too coarse for contacts"), "{err}");
    assert!(!check_warnings("physics_dt_s = 0.02\nphysics_substeps = 4\n").contains("coarse"));
}

/// A four-bar linkage whose last two links are joined in position and orientation by two dummies. It can close only if
/// the dummies have the same orientation; otherwise no positions of its three joints satisfy the link.
#[test]
fn a_loop_that_cannot_close_is_reported() {
    let four_bar = |turned: &str| {
        let post = |alias: &str, x: f64| {
            format!(
                "[[object]]\nkind = \"shape\"\nalias = \"{alias}\"\nsize_m = [0.05, 0.05, 0.05]\nposition_m = [{x}, 0, 1]\n"
            )
        };
        let link = |alias: &str, parent: &str, length: f64, at: [f64; 3], angle: f64| {
            body(alias, parent, "box", [length, 0.02, 0.02], length, &placed(at, [0.0, 1.0, 0.0], angle))
        };
        let up = -std::f64::consts::FRAC_PI_2;
        let dummy = |alias: &str, parent: &str, more: &str| {
            format!("[[object]]\nkind = \"dummy\"\nalias = \"{alias}\"\nparent = \"{parent}\"\n{more}\n")
        };
        post("g", 0.0)
            + &post("h", 1.0)
            + &joint("o", "/g", &about_y([0.0, 0.0, 1.0]))
            + &link("crank", "/g/o", 0.3, [0.0, 0.0, 1.15], up)
            + &joint("a", "/g/o/crank", &about_y([0.0, 0.0, 1.3]))
            + &link("coupler", "/g/o/crank/a", 1.0, [0.5, 0.0, 1.3], 0.0)
            + &joint("c", "/h", &about_y([1.0, 0.0, 1.0]))
            + &link("rocker", "/h/c", 0.3, [1.0, 0.0, 1.15], up)
            + &dummy("p", "/g/o/crank/a/coupler", &placed([1.0, 0.0, 1.3], [0.0, 1.0, 0.0], 0.0))
            + &dummy("q", "/h/c/rocker", &format!("{turned}\nlink = \"/g/o/crank/a/coupler/p\""))
    };
    let closed = placed([1.0, 0.0, 1.3], [0.0, 1.0, 0.0], 0.0);
    assert!(!check_warnings(&four_bar(&closed)).contains("cannot meet"));
    // The dummies are apart, but the joints can bring them together.
    let within = placed([1.0, 0.0, 1.28], [0.0, 1.0, 0.0], 0.02);
    assert!(!check_warnings(&four_bar(&within)).contains("cannot meet"), "{}", check_warnings(&four_bar(&within)));
    let turned = four_bar(&placed([1.0, 0.0, 1.3], [0.0, 0.0, 1.0], 0.3));
    let wanted = "the linked dummies /g/o/crank/a/coupler/p and /h/c/rocker/q cannot meet: at any position of \
                  the 3 joint axes between them, ";
    let err = check_warnings(&turned);
    assert!(err.contains(wanted) && err.contains("rad about z (world axes) remains"), "{err}");
    let err = TestFolder::scene(&turned).run(&["--steps", "1"]).good().err;
    assert!(err.contains(wanted), "expected the warning at the start of the run: {err}");
}

fn slider(alias: &str, keys: &str, shape: &str) -> String {
    joint("j", "/base", keys) + &body(alias, "/base/j", "box", [0.1; 3], 1.0, shape)
}

/// Returns standard error of `run` for one second.
fn run_warnings(scene: &str) -> String {
    scene_of(scene).run(&["--seconds", "1"]).good().err
}

/// A mechanism has one solver: that of its first shape, or of the only other shape that specifies one. `check` and
/// `run` report a `joint_solver` that is not used.
#[test]
fn a_solver_that_is_not_used_is_named() {
    let used = |scene: &str| {
        let json = scene_of(scene).tatu(&["check", "scene.toml", "--json"]).good().json();
        json["mechanisms"].to_string()
    };
    let alone = base([0.0; 3]) + &slider("l", "", "joint_solver = \"reduced\"");
    assert!(used(&alone).contains("reduced: its own joint_solver"), "{}", used(&alone));
    assert!(!check_warnings(&alone).contains("not used"));
    let other = base([0.0; 3]).replacen("alias", "joint_solver = \"tree\"\nalias", 1)
        + &slider("l", "", "joint_solver = \"reduced\"");
    for text in [check_warnings(&other), run_warnings(&other)] {
        let wanted =
            "`/base/j/l`: its `joint_solver` is not used, because a mechanism has one solver, and `/base` sets";
        assert_eq!(text.matches(wanted).count(), 1, "{text}");
    }
    assert!(used(&other).contains("tree: its own joint_solver"));
}

/// A dynamic shape below a kinematic joint is not held by it.
#[test]
fn a_dynamic_shape_below_a_kinematic_joint_is_reported_once() {
    let scene = base([0.0; 3]) + &slider("l", "mode = \"kinematic\"", "");
    for text in [check_warnings(&scene), run_warnings(&scene)] {
        assert_eq!(
            text.matches("`/base/j/l`: the shape is dynamic, but the joint above it is kinematic").count(),
            1,
            "{text}"
        );
    }
    assert!(!check_warnings(&(base([0.0; 3]) + &slider("l", "", ""))).contains("kinematic"));
}

/// A target of a motor without torque has no effect, whether a file or a script sets it.
#[test]
fn a_target_of_a_motor_without_torque_is_reported_once() {
    let wanted = "the target of the joint /base/j has no effect, because its motor has no torque: set `max_force_nm`";
    for control in ["velocity", "position"] {
        let keys = format!("control = \"{control}\"\n");
        let target = if control == "velocity" { "target_velocity_rad_s = 1.0" } else { "target_position_deg = 10.0" };
        let text = run_warnings(&(base([0.0; 3]) + &slider("l", &(keys.clone() + target), "")));
        assert_eq!(text.matches(wanted).count(), 1, "{text}");
        let name = if control == "velocity" { "Velocity" } else { "Position" };
        let hand = watcher(
            "hand",
            &format!("function sysCall_actuation() sim.setJointTarget{name}(sim.getObject('/base/j'), 1) end"),
        );
        let text = run_warnings(&(base([0.0; 3]) + &slider("l", &keys, "") + &hand));
        assert_eq!(text.matches(wanted).count(), 1, "{text}");
        let text =
            run_warnings(&(base([0.0; 3]) + &slider("l", &(keys + "max_force_nm = 1.0\n" + target), "") + &hand));
        assert!(!text.contains("no effect"), "{text}");
    }
}
