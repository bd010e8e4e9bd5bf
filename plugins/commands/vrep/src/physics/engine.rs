//! Commands on parameters of V-REP's physics engines for which shapes have an equivalent, and on V-REP's materials.

use crate::kit::*;

/// Returns the shape property (friction, restitution or damping) to which a parameter of Bullet, ODE, Newton or Vortex
/// corresponds.
fn prop(p: &Props, parameter: i64) -> Option<Prop> {
    Some(match parameter {
        6002 | 6003 | 15001 | 33001 | 33002 | 24001 => p.friction,
        6001 => p.restitution,
        6004 => p.linear_damping,
        6005 => p.angular_damping,
        _ => return None,
    })
}

/// Returns the friction of one of V-REP's materials against a floor with friction 1. The values are estimates,
/// because only the names of the materials are documented: wheels and grippers have high friction, feet slightly less,
/// and low-friction materials slide.
fn friction_of(material: i64) -> Option<f64> {
    Some(match material {
        2_310_013 | 2_310_021 => 0.71,
        2_310_014 | 2_310_019 | 2_310_020 => 1.0,
        2_310_017 | 2_310_018 => 0.8,
        2_310_015 => 0.2,
        2_310_016 => 0.0,
        _ => return None,
    })
}

/// Bullet's parameter number for the physics step.
const PHYSICS_STEP: i64 = 1;

/// The current, the previous and the flat name of a command.
type EngineCommandNames = (&'static str, &'static str, &'static str);

const GETTERS: [(&str, EngineCommandNames); 3] = [
    ("Bool", ("sim.getEngineBoolParam", "sim.getEngineBoolParameter", "simGetEngineBoolParameter")),
    ("Int32", ("sim.getEngineInt32Param", "sim.getEngineInt32Parameter", "simGetEngineInt32Parameter")),
    ("Float", ("sim.getEngineFloatParam", "sim.getEngineFloatParameter", "simGetEngineFloatParameter")),
];
const SETTERS: [(&str, EngineCommandNames); 3] = [
    ("Bool", ("sim.setEngineBoolParam", "sim.setEngineBoolParameter", "simSetEngineBoolParameter")),
    ("Int32", ("sim.setEngineInt32Param", "sim.setEngineInt32Parameter", "simSetEngineInt32Parameter")),
    ("Float", ("sim.setEngineFloatParam", "sim.setEngineFloatParameter", "simSetEngineFloatParameter")),
];

pub(crate) fn offer(offer: &mut Offer<Vrep>) {
    GETTERS.iter().for_each(|(kind, names)| get(offer, kind, *names));
    SETTERS.iter().for_each(|(kind, names)| set(offer, kind, *names));
    offer.command(
        both(["sim.setShapeMaterial", "simSetShapeMaterial"], MINUS_ONE, |c| {
            let shape = of_kind(c, 0, TATU_KIND_SHAPE)?;
            let friction = friction_of(c.i64(1)?)
                .ok_or_else(|| Fail::unsupported(format!("material {} is not supported", c.i64(1).unwrap_or(0))))?;
            c.world().set(shape, c.plugin().p.friction, &Value::Float(friction))?;
            finish_setter(c)
        })
        .param(object("shape"))
        .param(Param::int("material").text("sim.dynmat_..."))
        .text("Sets the friction of a shape to that of a material.")
        .partial("Friction values are estimates, because V-REP's values are not published."),
    );
}

fn get(offer: &mut Offer<Vrep>, kind: &'static str, (name, before, flat): EngineCommandNames) {
    offer.command(
        Cmd::new(name, move |c| {
            let (p, n) = (&c.plugin().p, c.i64(0)?);
            match (kind, prop(p, n)) {
                ("Float", Some(prop)) => {
                    let shape = of_kind(c, 1, TATU_KIND_SHAPE)?;
                    let x = c.world().f64(shape, prop)?;
                    c.ret(x);
                }
                ("Float", None) if n == PHYSICS_STEP => {
                    let x = c.world().f64(0, p.physics_dt)?;
                    c.ret(x);
                }
                ("Float", None) => c.ret(0.0),
                ("Bool", _) => c.ret(false),
                _ => c.ret(0_i64),
            }
            Ok(())
        })
        .alias(before)
        .old_name(flat, MINUS_ONE)
        .param(Param::int("parameter").text("a number from the tables of constants"))
        .param(Param::any("object").optional())
        .returns(Param::any("value"))
        .text("Returns a parameter of a physics engine.")
        .partial("Supports friction, restitution and damping of shapes, and the engine's step; others are 0."),
    );
}

fn set(offer: &mut Offer<Vrep>, kind: &'static str, (name, before, flat): EngineCommandNames) {
    offer.command(
        Cmd::new(name, move |c| {
            let (p, n) = (&c.plugin().p, c.i64(0)?);
            if let ("Float", Some(prop)) = (kind, prop(p, n)) {
                let (shape, x) = (of_kind(c, 1, TATU_KIND_SHAPE)?, c.f64(2)?);
                let most = if n == 6001 { 1.0 } else { f64::INFINITY };
                c.world().set(shape, prop, &Value::Float(x.clamp(0.0, most)))?;
            }
            finish_setter(c)
        })
        .alias(before)
        .old_name(flat, MINUS_ONE)
        .param(Param::int("parameter").text("a number from the tables of constants"))
        .param(Param::any("object").optional())
        .param(Param::any("value"))
        .text("Sets a parameter of a physics engine.")
        .partial("Supports friction, restitution and damping of shapes; other parameters have no effect."),
    );
}
