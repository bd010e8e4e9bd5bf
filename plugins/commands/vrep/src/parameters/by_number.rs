//! Parameters of objects by number, as in `sim.getObjectInt32Param(box, sim.shapeintparam_static)`.
//!
//! If an object has no parameter with the given number, a getter returns no value. The older getters, such as
//! `sim.getObjectInt32Parameter`, return 1 and the value, or only 0 if there is no such parameter.

use super::targets;
use crate::{
    kit::{algebra as al, *},
    poses::frame_velocity,
    vision::parameters,
};

pub(crate) fn offer(offer: &mut Offer<Vrep>) {
    family(offer, &INT32_NAMES, get_int, set_int, Param::int("value"));
    family(offer, &FLOAT_NAMES, get_float, set_float, Param::float("value"));
}

type NumberGetter<T> = fn(&Ctx<'_>, Object, i64) -> Result<Option<T>>;
type NumberSetter<T> = fn(&Ctx<'_>, Object, i64, T) -> Result<bool>;

/// Names of the getter and setter for one type of value: current, previous and flat.
struct AccessorNames {
    get: &'static str,
    set: &'static str,
    get_before: (&'static str, &'static [&'static str]),
    set_before: (&'static str, &'static [&'static str]),
}

const INT32_NAMES: AccessorNames = AccessorNames {
    get: "sim.getObjectInt32Param",
    set: "sim.setObjectInt32Param",
    get_before: ("sim.getObjectInt32Parameter", &["simGetObjectInt32Parameter", "simGetObjectIntParameter"]),
    set_before: ("sim.setObjectInt32Parameter", &["simSetObjectInt32Parameter", "simSetObjectIntParameter"]),
};
const FLOAT_NAMES: AccessorNames = AccessorNames {
    get: "sim.getObjectFloatParam",
    set: "sim.setObjectFloatParam",
    get_before: ("sim.getObjectFloatParameter", &["simGetObjectFloatParameter"]),
    set_before: ("sim.setObjectFloatParameter", &["simSetObjectFloatParameter"]),
};

/// Adds the commands for one type of value.
fn family<T: ParameterValue>(
    offer: &mut Offer<Vrep>,
    names: &'static AccessorNames,
    get: NumberGetter<T>,
    set: NumberSetter<T>,
    value: Param,
) {
    let id = || Param::int("parameter").text("a number from the tables of constants");
    let read = move |c: &Ctx<'_>| -> Result<Option<T>> {
        let n = c.i64(1)?;
        get(c, owner(c, n)?, n)
    };
    let write = move |c: &Ctx<'_>| -> Result<bool> {
        let (n, value) = (c.i64(1)?, T::read(c, 2)?);
        set(c, owner(c, n)?, n, value)
    };
    offer.command(
        Cmd::new(names.get, move |c| {
            if let Some(x) = read(c)? {
                x.return_value(c);
            }
            Ok(())
        })
        .param(object("object"))
        .param(id())
        .returns(value.clone().text("no value if the object has no such parameter"))
        .text("Returns a parameter of an object.")
        .example(format!("v = {}(box, 3005)", names.get)),
    );
    offer.command(
        Cmd::new(names.set, move |c| {
            if !write(c)? {
                let (o, n) = (existing_object(c, 0)?, c.i64(1)?);
                return Err(Fail::argument(format!(
                    "object {} `{}` has no settable parameter {n}",
                    o.handle(),
                    path(c, o.id)
                )));
            }
            finish_setter(c)
        })
        .param(object("object"))
        .param(id())
        .param(value.clone())
        .text("Sets a parameter of an object. Those of the texture, edges and shading of a shape are only stored.")
        .example(format!("{}(box, 3005, 1)", names.set)),
    );
    let getter = Cmd::new(names.get_before.0, move |c| {
        match read(c)? {
            Some(x) => {
                c.ret(1_i64);
                x.return_value(c);
            }
            None => c.ret(0_i64),
        }
        Ok(())
    });
    let setter = Cmd::new(names.set_before.0, move |c| {
        let done = write(c)?;
        c.ret(i64::from(done));
        Ok(())
    });
    let with_flat = |command: Cmd, flat: &[&str]| flat.iter().fold(command, |c, name| c.old_name(*name, MINUS_ONE));
    let getter = with_flat(getter, names.get_before.1);
    let setter = with_flat(setter, names.set_before.1);
    offer.command(
        getter
            .param(object("object"))
            .param(id())
            .returns(Param::int("result").text("1; 0 without a value: the object has no such parameter"))
            .returns(value.clone())
            .text("Returns whether an object has a parameter, and its value.")
            .example(format!("result, v = {}(box, 3005)", names.get_before.0)),
    );
    offer.command(
        setter
            .param(object("object"))
            .param(id())
            .param(value)
            .returns(Param::int("result").text("1; 0: the object has no such parameter"))
            .text("Sets a parameter of an object, if the object has such a parameter.")
            .example(format!("{}(box, 3005, 1)", names.set_before.0)),
    );
}

/// Returns the object in argument 0. In a run without a scene, the kind of a missing object is inferred from the number
/// of the parameter.
fn owner(c: &Ctx<'_>, n: i64) -> Result<Object> {
    let o = existing_object(c, 0)?;
    let (kind, key) = match n {
        1000..=1999 => (TATU_KIND_SENSOR, "depth_image/1"),
        2000..=2999 => (TATU_KIND_JOINT, "joint"),
        3000..=3999 => (TATU_KIND_SHAPE, "shape"),
        4000..=4999 => (TATU_KIND_SENSOR, "proximity/1"),
        _ => return Ok(o),
    };
    let becomes = o.kind != kind && c.world().used_as(o.id, key);
    if becomes { c.world().look(o.id) } else { Ok(o) }
}

/// The type of a parameter's value.
trait ParameterValue: Copy + 'static {
    fn read(c: &Ctx<'_>, i: usize) -> Result<Self>;
    fn return_value(self, c: &mut Ctx<'_>);
}
impl ParameterValue for i64 {
    fn read(c: &Ctx<'_>, i: usize) -> Result<Self> {
        c.i64(i)
    }
    fn return_value(self, c: &mut Ctx<'_>) {
        c.ret(self);
    }
}
impl ParameterValue for f64 {
    fn read(c: &Ctx<'_>, i: usize) -> Result<Self> {
        c.f64(i)
    }
    fn return_value(self, c: &mut Ctx<'_>) {
        c.ret(self);
    }
}

/// Number of the parameter that selects which objects a vision sensor detects.
const RENDERED_ENTITY: i64 = 1008;
/// Number of the parameter that selects which objects a proximity sensor detects.
const DETECTED_ENTITY: i64 = 4002;

fn get_int(c: &Ctx<'_>, o: Object, n: i64) -> Result<Option<i64>> {
    let (id, p) = (o.id, &c.plugin().p);
    let yes = |prop| bool_of(c, id, prop).map(i64::from);
    Ok(Some(match (o.kind, n) {
        (_, 10) => int_of(c, id, p.layer)?,
        (_, 36) => yes(p.visible)?,
        (TATU_KIND_JOINT, 2000) => i64::from(control(c, id)? != "free"),
        (TATU_KIND_JOINT, 2001) => i64::from(control(c, id)? == "position"),
        (TATU_KIND_JOINT, 2039) => match control(c, id)?.as_str() {
            "force" => 1,
            "velocity" => 4,
            "position" => 8,
            "spring" => 12,
            "callback" => 16,
            _ => 0,
        },
        (TATU_KIND_SHAPE, 3003) => 1 - yes(p.dynamic)?,
        (TATU_KIND_SHAPE, 3004) => yes(p.respondable)?,
        (TATU_KIND_SHAPE, 3016) => i64::from(text_of(c, id, p.primitive)? == "compound"),
        (TATU_KIND_SHAPE, 3017) => yes(p.convex)?,
        (TATU_KIND_SHAPE, 3019) => int_of(c, id, p.respondable_mask)?,
        (TATU_KIND_SHAPE, 3018) => yes(p.convex)?,
        (TATU_KIND_SHAPE, 3029) => yes(p.asleep)?,
        (TATU_KIND_SHAPE, 3014 | 3015 | 3024 | 3027) => tags::number(c, id, &look_tag(n))?.unwrap_or(0.0) as i64,
        (TATU_KIND_DUMMY, LINK_TYPE) => LOOP_CLOSURE,
        (TATU_KIND_SENSOR, RENDERED_ENTITY | DETECTED_ENTITY) => targets::get(c, id)?,
        // Whether and how V-REP displays the sensor's volume.
        (TATU_KIND_SENSOR, 4000) => 0,
        (TATU_KIND_SENSOR, 4001) => volume(c, id)?,
        (TATU_KIND_SENSOR, _) => return parameters::get_int(c, id, n),
        (TATU_KIND_SCRIPT, _) => return script_parameter(c, id, n),
        _ => return Ok(None),
    }))
}

/// Number of the parameter that states what the link of a dummy does, and the only supported value.
const LINK_TYPE: i64 = 10000;
const LOOP_CLOSURE: i64 = 0;

/// Number of the parameter that switches a script on.
const SCRIPT_ENABLED: i64 = 10104;

fn script_parameter(c: &Ctx<'_>, script: tatu_object, n: i64) -> Result<Option<i64>> {
    let p = &c.plugin().p;
    Ok(Some(match n {
        10101 => int_of(c, script, p.script_calls)?,
        10102 => match text_of(c, script, p.script_kind)?.as_str() {
            "main" => 0,
            "addon" => 2,
            "customization" => 6,
            "sandbox" => 8,
            _ => 1,
        },
        10103 => handle(script),
        SCRIPT_ENABLED => 1,
        10105 => handle(parent(c, script)?),
        _ => return Ok(None),
    }))
}

/// Returns V-REP's number for the shape of a proximity sensor's volume.
fn volume(c: &Ctx<'_>, sensor: tatu_object) -> Result<i64> {
    Ok(match text_of(c, sensor, c.world().host().prop("proximity.volume"))?.as_str() {
        "pyramid" => 30,
        "cylinder" => 31,
        "disc" => 32,
        "cone" => 33,
        _ => 34,
    })
}

fn set_int(c: &Ctx<'_>, o: Object, n: i64, value: i64) -> Result<bool> {
    let (id, p, w) = (o.id, &c.plugin().p, c.world());
    let yes = Value::Bool(value != 0);
    match (o.kind, n) {
        (_, 10) => w.set(id, p.layer, &Value::Int(value))?,
        (_, 36) => w.set(id, p.visible, &yes)?,
        (TATU_KIND_JOINT, 2000 | 2001 | 2039) => {
            let now = control(c, id)?;
            let next = control_after(&now, n, value)
                .ok_or_else(|| Fail::unsupported(format!("joint control mode {value} is not supported")))?;
            if next != now {
                w.set(id, p.joint_control, &next.into())?;
            }
        }
        (TATU_KIND_SHAPE, 3003) => w.set(id, p.dynamic, &Value::Bool(value == 0))?,
        (TATU_KIND_SHAPE, 3004) => w.set(id, p.respondable, &yes)?,
        (TATU_KIND_SHAPE, 3019) => w.set(id, p.respondable_mask, &Value::Int(value))?,
        (TATU_KIND_SHAPE, 3029) => w.set(id, p.asleep, &yes)?,
        (TATU_KIND_SHAPE, 3014 | 3015 | 3024 | 3027) => tags::set_number(c, id, &look_tag(n), value as f64)?,
        (TATU_KIND_DUMMY, LINK_TYPE) if value == LOOP_CLOSURE => {}
        (TATU_KIND_DUMMY, LINK_TYPE) => {
            return Err(Fail::unsupported(format!("the link type {value} of dummies is not supported")).help(
                "use sim.dummy_linktype_dynamics_loop_closure: linked dummies hold the shapes above them together",
            ));
        }
        (TATU_KIND_SENSOR, RENDERED_ENTITY | DETECTED_ENTITY) => targets::set(c, id, value)?,
        (TATU_KIND_SENSOR, _) => return parameters::set_int(c, id, n, value),
        (TATU_KIND_SCRIPT, SCRIPT_ENABLED) if value != 0 => {}
        (TATU_KIND_SCRIPT, SCRIPT_ENABLED) => {
            let text = "a script cannot be switched off by another one";
            return Err(
                Fail::unsupported(text).help("remove it with sim.removeObjects, or let it return early by a signal")
            );
        }
        _ => return Ok(false),
    }
    Ok(true)
}

fn control(c: &Ctx<'_>, joint: tatu_object) -> Result<String> {
    text_of(c, joint, c.plugin().p.joint_control)
}

/// Returns the control mode that results from setting parameter `n`: 2000 switches the motor, 2001 switches position
/// control, 2039 selects a mode. Returns `None` for an unsupported mode.
fn control_after(now: &str, n: i64, value: i64) -> Option<&str> {
    Some(match (n, value) {
        (2000, 0) => "free",
        (2000, _) if now == "free" => "velocity",
        (2001, 0) if now == "position" => "velocity",
        (2000, _) | (2001, 0) => now,
        (2001, _) => "position",
        (2039, 0) => "free",
        (2039, 1) => "force",
        (2039, 4) => "velocity",
        (2039, 8) => "position",
        (2039, 12) => "spring",
        (2039, 16) => "callback",
        _ => return None,
    })
}

/// Returns the tag under which a parameter of a shape's appearance is stored that has no effect: position and scale of
/// its texture (3006 to 3013), culling, edges and shading.
fn look_tag(n: i64) -> String {
    format!("look {n}")
}

/// Size reported for objects without a size, m.
const DEFAULT_SIZE_M: f64 = 0.01;

fn get_float(c: &Ctx<'_>, o: Object, n: i64) -> Result<Option<f64>> {
    let (id, p, w) = (o.id, &c.plugin().p, c.world());
    Ok(Some(match (o.kind, n) {
        (_, 11..=13) => frame_velocity(c, id)?[(n - 11) as usize],
        (_, 14) => {
            let t = w.twist(id)?;
            al::length([t[3], t[4], t[5]])
        }
        // The bounding box of a shape is centred on its origin.
        (TATU_KIND_SHAPE, 15..=17) => -w.f64s::<3>(id, p.size)?[(n - 15) as usize] / 2.0,
        (TATU_KIND_SHAPE, 18..=20) => w.f64s::<3>(id, p.size)?[(n - 18) as usize] / 2.0,
        (_, 15..=20) => {
            if w.used_as(id, "shape") {
                return get_float(c, w.look(id)?, n);
            }
            if n < 18 { -DEFAULT_SIZE_M / 2.0 } else { DEFAULT_SIZE_M / 2.0 }
        }
        (_, 34) => 1.0,
        (TATU_KIND_JOINT, 2005..=2011) => w.f64s::<7>(id, p.local_pose)?[(n - 2005) as usize],
        (TATU_KIND_JOINT, 2012) => w.f64(id, p.joint_velocity)?,
        (TATU_KIND_JOINT, 2002..=2004) => gains(c, id)?[(n - 2002) as usize] * engine_step(c)?,
        (TATU_KIND_JOINT, 2013..=2016) => w.f64s::<4>(id, p.joint_rotation)?[(n - 2013) as usize],
        (TATU_KIND_JOINT, 2017 | 2036) => w.f64(id, p.joint_max_velocity)?,
        (TATU_KIND_JOINT, 2018) => w.f64(id, p.joint_stiffness)?,
        (TATU_KIND_JOINT, 2019) => w.f64(id, p.joint_damping)?,
        (TATU_KIND_JOINT, 2034) => w.f64(id, p.joint_lead)? / std::f64::consts::TAU,
        (TATU_KIND_JOINT, 2042) => w.f64(id, p.joint_lead)?,
        (TATU_KIND_SHAPE, 3005) => w.f64(id, p.mass)?,
        (TATU_KIND_SHAPE, 3006..=3013 | 3025 | 3026) => {
            let usual = if matches!(n, 3012 | 3013) { 1.0 } else { 0.0 };
            tags::number(c, id, &look_tag(n))?.unwrap_or(usual)
        }
        (TATU_KIND_SENSOR, _) => return parameters::get_float(c, id, n),
        _ => return Ok(None),
    }))
}

/// Returns the gains P, I and D of a joint's position control, in 1/s, 1/s^2 and 1 (dimensionless).
fn gains(c: &Ctx<'_>, joint: tatu_object) -> Result<[f64; 3]> {
    let set = c.world().get(joint, c.plugin().p.joint_gains)?;
    let set: Vec<f64> = (0..3).filter_map(|i| set.number(i)).collect();
    // Joints without gains use V-REP's default for P, 0.1 per physics step of 5 ms.
    Ok(set.try_into().unwrap_or([20.0, 0.0, 0.0]))
}

/// Returns the physics step, s, to which V-REP's gains refer.
fn engine_step(c: &Ctx<'_>) -> Result<f64> {
    c.world().f64(0, c.plugin().p.physics_dt)
}

fn set_float(c: &Ctx<'_>, o: Object, n: i64, value: f64) -> Result<bool> {
    let (id, p, w) = (o.id, &c.plugin().p, c.world());
    match (o.kind, n) {
        (TATU_KIND_SHAPE, 3005) => w.set_f64s(id, p.mass, &[value.max(1e-7)])?,
        (TATU_KIND_SHAPE, 3006..=3013 | 3025 | 3026) => tags::set_number(c, id, &look_tag(n), value)?,
        (TATU_KIND_JOINT, 2002..=2004) => {
            let mut g = gains(c, id)?;
            g[(n - 2002) as usize] = value / engine_step(c)?;
            w.set(id, p.joint_gains, &Value::Floats(g.to_vec()))?;
        }
        (TATU_KIND_JOINT, 2017 | 2036) => w.set_f64s(id, p.joint_max_velocity, &[value])?,
        (TATU_KIND_JOINT, 2018) => w.set_f64s(id, p.joint_stiffness, &[value.max(0.0)])?,
        (TATU_KIND_JOINT, 2019) => w.set_f64s(id, p.joint_damping, &[value.max(0.0)])?,
        (TATU_KIND_JOINT, 2034) => w.set_f64s(id, p.joint_lead, &[value * std::f64::consts::TAU])?,
        (TATU_KIND_JOINT, 2042) => w.set_f64s(id, p.joint_lead, &[value])?,
        // In V-REP, a static shape with an initial velocity acts as a conveyor; the velocity is that of its surface,
        // in the world frame.
        (TATU_KIND_SHAPE, 3000..=3002) if !bool_of(c, id, p.dynamic)? => {
            let turn = al::rotation(&w.pose(id, 0)?);
            let mut v = al::rotate(turn, w.f64s::<3>(id, p.surface_velocity)?);
            v[(n - 3000) as usize] = value;
            let own = al::rotate(al::conjugate(turn), v);
            w.set(id, p.surface_velocity, &Value::Floats(own.to_vec()))?;
        }
        // Initial velocities are applied immediately, because there is no reset of dynamics that would apply them.
        (TATU_KIND_SHAPE, 3000..=3002 | 3020..=3022) => {
            let mut t = w.twist(id)?;
            t[if n < 3020 { n - 3000 } else { n - 3017 } as usize] = value;
            w.set_twist(id, &t)?;
        }
        (TATU_KIND_SENSOR, _) => return parameters::set_float(c, id, n, value),
        _ => return Ok(false),
    }
    Ok(true)
}

#[cfg(test)]
mod tests {
    use super::control_after;

    #[test]
    fn motor_parameters_select_the_control_mode() {
        assert_eq!(control_after("free", 2000, 1), Some("velocity"));
        assert_eq!(control_after("position", 2000, 1), Some("position"));
        assert_eq!(control_after("velocity", 2000, 0), Some("free"));
        assert_eq!(control_after("velocity", 2001, 1), Some("position"));
        assert_eq!(control_after("position", 2001, 0), Some("velocity"));
        assert_eq!(control_after("free", 2001, 0), Some("free"));
        assert_eq!(control_after("free", 2039, 8), Some("position"));
        assert_eq!(control_after("free", 2039, 12), Some("spring"));
        assert_eq!(control_after("free", 2039, 7), None);
    }
}
