//! `tatu.host.figures`: streams and curves of graphs, and drawings.

use std::cell::RefCell;

use nalgebra::Isometry3;
use tatu_devices::figures::{Drawing, Figures};
use tatu_errors::Refusal;
use tatu_plugin_api::{abi::*, safe::Value};
use tatu_scene::{
    Scene,
    graph::{CurveSpec, Graph, StreamSpec, parse_static_copy},
};

use super::{
    answer::{AnswerContext, HostResult, busy, fill, on_world, require, slot, with_context, write_value},
    properties::refuse_with,
};
use crate::cell::{HostFunction, WorldCell};
pub static TABLE: tatu_host_figures = tatu_host_figures {
    size: size_of::<tatu_host_figures>() as u32,
    reserved: 0,
    add: Some(add),
    change: Some(change),
    put: Some(put),
    record: Some(record),
    list: Some(list),
    get: Some(get),
    part: Some(super::ui_data::part),
    image: Some(super::ui_data::image),
};

/// The parts of the world that the functions of this table use.
struct FigureContext<'a> {
    scene: &'a RefCell<Scene>,
    figures: &'a RefCell<Figures>,
    /// Maximum size of all drawings, bytes.
    room: u64,
    answer: AnswerContext<'a>,
}

impl<'a> From<&'a WorldCell> for FigureContext<'a> {
    fn from(world: &'a WorldCell) -> Self {
        let room = world.store_limit();
        FigureContext { scene: &world.state.scene, figures: &world.devices.figures, room, answer: world.into() }
    }
}

impl FigureContext<'_> {
    /// Calls `f` with the scene and the figures.
    fn edit<T>(&self, f: impl FnOnce(&Scene, &mut Figures) -> Result<T, Refusal>) -> Result<T, tatu_status> {
        let scene = self.scene.try_borrow().map_err(|_| busy(self.answer))?;
        let mut all = self.figures.try_borrow_mut().map_err(|_| busy(self.answer))?;
        f(&scene, &mut all).map_err(|Refusal(code, text)| self.answer.calls.refuse(code, &text))
    }

    /// Returns the full handle of an object given by a caller.
    fn full_handle(&self, object: tatu_object) -> Result<tatu_object, tatu_status> {
        let scene = self.scene.try_borrow().map_err(|_| busy(self.answer))?;
        Ok(scene.id(slot(self.answer, &scene, object)?))
    }
}

fn missing<T>(what: &str, id: i64) -> Result<T, Refusal> {
    Err(Refusal(TATU_ERR_MISSING, format!("there is no {what} {id}")))
}

/// Copies the map that a caller passes.
fn map_argument(answer: AnswerContext<'_>, map: Option<&ValueRef<'_>>) -> Result<Option<Value>, tatu_status> {
    map.map(|map| map.to_value()).transpose().map_err(|e| answer.calls.refuse(e.code(), e.text()))
}

extern "C" fn add(
    w: WorldRef<'_>,
    object: tatu_object,
    what: u32,
    map: Option<&ValueRef<'_>>,
    out: Option<&mut i64>,
) -> tatu_status {
    with_context(w, HostFunction::mutating("figures.add"), |c: FigureContext<'_>| {
        let out = require(c.answer, "a pointer for the number", out)?;
        let Some(map) = map_argument(c.answer, map)? else {
            return Err(c.answer.calls.refuse(TATU_ERR_ARGUMENT, "expected a map of keys, found null"));
        };
        let owner = if what == TATU_FIGURE_DRAWING { 0 } else { c.full_handle(object)? };
        let id = c.edit(|scene, all| match what {
            TATU_FIGURE_STREAM => all.graph(scene, owner)?.add_stream(StreamSpec::from_value(&map)?),
            TATU_FIGURE_CURVE => all.graph(scene, owner)?.add_curve(CurveSpec::from_value(&map)?),
            TATU_FIGURE_COPY => {
                let (name, curve) = parse_static_copy(&map)?;
                all.graph(scene, owner)?.freeze(curve, &name)
            }
            TATU_FIGURE_DRAWING => {
                all.remove_orphans(scene);
                let mut drawing = Drawing::from_value(&map)?;
                if drawing.parent != 0 {
                    let gone = |_| Refusal(TATU_ERR_GONE, "the parent of the drawing no longer exists".into());
                    drawing.parent = scene.id(scene.resolve(drawing.parent).map_err(gone)?);
                }
                all.draw(drawing)
            }
            _ => {
                Err(Refusal(TATU_ERR_ARGUMENT, format!("unknown kind of figure {what}; expected one of TATU_FIGURE_*")))
            }
        })?;
        *out = id;
        Ok(())
    })
}

