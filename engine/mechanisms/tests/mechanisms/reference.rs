//! Comparison with MuJoCo's results for seven robots, in one random state each.

use tatu_mechanisms::Dynamics;

use super::robots::{ROBOTS, gravity, load};

/// Returns the maximum difference between two lists, relative to the maximum magnitude of `expected` or 1, whichever is
/// greater.
fn error(found: &[f64], expected: &[f64]) -> f64 {
    assert_eq!(found.len(), expected.len());
    let scale = expected.iter().fold(1.0f64, |m, x| m.max(x.abs()));
    found.iter().zip(expected).fold(0.0f64, |m, (a, b)| m.max((a - b).abs())) / scale
}

#[test]
fn mass_matrix_bias_and_acceleration_are_mujocos() {
    for name in ROBOTS {
        let robot = load(name);
        let tree = &robot.tree;
        let n = tree.velocities();
        let mut dynamics = Dynamics::new(tree);
        dynamics.update(tree, &robot.state).unwrap();
        let mut mass = vec![0.0; n * n];
        dynamics.mass_matrix(tree, &mut mass).unwrap();
        let mut bias = vec![0.0; n];
        dynamics.bias(tree, gravity(), &mut bias).unwrap();
        let mut acceleration = vec![0.0; n];
        dynamics.forward(tree, &vec![0.0; n], gravity(), &mut acceleration).unwrap();
        let errors = [error(&mass, &robot.mass), error(&bias, &robot.bias), error(&acceleration, &robot.acceleration)];
        println!("{name:8} mass {:.1e} bias {:.1e} acceleration {:.1e}", errors[0], errors[1], errors[2]);
        assert!(errors[0] < 1e-13 && errors[1] < 1e-13, "{name}: {errors:?}");
        assert!(errors[2] < if name == "chain20" { 1e-10 } else { 1e-11 }, "{name}: {errors:?}");
    }
}
