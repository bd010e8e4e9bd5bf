//! What all subjects share: interned keys, arguments, dialects, answers and messages.

pub(crate) use tatu_plugin_api::abi::*;
pub(crate) use tatu_plugin_api::safe::*;

/// The plugin: its interned property keys.
pub struct Vrep {
    pub(crate) p: Props,
}

/// A running command of this plugin.
pub(crate) type Ctx<'a> = Call<'a, Vrep>;

/// One that others may run beside.
pub(crate) type Shared<'a> = SharedCall<'a, Vrep>;

/// A command of this plugin.
pub(crate) type Cmd = Command<Vrep>;

/// Old error values: nil for values and tables,
pub(crate) const NIL: [Value; 1] = [Value::Nil];
/// and -1 for handles, counts, states and setters.
pub(crate) const MINUS: [Value; 1] = [Value::Int(-1)];

pub(crate) const HANDLE_ALL: i64 = -2;
pub(crate) const HANDLE_ALL_EXCEPT_EXPLICIT: i64 = -3;
pub(crate) const HANDLE_SELF: i64 = -4;
pub(crate) const HANDLE_MAIN_SCRIPT: i64 = -5;
pub(crate) const HANDLE_TREE: i64 = -6;
pub(crate) const HANDLE_CHAIN: i64 = -7;
pub(crate) const HANDLE_PARENT: i64 = -11;
pub(crate) const HANDLE_SCENE: i64 = -12;
/// The bits of a number that are the handle; those above are flags.
pub(crate) const HANDLE_BITS: i64 = 0xF_FFFF;

macro_rules! props {
    ($($name:ident: $key:literal,)*) => {
        /// Keys of the core's properties and of readings, interned at start.
        pub(crate) struct Props { $(pub(crate) $name: Prop,)* }
        impl Props {
            pub(crate) fn new(host: &Host) -> Self {
                Props { $($name: host.prop($key),)* }
            }
        }
    };
}
props! {
    alias: "object.alias",
    name: "object.name",
    path: "object.path",
    parent: "object.parent",
    local_pose: "object.pose",
    object_data: "object.data",
    scene_data: "scene.data",
    model_base: "object.model_base",
    visible: "object.visible",
    layer: "object.layer",
    primitive: "shape.primitive",
    size: "shape.size",
    surface: "shape.surface",
    convex: "shape.convex",
    inertia: "shape.inertia",
    color: "shape.color",
    mass: "shape.mass",
    com: "shape.com",
    dynamic: "shape.dynamic",
    respondable: "shape.respondable",
    friction: "shape.friction",
    restitution: "shape.restitution",
    linear_damping: "shape.linear_damping",
    angular_damping: "shape.angular_damping",
    surface_velocity: "shape.surface_velocity",
    respondable_mask: "shape.respondable_mask",
    detectable: "shape.detectable",
    detectable_mask: "shape.detectable_mask",
    joint_type: "joint.type",
    joint_mode: "joint.mode",
    joint_control: "joint.control",
    joint_position: "joint.position",
    joint_velocity: "joint.velocity",
    joint_target_velocity: "joint.target_velocity",
    joint_target_position: "joint.target_position",
    joint_max_force: "joint.max_force",
    joint_effort: "joint.effort",
    joint_cyclic: "joint.cyclic",
    joint_limits: "joint.limits",
    joint_rotation: "joint.rotation",
    joint_gains: "joint.gains",
    joint_stiffness: "joint.stiffness",
    joint_damping: "joint.damping",
    joint_lead: "joint.lead",
    joint_max_velocity: "joint.max_velocity",
    joint_follows: "joint.follows",
    joint_follow_factor: "joint.follow_factor",
    joint_follow_offset: "joint.follow_offset",
    link: "dummy.link",
    sensed_force: "force_sensor.force",
    sensed_torque: "force_sensor.torque",
    sensed: "force_sensor.measured",
    force_filter: "force_sensor.filter",
    force_samples: "force_sensor.samples",
    break_force: "force_sensor.break_force",
    break_torque: "force_sensor.break_torque",
    break_count: "force_sensor.break_count",
    broken: "force_sensor.broken",
    sensor_kind: "sensor.kind",
    sensor_explicit: "sensor.explicit",
    detected: "proximity.detected",
    distance: "proximity.distance",
    point: "proximity.point",
    seen_object: "proximity.object",
    normal: "proximity.normal",
    depth: "depth_image.depth",
    intrinsics: "depth_image.intrinsics",
    parallel: "depth_image.parallel",
    rgb: "color_image.rgb",
    graph_explicit: "graph.explicit",
    light_on: "light.on",
    light_color: "light.color",
    path_points: "path.points",
    path_rounding: "path.rounding",
    path_closed: "path.closed",
    script_kind: "script.kind",
    script_calls: "script.calls",
    time: "scene.time",
    clock: "scene.clock",
    dt: "scene.dt",
    physics_dt: "scene.physics_dt",
    step: "scene.step",
    gravity: "scene.gravity",
    seed: "scene.seed",
    file: "scene.file",
    stopping: "scene.stopping",
    running: "scene.running",
    phase: "scene.phase",
}

