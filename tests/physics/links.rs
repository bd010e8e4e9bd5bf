//! Tests of linked dummies between a mechanism or a free body and the world, and of joints and force sensors whose
//! child was detached.

use crate::{kit::*, scenes::*};

fn dummy(alias: &str, parent: &str, more: &str) -> String {
    let parent = if parent.is_empty() { String::new() } else { format!("parent = \"{parent}\"\n") };
    format!("[[object]]\nkind = \"dummy\"\nalias = \"{alias}\"\n{parent}{more}\n")
}

/// A rod of 1 kg whose end is held by a ball joint, and the nub of this joint by a link.
fn arm(more: &str) -> String {
    body("arm", "", "box", [0.5, 0.05, 0.05], 1.0, &format!("position_m = [0.25, 0, 1.8]\n{more}"))
        + &joint("ball", "/arm", "type = \"spherical\"\nposition_m = [-0.25, 0, 0]")
        + &body("nub", "/arm/ball", "sphere", [0.05; 3], 0.01, "")
}

/// A link to a static shape without a mechanism, or to the world itself, holds from either end.
#[test]
fn a_link_to_the_world_bears_load_from_either_end() {
    let post = "[[object]]\nkind = \"shape\"\nalias = \"base\"\nsize_m = [0.1, 0.1, 0.1]\nposition_m = [0, 0, 2]\n";
    let linked = |link: &str, other: &str| if link == other { format!("link = \"{link}\"\n") } else { String::new() };
    for solver in ["auto", "reduced", "impulse"] {
        for (above, at, path) in [("/base", "[0, 0, -0.2]", "/base/d1"), ("", "[0, 0, 1.8]", "/d1")] {
            for from in ["/arm/ball/nub/d2", path] {
                let scene = post.to_owned()
                    + &dummy("d1", above, &format!("position_m = {at}\n{}", linked("/arm/ball/nub/d2", from)))
                    + &arm(&format!("joint_solver = \"{solver}\""))
                    + &dummy("d2", "/arm/ball/nub", &linked(path, from));
                let lines = watch_run(&scene, &["/arm", "/arm/ball/nub"], 2.0);
                let what = format!("{solver} {above} {from}");
                for line in &lines {
                    near(&what, distance(position(line, "/arm/ball/nub"), [0.0, 0.0, 1.8]), 0.0, 2e-3);
                }
                let end = &lines[lines.len() - 1];
                near(&what, distance(position(end, "/arm"), [0.0, 0.0, 1.8]), 0.25, 5e-3);
            }
        }
    }
}

/// A box that hangs from a dummy of the world follows it when a script moves the dummy.
#[test]
fn a_link_to_the_world_follows_its_dummy() {
    let mover = watcher(
        "mover",
        "function sysCall_actuation()
            sim.setObjectPosition(sim.getObject('/d1'), {0.2 * math.min(1, sim.getSimulationTime()), 0, 1})
        end",
    );
    let scene = dummy("d1", "", "position_m = [0, 0, 1]\nlink = \"/box/d2\"")
        + &body("box", "", "box", [0.1; 3], 1.0, "position_m = [0, 0, 1]")
        + &dummy("d2", "/box", "")
        + &mover;
    let lines = watch_run(&scene, &["/box"], 3.0);
    near("end", distance(position(&lines[lines.len() - 1], "/box"), [0.2, 0.0, 1.0]), 0.0, 2e-3);
}

/// A joint and a force sensor carry the weight of their child, and no load after it was detached.
#[test]
fn an_unloaded_joint_or_force_sensor_measures_zero() {
    let scene = base([0.0, 0.0, 1.0])
        + &joint("j", "/base", &format!("{}\ncontrol = \"position\"\nmax_force_nm = 50.0", about_y([0.0, 0.0, 1.0])))
        + &body("l", "/base/j", "box", [0.5, 0.05, 0.05], 1.0, "world_pose = [0.25, 0, 1, 0, 0, 0, 1]")
        + "[[object]]\nkind = \"force_sensor\"\nalias = \"f\"\nparent = \"/base\"\n"
        + &body("w", "/base/f", "box", [0.1; 3], 2.0, "")
        + &watcher(
            "hand",
            "function sysCall_init()
                n, j, f = 0, sim.getObject('/base/j'), sim.getObject('/base/f')
                l, w = sim.getObject('/base/j/l'), sim.getObject('/base/f/w')
            end
            function sysCall_actuation()
                n = n + 1
                if n == 5 then sim.setObjectParent(l, -1, true) sim.setObjectParent(w, -1, true) end
            end
            function sysCall_sensing()
                local _, force, torque = sim.readForceSensor(f)
                print(string.format('load %.6f %.6f %.6f %.6f', sim.getJointForce(j), sim.getJointVelocity(j), force[3], torque[2]))
            end",
        );
    let err = scene_of(&scene).run(&["--steps", "10"]).good().err;
    let loads: Vec<Vec<f64>> = err
        .lines()
        .filter_map(|l| l.split_once("load "))
        .map(|(_, l)| l.split(' ').map(|x| x.trim().parse().unwrap()).collect())
        .collect();
    assert!(loads.len() >= 10, "{err}");
    near("torque", loads[3][0].abs(), G * 0.25, 1e-3);
    near("force", loads[3][2], -2.0 * G, 0.05);
    for after in &loads[4..] {
        assert_eq!(*after, vec![0.0; 4]);
    }
}
