//! Path objects of old scenes: their control points, and positions along the curve through them. Since V-REP 4.2, paths
//! are dummies.

use super::tables as paths;
use crate::kit::{
    algebra::{self as al, Pose},
    *,
};

const NOTES: &str = "Corners are rounded as set in the scene; a path created by a script consists of straight segments \
                     between its control points. Velocities and virtual distances are ignored. A dummy without control \
                     points is a path of one point.";

pub(crate) fn offer(offer: &mut Offer<Vrep>) {
    let path = || flagged("path");
    let along = || Param::float("along").text("0: the beginning, 1: the end");
    offer.command(
        both(["sim.createPath", "simCreatePath"], MINUS_ONE, |c| {
            // Since 4.2, a path is a dummy, and the first argument contains the control points, 7 numbers each.
            let modern = is_table(c.arg(0));
            let dummy = c.world().create(if modern { "dummy" } else { "path" }, 0, "Path")?;
            if modern {
                let all = floats(c, 0)?;
                let points: Vec<Pose> = all.chunks_exact(7).map(|p| std::array::from_fn(|i| p[i])).collect();
                let closed = c.arg(1).as_i64().unwrap_or(0) & 2 != 0;
                write(c, dummy, &PathShape { points, rounding: Vec::new(), closed })?;
            } else {
                let attributes = if c.has(0) { c.i64(0)? } else { 0 };
                write(
                    c,
                    dummy,
                    &PathShape {
                        points: Vec::new(),
                        rounding: Vec::new(),
                        closed: attributes > 0 && attributes & 4 != 0,
                    },
                )?;
            }
            c.ret(handle(dummy));
            Ok(())
        })
        .param(Param::any("points").text("7 numbers per control point; in old scripts, the attributes"))
        .param(Param::any("more").rest().text("options: 2 closes the path; others are ignored"))
        .returns(Param::int("path"))
        .text("Creates a path.")
        .partial(NOTES),
    );
    offer.command(
        both(["sim.insertPathCtrlPoints", "simInsertPathCtrlPoints"], MINUS_ONE, |c| {
            let (id, options, start, count) = (existing_object(c, 0)?.id, c.i64(1)?, c.i64(2)?, c.i64(3)?);
            let size = if options & 2 != 0 { 16 } else { 11 };
            let data = floats(c, 4)?;
            let mut path = read(c, id)?;
            let new: Vec<Pose> = data
                .chunks_exact(size)
                .take(usize::try_from(count).unwrap_or(0))
                .map(|p| al::pose([p[0], p[1], p[2]], al::from_euler([p[3], p[4], p[5]])))
                .collect();
            let at = usize::try_from(start).unwrap_or(0).min(path.points.len());
            path.points.splice(at..at, new);
            path.closed |= options & 1 != 0;
            write(c, id, &path)?;
            c.ret(1_i64);
            Ok(())
        })
        .param(path())
        .param(Param::int("options").text("1: closed, 2: 16 numbers per point instead of 11"))
        .param(Param::int("start").text("from 0"))
        .param(Param::int("count"))
        .param(table("data", "x, y, z, alpha, beta, gamma and further values per point"))
        .returns(Param::int("done"))
        .text("Inserts control points into a path.")
        .partial(NOTES),
    );
    offer.command(
        both(["sim.cutPathCtrlPoints", "simCutPathCtrlPoints"], MINUS_ONE, |c| {
            let (id, start, count) = (existing_object(c, 0)?.id, c.i64(1)?, c.i64(2)?);
            let mut path = read(c, id)?;
            if start < 0 {
                path.points.clear();
            } else {
                let from = (start as usize).min(path.points.len());
                let to = from.saturating_add(usize::try_from(count).unwrap_or(0)).min(path.points.len());
                path.points.drain(from..to);
            }
            write(c, id, &path)?;
            c.ret(1_i64);
            Ok(())
        })
        .param(path())
        .param(Param::int("start").text("from 0; -1: all"))
        .param(Param::int("count"))
        .returns(Param::int("done"))
        .text("Removes control points from a path."),
    );
    let at = |c: &Ctx<'_>| -> Result<Pose> {
        let id = of_path(c)?;
        let own = read(c, id)?.at(c.f64(1)?);
        Ok(al::compose(&c.world().pose(id, 0)?, &own))
    };
    offer.command(
        both(["sim.getPositionOnPath", "simGetPositionOnPath"], NIL, move |c| {
            let p = at(c)?;
            c.ret(&p[..3]);
            Ok(())
        })
        .param(path())
        .param(along())
        .returns(Param::floats("position", 3).unit("m"))
        .text("Returns the world position of a point on a path.")
        .partial(NOTES),
    );
    offer.command(
        both(["sim.getOrientationOnPath", "simGetOrientationOnPath"], NIL, move |c| {
            let p = at(c)?;
            c.ret(&al::to_euler(al::rotation(&p))[..]);
            Ok(())
        })
        .param(path())
        .param(along())
        .returns(Param::floats("angles", 3).unit("rad"))
        .text("Returns the orientation of a path at a position, in the world frame.")
        .partial(NOTES),
    );
    offer.command(
        both(["sim.getDataOnPath", "simGetDataOnPath"], NIL, |c| {
            of_path(c)?;
            c.ret(0_i64);
            c.ret(&[0.0; 4][..]);
            Ok(())
        })
        .param(path())
        .param(along())
        .returns(Param::int("flags"))
        .returns(Param::floats("channels", 4))
        .text("Returns zeros: auxiliary data of paths is not supported.")
        .stub("auxiliary data of control points is not stored"),
    );
    offer.command(
        both(["sim.getPathLength", "simGetPathLength"], NIL, |c| {
            let length = read(c, of_path(c)?)?.length();
            c.ret(length);
            Ok(())
        })
        .param(path())
        .returns(Param::float("length").unit("m"))
        .text("Returns the length of a path.")
        .partial(NOTES),
    );
    offer.command(
        both(["sim.getPathPosition", "simGetPathPosition"], NIL, |c| {
            let id = of_path(c)?;
            let at = tags::number(c, id, "path position")?.unwrap_or(0.0);
            c.ret(at);
            Ok(())
        })
        .param(path())
        .returns(Param::float("position").unit("m"))
        .text("Returns the position on a path that was last set."),
    );
    offer.command(
        both(["sim.setPathPosition", "simSetPathPosition"], MINUS_ONE, |c| {
            let (id, x) = (of_path(c)?, c.f64(1)?);
            tags::set_number(c, id, "path position", x)?;
            finish_setter(c)
        })
        .param(path())
        .param(Param::float("position").unit("m"))
        .text("Sets the current position on a path.")
        .partial("The position is only stored; no object moves along the path automatically."),
    );
    offer.command(
        both(["sim.getClosestPositionOnPath", "simGetClosestPositionOnPath"], NIL, |c| {
            let id = of_path(c)?;
            let (path, p) = (read(c, id)?, numbers::<3>(c, 1)?);
            let points: Vec<[f64; 3]> = path.line().iter().map(al::position).collect();
            let (i, t) = paths::nearest(&points, p);
            let lengths = path.lengths();
            let next = lengths.get(i + 1).copied().unwrap_or(lengths[i]);
            let total = path.length();
            c.ret(if total > 0.0 { (lengths[i] + (next - lengths[i]) * t) / total } else { 0.0 });
            Ok(())
        })
        .param(path())
        .param(table("point", "{x, y, z} in the path's frame"))
        .returns(Param::float("along").text("0 to 1"))
        .text("Returns the position on a path that is closest to a point.")
        .partial(NOTES),
    );
    offer.command(
        both(["sim.followPath", "simFollowPath"], NIL, follow_path)
            .param(flagged("object"))
            .param(path())
            .param(Param::int("what").default(3).optional().text("1: position, 2: orientation, 3: both"))
            .param(Param::float("start").default(0.0).optional().text("0 to 1: starting position"))
            .param(Param::float("velocity").unit("m/s").default(0.1).optional())
            .param(Param::float("acceleration").default(0.0).optional().text("ignored"))
            .returns(Param::float("left").unit("s").text("the unused part of the last step"))
            .text("Moves an object along a path.")
            .no_wait("the motion takes several steps, and only a thread can wait for them: call this in a thread")
            .partial("The motion has constant velocity, in straight lines between control points."),
    );
}

