//! Commands on paths as plain tables of configurations: lengths, interpolation, the closest point.

use super::interpolation::{Curve, PathTable, wrap_angle};
use crate::kit::*;

pub(crate) fn offer(offer: &mut Offer<Vrep>) {
    let path = || table("path", "concatenated configurations");
    let lengths = || table("lengths", "distance of each configuration along the path, from sim.getPathLengths");
    let method = || {
        Param::any("method").optional().text(
            "a table with type: 'linear' or 'quadraticBezier', strength (0.05 to 1), and forceOpen: true if the first and \
             the last configuration are equal but the path shall not bend there",
        )
    };
    let types =
        || Param::any("types").optional().text("per element, 0: linear, 1: cyclic angle, 2: part of a quaternion");
    offer.command(
        Cmd::new("sim.getPathLengths", |c| {
            let (path, n) = (floats(c, 0)?, dimension(c, 1)?);
            if path.len() % n != 0 {
                return Err(Fail::argument(format!(
                    "argument 1: {} numbers do not form configurations of {n} elements",
                    path.len()
                )));
            }
            let dof = Value::Int(n as i64);
            let configs: Vec<&[f64]> = path.chunks_exact(n).collect();
            let way = if c.has(2) { c.arg(2).as_func() } else { None };
            let (mut out, mut sum) = (vec![0.0], 0.0);
            for pair in configs.windows(2) {
                sum += match way {
                    Some(f) => {
                        let [a, b] = [pair[0], pair[1]].map(|p| Value::Floats(p.to_vec()));
                        let given = c.call_func(f, &[a, b, dof.clone()])?;
                        match given.first() {
                            Some(Value::Float(x)) => *x,
                            Some(Value::Int(i)) => *i as f64,
                            _ => return Err(Fail::argument("the distance function did not return a number")),
                        }
                    }
                    None => {
                        let k = n.min(3);
                        distance(&pair[0][..k], &pair[1][..k])
                    }
                };
                out.push(sum);
            }
            c.ret(&out[..]);
            c.ret(sum);
            Ok(())
        })
        .param(path())
        .param(Param::int("dof").text("number of elements of a configuration"))
        .param(Param::any("distance").optional().text("a function of two configurations and their number of elements; by default the distance of their first three elements"))
        .returns(Param::list("lengths"))
        .returns(Param::float("total"))
        .text("Returns the distance along a path of each of its configurations."),
    );
    offer.command(
        Cmd::new("sim.getPathInterpolatedConfig", |c| {
            let (path, lengths, t) = (floats(c, 0)?, floats(c, 1)?, c.f64(2)?);
            if t.is_nan() {
                return Err(Fail::argument("argument 3: expected a distance along the path, found NaN"));
            }
            let (curve, types) = (curve(c, 3)?, c.arg(4).numbers().unwrap_or_default());
            let at = PathTable::new(&path, &lengths, &types)?.at(t, curve);
            c.ret(&at[..]);
            Ok(())
        })
        .param(path())
        .param(lengths())
        .param(Param::float("at").text("distance along the path"))
        .param(method())
        .param(types())
        .returns(Param::list("config"))
        .text("Returns the configuration at a position on a path."),
    );
    offer.command(
        Cmd::new("sim.resamplePath", |c| {
            let (path, lengths) = (floats(c, 0)?, floats(c, 1)?);
            let n = usize::try_from(c.i64(2)?).ok().filter(|n| (2..=1_000_000).contains(n));
            let n =
                n.ok_or_else(|| Fail::argument("argument 3: expected a number of configurations from 2 to 1000000"))?;
            let total = lengths.last().copied().unwrap_or(0.0);
            let (curve, types) = (curve(c, 3)?, c.arg(4).numbers().unwrap_or_default());
            let table = PathTable::new(&path, &lengths, &types)?;
            check_result_size(n, path.len() / lengths.len().max(1))?;
            let mut out = Vec::new();
            for i in 0..n {
                out.extend(table.at(total * i as f64 / (n - 1) as f64, curve));
            }
            c.ret(&out[..]);
            Ok(())
        })
        .param(path())
        .param(lengths())
        .param(Param::int("count").text("number of configurations"))
        .param(method())
        .param(types())
        .returns(Param::list("path"))
        .text("Returns a path with the given number of evenly spaced configurations."),
    );
    offer.command(
        Cmd::new("sim.getClosestPosOnPath", |c| {
            let (path, lengths, p) = (floats(c, 0)?, floats(c, 1)?, numbers::<3>(c, 2)?);
            let n = path.len().checked_div(lengths.len()).unwrap_or(0);
            if n < 3 {
                return Err(Fail::argument("argument 1: expected at least 3 numbers for each element of argument 2"));
            }
            let points: Vec<[f64; 3]> = path.chunks_exact(n).map(|q| [q[0], q[1], q[2]]).collect();
            let (i, t) = nearest(&points, p);
            let next = lengths.get(i + 1).copied().unwrap_or(lengths[i]);
            c.ret(lengths[i] + (next - lengths[i]) * t);
            Ok(())
        })
        .param(path())
        .param(lengths())
        .param(table("point", "{x, y, z}"))
        .returns(Param::float("at").text("distance along the path"))
        .text("Returns the position on a path that is closest to a point."),
    );
    offer.command(
        Cmd::new("sim.getConfigDistance", |c| {
            let (a, b) = (floats(c, 0)?, floats(c, 1)?);
            if a.len() != b.len() {
                return Err(Fail::argument("arguments 1 and 2: expected configurations of the same length"));
            }
            let (metric, types) = (c.arg(2).numbers().unwrap_or_default(), c.arg(3).numbers().unwrap_or_default());
            let sum: f64 = (0..a.len())
                .map(|i| {
                    let d = if types.get(i) == Some(&1.0) { wrap_angle(b[i] - a[i]) } else { b[i] - a[i] };
                    (d * metric.get(i).copied().unwrap_or(1.0)).powi(2)
                })
                .sum();
            c.ret(sum.sqrt());
            Ok(())
        })
        .param(table("a", "a configuration"))
        .param(table("b", "another configuration"))
        .param(Param::any("metric").optional().text("the weight of each element"))
        .param(types())
        .returns(Param::float("distance"))
        .text("Returns the distance between two configurations."),
    );
}

