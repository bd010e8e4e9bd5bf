//! Durations and states of motions, compared with those of Ruckig 0.19.4 and TOPP-RA 0.6.10, and limits of random
//! motions.

use tatu_trajectories::{
    AxisBounds, Limits, MotionError, PathTiming, Profile, Spline, State, Synchronization, Trajectory,
};

/// Compares the duration with Ruckig's, to the digits that are known.
fn takes(start: State, target: State, limits: Limits, expected: f64) {
    let profile = Profile::to_position(start, target, &limits).unwrap();
    assert!((profile.duration() - expected).abs() < 2e-9, "{start:?} {target:?}: {} {expected}", profile.duration());
    let end = profile.at(profile.duration() - 1e-9);
    assert!((end.position - target.position).abs() < 1e-8 && (end.velocity - target.velocity).abs() < 1e-7, "{end:?}");
}

#[test]
fn durations_with_limited_jerk_equal_ruckig() {
    let limits = |v, a, j| Limits::symmetric(v, a, j);
    takes(State::at(0.0), State::at(1.0), limits(0.5, 1.0, 10.0), 2.6);
    takes(State::at(0.0), State::at(0.2), limits(5.0, 1.0, 10.0), 1.0);
    takes(State::at(0.0), State::at(0.01), limits(5.0, 10.0, 10.0), 0.317_480_210);
    takes(State::moving(0.0, 0.4), State::at(1.0), limits(0.5, 1.0, 10.0), 2.32);
    takes(State::moving(0.0, -0.4), State::at(1.0), limits(0.5, 1.0, 10.0), 3.2);
    takes(State::moving(0.0, 0.5), State::at(0.05), limits(0.5, 1.0, 10.0), 1.240_312_424);
    takes(State::at(0.0), State::moving(1.0, 0.3), limits(0.5, 1.0, 10.0), 2.36);
    takes(
        State { position: 0.0, velocity: 0.1, acceleration: 0.8 },
        State::at(1.0),
        limits(0.5, 1.0, 10.0),
        2.462_410_667,
    );
    let uneven = Limits { velocity: [-0.25, 0.5], acceleration: [-0.5, 1.0], jerk: 10.0 };
    takes(State::at(0.0), State::at(1.0), uneven, 2.825);
    takes(State::at(0.0), State::at(-1.0), uneven, 4.45);
    let degrees = std::f64::consts::PI / 180.0;
    takes(
        State::at(0.0),
        State::at(-70.1 * degrees),
        limits(180.0 * degrees, 40.0 * degrees, 80.0 * degrees),
        3.194_438_717,
    );
    takes(State::at(0.0), State::at(90.0 * degrees), limits(2.175, 15.0, 7500.0), 0.869_205_208);
}

#[test]
fn durations_with_unlimited_jerk_equal_ruckig() {
    let limits = |v, a| Limits::symmetric(v, a, f64::INFINITY);
    takes(State::at(0.0), State::at(1.0), limits(0.5, 1.0), 2.5);
    takes(State::at(0.0), State::at(0.2), limits(5.0, 1.0), 0.894_427_191);
    takes(State::at(0.0), State::at(0.01), limits(5.0, 10.0), 0.063_245_553);
    takes(State::moving(0.0, 0.4), State::at(1.0), limits(0.5, 1.0), 2.26);
    takes(State::moving(0.0, -0.4), State::at(1.0), limits(0.5, 1.0), 3.06);
    takes(State::moving(0.0, 0.5), State::at(0.05), limits(0.5, 1.0), 1.047_722_558);
    takes(State::at(0.0), State::moving(1.0, 0.3), limits(0.5, 1.0), 2.29);
    takes(State { position: 0.0, velocity: 0.1, acceleration: 0.8 }, State::at(1.0), limits(0.5, 1.0), 2.41);
}