/// A command under its name `sim.abc` and the flat one that follows from it, `simAbc`, whose failure value is given.
pub(crate) fn both<T: IntoResult + 'static>(
    name: &str,
    on_error: [Value; 1],
    run: impl Fn(&mut Ctx<'_>) -> Result<T> + Send + Sync + 'static,
) -> Cmd {
    Cmd::new(name, run).old_name(flat_name(name), on_error)
}
/// The same for one that others may run beside.
pub(crate) fn both_beside<T: IntoResult + 'static>(
    name: &str,
    on_error: [Value; 1],
    run: impl Fn(&mut Shared<'_>) -> Result<T> + Send + Sync + 'static,
) -> Cmd {
    Cmd::side_by_side(name, run).old_name(flat_name(name), on_error)
}
/// `sim.abc` -> `simAbc`
pub(crate) fn flat_name(name: &str) -> String {
    let rest = name.strip_prefix("sim.").unwrap_or(name);
    let (first, others) = rest.split_at(rest.len().min(1));
    format!("sim{}{others}", first.to_uppercase())
}

/// The number that scripts see; -1 for no object.
pub(crate) fn handle(id: tatu_object) -> i64 {
    match id & HANDLE_BITS as u64 {
        0 => -1,
        slot => slot as i64,
    }
}

/// A parameter that names an object.
pub(crate) fn object(key: &str) -> Param {
    Param::object(key).text("a handle")
}
/// A parameter that names an object, where old scripts may add flags to the number.
pub(crate) fn flagged(key: &str) -> Param {
    Param::int(key).text("a handle, flags may be added")
}
/// The object whose frame is meant.
pub(crate) fn frame_param() -> Param {
    Param::int("relativeTo")
        .default(-1)
        .optional()
        .text("-1: the world, sim.handle_parent: its parent, or an object; a joint's moved frame")
}
/// A table of at least as many numbers as its text says; longer ones are accepted.
pub(crate) fn table(key: &str, text: &str) -> Param {
    Param::floats(key, 0).text(text)
}

