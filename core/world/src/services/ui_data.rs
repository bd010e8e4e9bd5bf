//! Data for user interfaces: the declared properties of an object, the visible parts of a shape and their images, the
//! models, and the sources of scripts.

use std::cell::RefCell;

use tatu_geometry::{Form, Texture, TextureMapping};
use tatu_plugin_api::{abi::*, safe::Value};
use tatu_plugins::{ParameterSpec, Registry};
use tatu_scene::{ObjectVariant, Scene, pose_to_array, property_table::properties_of, visible_parts};

use super::answer::{AnswerContext, busy, on_world, slot, with_context, write_value};
use crate::{
    cell::{HostFunction, Scripts, WorldCell},
    reload,
    state::edits,
};

fn map<'a>(entries: impl IntoIterator<Item = (&'a str, Value)>) -> Value {
    Value::Map(entries.into_iter().map(|(k, v)| (Value::text(k), v)).collect())
}

/// Describes a declared property or parameter for user interfaces. `prefix` is the id of the device's kind, which
/// precedes the key, or empty for a property.
fn describe_property(p: &ParameterSpec, prefix: &str, settable: bool) -> Value {
    let choices = p.choices.iter().map(Value::text).collect();
    let key = if prefix.is_empty() { p.key.clone() } else { format!("{prefix}.{}", p.key) };
    let mut entries = vec![
        ("key", Value::text(key)),
        ("type", Value::Int(p.kind.into())),
        ("count", Value::Int(p.count.into())),
        ("unit", Value::text(p.unit.as_deref().unwrap_or(""))),
        ("settable", Value::Bool(settable)),
        ("choices", Value::List(choices)),
        ("text", Value::text(&p.text)),
    ];
    let limits = ["min", "max"].into_iter().zip(p.bounds());
    entries.extend(limits.filter_map(|(name, x)| Some((name, Value::Float(x?)))));
    map(entries)
}

/// The parts of the world that the functions of this module use.
struct DisplayContext<'a> {
    scene: &'a RefCell<Scene>,
    registry: &'a Registry,
    scripts: &'a RefCell<Scripts>,
    answer: AnswerContext<'a>,
}

impl<'a> From<&'a WorldCell> for DisplayContext<'a> {
    fn from(world: &'a WorldCell) -> Self {
        DisplayContext {
            scene: &world.state.scene,
            registry: &world.model.registry,
            scripts: &world.run.scripts,
            answer: world.into(),
        }
    }
}

pub(super) extern "C" fn row<'a>(
    w: WorldRef<'a>,
    object: tatu_object,
    index: u32,
    out: Option<&mut ValueRef<'a>>,
) -> tatu_status {
    with_context(w, HostFunction::read_only("scene.row"), |c: DisplayContext<'_>| {
        let found = nth_row(&c, object, index as usize)?.ok_or(TATU_ERR_MISSING)?;
        write_value(c.answer, &found, out)
    })
}

pub(super) extern "C" fn model<'a>(w: WorldRef<'a>, index: u32, out: Option<&mut ValueRef<'a>>) -> tatu_status {
    with_context(w, HostFunction::read_only("scene.model"), |c: DisplayContext<'_>| {
        let model = c.registry.model_at(index as usize).ok_or(TATU_ERR_MISSING)?;
        let entries = [("id", &model.id), ("text", &model.text), ("category", &model.category)];
        write_value(c.answer, &map(entries.map(|(key, text)| (key, Value::text(text)))), out)
    })
}

fn nth_row(c: &DisplayContext<'_>, object: tatu_object, index: usize) -> Result<Option<Value>, tatu_status> {
    let scene = c.scene.try_borrow().map_err(|_| busy(c.answer))?;
    let slot = if object == 0 { 0 } else { slot(c.answer, &scene, object)? };
    let kind = (object != 0).then(|| scene.get(slot).map(|o| o.kind())).flatten();
    let rows: Vec<_> = properties_of(kind).collect();
    if let Some(row) = rows.get(index) {
        let declared = ParameterSpec { key: row.key().to_owned(), ..row.declaration().clone() };
        return Ok(Some(describe_property(&declared, "", row.spec().is_settable())));
    }
    let (id, params) = match scene.get(slot).map(|o| &o.data).filter(|_| object != 0) {
        Some(ObjectVariant::Sensor(s)) => c.registry.sensors.get(s.kind).map(|k| (&k.id, &k.params)).unzip(),
        Some(ObjectVariant::Actuator(a) | ObjectVariant::Part(a)) => {
            c.registry.actuators.get(a.kind).map(|k| (&k.id, &k.params)).unzip()
        }
        _ => (None, None),
    };
    let (Some(id), Some(params)) = (id, params) else { return Ok(None) };
    Ok(params.get(index - rows.len()).map(|p| describe_property(p, id, p.flags & TATU_PARAM_READ_ONLY == 0)))
}

pub(super) extern "C" fn part<'a>(
    w: WorldRef<'a>,
    object: tatu_object,
    index: u32,
    out: Option<&mut ValueRef<'a>>,
) -> tatu_status {
    with_context(w, HostFunction::read_only("figures.part"), |c: DisplayContext<'_>| {
        let found = nth_part(&c, object, index as usize)?.ok_or(TATU_ERR_MISSING)?;
        write_value(c.answer, &found, out)
    })
}

