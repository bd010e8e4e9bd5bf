//! Commands on graphs: samples, streams, curves.
//!
//! Old scripts set the values of the scene's streams by name. Newer scripts add streams and curves, and refer to them
//! by number.

use crate::kit::*;

/// Option bit of a stream that is not drawn.
const INVISIBLE: i64 = 1;

pub(crate) fn offer(offer: &mut Offer<Vrep>) {
    samples(offer);
    streams(offer);
    curves(offer);
}

/// Builds a command with both of its names; failed calls by the flat name return -1.
fn command(names: CommandNames, run: fn(&mut Ctx<'_>) -> Result) -> Cmd {
    both(names, MINUS_ONE, run)
}

fn samples(offer: &mut Offer<Vrep>) {
    offer.command(
        command(["sim.handleGraph", "simHandleGraph"], |c| {
            let time = if c.has(1) { c.f64(1)? } else { c.world().f64(0, c.plugin().p.time)? };
            match c.i64(0)? {
                HANDLE_ALL_EXCEPT_EXPLICIT => c.world().record_graph(0, time)?,
                _ => graphs(c)?.into_iter().try_for_each(|g| c.world().record_graph(g, time))?,
            }
            finish_setter(c)
        })
        .param(flagged("graph").text("a handle, sim.handle_all or sim.handle_all_except_explicit"))
        .param(Param::float("time").unit("s").optional().text("time of the sample; default: simulation time"))
        .returns(Param::int("result").text("1, for scripts from before 4.0"))
        .text(
            "Records a sample of all streams of a graph. A user stream has no value in the sample if none was \
             set since the previous sample.",
        )
        .example("sim.handleGraph(graph, sim.getSimulationTime() + sim.getSimulationTimeStep())"),
    );
    offer.command(
        command(["sim.resetGraph", "simResetGraph"], |c| {
            for graph in graphs(c)? {
                c.world().put_figure(graph, 0, &[])?;
            }
            finish_setter(c)
        })
        .param(flagged("graph").text("a handle, sim.handle_all or sim.handle_all_except_explicit"))
        .returns(Param::int("result").text("1, for scripts from before 4.0"))
        .text("Removes all samples of a graph; its streams and curves remain.")
        .example("sim.resetGraph(graph)"),
    );
    offer.command(
        command(["sim.setGraphUserData", "simSetGraphUserData"], |c| {
            let (graph, name) = (of_kind(c, 0, TATU_KIND_GRAPH)?, c.text(1)?);
            if !bool_of(c, 0, c.plugin().p.running)? {
                return Err(Fail::unsupported("values of user streams can be set only while the simulation runs"));
            }
            let stream = match find(c, graph, TATU_FIGURE_STREAM, &name)? {
                Some(stream) => stream,
                // In a run without a scene, the substitute for a graph has no streams, so the requested one is added.
                None if c.world().makes_stand_ins() => {
                    c.world().add_figure(graph, TATU_FIGURE_STREAM, &map(vec![("name", Value::text(&name))]))?
                }
                None => return Err(Fail::missing(format!("the graph `{}` has no stream `{name}`", path(c, graph)))),
            };
            c.world().put_figure(graph, stream, &[c.f64(2)?])?;
            c.ret(1_i64);
            Ok(())
        })
        .param(object("graph"))
        .param(Param::string("stream").text("its name"))
        .param(Param::float("value"))
        .returns(Param::int("result").text("1"))
        .text("Sets the value that a user stream records in the next sample.")
        .example("sim.setGraphUserData(graph, 'distance', 0.5)"),
    );
}

fn streams(offer: &mut Offer<Vrep>) {
    offer.command(
        Cmd::new("sim.addGraphStream", |c| {
            let graph = of_kind(c, 0, TATU_KIND_GRAPH)?;
            let mut all = vec![
                ("name", Value::text(c.text(1)?)),
                ("unit", Value::text(text_or(c, 2)?)),
                ("hidden", Value::Bool(int_or(c, 3, 0)? & INVISIBLE != 0)),
            ];
            if c.has(4) {
                all.push(("color", color(c, 4)?));
            }
            let id = c.world().add_figure(graph, TATU_FIGURE_STREAM, &map(all))?;
            c.ret(id);
            Ok(())
        })
        .param(object("graph"))
        .param(Param::string("name"))
        .param(Param::string("unit").optional().text("displayed with the values"))
        .param(Param::int("options").default(0).optional().text("1: not drawn; other bits are ignored"))
        .param(table("color", "red, green, blue, 0 to 1; default: automatic").optional())
        .param(Param::any("cyclicRange").optional().text("ignored"))
        .returns(Param::int("stream"))
        .text("Adds a stream to a graph; scripts set the values of the stream.")
        .example("stream = sim.addGraphStream(graph, 'speed', 'm/s')"),
    );
    offer.command(
        Cmd::new("sim.setGraphStreamValue", |c| {
            let graph = of_kind(c, 0, TATU_KIND_GRAPH)?;
            c.world().put_figure(graph, c.i64(1)?, &[c.f64(2)?])?;
            Ok(())
        })
        .param(object("graph"))
        .param(Param::int("stream"))
        .param(Param::float("value"))
        .text("Sets the value that a stream records in the next sample.")
        .example("sim.setGraphStreamValue(graph, stream, 0.3)"),
    );
    offer.command(
        Cmd::new("sim.setGraphStreamTransformation", |c| {
            let (graph, stream) = (of_kind(c, 0, TATU_KIND_GRAPH)?, c.i64(1)?);
            let names = ["raw", "derivative", "integral", "cumulative"];
            let kind = usize::try_from(c.i64(2)?).ok().and_then(|i| names.get(i)).ok_or_else(|| {
                Fail::argument("argument 3: expected 0 (raw), 1 (derivative), 2 (integral) or 3 (cumulative)")
            })?;
            let number = |i: usize, otherwise: f64| if c.has(i) { c.f64(i) } else { Ok(otherwise) };
            let all = map(vec![
                ("transform", Value::text(kind)),
                ("factor", Value::Float(number(3, 1.0)?)),
                ("offset", Value::Float(number(4, 0.0)?)),
                ("window", Value::Int(int_or(c, 5, 1)?)),
            ]);
            c.world().change_figure(graph, stream, &all)?;
            Ok(())
        })
        .param(object("graph"))
        .param(Param::int("stream"))
        .param(Param::int("type").text("0 raw, 1 derivative, 2 integral, 3 cumulative"))
        .param(Param::float("factor").default(1.0).optional())
        .param(Param::float("offset").default(0.0).optional())
        .param(Param::int("window").default(1).optional().text("number of samples for the moving average"))
        .text(
            "Sets how a stream's values are processed: transformed, multiplied by the factor, shifted by the offset, \
             then averaged.",
        )
        .example("sim.setGraphStreamTransformation(graph, stream, 1)"),
    );
}

fn curves(offer: &mut Offer<Vrep>) {
    offer.command(
        Cmd::new("sim.addGraphCurve", add_curve)
            .param(object("graph"))
            .param(Param::string("name"))
            .param(Param::int("dim").text("2 or 3"))
            .param(Param::any("streams").text("a table of `dim` streams; -1: uses the default value instead"))
            .param(table("defaults", "`dim` numbers"))
            .param(Param::string("unit").optional().text("displayed with the values"))
            .param(Param::int("options").default(0).optional().text("ignored"))
            .param(table("color", "red, green, blue, 0 to 1; default: automatic").optional())
            .param(Param::any("width").optional().text("ignored"))
            .returns(Param::int("curve"))
            .text("Adds a curve that plots one stream against another, or three streams in space.")
            .example("curve = sim.addGraphCurve(graph, 'path', 2, {x, y}, {0, 0}, 'm')"),
    );
    offer.command(
        Cmd::new("sim.duplicateGraphCurveToStatic", |c| {
            let graph = of_kind(c, 0, TATU_KIND_GRAPH)?;
            let all = map(vec![("curve", Value::Int(c.i64(1)?)), ("name", Value::text(text_or(c, 2)?))]);
            let id = c.world().add_figure(graph, TATU_FIGURE_COPY, &all)?;
            c.ret(id);
            Ok(())
        })
        .param(object("graph"))
        .param(Param::int("curve"))
        .param(Param::string("name").optional())
        .returns(Param::int("curve").text("the new one"))
        .text("Adds a static copy of a curve in its current state.")
        .example("copy = sim.duplicateGraphCurveToStatic(graph, curve, 'first run')"),
    );
    offer.command(
        Cmd::new("sim.destroyGraphCurve", |c| {
            let graph = of_kind(c, 0, TATU_KIND_GRAPH)?;
            c.world().remove_figure(graph, c.i64(1)?)?;
            Ok(())
        })
        .param(object("graph"))
        .param(Param::int("curve").text("a curve or stream"))
        .text("Removes a curve or stream.")
        .example("sim.destroyGraphCurve(graph, curve)"),
    );
    offer.command(
        Cmd::new("sim.getGraphCurve", get_curve)
            .alias("sim.getGraphCurveData")
            .old_name("simGetGraphCurve", NIL)
            .param(object("graph"))
            .param(Param::int("type").text("0: streams over time, 1: curves in the plane, 2: curves in space"))
            .param(Param::int("index").text("from 0"))
            .returns(Param::string("label").text("no values past the last index"))
            .returns(Param::int("curveType").text("the requested type"))
            .returns(Param::floats("color", 3))
            .returns(Param::floats("x", 0).text("for a stream: times in s"))
            .returns(Param::floats("y", 0).text("for a stream: values"))
            .returns(Param::floats("z", 0).text("empty unless the curve is in space"))
            .returns(Param::floats("minMax", 6).text("minimum and maximum of x, y and z"))
            .returns(Param::int("curve"))
            .returns(Param::int("width").text("2"))
            .text("Returns the samples of a stream, or the points of a curve, without missing values.")
            .example("label, _, _, times, values = sim.getGraphCurve(graph, 0, 0)"),
    );
    offer.command(
        Cmd::new("sim.getGraphInfo", |c| {
            let graph = of_kind(c, 0, TATU_KIND_GRAPH)?;
            let color = |all: [f64; 3]| all;
            let title = text_of(c, graph, c.plugin().p.alias)?;
            c.ret(title.as_str());
            c.ret(0_i64);
            c.ret(&color([1.0, 1.0, 1.0])[..]);
            c.ret(&color([0.0, 0.0, 0.0])[..]);
            Ok(())
        })
        .param(object("graph"))
        .returns(Param::string("title").text("its alias"))
        .returns(Param::int("attributes").text("0"))
        .returns(Param::floats("background", 3))
        .returns(Param::floats("foreground", 3))
        .text("Returns the appearance of a graph: its title and its colours.")
        .example("title = sim.getGraphInfo(graph)"),
    );
}

/// Returns the graphs that argument 0 identifies.
fn graphs(c: &Ctx<'_>) -> Result<Vec<tatu_object>> {
    match c.i64(0)? {
        all @ (HANDLE_ALL | HANDLE_ALL_EXCEPT_EXPLICIT) => {
            let mut found = c.world().list(0, 1 << TATU_KIND_GRAPH, 0)?;
            if all == HANDLE_ALL_EXCEPT_EXPLICIT {
                let explicit = c.plugin().p.graph_explicit;
                found.retain(|g| !bool_of(c, *g, explicit).unwrap_or(false));
            }
            Ok(found)
        }
        _ => Ok(vec![of_kind(c, 0, TATU_KIND_GRAPH)?]),
    }
}

/// Finds a stream or curve by its name.
fn find(c: &Ctx<'_>, graph: tatu_object, what: u32, name: &str) -> Result<Option<i64>> {
    for id in c.world().figures(graph, what)? {
        if name_of(c, graph, id)? == name {
            return Ok(Some(id));
        }
    }
    Ok(None)
}

fn name_of(c: &Ctx<'_>, graph: tatu_object, id: i64) -> Result<String> {
    let map = c.world().figure(graph, id, false)?;
    Ok(map.get("name").and_then(|n| n.as_str().map(|s| s.into_owned())).unwrap_or_default())
}

fn map(entries: Vec<(&str, Value)>) -> Value {
    Value::Map(entries.into_iter().map(|(k, v)| (Value::text(k), v)).collect())
}

fn text_or(c: &Ctx<'_>, i: usize) -> Result<String> {
    if c.has(i) { c.text(i) } else { Ok(String::new()) }
}

/// Returns the colour in argument `i`, each component clamped to 0..1.
pub(crate) fn color(c: &Ctx<'_>, i: usize) -> Result<Value> {
    let rgb: [f64; 3] = numbers(c, i)?;
    Ok(Value::Floats(rgb.iter().map(|x| x.clamp(0.0, 1.0)).collect()))
}

fn add_curve(c: &mut Ctx<'_>) -> Result {
    let (graph, dims) = (of_kind(c, 0, TATU_KIND_GRAPH)?, c.i64(2)?);
    if !(2..=3).contains(&dims) {
        return Err(Fail::argument("argument 3: expected 2 or 3 dimensions"));
    }
    let (streams, defaults) = (c.arg(3), c.arg(4));
    let mut all = vec![("name", Value::text(c.text(1)?)), ("unit", Value::text(text_or(c, 5)?))];
    for (i, axis) in ["x", "y", "z"].into_iter().take(dims as usize).enumerate() {
        let stream = streams.number(i).ok_or_else(|| Fail::argument(format!("argument 4: expected {dims} streams")))?;
        all.push((
            axis,
            match stream {
                s if s < 0.0 => Value::Float(defaults.number(i).unwrap_or(0.0)),
                s => Value::text(name_of(c, graph, s as i64)?),
            },
        ));
    }
    if c.has(7) {
        all.push(("color", color(c, 7)?));
    }
    let id = c.world().add_figure(graph, TATU_FIGURE_CURVE, &map(all))?;
    c.ret(id);
    Ok(())
}

fn get_curve(c: &mut Ctx<'_>) -> Result {
    let (graph, kind, index) = (of_kind(c, 0, TATU_KIND_GRAPH)?, c.i64(1)?, c.i64(2)?);
    let Ok(index) = usize::try_from(index) else {
        return Err(Fail::argument(format!("argument 3: expected an index of at least 0, found {index}")));
    };
    let what = if kind == 0 { TATU_FIGURE_STREAM } else { TATU_FIGURE_CURVE };
    let mut ids = c.world().figures(graph, what)?;
    if kind != 0 {
        let dims = |id: &i64| c.world().figure(graph, *id, false).ok()?.get("dims")?.as_i64();
        ids.retain(|id| dims(id) == Some(kind + 1));
    }
    let Some(id) = ids.get(index).copied() else { return Ok(()) };
    let map = c.world().figure(graph, id, true)?;
    let numbers = |key: &str| map.get(key).and_then(|v| v.numbers()).unwrap_or_default();
    let mut rows: Vec<Vec<f64>> = match kind {
        0 => numbers("times").into_iter().zip(numbers("values")).map(|(t, v)| vec![t, v]).collect(),
        _ => numbers("points").chunks_exact(kind as usize + 1).map(<[f64]>::to_vec).collect(),
    };
    rows.retain(|r| r.iter().all(|x| x.is_finite()));
    let axis = |i: usize| -> Vec<f64> { rows.iter().filter_map(|r| r.get(i)).copied().collect() };
    let axes = [axis(0), axis(1), axis(2)];
    let bounds: Vec<f64> = axes
        .iter()
        .flat_map(|a| match a.is_empty() {
            true => [0.0, 0.0],
            false => {
                [a.iter().copied().fold(f64::INFINITY, f64::min), a.iter().copied().fold(f64::NEG_INFINITY, f64::max)]
            }
        })
        .collect();
    let (label, color) = (name_of(c, graph, id)?, numbers("color"));
    c.ret(label.as_str());
    c.ret(kind);
    c.ret(&color[..]);
    for a in &axes {
        c.ret(&a[..]);
    }
    c.ret(&bounds[..]);
    c.ret(id);
    c.ret(2_i64);
    Ok(())
}