/// The object that argument `i` names.
#[inline]
pub(crate) fn id(c: &Shared<'_>, i: usize) -> Result<tatu_object> {
    id_of(c.arg(i), i)
}
/// The object that a value names: an object, or a number whose flags are dropped.
#[inline]
pub(crate) fn id_of(v: ValueRef<'_>, i: usize) -> Result<tatu_object> {
    let id = match v.as_i64() {
        Some(n) if n > 0 => (n & HANDLE_BITS) as u64,
        Some(n) => return Err(Fail::missing(format!("there is no object {n}"))),
        None => v.as_object().ok_or_else(|| Fail::argument(format!("argument {}: expected a handle", i + 1)))?,
    };
    if id == 0 {
        return Err(Fail::missing("there is no object 0"));
    }
    Ok(id)
}
/// The object that argument `i` names, which must exist.
pub(crate) fn living(c: &Shared<'_>, i: usize) -> Result<Object> {
    let id = id(c, i)?;
    c.world().look(id).map_err(|e| no_object(id, &e))
}
/// The object that argument `i` names, which must be of a kind.
pub(crate) fn of_kind(c: &Shared<'_>, i: usize, kind: i32) -> Result<tatu_object> {
    let o = living(c, i)?;
    if o.kind == kind || c.world().used_as(o.id, kind_key(kind)) { Ok(o.id) } else { Err(wrong_kind(c, o, kind)) }
}
fn no_object(id: tatu_object, why: &Fail) -> Fail {
    Fail::with_code(why.code(), format!("there is no object {}", handle(id)))
}
fn wrong_kind(c: &Shared<'_>, o: Object, wanted: i32) -> Fail {
    Fail::argument(format!(
        "object {} `{}` is {}, not {}",
        o.handle(),
        path(c, o.id),
        kind_name(o.kind),
        kind_name(wanted)
    ))
}
/// Why an access failed: no such object, not of that kind, or what the host says.
#[cold]
pub(crate) fn explain(c: &Shared<'_>, id: tatu_object, wanted: i32, fail: Fail) -> Fail {
    match c.world().look(id) {
        Err(e) => no_object(id, &e),
        Ok(o) if o.kind != wanted => {
            c.world().used_as(o.id, kind_key(wanted));
            wrong_kind(c, o, wanted)
        }
        Ok(_) => fail,
    }
}
/// Likewise where any kind will do.
#[cold]
pub(crate) fn explain_any(c: &Shared<'_>, id: tatu_object, fail: Fail) -> Fail {
    match c.world().look(id) {
        Err(e) => no_object(id, &e),
        Ok(_) => fail,
    }
}
/// A kind as in the property `object.kind`.
fn kind_key(kind: i32) -> &'static str {
    match kind {
        TATU_KIND_SHAPE => "shape",
        TATU_KIND_JOINT => "joint",
        TATU_KIND_DUMMY => "dummy",
        TATU_KIND_SENSOR => "sensor",
        TATU_KIND_ACTUATOR => "actuator",
        TATU_KIND_FORCE_SENSOR => "force_sensor",
        TATU_KIND_CAMERA => "camera",
        TATU_KIND_LIGHT => "light",
        TATU_KIND_GRAPH => "graph",
        TATU_KIND_PATH => "path",
        _ => "",
    }
}
/// A kind for people.
fn kind_name(kind: i32) -> &'static str {
    match kind {
        TATU_KIND_SHAPE => "a shape",
        TATU_KIND_JOINT => "a joint",
        TATU_KIND_DUMMY => "a dummy",
        TATU_KIND_SENSOR => "a sensor",
        TATU_KIND_ACTUATOR => "an actuator",
        TATU_KIND_FORCE_SENSOR => "a force sensor",
        TATU_KIND_SCRIPT => "a script",
        TATU_KIND_CAMERA => "a camera",
        TATU_KIND_LIGHT => "a light",
        TATU_KIND_GRAPH => "a graph",
        TATU_KIND_PATH => "a path",
        _ => "an object of another kind",
    }
}
/// The path of an object, for messages.
pub(crate) fn path(c: &Shared<'_>, id: tatu_object) -> String {
    text_of(c, id, c.plugin().p.path).unwrap_or_default()
}
/// A property that is a text.
pub(crate) fn text_of(c: &Shared<'_>, id: tatu_object, prop: Prop) -> Result<String> {
    let v = c.world().get(id, prop).map_err(|e| explain_any(c, id, e))?;
    v.as_str().map(|s| s.into_owned()).ok_or_else(|| Fail::new("the host gave no text"))
}
/// A property that is true or false.
pub(crate) fn bool_of(c: &Shared<'_>, id: tatu_object, prop: Prop) -> Result<bool> {
    Ok(c.world().get(id, prop)?.truthy())
}
/// A property that is an integer.
pub(crate) fn int_of(c: &Shared<'_>, id: tatu_object, prop: Prop) -> Result<i64> {
    c.world().get(id, prop)?.as_i64().ok_or_else(|| Fail::new("the host gave no integer"))
}
/// The parent; 0: none.
pub(crate) fn parent(c: &Shared<'_>, id: tatu_object) -> Result<tatu_object> {
    let v = c.world().get(id, c.plugin().p.parent).map_err(|e| explain_any(c, id, e))?;
    Ok(v.as_object().unwrap_or(0))
}