/// Returns whether a dummy was created as a path.
pub(crate) fn is_path(c: &SharedCtx<'_>, id: tatu_object) -> bool {
    tags::private(c, id, "path").is_ok_and(|p| p.is_some())
}

fn of_path(c: &Ctx<'_>) -> Result<tatu_object> {
    let o = existing_object(c, 0)?;
    match o.kind {
        TATU_KIND_DUMMY | TATU_KIND_PATH => Ok(o.id),
        _ => Err(Fail::argument(format!("object {} `{}` is not a path", o.handle(), path(c, o.id)))),
    }
}

/// The shape of a path, in the frame of the path object.
struct PathShape {
    points: Vec<Pose>,
    /// For each control point, the fractions of half the adjacent segments that are rounded, before and after it, and
    /// the number of positions on the rounding. Empty if corners are not rounded.
    rounding: Vec<[f64; 3]>,
    closed: bool,
}

impl PathShape {
    /// Returns the vertices of the polyline that approximates the path.
    fn line(&self) -> Vec<Pose> {
        let n = self.points.len();
        if n == 0 {
            return vec![al::IDENTITY];
        }
        let mut line = Vec::new();
        for (i, p) in self.points.iter().enumerate() {
            let inner = self.closed || i > 0 && i + 1 < n;
            match self.rounding.get(i) {
                Some([before, after, places]) if inner && n > 2 && *places > 1.0 => {
                    let from = al::interpolate(p, &self.points[(i + n - 1) % n], *before / 2.0);
                    let to = al::interpolate(p, &self.points[(i + 1) % n], *after / 2.0);
                    // A quadratic Bézier curve whose middle control point is `p`.
                    line.extend((0..=*places as usize).map(|k| {
                        let t = k as f64 / places.trunc();
                        al::interpolate(&al::interpolate(&from, p, t), &al::interpolate(p, &to, t), t)
                    }));
                }
                _ => line.push(*p),
            }
        }
        if self.closed {
            line.push(line[0]);
        }
        line
    }
    fn lengths(&self) -> Vec<f64> {
        let (mut out, mut sum) = (vec![0.0], 0.0);
        for pair in self.line().windows(2) {
            sum += al::length(al::sub(al::position(&pair[1]), al::position(&pair[0])));
            out.push(sum);
        }
        out
    }
    fn length(&self) -> f64 {
        self.lengths().last().copied().unwrap_or(0.0)
    }
    /// Returns the pose at a fraction of the path's length.
    fn at(&self, along: f64) -> Pose {
        let (line, lengths) = (self.line(), self.lengths());
        let t = along.clamp(0.0, 1.0) * self.length();
        let i = lengths.partition_point(|l| *l <= t).clamp(1, lengths.len().max(2) - 1) - 1;
        let (Some(a), Some(b)) = (line.get(i), line.get(i + 1)) else { return line[0] };
        let way = lengths[i + 1] - lengths[i];
        al::interpolate(a, b, if way > 0.0 { ((t - lengths[i]) / way).clamp(0.0, 1.0) } else { 0.0 })
    }
}