#[test]
fn velocities_are_reached_as_by_ruckig() {
    for (jerk, expected) in [(10.0, 0.8), (f64::INFINITY, 0.7)] {
        let limits = Limits::symmetric(1.0, 1.0, jerk);
        let profile = Profile::to_velocity(State::moving(0.0, -0.2), 0.5, &limits).unwrap();
        assert!((profile.duration() - expected).abs() < 1e-12);
        let slower = Profile::to_velocity_in(State::moving(0.0, -0.2), 0.5, &limits, 2.0).unwrap();
        assert!((slower.duration() - 2.0).abs() < 1e-9);
        let later = profile.at(2.0);
        assert!((later.velocity - 0.5).abs() < 1e-12 && later.acceleration == 0.0);
        assert!((later.position - profile.at(expected).position - 0.5 * (2.0 - expected)).abs() < 1e-9);
    }
}

fn three(synchronization: Synchronization) -> Trajectory {
    Trajectory::to_positions(
        &[State::at(0.0), State::moving(0.0, -0.2), State::at(0.5)],
        &[State::at(1.0), State::at(-0.3), State::at(0.2)],
        &[Limits::symmetric(0.5, 1.0, 10.0), Limits::symmetric(1.0, 2.0, 5.0), Limits::symmetric(0.4, 1.0, 10.0)],
        synchronization,
    )
    .unwrap()
}

#[test]
fn coordinates_arrive_together_or_each_alone() {
    for (synchronization, expected) in
        [(Synchronization::Time, [2.6; 3]), (Synchronization::None, [2.6, 1.078_265, 1.25])]
    {
        for (profile, expected) in three(synchronization).profiles().iter().zip(expected) {
            assert!((profile.duration() - expected).abs() < 1e-6, "{} {expected}", profile.duration());
        }
    }
}

#[test]
fn synchronized_positions_equal_ruckig() {
    let second = |synchronization| {
        let limits = [Limits::symmetric(0.5, 1.0, 10.0); 2];
        let motion =
            Trajectory::to_positions(&[State::at(0.0); 2], &[State::at(1.0), State::at(0.5)], &limits, synchronization);
        let motion = motion.unwrap();
        assert!((motion.duration() - 2.6).abs() < 1e-9);
        [0.5, 1.3, 2.0].map(|t| motion.at(t).last().unwrap().position)
    };
    let close = |a: [f64; 3], b: [f64; 3]| a.iter().zip(b).for_each(|(a, b)| assert!((a - b).abs() < 2e-9, "{a} {b}"));
    close(second(Synchronization::Time), [0.074_621_125, 0.25, 0.403_456_516]);
    close(second(Synchronization::Phase), [0.050_833_333, 0.25, 0.425]);
    close(second(Synchronization::None), [0.101_666_667, 0.468_333_333, 0.5]);
}

#[test]
fn motion_on_a_line_needs_limits_that_allow_it() {
    let limits = [Limits::symmetric(0.5, 1.0, 10.0), Limits::symmetric(0.5, 0.2, 10.0)];
    let motion = |synchronization| {
        Trajectory::to_positions(&[State::at(0.0); 2], &[State::at(1.0), State::at(0.5)], &limits, synchronization)
            .unwrap()
    };
    for synchronization in [Synchronization::Phase, Synchronization::Time] {
        assert!((motion(synchronization).duration() - 3.182_340_905).abs() < 2e-9);
    }
    let pose = |synchronization| {
        let limits = [(0.4, 0.8, 0.6), (0.4, 0.8, 0.6), (0.4, 0.8, 0.6), (1.8, 0.9, 0.8)];
        let limits = limits.map(|(v, a, j)| Limits::symmetric(v, a, j));
        let targets = [0.3, -0.2, 0.1, 0.8].map(State::at);
        Trajectory::to_positions(&[State::at(0.0); 4], &targets, &limits, synchronization).unwrap()
    };
    for (synchronization, x) in [(Synchronization::Phase, 0.049_122), (Synchronization::Time, 0.070_877_168)] {
        let motion = pose(synchronization);
        assert!((motion.duration() - 3.174_802_104).abs() < 2e-9);
        assert!((motion.at(1.0).next().unwrap().position - x).abs() < 2e-9);
    }
}

