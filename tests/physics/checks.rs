//! Tests of the warnings of `tatu check` about mechanics.

use crate::{kit::*, scenes::*};

fn told(scene: &str) -> String {
    Place::scene(scene).tatu(&["check", "scene.toml"]).good().err
}

#[test]
fn sound_scenes_are_not_blamed() {
    let file = root().join("scenes/course/manta_keyboard_statusbar.toml");
    let err = Place::new().tatu(&["check", file.to_str().unwrap()]).good().err;
    assert!(!err.contains("warning"), "{err}");
    let robots = "[[model]]\nmodel = \"pioneer_p3dx\"\n[[model]]\nmodel = \"pioneer_p3dx\"\n";
    let err = told(&format!("{}{robots}", floor(1.0)));
    assert!(!err.contains("warning"), "{err}");
    // One warning lists all bodies that it concerns.
    let flat = |alias: &str| body(alias, "", "box", [0.1; 3], 1.0, "inertia_kg_m2 = [0.001, 0.001, 0.01]");
    let err = told(&format!("{}{}", flat("b"), flat("c")));
    assert_eq!(err.matches("warning").count(), err.matches("no body has moments of inertia").count(), "{err}");
}

#[test]
fn no_body_has_such_an_inertia() {
    let err = told(&body("b", "", "box", [0.1; 3], 1.0, "inertia_kg_m2 = [0.001, 0.001, 0.01]"));
    assert!(err.contains("`/b`: no body has moments of inertia of 1.000e-3, 1.000e-3 and 1.000e-2 kg m^2"), "{err}");
    assert!(err.contains("a homogeneous body of its size and mass has 1.667e-3"), "{err}");
    let err = told(&body("b", "", "box", [0.1; 3], 1.0, "inertia_kg_m2 = [0.001, 0.001, 0.0]"));
    assert!(err.contains("must be above 0"), "{err}");
}

#[test]
fn a_heavy_body_on_a_light_one_is_hard() {
    let chain = |mass: f64| {
        body("a", "", "box", [0.1; 3], mass, "") + &joint("j", "/a", "") + &body("b", "/a/j", "box", [0.1; 3], 1e-3, "")
    };
    assert!(told(&chain(2.0)).contains("`/a/j` connects bodies of 2.000e0 kg and 1.000e-3 kg"));
    assert!(!told(&chain(0.5)).contains("connects bodies"));
}

#[test]
fn a_gripper_is_too_weak() {
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
    let err = told(&(palm.to_owned() + &finger(-1.0, 10.0) + &finger(1.0, 10.0) + &held));
    assert!(
        err.contains("cannot hold `/o`: 10 N from both sides yield 6.000 N of friction, but its weight is 9.810 N"),
        "{err}"
    );
    let err = told(&(palm.to_owned() + &finger(-1.0, 20.0) + &finger(1.0, 20.0) + &held));
    assert!(!err.contains("cannot hold"), "{err}");
}

#[test]
fn steps_are_too_coarse() {
    let err = told("physics_dt_s = 0.05\nphysics_substeps = 4\n");
    assert!(err.contains("physics steps of 0.05 s in 4 sub-steps are too coarse for contacts"), "{err}");
    assert!(!told("physics_dt_s = 0.02\nphysics_substeps = 4\n").contains("coarse"));
}

/// A four-bar linkage whose last two links are joined in position and orientation by two dummies. It can close only if
/// the dummies have the same orientation; otherwise no positions of its three joints satisfy the link.
#[test]
fn a_loop_that_cannot_close_is_told() {
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
    assert!(!told(&four_bar(&closed)).contains("cannot meet"));
    // The dummies are apart, but the joints can bring them together.
    let within = placed([1.0, 0.0, 1.28], [0.0, 1.0, 0.0], 0.02);
    assert!(!told(&four_bar(&within)).contains("cannot meet"), "{}", told(&four_bar(&within)));
    let turned = four_bar(&placed([1.0, 0.0, 1.3], [0.0, 0.0, 1.0], 0.3));
    let wanted = "the linked dummies /g/o/crank/a/coupler/p and /h/c/rocker/q cannot meet: at any position of \
                  the 3 joint axes between them, ";
    let err = told(&turned);
    assert!(err.contains(wanted) && err.contains("rad about z (world axes) remains"), "{err}");
    let err = Place::scene(&turned).run(&["--steps", "1"]).good().err;
    assert!(err.contains(wanted), "expected the warning at the start of the run: {err}");
}