fn is_kind(c: &Ctx<'_>, id: tatu_object) -> bool {
    c.world().look(id).is_ok_and(|o| o.kind == TATU_KIND_PATH)
}

fn read(c: &Ctx<'_>, id: tatu_object) -> Result<PathShape> {
    let p = &c.plugin().p;
    let sevens = |numbers: &[f64]| numbers.chunks_exact(7).map(|p| std::array::from_fn(|i| p[i])).collect();
    if is_kind(c, id) {
        let points = c.world().get(id, p.path_points)?.numbers().unwrap_or_default();
        let rounding = c.world().get(id, p.path_rounding)?.numbers().unwrap_or_default();
        let rounding = rounding.chunks_exact(3).map(|r| [r[0], r[1], r[2]]).collect();
        return Ok(PathShape { points: sevens(&points), rounding, closed: bool_of(c, id, p.path_closed)? });
    }
    let text = tags::private(c, id, "path")?.unwrap_or_default();
    let text = String::from_utf8_lossy(&text).into_owned();
    let numbers: Vec<f64> = text.split(' ').filter_map(|t| t.parse().ok()).collect();
    let points = sevens(numbers.get(1..).unwrap_or_default());
    Ok(PathShape { points, rounding: Vec::new(), closed: numbers.first() == Some(&1.0) })
}

