//! Commands on properties by name: `sim.getFloatProperty(thruster, 'thruster.thrust')` and similar ones.
//!
//! A name is either the key of a Tatu property, including properties of devices, or a property name of V-REP:
//! `customData.NAME` and `signal.NAME`, which are created when set, and V-REP's names for properties of Tatu.

use crate::{kit::*, simulation::run::state_now};

const HANDLE_APP: i64 = -13;

pub(crate) fn offer(offer: &mut Offer<Vrep>) {
    let float = TypeOfProperty { name: "float", storage: "float" };
    let names = ["sim.getFloatProperty", "sim.setFloatProperty"];
    family(offer, float, names, Param::float("value"), "-0.5", |v| v.as_f64().map(Value::Float));
    let int = TypeOfProperty { name: "int", storage: "int" };
    let names = ["sim.getIntProperty", "sim.setIntProperty"];
    family(offer, int, names, Param::int("value"), "2", |v| v.as_i64().map(Value::Int));
    let long = TypeOfProperty { name: "long", ..int };
    let names = ["sim.getLongProperty", "sim.setLongProperty"];
    family(offer, long, names, Param::int("value"), "2", |v| v.as_i64().map(Value::Int));
    let bool = TypeOfProperty { name: "bool", storage: "bool" };
    let names = ["sim.getBoolProperty", "sim.setBoolProperty"];
    family(offer, bool, names, Param::bool("value"), "true", |v| v.as_bool().map(Value::Bool));
    let string = TypeOfProperty { name: "string", storage: "string" };
    let names = ["sim.getStringProperty", "sim.setStringProperty"];
    family(offer, string, names, Param::string("value"), "'text'", |v| v.as_str().map(|s| Value::text(s.as_bytes())));
    let buffer = TypeOfProperty { name: "buffer", storage: "buffer" };
    let names = ["sim.getBufferProperty", "sim.setBufferProperty"];
    family(offer, buffer, names, Param::string("value").text("any bytes"), "'bytes'", |v| {
        v.as_bytes().map(|b| Value::Bytes(b.to_vec()))
    });
    of_any_type(offer);
    lists(offer);
}

/// Adds commands that get and set lists of numbers. Scripts can store a list by one of these types, and read it by
/// another.
fn lists(offer: &mut Offer<Vrep>) {
    let list = |name| TypeOfProperty { name, storage: "floatarray" };
    let names = ["sim.getFloatArrayProperty", "sim.setFloatArrayProperty"];
    let any = Param::floats("value", 0);
    family(offer, list("floatarray"), names, any, "{0, 0, 1}", |v| v.numbers().map(Value::Floats));
    let whole = Param::floats("value", 0).text("whole numbers");
    let names = ["sim.getIntArrayProperty", "sim.setIntArrayProperty"];
    family(offer, list("intarray"), names, whole, "{0, 0, 1}", |v| {
        v.numbers().map(|all| Value::Ints(all.into_iter().map(|x| x as i64).collect()))
    });
    fn of_length<const N: usize>(v: ValueRef<'_>) -> Option<Value> {
        v.numbers().filter(|all| all.len() == N).map(Value::Floats)
    }
    let of_two = Param::floats("value", 2);
    let names = ["sim.getVector2Property", "sim.setVector2Property"];
    family(offer, list("vector2"), names, of_two, "{0, 1}", of_length::<2>);
    let of_three = || Param::floats("value", 3);
    let names = ["sim.getVector3Property", "sim.setVector3Property"];
    family(offer, list("vector3"), names, of_three(), "{0, 0, 1}", of_length::<3>);
    let names = ["sim.getColorProperty", "sim.setColorProperty"];
    family(offer, list("color"), names, of_three().text("red, green, blue, 0 to 1"), "{0, 0, 1}", of_length::<3>);
    let of_four = Param::floats("value", 4).text("x y z w");
    let names = ["sim.getQuaternionProperty", "sim.setQuaternionProperty"];
    family(offer, list("quaternion"), names, of_four, "{0, 0, 0, 1}", of_length::<4>);
    let of_seven = Param::floats("value", 7).text("position and quaternion");
    let names = ["sim.getPoseProperty", "sim.setPoseProperty"];
    family(offer, list("pose"), names, of_seven, "{0, 0, 1, 0, 0, 0, 1}", of_length::<7>);
}

