//! Tests of the joints of imported V-REP scenes.

use super::opacity::{converted, element, singles, vrep_file};

/// Returns a scene with a revolute joint in a mode at 0.5 rad, whose target is 1 rad.
fn joint(mode: i32, motor: u8) -> Vec<u8> {
    let common = [
        element("Ids", [1_i32.to_le_bytes(), (-1_i32).to_le_bytes()].concat()),
        element("Nme", [5_i32.to_le_bytes().as_slice(), b"hinge"].concat()),
        element("Cfq", singles(&[1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0])),
        b"NXT".to_vec(),
    ];
    let own = [
        element("Jtt", 10_i32.to_le_bytes().to_vec()),
        element("Prt", singles(&[0.5])),
        element("Pmr", singles(&[-1.0, 2.0])),
        element("Va9", vec![motor]),
        element("Jmd", mode.to_le_bytes().to_vec()),
        element("Dmp", singles(&[0.0, 40.0])),
        element("Dtp", singles(&[1.0])),
    ];
    vrep_file(element("JNT", [common.concat(), own.concat(), b"EOO".to_vec()].concat()))
}

#[test]
fn hybrid_joints_of_inverse_kinematics_hold_their_position_dynamically() {
    const INVERSE_KINEMATICS: i32 = 2;
    const HYBRID: u8 = 64;
    let text = converted("arm.ttt", &joint(INVERSE_KINEMATICS, HYBRID));
    assert!(text.contains("control = \"position\"") && !text.contains("kinematic"), "{text}");
    assert!(text.contains("max_force_nm = 40"), "{text}");
    // The target is the present position, 0.5 rad.
    assert!(text.contains("target_position_deg = 28.6478"), "{text}");
    // Without the bit, and in other modes, the joint is not driven.
    for (mode, motor) in [(INVERSE_KINEMATICS, 0), (0, HYBRID)] {
        let text = converted("arm.ttt", &joint(mode, motor));
        assert!(text.contains("mode = \"kinematic\""), "{mode}: {text}");
    }
}