fn write(c: &Ctx<'_>, id: tatu_object, path: &PathShape) -> Result {
    let p = &c.plugin().p;
    let numbers: Vec<f64> = path.points.iter().flatten().copied().collect();
    if is_kind(c, id) {
        let rounding = if path.rounding.len() == path.points.len() { path.rounding.concat() } else { Vec::new() };
        c.world().set(id, p.path_rounding, &Value::Floats(rounding))?;
        c.world().set(id, p.path_closed, &Value::Bool(path.closed))?;
        return c.world().set(id, p.path_points, &Value::Floats(numbers));
    }
    let mut text = String::from(if path.closed { "1" } else { "0" });
    numbers.iter().for_each(|x| text += &format!(" {x}"));
    tags::set_private(c, id, "path", Some(text.as_bytes()))
}

/// Advances an object along a path by one step. The host calls this again in each step until the motion ends; the
/// number passed to `wait_steps` is the key of the motion in `follows`.
fn follow_path(c: &mut Ctx<'_>) -> Result<Outcome> {
    let (w, dt) = (c.world(), c.world().f64(0, c.plugin().p.dt)?);
    let word = match c.resumed() {
        0 => {
            if !c.can_wait() {
                return Err(Fail::unsupported(
                    "the motion takes several steps, but the calling script is not threaded",
                ));
            }
            let (object, path) = (existing_object(c, 0)?.id, existing_object(c, 1)?.id);
            let start = if c.has(3) { c.f64(3)? } else { 0.0 };
            let v = if c.has(4) { c.f64(4)? } else { 0.1 };
            let mut state = crate::state::state(c)?;
            state.motion.moved += 1;
            let number = state.motion.moved;
            let what = int_or(c, 2, 3)?;
            state.motion.follows.insert(number, (object, path, what, start, v));
            number
        }
        word => word as i64,
    };
    let found = crate::state::state(c)?.motion.follows.get(&word).copied();
    let Some((object, path, what, along, v)) = found else {
        return Err(Fail::new("the motion along the path no longer exists"));
    };
    let length = read(c, path)?.length();
    let next = if length > 0.0 { along + v * dt / length } else { 1.0 };
    let at = al::compose(&w.pose(path, 0)?, &read(c, path)?.at(next));
    let now = w.pose(object, 0)?;
    let p = if what & 1 != 0 { al::position(&at) } else { al::position(&now) };
    let q = if what & 2 != 0 { al::rotation(&at) } else { al::rotation(&now) };
    w.set_pose(object, 0, &al::pose(p, q))?;
    let arrived = next >= 1.0 || v <= 0.0;
    {
        let mut state = crate::state::state(c)?;
        if arrived {
            state.motion.follows.remove(&word);
        } else if let Some(f) = state.motion.follows.get_mut(&word) {
            f.3 = next;
        }
    }
    if arrived {
        let over = if v > 0.0 { ((next - 1.0) * length / v).clamp(0.0, dt) } else { 0.0 };
        c.ret(over);
        return Ok(Outcome::Done);
    }
    c.wait_steps(1, word as u64)
}
