//! Scenes for tests, and values for declared parameters.

use tatu_core::plugins::{ParameterSpec, SensorKind, units};
use tatu_plugin_api::{abi::*, safe::Value};

/// Returns a scene: a room with walls at different distances, a body that falls and slides, a rotating joint, and
/// a sensor. `devices` are further tables; if `script` is not empty, the scene has the script `check.lua`.
pub fn scene(devices: &str, script: &str) -> String {
    let mut out = String::from("format = 1\n[scene]\ntext = \"A plugin is checked\"\nseed = 7\n");
    let wall = |alias: &str, at: [f64; 3], size: [f64; 3]| {
        format!(
            "\n[[object]]\nkind = \"shape\"\nalias = \"{alias}\"\nsize_m = {size:?}\nposition_m = {at:?}\nrespondable = true\n"
        )
    };
    out += &wall("floor", [0.0, 0.0, -0.05], [8.0, 8.0, 0.1]);
    out += &wall("ceiling", [0.0, 0.0, 2.0], [8.0, 8.0, 0.1]);
    out += &wall("east", [1.1, 0.0, 1.0], [0.2, 4.0, 2.0]);
    out += &wall("west", [-1.4, 0.0, 1.0], [0.2, 4.0, 2.0]);
    out += &wall("north", [0.0, 1.7, 1.0], [4.0, 0.2, 2.0]);
    out += &wall("south", [0.0, -2.0, 1.0], [4.0, 0.2, 2.0]);
    out += SCENE_BODIES;
    out += devices;
    if !script.is_empty() {
        out += "\n[[object]]\nkind = \"dummy\"\nalias = \"checker\"\nscript = \"check.lua\"\n";
    }
    out
}

const SCENE_BODIES: &str = r#"
[[object]]
kind = "shape"
alias = "body"
size_m = [0.2, 0.2, 0.2]
position_m = [0.3, 0.4, 0.3]
dynamic = true
respondable = true
mass_kg = 1.0

[[object]]
kind = "joint"
alias = "hinge"
position_m = [-0.5, 0.6, 0.5]

[[object]]
kind = "shape"
alias = "lever"
parent = "/hinge"
size_m = [0.3, 0.05, 0.05]
position_m = [0.15, 0.0, 0.0]
dynamic = true
mass_kg = 0.2

[[object]]
kind = "sensor"
sensor = "proximity"
alias = "eye"
position_m = [0.0, 0.0, 0.5]
orientation_deg = [0.0, 90.0, 0.0]
"#;

/// Placements of sensors, as lines of a table: facing walls, facing up, far from everything, and on a moving body.
pub const SENSOR_PLACES: [&str; 5] = [
    "position_m = [0.0, 0.0, 0.5]\norientation_deg = [0.0, 90.0, 0.0]\n",
    "position_m = [0.1, -0.2, 0.6]\norientation_deg = [90.0, 0.0, 20.0]\n",
    "position_m = [0.0, 0.0, 0.4]\n",
    "position_m = [0.0, 0.0, 500.0]\n",
    "parent = \"/body\"\nposition_m = [0.0, 0.0, 0.15]\norientation_deg = [0.0, -80.0, 0.0]\n",
];

/// Returns valid values of a parameter, its default first, or an empty list if scenes cannot set it.
pub fn valid_values(p: &ParameterSpec) -> Vec<Value> {
    let mut out = Vec::new();
    if p.fallback != Value::Nil {
        out.push(p.fallback.clone());
    }
    out.extend(p.choices.iter().map(Value::text));
    let any = p.flags & TATU_PARAM_ANY != 0;
    match p.kind {
        _ if any || !p.choices.is_empty() => {}
        TATU_BOOL => out.extend([Value::Bool(true), Value::Bool(false)]),
        TATU_I64 => out.extend(between(p).into_iter().map(|x| Value::Int(x.ceil() as i64))),
        TATU_F64 => out.extend(between(p).into_iter().map(Value::Float)),
        TATU_TEXT => out.push(Value::text("text")),
        TATU_F64S => {
            let n = if p.count == 0 { 3 } else { p.count as usize };
            out.extend(between(p).into_iter().map(|x| Value::Floats(vec![x; n])));
        }
        _ => {}
    }
    let allowed = |v: &Value| match v {
        Value::Float(x) => (p.lowest..=p.highest).contains(x),
        Value::Int(i) => (p.lowest..=p.highest).contains(&(*i as f64)),
        _ => true,
    };
    out.retain(allowed);
    let mut unique: Vec<Value> = Vec::new();
    out.into_iter().for_each(|v| {
        if !unique.contains(&v) {
            unique.push(v);
        }
    });
    unique
}

/// Returns candidate values of a parameter: near its default, if it has one, then at its bounds and between them. Those
/// near the default may be out of bounds.
fn between(p: &ParameterSpec) -> Vec<f64> {
    let (low, high) = (p.lowest.is_finite().then_some(p.lowest), p.highest.is_finite().then_some(p.highest));
    let middle = match (low, high) {
        (Some(a), Some(b)) => vec![(a + b) / 2.0, a, b],
        (Some(a), None) => vec![a + 1.0, a],
        (None, Some(b)) => vec![b - 1.0, b],
        (None, None) => vec![1.0, 2.0],
    };
    let near = match p.fallback {
        Value::Float(x) => vec![x * 0.8, x * 1.25, x + 0.1],
        Value::Int(i) => vec![i as f64 + 1.0, i as f64 - 1.0],
        _ => Vec::new(),
    };
    near.into_iter().chain(middle).filter(|x| x.is_finite() && x.abs() < 1e9).collect()
}

/// Returns the line that sets a parameter in a scene file, or `None` if a scene file cannot set it.
pub fn line(p: &ParameterSpec, value: &Value) -> Option<String> {
    let unit = p.unit.as_deref();
    let key = units::key_with_unit(&p.key, unit);
    let factor = units::factor(&key, &p.key, unit)?;
    let number = |x: f64| format!("{:?}", x / factor);
    let text = match value {
        Value::Bool(b) => b.to_string(),
        Value::Int(i) => i.to_string(),
        Value::Float(x) => number(*x),
        Value::Text(t) => format!("{:?}", String::from_utf8_lossy(t)),
        Value::Floats(all) => format!("[{}]", all.iter().map(|x| number(*x)).collect::<Vec<_>>().join(", ")),
        _ => return None,
    };
    Some(format!("{key} = {text}\n"))
}

/// Returns lines that set all required parameters, or `None` if one of them cannot be set in a scene file.
pub fn required(params: &[ParameterSpec]) -> Option<String> {
    let all = params.iter().filter(|p| !p.optional());
    all.map(|p| valid_values(p).first().and_then(|v| line(p, v))).collect()
}

/// Returns the lines of a sensor that are required, and its targets.
pub fn sensor_lines(kind: &SensorKind) -> Option<String> {
    Some(required(&kind.params)? + targets(kind.raw.inputs))
}

/// Returns the line with the targets of a device, if its kind takes targets: bodies, and a wall.
pub fn targets(inputs: u32) -> &'static str {
    match inputs & TATU_IN_TARGETS {
        0 => "",
        _ => "targets = [\"/body\", \"/hinge/lever\", \"/east\"]\n",
    }
}
