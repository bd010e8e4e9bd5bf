//! A car parks backward between two others.

use tatu_planning::{CarMotion, Goal, Problem, Settings, StateSpace, plan, shorten};

/// Half of the length and width of a car, m.
const HALF: [f64; 2] = [2.0, 0.9];
/// The parked cars, and the wall behind them: centre, and half of the extents, m.
const OBSTACLES: [([f64; 2], [f64; 2]); 3] =
    [([3.0, 1.0], [1.9, 0.9]), ([14.0, 1.0], [1.9, 0.9]), ([8.0, -0.5], [9.0, 0.3])];

/// Returns whether the outline of a car at x, y and yaw touches nothing: points along it, at a distance of 0.2 m.
fn is_free(pose: &[f64]) -> bool {
    let (sine, cosine) = (libm::sin(pose[2]), libm::cos(pose[2]));
    let outline = (-10..=10).flat_map(|i| {
        let share = f64::from(i) / 10.0;
        [[share, 1.0], [share, -1.0], [1.0, share], [-1.0, share]]
    });
    outline.into_iter().all(|[along, across]| {
        let (a, b) = (along * HALF[0], across * HALF[1]);
        let (x, y) = (pose[0] + cosine * a - sine * b, pose[1] + sine * a + cosine * b);
        OBSTACLES.iter().all(|(centre, half)| (x - centre[0]).abs() > half[0] || (y - centre[1]).abs() > half[1])
    })
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let space = StateSpace::car([0.0, 0.0], [17.0, 8.0], 4.5, CarMotion::ReedsShepp)?;
    let (start, goal) = ([3.0, 4.0, 0.0], vec![8.5, 1.0, 0.0]);
    let problem = Problem { space: &space, start: &start, goal: Goal::States(vec![goal]) };
    let settings = Settings { resolution: 0.005, ..Settings::default() };
    let mut found = plan(problem, &settings, &mut is_free, &mut |_| true)?;
    shorten(&mut found.path, &space, &settings, &mut is_free, &mut |_| true)?;
    println!("{:.1} m, by way of:", found.path.length(&space));
    for state in &found.path.states {
        println!("x {:5.2} m  y {:5.2} m  yaw {:5.2} rad", state[0], state[1], state[2]);
    }
    Ok(())
}