/// Reads how a path runs between its configurations.
fn curve(c: &Ctx<'_>, i: usize) -> Result<Curve> {
    let method = c.arg(i);
    let kind = method.as_str().or_else(|| method.get("type").and_then(|v| v.as_str()));
    match kind.as_deref() {
        None | Some("linear") => Ok(Curve::Linear),
        Some("quadraticBezier") => {
            let strength = method.get("strength").and_then(|v| v.as_f64()).unwrap_or(1.0);
            let open = method.get("forceOpen").is_some_and(|v| v.truthy());
            Ok(Curve::Bezier { strength: if strength.is_nan() { 1.0 } else { strength.clamp(0.05, 1.0) }, open })
        }
        Some(other) => Err(Fail::argument(format!(
            "argument {}: the interpolation method {other:?} is unknown: expected 'linear' or 'quadraticBezier'",
            i + 1
        ))),
    }
}

fn dimension(c: &Ctx<'_>, i: usize) -> Result<usize> {
    usize::try_from(c.i64(i)?)
        .ok()
        .filter(|n| *n > 0)
        .ok_or_else(|| Fail::argument(format!("argument {}: expected a number of at least 1", i + 1)))
}

fn distance(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt()
}

/// Returns the position on a polyline that is closest to `p`: the index of the preceding point, and the fraction of the
/// segment that follows it (0 to 1).
pub(crate) fn nearest(points: &[[f64; 3]], p: [f64; 3]) -> (usize, f64) {
    let mut best = (f64::MAX, 0, 0.0);
    for (i, pair) in points.windows(2).enumerate() {
        let (a, b) = (pair[0], pair[1]);
        let dot = |x: &dyn Fn(usize) -> f64| (0..3).map(|k| x(k) * (b[k] - a[k])).sum::<f64>();
        let long = dot(&|k| b[k] - a[k]);
        let t = if long > 0.0 { (dot(&|k| p[k] - a[k]) / long).clamp(0.0, 1.0) } else { 0.0 };
        let d = (0..3).map(|k| (a[k] + t * (b[k] - a[k]) - p[k]).powi(2)).sum::<f64>();
        if d < best.0 {
            best = (d, i, t);
        }
    }
    (best.1, best.2)
}
