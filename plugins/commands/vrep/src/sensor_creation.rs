//! Commands that create proximity and vision sensors with all their parameters. Each command describes the sensor in
//! the scene format, and adds the objects in this description to the scene.

use std::f64::consts::{FRAC_PI_2, TAU};

use crate::kit::*;

pub(crate) fn offer(offer: &mut Offer<Vrep>) {
    offer.command(
        both(["sim.createProximitySensor", "simCreateProximitySensor"], MINUS_ONE, |c| {
            let (kind, waves, options) = (c.i64(0)?, c.i64(1)?, c.i64(2)?);
            let text = proximity(kind, waves, options, &listed(c, 3), &listed(c, 4))?;
            let made = c.world().add_text(text.as_bytes(), 0)?;
            c.ret(handle(made));
            Ok(())
        })
        .param(Param::int("sensorType").text("sim.proximitysensor_..._subtype"))
        .param(
            Param::int("subType")
                .text("type of its waves: 16 ultrasonic, 32 infrared, 64 laser, 128 inductive, 256 capacitive"),
        )
        .param(Param::int("options").text(
            "1: explicit, 8: front faces are not detected, 16: nor back faces, 64: limited angle, 128: occlusion, 256: \
             minimum distance, 512: random rays in a cone; others are ignored",
        ))
        .param(table(
            "intParams",
            "8 numbers, of which the fifth and sixth count: random rays, and how many of them must hit",
        ))
        .param(table(
            "floatParams",
            "15 numbers: offset, range, x and y size, x and y size of the far end, inside gap, radius, radius of the \
             far end, angle, limit of the angle, minimum distance, and three that are ignored",
        ))
        .param(Param::any("color").optional().text("ignored"))
        .returns(Param::int("sensor"))
        .text("Creates a proximity sensor at the origin, which detects along its z axis.")
        .example(
            "local ray = sim.createProximitySensor(sim.proximitysensor_ray_subtype, 16, 0, {0, 0, 0, 0, 0, 0, 0, 0}, \
             {0, 2, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0})\nsim.setObjectPosition(ray, {0, 0, 60})\n\
             assert(sim.getObjectType(ray) == sim.object_proximitysensor_type)",
        ),
    );
    offer.command(
        both(["sim.createVisionSensor", "simCreateVisionSensor"], MINUS_ONE, |c| {
            let text = vision(c.i64(0)?, &listed(c, 1), &listed(c, 2))?;
            let made = c.world().add_text(text.as_bytes(), 0)?;
            c.ret(handle(made));
            Ok(())
        })
        .param(Param::int("options").text(
            "1: explicit, 2: perspective, 128: background of the given colour; others are ignored",
        ))
        .param(table("integers", "{columns, rows, 0, 0}"))
        .param(table(
            "floats",
            "11 numbers: near and far plane, angle (rad) or, without perspective, size (m), three that are ignored, the \
             colour of the background, and two that are ignored",
        ))
        .param(Param::any("color").optional().text("ignored"))
        .returns(Param::int("sensor"))
        .text("Creates a vision sensor at the origin, which looks along its z axis."),
    );
}

/// Returns the numbers of a table argument, or an empty list if the argument is not a table.
fn listed(c: &Ctx<'_>, i: usize) -> Vec<f64> {
    c.arg(i).numbers().unwrap_or_default()
}

/// Returns the description of a sensor in the scene format. `keys` contains the keys that only sensors of its kind
/// have.
fn described(sensor: &str, alias: &str, explicit: bool, keys: &[(&str, String)]) -> String {
    let head = format!("format = 1\n[[object]]\nkind = \"sensor\"\nsensor = \"{sensor}\"\nalias = \"{alias}\"\n");
    let keys = keys.iter().map(|(key, value)| format!("{key} = {value}\n"));
    keys.fold(format!("{head}explicit = {explicit}\n"), |text, line| text + &line)
}

/// Formats a number for the scene format.
fn float(x: f64) -> String {
    format!("{x:?}")
}
fn pair([x, y]: [f64; 2]) -> String {
    format!("[{x:?}, {y:?}]")
}
fn quoted(text: &str) -> String {
    format!("\"{text}\"")
}