/// A type of V-REP's properties, with the commands that get and set such properties.
#[derive(Clone, Copy)]
struct TypeOfProperty {
    /// The name of the type.
    name: &'static str,
    /// The type under which custom data and signals are stored, one of [`PROPERTY_TYPES`].
    storage: &'static str,
}

/// Types of the values that scripts can store under arbitrary names, in the order in which they are searched.
const PROPERTY_TYPES: [&str; 6] = ["string", "buffer", "int", "float", "bool", "floatarray"];

/// Adds commands that get and set a property of any type.
fn of_any_type(offer: &mut Offer<Vrep>) {
    let any = |v: ValueRef<'_>| v.to_value().ok();
    offer.command(
        Cmd::new("sim.getProperty", move |c| {
            let name = c.text(1)?;
            let own = PROPERTY_TYPES
                .iter()
                .find(|of| storage_of(&name, of).is_some_and(|_| find(c, &name, of, any, of).is_ok()));
            let own = own.copied().unwrap_or("string");
            let found = find(c, &name, own, any, own);
            return_property(c, found)
        })
        .param(target_param())
        .param(key_param())
        .param(Param::any("options").optional().text("{noError = true}: nil if the property is missing"))
        .returns(Param::any("value"))
        .text("Returns a property of any type by its name.")
        .example("value = sim.getProperty(object, name)"),
    );
    offer.command(
        Cmd::new("sim.setProperty", |c| {
            let value = c.arg(2).to_value()?;
            let of = match value {
                Value::Text(_) => "string",
                Value::Bytes(_) => "buffer",
                Value::Int(_) => "int",
                Value::Float(_) => "float",
                Value::Bool(_) => "bool",
                _ => "floatarray",
            };
            set_property(c, of, &value)
        })
        .param(target_param())
        .param(key_param())
        .param(Param::any("value"))
        .param(Param::any("options").optional().text("ignored"))
        .text("Sets a property by its name; the old value is restored at the end of the simulation.")
        .example("sim.setProperty(object, name, 0.5)"),
    );
}

fn target_param() -> Param {
    Param::int("target").text("a handle; sim.handle_scene or sim.handle_app: the world itself")
}
fn key_param() -> Param {
    Param::string("name").text(
        "`<kind>.<key>` (`joint.max_force`, `thruster.thrust`), a name in V-REP, `customData.NAME` or `signal.NAME`",
    )
}

/// Returns a property to the script, or nil if it is missing and the script has set `noError`.
fn return_property(c: &mut Ctx<'_>, found: Result<Value>) -> Result {
    match found {
        Ok(Value::Object(id)) => c.ret(handle(id)),
        Ok(value) => c.ret(value),
        Err(e) if e.code() == TATU_ERR_MISSING && no_error(c) => c.ret(Value::Nil),
        Err(e) => return Err(e),
    }
    Ok(())
}

/// Sets the property of argument 0 whose name is argument 1.
fn set_property(c: &Ctx<'_>, of: &str, value: &Value) -> Result {
    let name = c.text(1)?;
    let id = target_of(c)?;
    if let Some(own) = storage_of(&name, of) {
        return store(c, id, own, value);
    }
    // Use the first key that the object has. If it has none of them, the error must contain the script's own spelling.
    let keys = candidates(c, id, &name)?;
    let known = keys.iter().find(|key| c.world().get(id, c.world().host().prop(key)).is_ok()).unwrap_or(&name);
    c.world().set(id, c.world().host().prop(known), value)
}