fn nth_part(c: &DisplayContext<'_>, object: tatu_object, index: usize) -> Result<Option<Value>, tatu_status> {
    let scene = c.scene.try_borrow().map_err(|_| busy(c.answer))?;
    let slot = slot(c.answer, &scene, object)?;
    let Some(shape) = scene.get(slot).and_then(|o| o.shape()) else { return Ok(None) };
    let parts = visible_parts(shape);
    let Some(part) = parts.get(index) else { return Ok(None) };
    let (form, size) = match &part.form {
        Form::Plane => ("plane", None),
        Form::Box { half } => ("box", Some([2.0 * half.x, 2.0 * half.y, 2.0 * half.z])),
        Form::Sphere { radius } => ("sphere", Some([2.0 * radius; 3])),
        Form::Cylinder { radius, half_length } => ("cylinder", Some([2.0 * radius, 2.0 * radius, 2.0 * half_length])),
        Form::Capsule { radius, half_length } => {
            ("capsule", Some([2.0 * radius, 2.0 * radius, 2.0 * (half_length + radius)]))
        }
        Form::Mesh { .. } => ("mesh", None),
    };
    let mut entries = vec![
        (Value::text("form"), Value::text(form)),
        (Value::text("pose"), Value::Floats(pose_to_array(&part.pose).to_vec())),
        (Value::text("color"), Value::Floats(part.color.unwrap_or(shape.color).to_vec())),
        (Value::text("opacity"), Value::Float(part.opacity.unwrap_or(shape.opacity))),
    ];
    if let Some(size) = size {
        entries.push((Value::text("size"), Value::Floats(size.to_vec())));
    }
    if let Form::Mesh { mesh, .. } = &part.form {
        let points = mesh.vertices.iter().flat_map(|p| [p.x, p.y, p.z]).collect();
        let triangles = mesh.triangles.iter().flatten().map(|i| i64::from(*i)).collect();
        entries.push((Value::text("points"), Value::Floats(points)));
        entries.push((Value::text("triangles"), Value::Ints(triangles)));
        let mapped = part.texture.as_ref().is_some_and(|t| t.projection.mapping == TextureMapping::Mesh);
        if mapped && !mesh.coordinates.is_empty() {
            let coordinates = mesh.coordinates.iter().flatten().map(|x| f64::from(*x)).collect();
            entries.push((Value::text("coordinates"), Value::Floats(coordinates)));
        }
    }
    if let Some(texture) = &part.texture {
        entries.push((Value::text("texture"), texture_of(texture)));
    }
    Ok(Some(Value::Map(entries)))
}

fn texture_of(texture: &Texture) -> Value {
    let p = &texture.projection;
    map([
        ("image", Value::text(format!("{:016x}", texture.image.hash()))),
        ("mapping", Value::text(p.mapping.name())),
        ("size", Value::Floats(p.size.to_vec())),
        ("pose", Value::Floats(pose_to_array(&p.pose).to_vec())),
        ("repeat", Value::List(p.repeat.map(Value::Bool).to_vec())),
        ("smooth", Value::Bool(p.smooth)),
        ("blend", Value::text(p.blend.name())),
    ])
}

pub(super) extern "C" fn image<'a>(
    w: WorldRef<'a>,
    object: tatu_object,
    index: u32,
    out: Option<&mut ValueRef<'a>>,
) -> tatu_status {
    with_context(w, HostFunction::read_only("figures.image"), |c: DisplayContext<'_>| {
        let found = {
            let scene = c.scene.try_borrow().map_err(|_| busy(c.answer))?;
            let slot = slot(c.answer, &scene, object)?;
            let parts = scene.get(slot).and_then(|o| o.shape()).map(visible_parts).unwrap_or_default();
            let texture = parts.get(index as usize).and_then(|part| part.texture.clone());
            texture.ok_or(TATU_ERR_MISSING)?.image.clone()
        };
        let told = map([
            ("columns", Value::Int(found.columns().into())),
            ("rows", Value::Int(found.rows().into())),
            ("rgba", Value::Bytes(found.rgba().to_vec())),
        ]);
        write_value(c.answer, &told, out)
    })
}

pub(super) extern "C" fn text<'a>(w: WorldRef<'a>, script: tatu_object, out: Option<&mut ValueRef<'a>>) -> tatu_status {
    with_context(w, HostFunction::read_only("scripts.text"), |c: DisplayContext<'_>| {
        let found = script_at(&c, script)?;
        write_value(c.answer, &Value::Bytes(found.text.to_vec()), out)
    })
}

/// Returns a script, given by its handle.
fn script_at(c: &DisplayContext<'_>, script: tatu_object) -> Result<std::rc::Rc<crate::cell::Script>, tatu_status> {
    let slot = {
        let scene = c.scene.try_borrow().map_err(|_| busy(c.answer))?;
        slot(c.answer, &scene, script)?
    };
    let found = c.scripts.try_borrow().map_err(|_| busy(c.answer))?.by_slot(slot);
    found.ok_or_else(|| c.answer.calls.refuse(TATU_ERR_ARGUMENT, &format!("object {slot} is not a script")))
}

pub(super) extern "C" fn change(w: WorldRef<'_>, script: tatu_object, text: Lent<'_>) -> tatu_status {
    on_world(w, HostFunction::mutating("scripts.change"), |world| {
        let found = script_at(&world.into(), script)?;
        let text = text.bytes().to_vec();
        reload::change_script(world, &found, text).map_err(|e| {
            let place = e.place.as_ref().map_or(String::new(), |p| format!("{}:{}: ", p.file.display(), p.line));
            world.run.calls.refuse(TATU_ERR_ARGUMENT, &format!("{place}{}", e.text))
        })?;
        edits::note_script(world);
        Ok(())
    })
}
