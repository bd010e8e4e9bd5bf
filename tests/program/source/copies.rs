//! Tests of text that must exist in two places: both copies must be equal.

use std::fs;

use crate::kit::*;

/// The last line of the constants of a controller. The code after it does not depend on the robot.
const LAST_CONSTANT: &str = "local RATE_DAMPING = ";

/// A model is a folder that can be copied alone (docs/decisions/0040), so each flying robot has its own controller.
#[test]
fn controllers_of_flying_robots_differ_only_in_constants() {
    let law = |model: &str| {
        let text = fs::read_to_string(root().join(format!("models/{model}/{model}.lua"))).unwrap();
        let (_, rest) = text.split_once(LAST_CONSTANT).expect(model);
        rest.split_once('\n').unwrap().1.to_owned()
    };
    assert_eq!(law("crazyflie"), law("quadrotor"), "change both, or only the constants above");
}
