//! The fastest traversal of a path: `sim.generateTimeOptimalTrajectory`.

use tatu_trajectories::{AxisBounds, PathTiming, Spline};

use crate::kit::*;

/// Parts of the path for which limits are checked.
const PARTS: usize = 2000;

/// Most samples of a trajectory.
const MAX_SAMPLES: i64 = 1_000_000;

pub(crate) fn offer(offer: &mut Offer<Vrep>) {
    offer.command(
        Cmd::new("sim.generateTimeOptimalTrajectory", |c| {
            let (path, lengths) = (floats(c, 0)?, floats(c, 1)?);
            let (velocities, accelerations) = (floats(c, 2)?, floats(c, 3)?);
            let count = path.len().checked_div(lengths.len()).unwrap_or(0);
            for (i, limits) in [(3, &velocities), (4, &accelerations)] {
                if limits.len() != 2 * count {
                    return Err(Fail::argument(format!(
                        "argument {i}: bad table size: a path with {count} columns needs {} numbers, a minimum and a \
                         maximum for each column, but there are {}",
                        2 * count,
                        limits.len()
                    )));
                }
            }
            let samples = int_or(c, 4, 1000)?;
            if !(2..=MAX_SAMPLES).contains(&samples) {
                return Err(Fail::argument(format!(
                    "argument 5: expected a number of samples from 2 to {MAX_SAMPLES}"
                )));
            }
            check_result_size(samples as usize, count)?;
            if let Some(boundary) = c.arg(5).as_str().filter(|b| b != "not-a-knot") {
                return Err(Fail::unsupported(format!("the boundary condition {boundary:?} is not supported"))
                    .help("use 'not-a-knot', the default"));
            }
            let spline = Spline::new(&lengths, count, &path).ok_or_else(|| {
                Fail::argument(
                    "arguments 1 and 2: expected at least two configurations of finite numbers, at lengths that ascend",
                )
            })?;
            let pair = |list: &[f64], k: usize| [list[2 * k], list[2 * k + 1]];
            let bounds: Vec<AxisBounds> = (0..count)
                .map(|k| AxisBounds { velocity: pair(&velocities, k), acceleration: pair(&accelerations, k) })
                .collect();
            let timing = PathTiming::new(&spline, &bounds, PARTS).map_err(|e| Fail::argument(e.to_string()))?;
            let times: Vec<f64> = (0..samples).map(|k| timing.duration() * k as f64 / (samples - 1) as f64).collect();
            let points: Vec<f64> = times.iter().flat_map(|t| spline.at(timing.parameter_at(*t)).position).collect();
            c.ret(&points[..]);
            c.ret(&times[..]);
            Ok(())
        })
        .param(table("path", "concatenated configurations"))
        .param(table("lengths", "distance of each configuration along the path, ascending"))
        .param(table("minMaxVel", "minimum and maximum velocity of each column"))
        .param(table("minMaxAccel", "minimum and maximum acceleration of each column"))
        .param(Param::int("samples").default(1000).optional().text("number of points of the result"))
        .param(Param::any("boundary").optional().text("'not-a-knot'"))
        .param(Param::any("timeout").optional().text("ignored: the computation takes some milliseconds"))
        .param(Param::any("script").optional().text("ignored"))
        .returns(Param::list("points").text("concatenated configurations at equal intervals of time"))
        .returns(Param::list("times").unit("s").text("time of each point"))
        .text(
            "Returns the fastest motion along a smooth curve through the configurations of a path, from rest to rest, \
             within limits of velocity and acceleration.",
        ),
    );
}