/// Adds commands that get and set properties of one type.
fn family(
    offer: &mut Offer<Vrep>,
    TypeOfProperty { name: of, storage }: TypeOfProperty,
    [get, set]: [&'static str; 2],
    value: Param,
    sample: &str,
    read: fn(ValueRef<'_>) -> Option<Value>,
) {
    offer.command(
        Cmd::new(get, move |c| {
            let name = c.text(1)?;
            let found = find(c, &name, storage, read, of);
            return_property(c, found)
        })
        .param(target_param())
        .param(key_param())
        .param(Param::any("options").optional().text("{noError = true}: nil if the property is missing"))
        .returns(value.clone())
        .text(format!("Returns a property of type {of} by its name."))
        .example(format!("value = {get}(object, name)")),
    );
    offer.command(
        Cmd::new(set, move |c| {
            let value =
                read(c.arg(2)).ok_or_else(|| Fail::argument(format!("argument 3: expected a value of type {of}")))?;
            set_property(c, storage, &value)
        })
        .param(target_param())
        .param(key_param())
        .param(value)
        .param(Param::any("options").optional().text("ignored"))
        .text(format!("Sets a property of type {of} by its name; its old value is restored at the end of the run."))
        .example(format!("{set}(object, name, {sample})")),
    );
}

fn no_error(c: &Ctx<'_>) -> bool {
    c.arg(2).get("noError").is_some_and(|v| v.truthy())
}

fn target_of(c: &Ctx<'_>) -> Result<tatu_object> {
    if [HANDLE_SCENE, HANDLE_APP].contains(&c.i64(0)?) { Ok(0) } else { Ok(existing_object(c, 0)?.id) }
}

/// Storage of a value that is not a property of the core.
enum ValueStorage<'a> {
    /// Custom data under this tag.
    Block(&'a str),
    /// Private custom data under this tag: a `customData` value that is not a buffer, or a signal that is a boolean or
    /// a list of numbers.
    PrivateBlock(String),
    /// A signal of this kind and name, which belongs to the world or to an object.
    Signal(u32, &'a str),
}

fn storage_of<'a>(name: &'a str, of: &str) -> Option<ValueStorage<'a>> {
    if let Some(tag) = name.strip_prefix("customData.") {
        return Some(if of == "buffer" {
            ValueStorage::Block(tag)
        } else {
            ValueStorage::PrivateBlock(format!("property {of} {tag}"))
        });
    }
    let signal = name.strip_prefix("signal.")?;
    Some(match of {
        "int" => ValueStorage::Signal(0, signal),
        "float" => ValueStorage::Signal(1, signal),
        "string" | "buffer" => ValueStorage::Signal(2, signal),
        _ => ValueStorage::PrivateBlock(format!("signal {of} {signal}")),
    })
}

fn store(c: &Ctx<'_>, id: tatu_object, own: ValueStorage<'_>, value: &Value) -> Result {
    match own {
        ValueStorage::Block(tag) => {
            let data = c.bytes(2)?;
            tags::set(c, id, tag.as_bytes(), (!data.is_empty()).then_some(data))
        }
        ValueStorage::Signal(kind, name) if id == 0 => c.world().set_signal(kind, name.as_bytes(), c.arg(2)),
        ValueStorage::Signal(kind, name) => {
            tags::set_private(c, id, &format!("signal {kind} {name}"), Some(&tables::pack(value)?))
        }
        ValueStorage::PrivateBlock(name) => tags::set_private(c, id, &name, Some(&tables::pack(value)?)),
    }
}

/// Returns a property that scripts store as `storage`, or a property of the core. `of` is the name of the expected
/// type.
fn find(c: &Ctx<'_>, name: &str, storage: &str, read: fn(ValueRef<'_>) -> Option<Value>, of: &str) -> Result<Value> {
    let id = target_of(c)?;
    let missing = || Fail::missing(format!("there is no property `{name}`"));
    if let Some(own) = storage_of(name, storage) {
        return match own {
            ValueStorage::Block(tag) => tags::get(c, id, tag.as_bytes())?.map(Value::Bytes).ok_or_else(missing),
            ValueStorage::Signal(kind, signal) if id == 0 => {
                let v = c.world().signal(kind, signal.as_bytes())?;
                read(v).filter(|_| !v.is_nil()).ok_or_else(missing)
            }
            ValueStorage::Signal(kind, signal) => {
                packed(c, id, &format!("signal {kind} {signal}"))?.ok_or_else(missing)
            }
            ValueStorage::PrivateBlock(key) => packed(c, id, &key)?.ok_or_else(missing),
        };
    }
    if let Some(v) = constant(c, name)? {
        return Ok(v);
    }
    for key in candidates(c, id, name)? {
        match c.world().get(id, c.world().host().prop(&key)) {
            Ok(v) => {
                return read(v)
                    .ok_or_else(|| Fail::argument(format!("property `{key}`: expected a value of type {of}")));
            }
            Err(e) if e.code() == TATU_ERR_MISSING => {}
            Err(e) => return Err(e),
        }
    }
    // Query the name itself once more, because the host's error lists the most similar names.
    let v = c.world().get(id, c.world().host().prop(name))?;
    read(v).ok_or_else(missing)
}

