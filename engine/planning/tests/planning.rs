//! Tests of the planners on problems whose answers are known.

#![allow(clippy::disallowed_methods, reason = "expected values in tests do not affect results")]

use std::f64::consts::FRAC_PI_2;

use tatu_planning::{
    Algorithm, CarMotion, Goal, Path, PlanError, Problem, Random, Seeds, Settings, Solution, StateSpace, Subspace,
    divide, divide_by_resolution, plan, plan_with_seeds, shorten, smooth,
};

const ALL: [Algorithm; 5] =
    [Algorithm::RrtConnect, Algorithm::Rrt, Algorithm::RrtStar, Algorithm::Prm, Algorithm::PrmStar];

fn square() -> StateSpace {
    StateSpace::reals(&[0.0, 0.0], &[1.0, 1.0]).unwrap()
}
/// A wall from the bottom up to y = 0.8, 0.1 thick.
fn beside_the_wall(p: &[f64]) -> bool {
    !((0.45..=0.55).contains(&p[0]) && p[1] < 0.8)
}
fn solve(
    space: &StateSpace,
    ends: [&[f64]; 2],
    settings: &Settings,
    valid: fn(&[f64]) -> bool,
) -> Result<Solution, PlanError> {
    let problem = Problem { space, start: ends[0], goal: Goal::States(vec![ends[1].to_vec()]) };
    plan(problem, settings, &mut { valid }, &mut |_| true)
}
/// Tests a path with a finer resolution than the planner.
fn assert_free(space: &StateSpace, path: &Path, valid: fn(&[f64]) -> bool) {
    let fine = divide_by_resolution(path, space, 0.004);
    let free = fine.states.iter().filter(|s| valid(s)).count();
    assert!(free * 100 >= fine.states.len() * 98, "{free} of {} states are possible", fine.states.len());
}

#[test]
fn all_methods_go_around_a_wall() {
    let (space, ends) = (square(), [[0.1, 0.1], [0.9, 0.1]]);
    for algorithm in ALL {
        for seed in 1..6 {
            let settings = Settings { algorithm, seed, max_checks: 20_000, ..Settings::default() };
            let found = solve(&space, [&ends[0], &ends[1]], &settings, beside_the_wall).unwrap();
            assert_eq!(found.path.states.first().unwrap(), &ends[0]);
            assert_eq!(found.path.states.last().unwrap(), &ends[1]);
            assert_free(&space, &found.path, beside_the_wall);
            // The shortest: to (0.45, 0.8), to (0.55, 0.8), to the goal.
            let shortest = 2.0 * 0.35_f64.hypot(0.7) + 0.1;
            let length = found.path.length(&space);
            assert!(length > shortest - 0.02, "{algorithm:?}: {length}");
            if matches!(algorithm, Algorithm::RrtStar | Algorithm::PrmStar) {
                assert!(length < 1.15 * shortest, "{algorithm:?}: {length} for {shortest}");
            }
            let again = solve(&space, [&ends[0], &ends[1]], &settings, beside_the_wall).unwrap();
            assert_eq!(again, found, "{algorithm:?}");
        }
    }
}

#[test]
fn shortened_paths_are_nearly_the_shortest() {
    let space = square();
    for seed in 1..20 {
        let settings = Settings { seed, ..Settings::default() };
        let mut path = solve(&space, [&[0.1, 0.1], &[0.9, 0.1]], &settings, beside_the_wall).unwrap().path;
        let before = path.length(&space);
        shorten(&mut path, &space, &settings, &mut beside_the_wall, &mut |_| true).unwrap();
        let shortest = 2.0 * 0.35_f64.hypot(0.7) + 0.1;
        assert!(path.length(&space) <= before && path.length(&space) < 1.1 * shortest, "{}", path.length(&space));
        let corners = path.states.len();
        smooth(&mut path, 3, &space, &settings, &mut beside_the_wall, &mut |_| true).unwrap();
        assert!(path.states.len() > corners && path.length(&space) < 1.1 * shortest);
        assert_free(&space, &path, beside_the_wall);
        assert_eq!(path.states.last().unwrap(), &[0.9, 0.1]);
    }
}

#[test]
fn cars_reach_their_goals_with_all_methods() {
    for motion in [CarMotion::Dubins, CarMotion::SymmetricDubins, CarMotion::ReedsShepp] {
        let space = StateSpace::car([0.0, 0.0], [10.0, 10.0], 0.8, motion).unwrap();
        let valid = |p: &[f64]| {
            p.iter().take(2).all(|x| (0.0..=10.0).contains(x)) && !((4.5..5.5).contains(&p[0]) && p[1] < 7.0)
        };
        for algorithm in ALL {
            let settings = Settings { algorithm, max_checks: 6000, ..Settings::default() };
            let found = solve(&space, [&[2.0, 2.0, FRAC_PI_2], &[8.0, 2.0, -FRAC_PI_2]], &settings, valid);
            let path = found.unwrap_or_else(|e| panic!("{motion:?} {algorithm:?}: {e}")).path;
            assert_free(&space, &path, valid);
        }
    }
}

