//! Commands on the colours of objects, the size of shapes, and string parameters of objects.

use super::colors;
use crate::kit::*;

/// `sim.colorcomponent_transparency`.
pub(super) const TRANSPARENCY: i64 = 4;

/// Sets the opacity of a shape, or of its parts with the given name, to the first number of argument 3, clamped to
/// 0..1.
pub(super) fn set_opacity(c: &Ctx<'_>, shape: tatu_object, name: Option<&str>) -> Result {
    let expected = || Fail::argument("argument 4: expected a table with the opacity, from 0 to 1");
    let given = element(c.arg(3), 0).filter(|x| x.is_finite()).ok_or_else(expected)?;
    colors::opacity(c).set(c, shape, name, [given.clamp(0.0, 1.0)])
}

pub(crate) fn offer(offer: &mut Offer<Vrep>) {
    let component = || Param::int("component").text("0: sim.colorcomponent_ambient_diffuse");
    offer.command(
        Cmd::new("sim.getObjectColor", |c| {
            let o = existing_object(c, 0)?;
            let own = match (o.kind, c.i64(2)?) {
                (TATU_KIND_SHAPE, 0 | 1) => colors::diffuse(c).get(c, o.id, None)?,
                (TATU_KIND_SHAPE, TRANSPARENCY) => [colors::opacity(c).get(c, o.id, None)?[0], 0.0, 0.0],
                _ => [0.0; 3],
            };
            c.ret(&own[..]);
            Ok(())
        })
        .param(object("object"))
        .param(Param::int("index").text("ignored: an object has one colour"))
        .param(component())
        .returns(Param::floats("rgb", 3))
        .text("Returns the colour or the opacity of an object.")
        .partial("Shapes have a single colour; all other objects are black."),
    );
    offer.command(
        Cmd::new("sim.setObjectColor", |c| {
            let (o, component) = (existing_object(c, 0)?, c.i64(2)?);
            let can = o.kind == TATU_KIND_SHAPE;
            if component == TRANSPARENCY {
                if can {
                    set_opacity(c, o.id, None)?;
                }
                c.ret(can);
                return Ok(());
            }
            let rgb = numbers::<3>(c, 3)?;
            if can && matches!(component, 0 | 1) {
                colors::diffuse(c).set(c, o.id, None, rgb.map(|x| x.clamp(0.0, 1.0)))?;
            }
            c.ret(can);
            Ok(())
        })
        .param(object("object"))
        .param(Param::int("index").text("ignored: an object has one colour"))
        .param(component())
        .param(table("rgb", "0 to 1; for sim.colorcomponent_transparency, {opacity}"))
        .returns(Param::bool("done"))
        .text("Sets the colour or the opacity of an object.")
        .partial("Shapes have a single colour; other components are ignored."),
    );
    offer.command(
        Cmd::new("sim.changeEntityColor", |c| {
            let (w, paint) = (c.world(), colors::diffuse(c));
            let rgb = numbers::<3>(c, 1)?.map(|x| x.clamp(0.0, 1.0));
            let mut before = Vec::new();
            for o in crate::lookup::entities::entity(c, 0)?.list(c)? {
                if w.look(o)?.kind != TATU_KIND_SHAPE {
                    continue;
                }
                let entry = [("handle", Value::Int(handle(o))), ("data", Value::Floats(paint.all(c, o)?))];
                before.push(Value::Map(entry.map(|(k, v)| (Value::text(k), v)).to_vec()));
                paint.set(c, o, None, rgb)?;
            }
            c.ret(Value::List(before));
            Ok(())
        })
        .param(Param::int("entity").text("an object or a collection"))
        .param(table("rgb", "0 to 1"))
        .param(Param::int("component").default(0).optional().text("ignored"))
        .returns(Param::list("before"))
        .text("Changes the colour of shapes temporarily."),
    );
    offer.command(
        Cmd::new("sim.restoreEntityColor", |c| {
            let paint = colors::diffuse(c);
            for v in c.arg(0).list().unwrap_or_default() {
                let id = v.get("handle").and_then(|h| h.as_object()).unwrap_or(0);
                if let (Ok(o), Some(all)) = (c.world().look(id), v.get("data").and_then(|d| d.numbers())) {
                    paint.restore(c, o.id, &all)?;
                }
            }
            Ok(())
        })
        .param(Param::list("before").text("the value that sim.changeEntityColor returned"))
        .text("Restores the previous colour of shapes."),
    );
    offer.command(
        Cmd::new("sim.setShapeBB", |c| {
            let shape = of_kind(c, 0, TATU_KIND_SHAPE)?;
            let (size, p, w) = (numbers::<3>(c, 1)?, &c.plugin().p, c.world());
            let mass = w.f64(shape, p.mass)?;
            w.set_f64s(shape, p.size, &size)?;
            w.set_f64s(shape, p.mass, &[mass])
        })
        .param(object("shape"))
        .param(table("size", "{x, y, z} m"))
        .text("Changes the size of a shape.")
        .partial("Applies to primitives; the triangles of a mesh are unchanged."),
    );
    offer.command(
        Cmd::new("sim.getShapeAppearance", |_| Ok(()))
            .param(Param::any("arguments").rest())
            .text("Returns no value; appearances cannot be queried.")
            .stub("appearances cannot be queried"),
    );
    texts(offer);
}

/// Adds commands on string parameters by number. V-REP has a few such parameters; here they are only stored.
fn texts(offer: &mut Offer<Vrep>) {
    let key = |c: &Ctx<'_>| Ok::<_, Fail>(format!("text {}", c.i64(1)?));
    let get = move |c: &mut Ctx<'_>| -> Result {
        let id = existing_object(c, 0)?.id;
        if let Some(text) = tags::private(c, id, &key(c)?)? {
            c.ret(text.as_slice());
        }
        Ok(())
    };
    let number = || Param::int("parameter").text("a number from the tables of constants");
    let kept = "The strings are only stored and returned; they have no effect.";
    offer.command(
        Cmd::new("sim.getObjectStringParam", get)
            .alias("sim.getObjectStringParameter")
            .old_name("simGetObjectStringParameter", NIL)
            .param(object("object"))
            .param(number())
            .returns(Param::string("text").text("no value if the string was not set"))
            .text("Returns a string parameter of an object.")
            .partial(kept),
    );
    offer.command(
        Cmd::new("sim.setObjectStringParam", move |c| {
            let id = existing_object(c, 0)?.id;
            tags::set_private(c, id, &key(c)?, Some(c.bytes(2)?))?;
            c.ret(1_i64);
            Ok(())
        })
        .alias("sim.setObjectStringParameter")
        .old_name("simSetObjectStringParameter", MINUS_ONE)
        .param(object("object"))
        .param(number())
        .param(Param::string("text"))
        .returns(Param::int("done"))
        .text("Sets a string parameter of an object.")
        .partial(kept),
    );
}
