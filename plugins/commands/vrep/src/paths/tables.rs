//! Commands on paths as plain tables of configurations: lengths, interpolation, the closest point.

use crate::kit::*;

pub(crate) fn offer(offer: &mut Offer<Vrep>) {
    let path = || table("path", "concatenated configurations");
    let lengths = || table("lengths", "distance of each configuration along the path, from sim.getPathLengths");
    let types =
        || Param::any("types").optional().text("per element, 0: linear, 1: cyclic angle, 2: part of a quaternion");
    offer.command(
        Cmd::new("sim.getPathLengths", |c| {
            let (path, n) = (floats(c, 0)?, dimension(c, 1)?);
            let configs: Vec<&[f64]> = path.chunks_exact(n).collect();
            let way = if c.has(2) { c.arg(2).as_func() } else { None };
            let (mut out, mut sum) = (vec![0.0], 0.0);
            for pair in configs.windows(2) {
                sum += match way {
                    Some(f) => {
                        let given =
                            c.call_func(f, &[Value::Floats(pair[0].to_vec()), Value::Floats(pair[1].to_vec())])?;
                        match given.first() {
                            Some(Value::Float(x)) => *x,
                            Some(Value::Int(i)) => *i as f64,
                            _ => return Err(Fail::argument("the distance function did not return a number")),
                        }
                    }
                    None => {
                        // Configurations of 7 numbers are poses; their distance is that of their positions.
                        let k = if n == 7 { 3 } else { n };
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
        .param(Param::any("distance").optional().text("a function of two configurations"))
        .returns(Param::list("lengths"))
        .returns(Param::float("total"))
        .text("Returns the distance along a path of each of its configurations."),
    );
    offer.command(
        Cmd::new("sim.getPathInterpolatedConfig", |c| {
            let (path, lengths, t) = (floats(c, 0)?, floats(c, 1)?, c.f64(2)?);
            let at = config_at(&path, &lengths, t, &c.arg(4).numbers().unwrap_or_default())?;
            c.ret(&at[..]);
            Ok(())
        })
        .param(path())
        .param(lengths())
        .param(Param::float("at").text("distance along the path"))
        .param(Param::any("method").optional().text("ignored: interpolation is linear"))
        .param(types())
        .returns(Param::list("config"))
        .text("Returns the configuration at a position on a path.")
        .partial("Interpolation between configurations is always linear, regardless of the method."),
    );
    offer.command(
        Cmd::new("sim.resamplePath", |c| {
            let (path, lengths) = (floats(c, 0)?, floats(c, 1)?);
            let n = usize::try_from(c.i64(2)?).ok().filter(|n| (2..=1_000_000).contains(n));
            let n =
                n.ok_or_else(|| Fail::argument("argument 3: expected a number of configurations from 2 to 1000000"))?;
            let total = lengths.last().copied().unwrap_or(0.0);
            let types = c.arg(4).numbers().unwrap_or_default();
            let mut out = Vec::new();
            for i in 0..n {
                out.extend(config_at(&path, &lengths, total * i as f64 / (n - 1) as f64, &types)?);
            }
            c.ret(&out[..]);
            Ok(())
        })
        .param(path())
        .param(lengths())
        .param(Param::int("count").text("number of configurations"))
        .param(Param::any("method").optional().text("ignored: interpolation is linear"))
        .param(types())
        .returns(Param::list("path"))
        .text("Returns a path with the given number of evenly spaced configurations.")
        .partial("Interpolation between configurations is always linear, regardless of the method."),
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

pub(crate) fn floats(c: &Ctx<'_>, i: usize) -> Result<Vec<f64>> {
    c.arg(i).numbers().ok_or_else(|| Fail::argument(format!("argument {}: expected a table of numbers", i + 1)))
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

/// Wraps an angle to -pi..pi.
fn wrap_angle(a: f64) -> f64 {
    let full = std::f64::consts::TAU;
    a - full * (a / full).round()
}

/// Returns the configuration at position `t` along a path.
fn config_at(path: &[f64], lengths: &[f64], t: f64, types: &[f64]) -> Result<Vec<f64>> {
    let n = path.len().checked_div(lengths.len()).unwrap_or(0);
    if n == 0 || path.len() != n * lengths.len() {
        return Err(Fail::argument(format!(
            "{} numbers do not form a path of {} configurations",
            path.len(),
            lengths.len()
        )));
    }
    let i = lengths.partition_point(|l| *l <= t).clamp(1, lengths.len().max(2) - 1) - 1;
    let config = |i: usize| &path[i.min(lengths.len() - 1) * n..][..n];
    let (a, b) = (config(i), config(i + 1));
    let (from, to) = (lengths[i], lengths.get(i + 1).copied().unwrap_or(lengths[i]));
    let u = if to > from { ((t - from) / (to - from)).clamp(0.0, 1.0) } else { 0.0 };
    let mut out: Vec<f64> = (0..n)
        .map(|k| {
            let d = if types.get(k) == Some(&1.0) { wrap_angle(b[k] - a[k]) } else { b[k] - a[k] };
            a[k] + d * u
        })
        .collect();
    // Quaternions are interpolated along the shorter rotation, then normalized.
    let quaternion = if types.is_empty() && n == 7 { Some(3) } else { types.iter().position(|t| *t == 2.0) };
    if let Some(q) = quaternion.filter(|q| q + 4 <= n) {
        let same: f64 = (q..q + 4).map(|k| a[k] * b[k]).sum();
        let sign = if same < 0.0 { -1.0 } else { 1.0 };
        (q..q + 4).for_each(|k| out[k] = a[k] * (1.0 - u) + sign * b[k] * u);
        let l = out[q..q + 4].iter().map(|x| x * x).sum::<f64>().sqrt().max(1e-300);
        (q..q + 4).for_each(|k| out[k] /= l);
    }
    Ok(out)
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