extern "C" fn change(w: WorldRef<'_>, object: tatu_object, id: i64, map: Option<&ValueRef<'_>>) -> tatu_status {
    with_context(w, HostFunction::mutating("figures.change"), |c: FigureContext<'_>| {
        let map = map_argument(c.answer, map)?;
        if object == 0 {
            return c.edit(|_, all| match (map, all.drawings.remove(&id)) {
                (None, Some(_)) => Ok(()),
                (None, None) => missing("drawing", id),
                (Some(_), found) => {
                    found.map(|d| all.drawings.insert(id, d));
                    Err(Refusal(
                        TATU_ERR_UNSUPPORTED,
                        "a drawing cannot be changed: remove it and create a new one".into(),
                    ))
                }
            });
        }
        let owner = c.full_handle(object)?;
        c.edit(|scene, all| {
            let graph = all.graph(scene, owner)?;
            match map {
                Some(map) => {
                    let stream = graph.stream(id)?;
                    stream.spec = StreamSpec { name: stream.spec.name.clone(), ..stream.spec.with(&map)? };
                    stream.color = stream.spec.color.unwrap_or(stream.color);
                    Ok(())
                }
                None if graph.remove(id) => Ok(()),
                None => missing("stream or curve", id),
            }
        })
    })
}

unsafe extern "C" fn put(
    w: WorldRef<'_>,
    object: tatu_object,
    id: i64,
    numbers: *const f64,
    n: u64,
    taken: Option<&mut u64>,
) -> tatu_status {
    // SAFETY: the header requires `numbers` to be null or to hold `n` numbers for the whole call.
    unsafe {
        with_context(w, HostFunction::mutating("figures.put"), |c: FigureContext<'_>| {
            let numbers =
                if numbers.is_null() || n == 0 { &[][..] } else { std::slice::from_raw_parts(numbers, n as usize) };
            let owner = if object == 0 { 0 } else { c.full_handle(object)? };
            let room = c.room;
            let count = c.edit(|scene, all| {
                if owner == 0 {
                    all.remove_orphans(scene);
                    if !numbers.is_empty() && all.bytes() + 8 * numbers.len() as u64 > room {
                        let text = format!(
                            "drawings of the scene would exceed {} MB, the memory limit of its scripts: remove \
                             items, or raise `budget.memory_mb` in the scene",
                            room >> 20
                        );
                        return Err(Refusal(TATU_ERR_SPACE, text));
                    }
                    let Some(drawing) = all.drawings.get_mut(&id) else { return missing("drawing", id) };
                    if numbers.is_empty() {
                        drawing.items.clear();
                        return Ok(0);
                    }
                    return drawing.add(numbers, &frame(scene, drawing));
                }
                let graph = all.graph(scene, owner)?;
                match (id, numbers) {
                    (0, []) => graph.clear(),
                    (_, [x]) => {
                        let stream = graph.stream(id)?;
                        if !stream.spec.of.is_empty() {
                            let text = format!(
                                "the stream `{}` records a value of an object, so it does not accept numbers",
                                stream.spec.name
                            );
                            return Err(Refusal(TATU_ERR_ARGUMENT, text));
                        }
                        stream.given = Some(*x);
                    }
                    _ => return Err(Refusal(TATU_ERR_ARGUMENT, "a stream accepts exactly one number".into())),
                }
                Ok(numbers.len())
            })?;
            if let Some(taken) = taken {
                *taken = count as u64;
            }
            Ok(())
        })
    }
}

/// Returns the world pose of a drawing's parent.
fn frame(scene: &Scene, drawing: &Drawing) -> Isometry3<f64> {
    scene.resolve(drawing.parent).map_or(Isometry3::identity(), |slot| scene.world(slot))
}