/// Returns the description of a proximity sensor in the scene format.
fn proximity(kind: i64, waves: i64, options: i64, ints: &[f64], floats: &[f64]) -> Result<String> {
    const TYPES: [(i64, &str); 5] = [(30, "pyramid"), (31, "cylinder"), (32, "disc"), (33, "cone"), (34, "ray")];
    let has = |bit: i64| options & bit != 0;
    let at = |i: usize| floats.get(i).copied().filter(|x| x.is_finite()).unwrap_or(0.0);
    let volume = match TYPES.iter().find(|(n, _)| *n == kind) {
        Some((33, _)) if has(512) => "random_rays",
        Some((_, name)) => name,
        None => {
            return Err(Fail::argument(format!("argument 1: there is no proximity sensor type {kind}"))
                .help("use 30 (pyramid), 31 (cylinder), 32 (disc), 33 (cone) or 34 (ray)"));
        }
    };
    let (offset, range) = (at(0).max(0.0), at(1));
    if range <= 0.0 {
        return Err(Fail::argument(format!("argument 5: expected a range of more than 0 m, found {range} m")));
    }
    let positive = |i: usize| at(i).max(1e-6);
    let angle = at(9).clamp(1e-4, TAU);
    let mut keys = vec![
        ("volume", quoted(volume)),
        ("near_m", float(offset)),
        ("range_m", float(offset + range)),
        ("front_faces", (!has(8)).to_string()),
        ("back_faces", (!has(16)).to_string()),
        ("occlusion", has(128).to_string()),
    ];
    match volume {
        "pyramid" => keys.extend([
            ("size_near_m", pair([positive(2), positive(3)])),
            ("size_far_m", pair([positive(4), positive(5)])),
        ]),
        "cylinder" => keys.extend([("radius_near_m", float(positive(7))), ("radius_far_m", float(positive(8)))]),
        "disc" => keys.extend([
            ("angle_deg", float(angle.to_degrees())),
            ("gap_deg", float((at(6).clamp(0.0, 0.99) * angle).to_degrees())),
            ("height_m", float(positive(3))),
        ]),
        "cone" => keys.push(("angle_deg", float(angle.to_degrees()))),
        "random_rays" => {
            let count = |i: usize| ints.get(i).map_or(1, |n| n.clamp(1.0, 1e5) as i64);
            keys.extend([
                ("angle_deg", float(angle.to_degrees())),
                ("samples", count(4).to_string()),
                ("samples_needed", count(5).min(count(4)).to_string()),
            ]);
        }
        _ => {}
    }
    if has(64) && at(10) > 0.0 && at(10) < FRAC_PI_2 {
        keys.push(("max_incidence_deg", float(at(10).to_degrees())));
    }
    if has(256) && at(11) > 0.0 {
        keys.push(("min_range_m", float(at(11))));
    }
    let waves = match waves {
        0x10 => "ultrasonic",
        0x20 => "infrared",
        0x40 => "laser",
        0x80 => "inductive",
        0x100 => "capacitive",
        _ => "any",
    };
    keys.push(("waves", quoted(waves)));
    Ok(described("proximity", "proximitySensor", has(1), &keys))
}

/// Returns the description of a vision sensor in the scene format.
fn vision(options: i64, ints: &[f64], floats: &[f64]) -> Result<String> {
    let has = |bit: i64| options & bit != 0;
    let at = |i: usize| floats.get(i).copied().filter(|x| x.is_finite()).unwrap_or(0.0);
    let side = |i: usize| match ints.get(i) {
        Some(n) if (1.0..=8192.0).contains(n) => Ok(*n as i64),
        _ => Err(Fail::argument("argument 2: expected {columns, rows, 0, 0}, both from 1 to 8192")),
    };
    let (near, far) = (at(0), at(1));
    if near <= 0.0 || far <= near {
        return Err(Fail::argument(format!(
            "argument 3: the near plane is at {near} m and the far plane at {far} m; expected 0 < near < far"
        )));
    }
    let mut keys = vec![
        ("columns", side(0)?.to_string()),
        ("rows", side(1)?.to_string()),
        ("near_m", float(near)),
        ("far_m", float(far)),
    ];
    match has(2) {
        true => keys.push(("perspective_angle_deg", float(at(2).clamp(1e-3, 3.13).to_degrees()))),
        false => keys.push(("ortho_size_m", float(at(2).max(1e-6)))),
    }
    if has(128) {
        let rgb: [f64; 3] = std::array::from_fn(|i| at(6 + i).clamp(0.0, 1.0));
        keys.push(("background", format!("{rgb:?}")));
    }
    Ok(described("depth_camera", "visionSensor", has(1), &keys))
}