/// The first `N` numbers of argument `i`, a table that may be longer.
pub(crate) fn numbers<const N: usize>(c: &Shared<'_>, i: usize) -> Result<[f64; N]> {
    numbers_of(c.arg(i), i)
}
/// Likewise of a value that stands at place `i`.
pub(crate) fn numbers_of<const N: usize>(v: ValueRef<'_>, i: usize) -> Result<[f64; N]> {
    let mut out = [0.0; N];
    if v.len() < N {
        return Err(Fail::argument(format!(
            "argument {}: expected a table of {N} numbers, found {}",
            i + 1,
            if is_table(v) { format!("{}", v.len()) } else { "no table".into() }
        )));
    }
    for (k, x) in out.iter_mut().enumerate() {
        *x = v
            .number(k)
            .filter(|x| x.is_finite())
            .ok_or_else(|| Fail::argument(format!("argument {}: element {} is not a finite number", i + 1, k + 1)))?;
    }
    Ok(out)
}
/// Whether a value is a table of numbers or values.
pub(crate) fn is_table(v: ValueRef<'_>) -> bool {
    (TATU_F64S..=TATU_MAP).contains(&v.tag())
}
/// Packed data that stands in for what a scene had: it unpacks to zeros, or to an empty table.
pub(crate) const STAND_IN: &[u8] = &[0; 512];

/// An integer argument, or what stands for it when it is not given.
pub(crate) fn int_or(c: &Shared<'_>, i: usize, otherwise: i64) -> Result<i64> {
    if c.has(i) { c.i64(i) } else { Ok(otherwise) }
}

/// The version whose manners the calling script was written for; without one, the newest.
pub(crate) fn version(c: &Shared<'_>) -> (u32, u32) {
    version_of(c.caller_dialect())
}
pub(crate) fn version_of(dialect: &[u8]) -> (u32, u32) {
    // Bytes, not a text: each call asks that makes a difference between versions. This is how they mostly look.
    if let [major @ b'0'..=b'9', b'.', minor @ b'0'..=b'9'] = dialect {
        return (u32::from(major - b'0'), u32::from(minor - b'0'));
    }
    let number = |part: &[u8]| {
        let digits = part.trim_ascii();
        let value = |n: u32, b: &u8| b.is_ascii_digit().then(|| n * 10 + u32::from(b - b'0'));
        (1..9).contains(&digits.len()).then(|| digits.iter().try_fold(0, value)).flatten()
    };
    let mut parts = dialect.split(|b| *b == b'.').map(number);
    match (parts.next().flatten(), parts.next().flatten()) {
        (Some(major), minor) => (major, minor.unwrap_or(0)),
        _ => (4, 9),
    }
}
/// Whether the command was called by a flat name; for commands that have no other names than `sim.x` and flat ones.
pub(crate) fn flat(c: &Shared<'_>) -> bool {
    c.alias() > 0
}
/// Whether the caller expects what scripts of before 4.2 got; who has no version, by the name that was called.
pub(crate) fn old_era(c: &Shared<'_>) -> bool {
    if c.caller_dialect().is_empty() { flat(c) } else { version(c) < (4, 2) }
}
/// A setter has done its work: 1 in the old days, nothing since.
pub(crate) fn done(c: &mut Shared<'_>) -> Result {
    if old_era(c) {
        c.ret(1_i64);
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dialects() {
        assert_eq!(version_of(b"3.2"), (3, 2));
        assert_eq!(version_of(b"2.6.11"), (2, 6));
        assert_eq!(version_of(b"4.10"), (4, 10));
        assert_eq!(version_of(b""), (4, 9));
    }

    #[test]
    fn flat_names() {
        assert_eq!(flat_name("sim.getJointPosition"), "simGetJointPosition");
    }

    #[test]
    fn handles() {
        assert_eq!(handle(0), -1);
        assert_eq!(handle(3 << 20 | 17), 17);
    }
}