extern "C" fn record(w: WorldRef<'_>, object: tatu_object, time: f64) -> tatu_status {
    on_world(w, HostFunction::mutating("figures.record"), |world| {
        if !time.is_finite() {
            return Err(world.run.calls.refuse(TATU_ERR_ARGUMENT, "the time of a sample must be finite"));
        }
        let done = match object {
            0 => crate::recording::record_due(world, time).map(drop),
            one => crate::recording::record(world, FigureContext::from(world).full_handle(one)?, time),
        };
        done.map_err(|r| refuse_with(world, r))
    })
}

unsafe extern "C" fn list(
    w: WorldRef<'_>,
    object: tatu_object,
    what: u32,
    out: *mut i64,
    cap: u32,
    n: Option<&mut u32>,
) -> tatu_status {
    // SAFETY: the header requires `out` to be null or to have room for `cap` elements for the whole call.
    unsafe {
        with_context(w, HostFunction::read_only("figures.list"), |c: FigureContext<'_>| {
            let owner = if object == 0 { 0 } else { c.full_handle(object)? };
            let ids: Vec<i64> = c.edit(|scene, all| {
                all.remove_orphans(scene);
                Ok(match what {
                    TATU_FIGURE_STREAM => all.graph(scene, owner)?.streams.iter().map(|s| s.id).collect(),
                    TATU_FIGURE_CURVE => all.graph(scene, owner)?.curves.iter().map(|c| c.id).collect(),
                    TATU_FIGURE_DRAWING => all.drawings.keys().copied().collect(),
                    _ => {
                        return Err(Refusal(
                            TATU_ERR_ARGUMENT,
                            format!("unknown kind of figure {what}; expected one of TATU_FIGURE_*"),
                        ));
                    }
                })
            })?;
            fill(&ids, out, cap, n)
        })
    }
}

extern "C" fn get<'a>(
    w: WorldRef<'a>,
    object: tatu_object,
    id: i64,
    numbers: u32,
    out: Option<&mut ValueRef<'a>>,
) -> tatu_status {
    with_context(w, HostFunction::read_only("figures.get"), |c: FigureContext<'a>| -> HostResult {
        let owner = if object == 0 { 0 } else { c.full_handle(object)? };
        let value = c.edit(|scene, all| match owner {
            0 => match all.drawings.get(&id) {
                Some(d) => Ok(drawing_value(d, scene, numbers != 0)),
                None => missing("drawing", id),
            },
            _ => graph_value(all.graph(scene, owner)?, id, numbers != 0),
        })?;
        write_value(c.answer, &value, out)
    })
}

/// Returns a map with additional entries.
fn with_entries(value: Value, entries: impl IntoIterator<Item = (&'static str, Value)>) -> Value {
    let mut all = if let Value::Map(all) = value { all } else { Vec::new() };
    all.extend(entries.into_iter().map(|(k, v)| (Value::text(k), v)));
    Value::Map(all)
}

fn drawing_value(d: &Drawing, scene: &Scene, numbers: bool) -> Value {
    let stride = Value::Int(d.stride() as i64);
    let value = with_entries(d.entries(), [("figure", Value::Int(TATU_FIGURE_DRAWING.into())), ("stride", stride)]);
    if numbers { with_entries(value, [("items", Value::Floats(d.in_world(&frame(scene, d))))]) } else { value }
}

fn graph_value(graph: &Graph, id: i64, numbers: bool) -> Result<Value, Refusal> {
    if let Some(s) = graph.streams.iter().find(|s| s.id == id) {
        let spec = StreamSpec { color: Some(s.color), ..s.spec.clone() };
        let value = with_entries(spec.to_value(), [("figure", Value::Int(TATU_FIGURE_STREAM.into()))]);
        let floats = |all: &std::collections::VecDeque<f64>| Value::Floats(all.iter().copied().collect());
        let held = [("times", floats(&graph.times)), ("values", floats(&s.values))];
        return Ok(if numbers { with_entries(value, held) } else { value });
    }
    let Some(c) = graph.curves.iter().find(|c| c.id == id) else { return missing("stream or curve", id) };
    let spec = CurveSpec { color: Some(c.color), ..c.spec.clone() };
    let dims = Value::Int(c.spec.axes.len() as i64);
    let value = with_entries(spec.to_value(), [("figure", Value::Int(TATU_FIGURE_CURVE.into())), ("dims", dims)]);
    let points = || Value::Floats(graph.points(c).concat());
    Ok(if numbers { with_entries(value, [("points", points())]) } else { value })
}
