//! Properties of objects by name: `sim.getFloatProperty(thruster, 'thruster.thrust')` and its relatives.
//!
//! The names are the keys of this simulator's properties, those of plugins' devices included.

use crate::kit::*;

pub(crate) fn offer(offer: &mut Offer<Vrep>) {
    family(offer, "float", ["sim.getFloatProperty", "sim.setFloatProperty"], Param::float("value"), "-0.5", |v| {
        v.as_f64().map(Value::Float)
    });
    family(offer, "int", ["sim.getIntProperty", "sim.setIntProperty"], Param::int("value"), "2", |v| {
        v.as_i64().map(Value::Int)
    });
    family(offer, "bool", ["sim.getBoolProperty", "sim.setBoolProperty"], Param::bool("value"), "true", |v| {
        v.as_bool().map(Value::Bool)
    });
    family(
        offer,
        "string",
        ["sim.getStringProperty", "sim.setStringProperty"],
        Param::string("value"),
        "'text'",
        |v| v.as_str().map(|s| Value::text(s.as_bytes())),
    );
    family(
        offer,
        "floatarray",
        ["sim.getFloatArrayProperty", "sim.setFloatArrayProperty"],
        Param::floats("value", 0),
        "{0, 0, 1}",
        |v| v.numbers().map(Value::Floats),
    );
}

/// Reading and setting properties of one type.
fn family(
    offer: &mut Offer<Vrep>,
    of: &'static str,
    [get, set]: [&'static str; 2],
    value: Param,
    sample: &str,
    read: fn(ValueRef<'_>) -> Option<Value>,
) {
    let target = || Param::int("target").text("a handle, or sim.handle_scene: the world itself");
    let key = || Param::string("name").text("`<kind>.<key>`: `joint.max_force`, `thruster.thrust`");
    offer.command(
        Cmd::new(get, move |c| {
            let (id, key) = (target_of(c)?, c.text(1)?);
            let v = c.world().get(id, c.world().host().prop(&key))?;
            let v = read(v).ok_or_else(|| Fail::argument(format!("the property `{key}` is not of type {of}")))?;
            c.ret(v);
            Ok(())
        })
        .param(target())
        .param(key())
        .param(Param::any("options").optional().text("ignored"))
        .returns(value.clone())
        .text(format!("Gives a property of type {of} by its name."))
        .example(format!("value = {get}(object, name)")),
    );
    offer.command(
        Cmd::new(set, move |c| {
            let (id, key) = (target_of(c)?, c.text(1)?);
            let value = read(c.arg(2)).ok_or_else(|| Fail::argument("argument 3 is of another type"))?;
            c.world().set(id, c.world().host().prop(&key), &value)
        })
        .param(target())
        .param(key())
        .param(value)
        .param(Param::any("options").optional().text("ignored"))
        .text(format!("Sets a property of type {of} by its name; at the end of the simulation it is what it was."))
        .example(format!("{set}(object, name, {sample})")),
    );
}

fn target_of(c: &Ctx<'_>) -> Result<tatu_object> {
    if c.i64(0)? == HANDLE_SCENE { Ok(0) } else { Ok(living(c, 0)?.id) }
}
