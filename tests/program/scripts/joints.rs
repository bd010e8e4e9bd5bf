//! Tests of scripts that change the limits of joints.

use crate::kit::*;

/// An arm on a motor whose limits a script changes to ones that exclude the position of the joint. The position that the
/// joint reports is compared with the angle between the bodies that it connects.
#[test]
fn limits_that_exclude_the_position_move_the_link() {
    let scene = "gravity_m_s2 = [0, 0, 0]
[[object]]
kind = \"shape\"
alias = \"base\"
size_m = [0.2, 0.2, 0.2]
[[object]]
kind = \"joint\"
alias = \"joint\"
parent = \"/base\"
control = \"position\"
max_force_nm = 50.0
max_velocity_rad_s = 2.0
[[object]]
kind = \"shape\"
alias = \"arm\"
parent = \"/base/joint\"
dynamic = true
mass_kg = 1.0
position_m = [0.3, 0, 0]
";
    let script = watcher(
        "probe",
        "function sysCall_init()
            joint, arm = sim.getObject('/base/joint'), sim.getObject('/base/joint/arm')
            sim.setJointInterval(joint, false, { 0.5, 1 })
        end
        function sysCall_sensing()
            local p, t = sim.getObjectPosition(arm), sim.getSimulationTime()
            if math.abs(t - 0.5) < 1e-6 then sim.setJointTargetPosition(joint, 1.2) end
            print(string.format('angles %.4f %.6f %.6f', t, sim.getJointPosition(joint), math.atan(p[2], p[1])))
        end",
    );
    let err = TestFolder::scene(&format!("{scene}{script}")).run(&["--seconds", "3"]).good().err;
    let lines: Vec<[f64; 3]> = err
        .lines()
        .filter_map(|l| l.split_once("angles "))
        .map(|(_, l)| l.split(' ').map(|x| x.trim().parse().unwrap()).collect::<Vec<f64>>().try_into().unwrap())
        .collect();
    assert!(lines.len() > 50, "{err}");
    for [t, position, angle] in &lines {
        assert!((position - angle).abs() < 1e-4, "{t}: {position} {angle}");
    }
    // The interval is that of the lowest position and its range.
    assert!((lines[0][1] - 0.5).abs() < 0.02, "{:?}", lines[0]);
    assert!((lines.last().unwrap()[1] - 1.2).abs() < 1e-3, "{:?}", lines.last());
}