/// Random numbers from -1 to 1 in a fixed sequence.
struct Random(u64);

impl Random {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }
}

#[test]
fn random_motions_stay_within_limits_and_arrive() {
    let mut random = Random(7);
    for k in 0..20_000 {
        let limits = Limits {
            velocity: [-0.1 - random.next().abs(), 0.1 + random.next().abs()],
            acceleration: [-0.1 - random.next().abs(), 0.1 + random.next().abs()],
            jerk: if k % 3 == 0 { f64::INFINITY } else { 0.5 + 10.0 * random.next().abs() },
        };
        let start = State {
            position: random.next(),
            velocity: 2.0 * random.next(),
            acceleration: if k % 2 == 0 { 0.0 } else { random.next() },
        };
        let target = State::moving(random.next(), 0.1 * random.next());
        let profile = Profile::to_position(start, target, &limits).unwrap_or_else(|e| panic!("{k}: {e}"));
        let end = profile.duration();
        assert!(end.is_finite() && end >= 0.0);
        // The segments, not the exact target, must arrive.
        let arrived = profile.at(end * (1.0 - 1e-12));
        assert!((arrived.position - target.position).abs() < 1e-7, "{k}: {arrived:?} {target:?}");
        assert!((arrived.velocity - target.velocity).abs() < 1e-7, "{k}: {arrived:?} {target:?}");
        let slack = 1e-9;
        let mut inside = limits.velocity.map(|v| v.signum() * slack + v);
        // A start beyond the limits, or accelerating towards them, is brought back first.
        let overshoot =
            if limits.jerk.is_finite() { start.acceleration * start.acceleration / (2.0 * limits.jerk) } else { 0.0 };
        inside[0] = inside[0].min(start.velocity - overshoot - slack);
        inside[1] = inside[1].max(start.velocity + overshoot + slack);
        for i in 0..=100 {
            let state = profile.at(end * f64::from(i) / 100.0);
            assert!((inside[0]..=inside[1]).contains(&state.velocity), "{k}: {state:?} {limits:?}");
        }
        if end > 0.0 && start.velocity == 0.0 {
            let longer = Profile::to_position_in(start, target, &limits, 1.7 * end);
            assert!((longer.unwrap().duration() - 1.7 * end).abs() < 1e-9);
        }
    }
}

#[test]
fn random_rests_are_reached_in_any_longer_time() {
    let mut random = Random(11);
    for k in 0..2_000 {
        let limits =
            Limits::symmetric(0.1 + random.next().abs(), 0.1 + random.next().abs(), 0.5 + 10.0 * random.next().abs());
        let (start, target) = (State::at(random.next()), State::at(random.next()));
        let fastest = Profile::to_position(start, target, &limits).unwrap().duration();
        for factor in [1.0, 1.001, 1.5, 10.0] {
            let profile = Profile::to_position_in(start, target, &limits, factor * fastest);
            let profile = profile.unwrap_or_else(|e| panic!("{k} {factor}: {e}"));
            assert!((profile.duration() - factor * fastest).abs() < 1e-9);
        }
    }
}

#[test]
fn several_coordinates_with_velocities_arrive_together() {
    let mut random = Random(3);
    let mut impossible = 0;
    for _ in 0..2_000 {
        let limits = [0; 3].map(|_| Limits::symmetric(0.5 + random.next().abs(), 0.5 + random.next().abs(), 5.0));
        let starts = [0; 3].map(|_| State::moving(random.next(), 0.4 * random.next()));
        let targets = [0; 3].map(|_| State::moving(random.next(), 0.4 * random.next()));
        match Trajectory::to_positions(&starts, &targets, &limits, Synchronization::Time) {
            Ok(motion) => {
                let end = motion.duration();
                motion.profiles().iter().for_each(|p| assert!((p.duration() - end).abs() < 1e-9));
            }
            Err(MotionError::Duration(_)) => impossible += 1,
            Err(e) => panic!("{e}"),
        }
    }
    assert!(impossible < 20, "{impossible} of 2000 motions cannot be synchronized");
}

