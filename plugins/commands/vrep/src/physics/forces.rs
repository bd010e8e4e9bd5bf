//! Commands on the dynamics of shapes: forces, velocity, contacts.

use crate::kit::{algebra as al, *};

pub(crate) fn offer(offer: &mut Offer<Vrep>) {
    offer.command(
        Cmd::new("sim.addForceAndTorque", |c| {
            let shape = shape_argument(c)?;
            let three = |i: usize| {
                if c.has(i) { numbers::<3>(c, i) } else { Ok([0.0; 3]) }
            };
            let (force, torque) = (three(1)?, three(2)?);
            apply_force(c, shape, &force, &torque)?;
            c.ret(1_i64);
            Ok(())
        })
        .old_name("simAddForceAndTorque", MINUS_ONE)
        .param(flagged("shape"))
        .param(table("force", "{x, y, z} N, world frame, at the centre of mass").optional())
        .param(table("torque", "{x, y, z} N m, world frame").optional())
        .returns(Param::int("done"))
        .text("Applies a force to a shape for the next step; in `sysCall_dyn`, for one physics step. Forces add up.")
        .example("sim.addForceAndTorque(box, {0, 0, 5}, {0, 0, 0})"),
    );
    offer.command(
        Cmd::new("sim.addForce", |c| {
            let shape = shape_argument(c)?;
            let (at, force): ([f64; 3], [f64; 3]) = (numbers(c, 1)?, numbers(c, 2)?);
            let w = c.world();
            let q = al::rotation(&w.pose(shape, 0)?);
            let com = w.f64s::<3>(shape, c.plugin().p.com)?;
            let lever = al::rotate(q, al::sub(at, com));
            let force = al::rotate(q, force);
            apply_force(c, shape, &force, &al::cross(lever, force))?;
            c.ret(1_i64);
            Ok(())
        })
        .old_name("simAddForce", MINUS_ONE)
        .param(flagged("shape"))
        .param(table("position", "{x, y, z} m, the point of application in the shape's frame"))
        .param(table("force", "{x, y, z} N, in the shape's frame"))
        .returns(Param::int("done"))
        .text(
            "Applies a force to a point of a shape for the next step; in `sysCall_dyn`, for one physics step. Forces \
             add up.",
        )
        .example("sim.addForce(box, {0, 0, 0.1}, {2, 0, 0})"),
    );
    offer.command(
        Cmd::new("sim.getVelocity", |c| {
            let shape = of_kind(c, 0, TATU_KIND_SHAPE)?;
            let t = c.world().twist(shape)?;
            c.ret(&t[..3]);
            c.ret(&t[3..]);
            Ok(())
        })
        .old_name("simGetVelocity", NIL)
        .param(flagged("shape"))
        .returns(Param::floats("linear", 3).unit("m/s"))
        .returns(Param::floats("angular", 3).unit("rad/s"))
        .text("Returns the linear velocity of a shape's centre of mass and its angular velocity, in the world frame.")
        .example("v, w = sim.getVelocity(box)"),
    );
    offer.command(
        Cmd::new("sim.resetDynamicObject", |c| {
            existing_object(c, 0)?;
            c.ret(1_i64);
            Ok(())
        })
        .old_name("simResetDynamicObject", MINUS_ONE)
        .param(flagged("object"))
        .returns(Param::int("done"))
        .text("Has no effect: physics detects changes of objects automatically.")
        .example("sim.resetDynamicObject(box)"),
    );
    offer.command(
        Cmd::new("sim.isDynamicallyEnabled", |c| {
            let o = existing_object(c, 0)?;
            let dynamic = c.world().is_dynamic(o.id)?;
            c.ret(dynamic);
            Ok(())
        })
        .param(object("object"))
        .returns(Param::bool("dynamic").text("false before physics has run for the first time"))
        .text("Returns whether physics moves a shape or a joint.")
        .example("moves = sim.isDynamicallyEnabled(box)"),
    );
    offer.command(
        Cmd::new("sim.getContactInfo", contact)
            .old_name("simGetContactInfo", NIL)
            .param(Param::int("dynamicPass").text("ignored: returns the contacts of the whole last step"))
            .param(Param::int("object").text("a shape, or sim.handle_all"))
            .param(Param::int("index").text("from 0; with sim.handleflag_extended added, the normal is also returned"))
            .returns(Param::list("objects").text("the two shapes; no values past the last contact"))
            .returns(Param::floats("point", 3).unit("m"))
            .returns(Param::floats("force", 3).unit("N").text("on the second shape, friction included"))
            .returns(Param::floats("normal", 3).text("from the first to the second shape"))
            .text("Returns a contact of the last step, by index, in the world frame.")
            .example("shapes, point, force = sim.getContactInfo(sim.handle_all, box, 0)"),
    );
}

/// Applies a force and a torque to a shape; has no effect if physics does not move the shape.
fn apply_force(c: &Ctx<'_>, shape: tatu_object, force: &[f64; 3], torque: &[f64; 3]) -> Result {
    if bool_of(c, shape, c.plugin().p.dynamic)? { c.world().push(shape, force, torque) } else { Ok(()) }
}

/// Returns the shape in argument 0, to which a force will be applied.
fn shape_argument(c: &Ctx<'_>) -> Result<tatu_object> {
    let flags = c.arg(0).as_i64().unwrap_or(0);
    if flags > HANDLE_BITS && flags & 0xC0_0000 != 0 {
        return Err(Fail::unsupported("forces added earlier in a step cannot be removed")
            .help("omit sim.handleflag_resetforce and sim.handleflag_resettorque"));
    }
    of_kind(c, 0, TATU_KIND_SHAPE)
}

fn contact(c: &mut Ctx<'_>) -> Result {
    let shape = if c.i64(1)? == HANDLE_ALL { 0 } else { existing_object(c, 1)?.id };
    let (index, extended) = (c.i64(2)? & HANDLE_BITS, c.i64(2)? & 0x40_0000 != 0);
    if c.i64(2)? < 0 {
        return Ok(());
    }
    let contacts = c.world().contacts(shape)?;
    let Some(contact) = contacts.get(index as usize) else {
        return Ok(());
    };
    c.ret(&contact.shape.map(handle)[..]);
    c.ret(&contact.point[..]);
    let friction = c.world().frictions(shape)?.get(index as usize).copied().unwrap_or_default();
    let force: [f64; 3] = std::array::from_fn(|i| contact.normal[i] * contact.force + friction[i]);
    c.ret(&force[..]);
    if extended || version(c).0 >= 4 {
        c.ret(&contact.normal[..]);
    }
    Ok(())
}
