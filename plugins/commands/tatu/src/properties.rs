//! Commands that list objects by kind, and read and set their properties by key.

use tatu_plugin_api::{
    abi::*,
    safe::{Fail, Offer, Param, Value},
};

use crate::plugin::{Cmd, Tatu};

const KINDS: &[(&str, u32)] = &[
    ("shape", TATU_KIND_SHAPE as u32),
    ("joint", TATU_KIND_JOINT as u32),
    ("dummy", TATU_KIND_DUMMY as u32),
    ("sensor", TATU_KIND_SENSOR as u32),
    ("actuator", TATU_KIND_ACTUATOR as u32),
    ("force_sensor", TATU_KIND_FORCE_SENSOR as u32),
    ("graph", TATU_KIND_GRAPH as u32),
    ("camera", TATU_KIND_CAMERA as u32),
    ("light", TATU_KIND_LIGHT as u32),
    ("path", TATU_KIND_PATH as u32),
    ("part", TATU_KIND_PART as u32),
];

pub(crate) fn offer(offer: &mut Offer<Tatu>) {
    offer.command(
        Cmd::new("tatu.list", |c| {
            let kind = if c.has(0) { c.text(0)? } else { String::new() };
            let base = if c.has(1) { c.world().look(c.i64(1)? as u64)?.id } else { 0 };
            let all = if kind == "script" {
                c.world().scripts(base)?
            } else {
                let bits = match KINDS.iter().find(|(name, _)| *name == kind) {
                    Some((_, bit)) => 1 << bit,
                    None if kind.is_empty() => 0,
                    None => {
                        let known: Vec<_> = KINDS.iter().map(|(name, _)| *name).collect();
                        let known = known.join(", ");
                        return Err(Fail::argument(format!(
                            "there is no kind `{kind}`; expected one of: {known}, script"
                        )));
                    }
                };
                c.world().list(base, bits, if base == 0 { 0 } else { TATU_LIST_SKIP_BASE })?
            };
            let handles: Vec<i64> = all.iter().map(|o| i64::from(tatu_slot(*o))).collect();
            c.ret(handles.as_slice());
            Ok(())
        })
        .param(
            Param::string("kind")
                .optional()
                .text("shape, joint, dummy, sensor, actuator, force_sensor, graph or script; omitted: any object"),
        )
        .param(Param::int("base").optional().text("lists only descendants of this object"))
        .returns(Param::list("handles").text("in the order of the scene tree"))
        .text("Lists objects by kind; scripts only if they are requested.")
        .example("assert(#tatu.list('script') >= 1)"),
    );
    offer.command(
        Cmd::new("tatu.get", |c| {
            let (object, key) = (c.i64(0)?, c.text(1)?);
            let world = c.world();
            let object = if object == 0 { 0 } else { world.look(object as u64)?.id };
            let value = world.get(object, world.host().prop(&key))?.to_value()?;
            let value = match value {
                Value::Object(o) => Value::Int(i64::from(tatu_slot(o))),
                other => other,
            };
            c.ret(value);
            Ok(())
        })
        .param(Param::int("object").text("a handle; 0: the world"))
        .param(Param::string("key").text("such as joint.position: docs/reference/properties.md"))
        .returns(Param::any("value"))
        .text("Reads a property of an object, in SI units and radians.")
        .example("assert(tatu.get(0, 'scene.dt') > 0)"),
    );
    offer.command(
        Cmd::new("tatu.set", |c| {
            let (object, key) = (c.i64(0)?, c.text(1)?);
            let world = c.world();
            let object = if object == 0 { 0 } else { world.look(object as u64)?.id };
            world.set(object, world.host().prop(&key), &c.arg(2).to_value()?)
        })
        .param(Param::int("object").text("a handle; 0: the world"))
        .param(Param::string("key"))
        .param(Param::any("value"))
        .text("Sets a property of an object, in SI units and radians.")
        .example("tatu.set(0, 'scene.gravity', {0, 0, -1.62})\nassert(tatu.get(0, 'scene.gravity')[3] == -1.62)"),
    );
}