#[test]
fn invalid_arguments_are_named() {
    let good = Limits::symmetric(1.0, 1.0, 1.0);
    let error = |limits: Limits| Profile::to_position(State::at(0.0), State::at(1.0), &limits).unwrap_err();
    assert_eq!(error(Limits { jerk: 0.0, ..good }), MotionError::Jerk(0.0));
    assert_eq!(error(Limits { velocity: [-1.0, 0.0], ..good }), MotionError::Velocity([-1.0, 0.0]));
    assert_eq!(error(Limits { acceleration: [0.0, 1.0], ..good }), MotionError::Acceleration([0.0, 1.0]));
    assert_eq!(Profile::to_position(State::at(f64::NAN), State::at(1.0), &good), Err(MotionError::State));
    let fast = Profile::to_position(State::at(0.0), State::moving(1.0, 3.0), &good).unwrap_err();
    assert!(fast.to_string().contains("target velocity 3"), "{fast}");
}

#[test]
fn spline_reproduces_cubic_curves() {
    let cubic = |s: f64| [s * s * s - 2.0 * s * s + 0.5, -s * s * s + s];
    for parameters in [vec![0.0, 1.0, 1.5, 4.0], vec![-1.0, 0.0, 0.25, 1.0, 2.0, 5.0]] {
        let values: Vec<f64> = parameters.iter().flat_map(|s| cubic(*s)).collect();
        let spline = Spline::new(&parameters, 2, &values).unwrap();
        for s in [0.1, 0.9, 1.7] {
            let point = spline.at(s);
            for (a, b) in point.position.iter().zip(cubic(s)) {
                assert!((a - b).abs() < 1e-12, "{a} {b}");
            }
            assert!((point.first[0] - (3.0 * s * s - 4.0 * s)).abs() < 1e-12);
            assert!((point.second[1] + 6.0 * s).abs() < 1e-12);
        }
    }
    assert_eq!(Spline::new(&[0.0, 0.0], 1, &[0.0, 1.0]), None);
}

#[test]
fn straight_paths_last_as_long_as_a_trapezoid() {
    let bounds = AxisBounds { velocity: [-1.0, 1.0], acceleration: [-2.0, 2.0] };
    for (length, expected) in [(1.0, 1.5), (0.25, 0.5_f64.sqrt())] {
        let line = Spline::new(&[0.0, length / 2.0, length], 1, &[0.0, length / 2.0, length]).unwrap();
        let timing = PathTiming::new(&line, &[bounds], 1000).unwrap();
        assert!((timing.duration() - expected).abs() < 1e-6, "{} {expected}", timing.duration());
        assert!((timing.parameter_at(expected / 2.0) - length / 2.0).abs() < 1e-6);
    }
}

#[test]
fn curved_paths_stay_within_limits() {
    let points: Vec<f64> = vec![0.0, 0.0, 1.0, 0.2, 1.0, 1.0, 0.3, 1.4, 0.0, 2.0];
    let path = Spline::new(&[0.0, 1.0, 2.0, 3.0, 4.0], 2, &points).unwrap();
    let bounds = [AxisBounds { velocity: [-1.0, 0.8], acceleration: [-2.0, 1.5] }; 2];
    let timing = PathTiming::new(&path, &bounds, 2000).unwrap();
    let h = timing.duration() / 4000.0;
    let at = |k: i32| path.at(timing.parameter_at(h * f64::from(k))).position;
    for k in 1..4000 {
        let (before, now, after) = (at(k - 1), at(k), at(k + 1));
        for c in 0..2 {
            let velocity = (after[c] - before[c]) / (2.0 * h);
            let acceleration = (after[c] - 2.0 * now[c] + before[c]) / (h * h);
            assert!((-1.001..=0.801).contains(&velocity), "{velocity}");
            assert!((-2.1..=1.6).contains(&acceleration), "{acceleration}");
        }
    }
}