#[test]
fn rigid_bodies_turn_to_pass() {
    // A bar of half length 0.6 through a gap of width 0.8: only when it points along x.
    let space = StateSpace::se2([-2.0, -2.0], [2.0, 2.0]).unwrap();
    let valid = |s: &[f64]| {
        (-6..=6).all(|i| {
            let along = 0.1 * f64::from(i);
            let (x, y) = (s[0] + along * s[2].cos(), s[1] + along * s[2].sin());
            x.abs() > 0.1 || y.abs() < 0.4
        })
    };
    for algorithm in [Algorithm::RrtConnect, Algorithm::Prm] {
        let settings = Settings { algorithm, resolution: 0.005, ..Settings::default() };
        let path = solve(&space, [&[-1.2, 0.5, FRAC_PI_2], &[1.2, -0.5, FRAC_PI_2]], &settings, valid).unwrap().path;
        assert_free(&space, &path, valid);
    }
}

#[test]
fn regions_are_reached_by_a_single_tree() {
    let space = square();
    let region = |p: &[f64]| (p[0] - 0.9).hypot(p[1] - 0.1) - 0.05;
    let problem = Problem { space: &space, start: &[0.1, 0.1], goal: Goal::Region(Box::new(region)) };
    let found = plan(problem, &Settings::default(), &mut beside_the_wall, &mut |_| true).unwrap();
    assert!(region(found.path.states.last().unwrap()) <= 0.0);
}

#[test]
fn failures_name_their_reason() {
    let space = square();
    let settings = Settings { max_checks: 3000, ..Settings::default() };
    let run = |start: &[f64], goal: &[f64]| solve(&space, [start, goal], &settings, |p| p[0] < 0.45 || p[0] > 0.55);
    assert_eq!(run(&[0.5, 0.1], &[0.9, 0.1]), Err(PlanError::StartInvalid));
    assert_eq!(run(&[-0.5, 0.1], &[0.9, 0.1]), Err(PlanError::StartInvalid));
    assert_eq!(run(&[0.1, 0.1], &[0.5, 0.1]), Err(PlanError::GoalInvalid));
    let text = |r: Result<Solution, PlanError>| r.unwrap_err().to_string();
    assert_eq!(text(run(&[0.1], &[0.9, 0.1])), "the start has 1 numbers; expected 2, those of a state");
    assert_eq!(text(run(&[0.1, 0.1], &[0.9, f64::NAN])), "number 2 of goal 1 is NaN; expected a finite one");
    let Err(PlanError::NotFound { checks, nearest: Some((path, distance)) }) = run(&[0.1, 0.1], &[0.9, 0.1]) else {
        panic!("the wall is closed")
    };
    assert!((3000..3020).contains(&checks) && distance < 0.6);
    assert_eq!(path.states[0], [0.1, 0.1]);
    for algorithm in ALL {
        let settings = Settings { algorithm, ..settings };
        let closed = solve(&space, [&[0.1, 0.1], &[0.9, 0.1]], &settings, |p| p[0] < 0.45 || p[0] > 0.55);
        assert!(matches!(closed, Err(PlanError::NotFound { .. })), "{algorithm:?}");
    }
    let none = Problem { space: &space, start: &[0.1, 0.1], goal: Goal::States(vec![]) };
    assert!(matches!(plan(none, &settings, &mut beside_the_wall, &mut |_| true), Err(PlanError::Argument(_))));
}

#[test]
fn observers_end_a_search() {
    let space = square();
    let problem = Problem { space: &space, start: &[0.1, 0.1], goal: Goal::States(vec![vec![0.9, 0.1]]) };
    let mut reports = 0;
    let closed = &mut |p: &[f64]| p[0] < 0.45 || p[0] > 0.55;
    let ended = plan(problem, &Settings::default(), closed, &mut |progress| {
        reports += 1;
        progress.checks < 2000
    });
    assert!(matches!(ended, Err(PlanError::Cancelled { checks: 2000..3000 })) && reports > 2);
}

#[test]
fn threads_do_not_change_the_path() {
    let space = StateSpace::reals(&[-1.0; 4], &[1.0; 4]).unwrap();
    let mut random = Random::new(9);
    let blocks: Vec<Vec<f64>> = (0..60).map(|_| space.sample(&mut random)).collect();
    let valid = |s: &[f64]| blocks.iter().all(|b| space.distance(b, s) > 0.45);
    let ends: Vec<Vec<f64>> =
        std::iter::repeat_with(|| space.sample(&mut random)).filter(|s| valid(s)).take(2).collect();
    let settings = Settings { range: 0.3, ..Settings::default() };
    let run = |threads| {
        plan_with_seeds(&space, &ends[0], &ends[1..], &settings, Seeds { count: 6, threads }, &|| valid, &|| false)
    };
    let one = run(1).unwrap();
    for _ in 0..10 {
        assert_eq!(run(2).unwrap(), one);
        assert_eq!(run(4).unwrap(), one);
    }
}

#[test]
fn divided_paths_have_their_states_and_the_count() {
    let space = StateSpace::new(vec![(Subspace::Reals { low: vec![0.0], high: vec![10.0] }, 1.0)]).unwrap();
    let path = Path { states: vec![vec![0.0], vec![1.0], vec![4.0], vec![10.0]] };
    for count in [2, 4, 5, 11, 100] {
        let divided = divide(&path, &space, count);
        assert_eq!(divided.states.len(), count.max(4));
        assert!(path.states.iter().all(|s| divided.states.contains(s)));
        assert!(divided.states.windows(2).all(|w| w[0][0] < w[1][0]));
    }
    assert_eq!(divide_by_resolution(&path, &space, 0.1).states.len(), 11);
}
