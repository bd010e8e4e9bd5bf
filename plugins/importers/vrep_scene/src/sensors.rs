//! Builds proximity, vision and force sensors.

use tatu_plugin_api::safe::{Node, Result};

use crate::{
    dynamics::ObjectTree,
    read::{
        file::{FileObject, VrepFile},
        sensor::{ForcePart, ProximityPart, VisionPart},
    },
    report::ImportReport,
    targets,
};

/// Clamps a length or angle to a range. A non-finite number becomes `low`, because fields that a kind does not use may
/// contain garbage.
fn clamp_finite(x: f64, low: f64, high: f64) -> f64 {
    if x.is_finite() { x.clamp(low, high) } else { low }
}

/// Maximum range of a sensor, m.
const MAX_RANGE_M: f64 = 1e6;

/// Sets the properties of a proximity sensor, and the objects that it detects.
pub fn proximity(
    (file, tree): (&VrepFile, &ObjectTree<'_>),
    s: &ProximityPart,
    o: &FileObject,
    node: Node<'_>,
    report: &mut ImportReport,
) -> Result {
    let v = &s.volume;
    // The sensor's kind takes precedence over the type in its volume.
    let volume = match s.kind {
        30 => "pyramid",
        31 => "cylinder",
        32 => "disc",
        33 => "cone",
        _ if s.random.is_some_and(|[rays, _]| rays > 0) && v.kind == 5 => "random_rays",
        _ => "ray",
    };
    let start = clamp_finite(v.offset, 0.0, MAX_RANGE_M);
    let far = clamp_finite(v.offset + v.range, start + 1e-6, MAX_RANGE_M);
    // An assumption that was not verified with V-REP: objects closer than the minimum distance are not detected, and do
    // not hide others. Otherwise, a robot's own shell would block the sonars inside it.
    let near = v.smallest.map_or(start, |least| start.max(clamp_finite(least, 0.0, far - 1e-6)));
    let node = node.device("proximity/1")?.set("volume", volume)?.set("near", near)?.set("range", far)?;
    let size = |x: f64| clamp_finite(x, 1e-6, MAX_RANGE_M);
    let angle = clamp_finite(v.angle, 1e-4, std::f64::consts::TAU);
    match volume {
        "pyramid" => {
            let part = (near - start) / (far - start);
            let at = |i: usize| size(v.near[i]) + part * (size(v.far[i]) - size(v.near[i]));
            node.set("size_near", [at(0), at(1)])?.set("size_far", v.far.map(size)).map(drop)?;
        }
        "cylinder" => node.set("radius_near", size(v.radius))?.set("radius_far", size(v.radius)).map(drop)?,
        "disc" => {
            let gap = clamp_finite(v.inside, 0.0, 0.99) * angle;
            node.set("angle", angle)?.set("gap", gap)?.set("height", size(v.near[1]).min(far)).map(drop)?;
        }
        "cone" => {
            node.set("angle", angle)?;
            if clamp_finite(v.inside, 0.0, 1.0) > 0.0 {
                report.add(
                    "without",
                    "the sensor has a cone with a gap inside; here, it also detects objects in the gap",
                    o,
                );
            }
        }
        "random_rays" => {
            let [rays, needed] = s.random.unwrap_or([1, 1]).map(|n| i64::from(n.clamp(1, 100_000)));
            node.set("angle", angle)?.set("samples", rays)?.set("samples_needed", needed.min(rays)).map(drop)?;
        }
        _ => {}
    }
    let limited = s.angle_alone || s.bits & 4 != 0;
    let quarter = std::f64::consts::FRAC_PI_2;
    if limited && s.angle > 1e-3 && s.angle < quarter {
        node.set("max_incidence", s.angle)?;
    }
    let (front, back) = (s.bits & 0x10 == 0, s.bits & 0x20 == 0);
    match front || back {
        true => node.set("front_faces", front)?.set("back_faces", back).map(drop)?,
        false => {
            report.add("replaced", "the sensor detects neither side of faces in the original; here, it detects both", o)
        }
    }
    let waves = match s.waves {
        0x10 => "ultrasonic",
        0x20 => "infrared",
        0x40 => "laser",
        0x80 => "inductive",
        0x100 => "capacitive",
        _ => "any",
    };
    node.set("waves", waves)?.set("sensor.explicit", s.bits & 0x80 != 0)?;
    if is_all_but_own_model(file, s.entity, o) {
        node.set("skip_own_model", true)?;
        return Ok(());
    }
    targets::declare_targets((file, tree), s.entity, o, node, report)
}

/// Returns whether a sensor detects a collection of all objects except those of its own model.
fn is_all_but_own_model(file: &VrepFile, entity: i32, o: &FileObject) -> bool {
    let find = |id: i32| file.objects.iter().find(|o| o.common.id == id);
    let Some(collection) = file.collections.iter().find(|k| k.handle == entity) else { return false };
    let [all, own] = collection.items.as_slice() else { return false };
    let mut above = Some(o);
    let mut model = None;
    // This loop terminates, because the reader rejects cycles of parents.
    while let Some(at) = above {
        model = if at.common.model_base { Some(at.common.id) } else { model };
        above = find(at.common.parent);
    }
    (all.kind, all.remove) == (5, false) && (own.kind, own.remove) == (1, true) && model == Some(own.object)
}

/// Sets the properties of a vision sensor, which is simulated by a depth camera.
pub fn vision(
    of: (&VrepFile, &ObjectTree<'_>),
    s: &VisionPart,
    o: &FileObject,
    node: Node<'_>,
    report: &mut ImportReport,
) -> Result {
    let [side, angle, near, far] = s.clip;
    let near = clamp_finite(near, 1e-5, MAX_RANGE_M);
    let far = clamp_finite(far, near * 1.001 + 1e-6, MAX_RANGE_M);
    let pixels = |n: i32| i64::from(n.clamp(1, 8192));
    let node = node
        .device("depth_camera")?
        .set("columns", pixels(s.resolution[0]))?
        .set("rows", pixels(s.resolution[1]))?
        .set("near", near)?
        .set("far", far)?
        .set("background", s.background.map(|x| clamp_finite(x, 0.0, 1.0)))?
        .set("color", s.more_bits & 2 == 0)?
        .set("sensor.explicit", s.bits & 2 != 0)?;
    match s.bits & 1 != 0 {
        true => node.set("perspective_angle", clamp_finite(angle, 1e-3, 3.13))?,
        false => node.set("ortho_size", clamp_finite(side, 1e-6, MAX_RANGE_M))?,
    };
    targets::declare_targets(of, s.entity, o, node, report)?;
    if s.filters.iter().any(|f| !matches!(f, 1 | 4)) {
        report.add("without", "the filters of the sensor are ignored", o);
    }
    if matches!(s.mode, 2) {
        report.add("replaced", "the sensor renders each object in a unique colour in the original; here, it renders the object's own colours", o);
    }
    Ok(())
}

/// Sets the properties of a force sensor.
pub fn force(f: &ForcePart, o: &FileObject, node: Node<'_>, report: &mut ImportReport) -> Result {
    let node = node.set("force_sensor.samples", i64::from(f.samples.clamp(1, 1000)))?;
    let node = node.set("force_sensor.filter", if f.filter == 1 { "median" } else { "mean" })?;
    let ([force, torque], count) = f.threshold;
    let known = |x: f64| x.is_finite() && x > 0.0;
    if f.bits & 1 != 0 && known(force) {
        node.set("force_sensor.break_force", force)?;
    }
    if f.bits & 2 != 0 && known(torque) {
        node.set("force_sensor.break_torque", torque)?;
    }
    if f.bits & 3 != 0 {
        node.set("force_sensor.break_count", i64::from(count.max(1)))?;
        report.add(
            "kept",
            "the sensor breaks above its thresholds; in the original, its scripts decide whether it breaks",
            o,
        );
    }
    Ok(())
}
