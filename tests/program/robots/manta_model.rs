//! Tests of the Manta model: its meshes, and the curves by which its front wheels are steered.

use super::flat::{FlatRobot, is_closed};

#[test]
fn meshes_are_closed_and_face_outwards() {
    let car = FlatRobot::new("manta", "");
    let meshes: Vec<_> = car.objects.iter().filter(|o| o.has("mesh")).map(|o| car.mesh(o)).collect();
    assert_eq!(meshes.len(), 2);
    meshes.iter().for_each(is_closed);
}

/// The line through the axle of each front wheel intersects the line of the rear axle at the same point,
/// 0.6 m / tan(steering) to the left.
#[test]
fn front_wheels_turn_about_one_point() {
    let car = FlatRobot::new("manta", "");
    for (side, y) in [("l", 0.175), ("r", -0.175)] {
        let curve = car.get(&format!("f{side}_steer_joint")).numbers("follow_curve");
        assert_eq!(curve.len(), 98, "the curve must have 24 segments to each side");
        assert!((curve[0].to_degrees() + 30.0).abs() < 1e-9 && (curve[96].to_degrees() - 30.0).abs() < 1e-9);
        for pair in curve.chunks(2) {
            let (steering, angle) = (pair[0], pair[1]);
            if steering == 0.0 {
                assert_eq!(angle, 0.0);
                continue;
            }
            let centre = 0.6 / steering.tan();
            assert!((y + 0.6 / angle.tan() - centre).abs() < 1e-9, "{side}: {steering} {angle}");
        }
    }
}