fn packed(c: &Ctx<'_>, id: tatu_object, key: &str) -> Result<Option<Value>> {
    tags::private(c, id, key)?.map(|data| tables::unpack(&data)).transpose()
}

/// Returns a property of V-REP's application or scene that is constant in Tatu or derived from other values, or `None`
/// for any other name.
fn constant(c: &Ctx<'_>, name: &str) -> Result<Option<Value>> {
    Ok(Some(match (c.i64(0)?, name) {
        (HANDLE_SCENE, "simulationState" | "simulation.state") => Value::Int(state_now(c)?),
        (HANDLE_SCENE, "realtimeSimulation" | "simulation.realtime") => Value::Bool(false),
        (HANDLE_SCENE, "dynamicsEnabled" | "dynamics.enabled") => Value::Bool(true),
        (HANDLE_SCENE, "dynamicsEngine" | "dynamics.engine") => Value::Ints(vec![0, 0]),
        (HANDLE_APP, "headlessMode") => Value::Int(1),
        // The value of `sim.intparam_platform` on Linux.
        (HANDLE_APP, "platform") => Value::Int(2),
        (HANDLE_APP, "displayEnabled") => Value::Bool(false),
        (HANDLE_APP, "processCnt") => Value::Int(1),
        (HANDLE_APP, "processId") => Value::Int(0),
        _ => return Ok(None),
    }))
}

/// Pairs of a V-REP property name and the key of a Tatu property to which it can refer, in addition to the keys that
/// `candidates` derives from the name.
const RENAMED_PROPERTIES: &[(&str, &str)] = &[
    ("simulationTime", "scene.time"),
    ("simulation.time", "scene.time"),
    ("timeStep", "scene.dt"),
    ("simulation.timeStep", "scene.dt"),
    ("stepCount", "scene.step"),
    ("dynamics.gravity", "scene.gravity"),
    ("dynamicsStepSize", "scene.physics_dt"),
    ("dynamics.stepSize", "scene.physics_dt"),
    ("scenePath", "scene.file"),
    ("path", "scene.file"),
    ("modelBase", "object.model_base"),
    ("jointPosition", "joint.position"),
    ("targetForce", "joint.max_force"),
    ("maxForce", "joint.max_force"),
    ("restitution", "shape.restitution"),
];

/// Returns the keys to which a name can refer, in the order in which they are tried.
fn candidates(c: &Ctx<'_>, id: tatu_object, name: &str) -> Result<Vec<String>> {
    let mut keys = vec![name.to_owned()];
    keys.extend(RENAMED_PROPERTIES.iter().filter(|(theirs, _)| *theirs == name).map(|(_, ours)| (*ours).to_owned()));
    let mut snake = String::new();
    for ch in name.chars() {
        if ch.is_ascii_uppercase() {
            snake.push('_');
        }
        snake.push(ch.to_ascii_lowercase());
    }
    match id {
        0 => keys.push(format!("scene.{snake}")),
        _ => {
            let kind = c.world().look(id)?.kind;
            if kind == TATU_KIND_SENSOR {
                keys.push(format!("{}.{snake}", text_of(c, id, c.plugin().p.sensor_kind)?));
            }
            keys.push(format!("{}.{snake}", kind_key(kind)));
            keys.push(format!("object.{snake}"));
        }
    }
    Ok(keys)
}
