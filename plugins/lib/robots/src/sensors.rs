//! Builds the sensors of links, with their noise, as SDF describes them; URDF has the same elements in `<gazebo>`.

use std::f64::consts::{PI, TAU};

use nalgebra::{Isometry3, Matrix3, Rotation3, UnitQuaternion, Vector3};
use tatu_plugin_api::safe::{Builder, Node, Result, Value};

use crate::{
    element::Element,
    findings::{FindingKind, Findings},
    form::set_object_pose,
    robot::alias,
};

/// Range of a scanner that states none, or an infinite one, m.
const MAX_RANGE: f64 = 1000.0;
/// Largest number of beams in a row, and of pixels in a row or column.
const MAX_COUNT: f64 = 8192.0;
/// Largest number of rows of beams.
const MAX_LAYERS: f64 = 4096.0;
/// The magnetic field of a world that states none, T.
pub const DEFAULT_FIELD: [f64; 3] = [5.5645e-6, 22.8758e-6, -42.3884e-6];

/// Builds sensors.
pub struct SensorBuilder<'w, 'b> {
    /// Where they are built.
    pub builder: &'w Builder<'b>,
    /// What is left out.
    pub findings: &'w Findings,
    /// Magnetic field, T; x points east and y north.
    pub field: [f64; 3],
}

/// Returns the rotation of a sensor that looks along +x with z up into the frame of one that looks along +z with y up.
fn looking() -> Isometry3<f64> {
    let axes = Matrix3::new(0.0, 0.0, 1.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0);
    let turn = UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(axes));
    Isometry3::from_parts(Default::default(), turn)
}

impl<'b> SensorBuilder<'_, 'b> {
    /// Builds a sensor whose pose below `parent` is `pose`. What cannot be read is left out.
    pub fn sensor(&self, tag: &Element, parent: Node<'b>, pose: &Isometry3<f64>) -> Result {
        let kind = tag.attribute("type").unwrap_or_default();
        let device = match kind {
            "ray" | "gpu_ray" | "lidar" | "gpu_lidar" => "laser",
            "camera" | "depth" | "depth_camera" | "rgbd_camera" | "rgbd" | "wideanglecamera" | "wide_angle_camera" => {
                "depth_camera"
            }
            "imu" => "imu",
            "gps" | "navsat" => "gps",
            "contact" => "contact",
            "magnetometer" => "compass",
            "air_pressure" => "barometer",
            _ => {
                let text = format!("the sensor `{}` is left out: there is no sensor of the type `{kind}`", tag.label());
                self.findings.warn(FindingKind::Sensor, tag.line, text);
                return Ok(());
            }
        };
        // Older files place the camera in its sensor.
        let own = match tag.at(&["camera", "pose"]).filter(|_| device == "depth_camera") {
            Some(pose) => pose.own_pose()?,
            None => Isometry3::identity(),
        };
        let looks = matches!(device, "laser" | "depth_camera");
        let at = if looks { pose * own * looking() } else { *pose };
        let name = if tag.label().is_empty() { kind } else { tag.label() };
        let node = self.builder.object("sensor", Some(parent), &alias(name))?.device(device)?;
        set_object_pose(node, &at)?;
        if let Some(rate) = tag.finite("update_rate")?.filter(|rate| *rate > 0.0) {
            node.set("sensor.rate", rate)?;
        }
        let mut noise = String::new();
        match device {
            "laser" => self.laser(tag, node, &mut noise)?,
            "depth_camera" => self.camera(tag, kind, node, &mut noise)?,
            "imu" => self.imu(tag, &mut noise)?,
            "gps" => self.gps(tag, &mut noise)?,
            "compass" => {
                let [x, y, z] = self.field;
                let level = libm::hypot(x, y);
                node.set("compass.declination", libm::atan2(x, y))?
                    .set("compass.inclination", libm::atan2(-z, level))?
                    .set("compass.strength", libm::hypot(level, z).min(1.0))?;
                self.axes(tag.child("magnetometer"), "field", &mut noise)?;
            }
            "barometer" => {
                let pressure = tag.child("air_pressure").and_then(|t| t.child("pressure"));
                self.noise("pressure", &[pressure.and_then(|p| p.child("noise"))], 1.0, &mut noise)?;
            }
            _ => {}
        }
        if !noise.is_empty() {
            node.set("sensor.noise", noise.as_str())?;
        }
        Ok(())
    }

    /// Returns the nearest number that a sensor here can have, and tells if it is not that of the file.
    fn bounded(&self, tag: &Element, what: &str, value: f64, (low, high): (f64, f64)) -> f64 {
        let bounded = value.clamp(low, high);
        if (bounded - value).abs() > 1e-3 * value.abs() {
            let text = format!("the {what} of `{}` is {bounded} here, not {value}", tag.label());
            self.findings.warn(FindingKind::Sensor, tag.line, text);
        }
        bounded
    }

    fn laser(&self, tag: &Element, node: Node<'b>, noise: &mut String) -> Result {
        let empty = Element { line: tag.line, ..Element::default() };
        let ray = tag.child("ray").or(tag.child("lidar")).unwrap_or(&empty);
        let row = |name: &str, count: f64| -> Result<(usize, f64, f64)> {
            let Some(row) = ray.child("scan").and_then(|scan| scan.child(name)) else {
                return Ok((count as usize, 0.0, 0.0));
            };
            let samples = row.finite("samples")?.unwrap_or(count) * row.finite("resolution")?.unwrap_or(1.0);
            let angle = |name: &str| row.finite(name).map(|x| x.unwrap_or(0.0));
            let samples = self.bounded(tag, &format!("number of {name} beams"), samples.round(), (1.0, MAX_COUNT));
            Ok((samples as usize, angle("min_angle")?, angle("max_angle")?))
        };
        let (mut rays, mut start, mut end) = row("horizontal", 640.0)?;
        // A scan that begins ahead or behind is turned to the range from -pi to pi.
        if start >= 0.0 && end > PI && end - start <= TAU + 1e-3 {
            let text = format!("the scan of `{}` from {start:.3} to {end:.3} rad begins at -pi here", tag.label());
            self.findings.note(FindingKind::Sensor, tag.line, text);
            (start, end) = (-PI, (end - start - PI).min(PI));
        }
        start = self.bounded(tag, "first angle (rad)", start, (-PI, PI));
        end = self.bounded(tag, "last angle (rad)", end, (-PI, PI));
        if end <= start {
            // All beams have the same direction.
            (rays, end) = (1, (start + 1e-3).min(PI));
            start = start.min(end - 1e-6);
        }
        node.set("laser.start_angle", start)?.set("laser.end_angle", end)?.set("laser.rays", rays as i64)?;
        let (layers, low, high) = row("vertical", 1.0)?;
        if layers > 1 || low != 0.0 {
            let step = if layers > 1 { (high - low) / (layers - 1) as f64 } else { 0.0 };
            let layers = self.bounded(tag, "number of vertical beams", layers as f64, (1.0, MAX_LAYERS)) as usize;
            let low = self.bounded(tag, "lowest elevation (rad)", low, (-PI / 2.0, PI / 2.0));
            let each = |i: usize| (low + step * i as f64).clamp(-PI / 2.0, PI / 2.0);
            node.set("laser.elevations", Value::Floats((0..layers).map(each).collect()))?;
        }
        let range = ray.child("range").unwrap_or(&empty);
        let far = range.number("max")?.filter(|far| far.is_finite() && *far > 0.0).unwrap_or(MAX_RANGE);
        let near = range.finite("min")?.unwrap_or(0.0).clamp(0.0, far * 0.999);
        node.set("laser.min_range", near)?.set("laser.range", far)?;
        self.noise("distance", &[ray.child("noise")], 1.0, noise)
    }

    fn camera(&self, tag: &Element, kind: &str, node: Node<'b>, noise: &mut String) -> Result {
        let empty = Element { line: tag.line, ..Element::default() };
        let camera = tag.child("camera").unwrap_or(&empty);
        let field = camera.finite("horizontal_fov")?.unwrap_or(1.047);
        let image = camera.child("image").unwrap_or(&empty);
        let count = |name: &str, default: f64| {
            let stated = image.finite(name)?.unwrap_or(default).round();
            Result::Ok(self.bounded(tag, &format!("{name} in pixels"), stated, (1.0, MAX_COUNT)))
        };
        let (columns, rows) = (count("width", 320.0)?, count("height", 240.0)?);
        let mut field = self.bounded(tag, "field of view (rad)", field, (0.001, 3.1));
        let unread = ["distortion", "lens"].into_iter().filter(|name| camera.child(name).is_some());
        for name in unread {
            let text = format!("the {name} of the camera `{}` is not read: its image is flat", tag.label());
            self.findings.warn(FindingKind::Sensor, camera.line, text);
        }
        if rows > columns {
            // The angle of view is that along the longer side.
            field = 2.0 * libm::atan(libm::tan(field / 2.0) * rows / columns);
        }
        let has_depth = !matches!(kind, "camera" | "wideanglecamera" | "wide_angle_camera");
        let clip = camera.child("clip").unwrap_or(&empty);
        let depth = camera.child("depth_camera").and_then(|d| d.child("clip")).unwrap_or(clip);
        let near = depth.finite("near")?.unwrap_or(0.1).max(1e-4);
        let far = depth.finite("far")?.unwrap_or(if has_depth { 10.0 } else { 100.0 }).max(near * 1.001);
        node.set("depth_camera.columns", columns as i64)?
            .set("depth_camera.rows", rows as i64)?
            .set("depth_camera.perspective_angle", field)?
            .set("depth_camera.near", near)?
            .set("depth_camera.far", far)?
            .set("depth_camera.color", !matches!(kind, "depth" | "depth_camera"))?;
        // Shares of the greatest brightness become those of a byte; a depth camera's noise is that of its distances.
        let (target, scale) = if matches!(kind, "depth" | "depth_camera") { ("depth", 1.0) } else { ("rgb", 255.0) };
        self.noise(target, &[camera.child("noise")], scale, noise)
    }

    fn imu(&self, tag: &Element, noise: &mut String) -> Result {
        let imu = tag.child("imu");
        self.axes(imu.and_then(|imu| imu.child("angular_velocity")), "angular_velocity", noise)?;
        self.axes(imu.and_then(|imu| imu.child("linear_acceleration")), "acceleration", noise)
    }

    /// Reads the noise of the elements `x`, `y` and `z`.
    fn axes(&self, tag: Option<&Element>, field: &str, noise: &mut String) -> Result {
        let of = |axis: &str| tag.and_then(|tag| tag.at(&[axis, "noise"]));
        self.noise(field, &["x", "y", "z"].map(of), 1.0, noise)
    }

    fn gps(&self, tag: &Element, noise: &mut String) -> Result {
        let gps = tag.child("gps").or(tag.child("navsat"));
        for (element, field) in [("position_sensing", "position"), ("velocity_sensing", "velocity")] {
            let of = |axis: &str| gps.and_then(|gps| gps.at(&[element, axis, "noise"]));
            let (level, height) = (of("horizontal"), of("vertical"));
            self.noise(field, &[level, level, height], 1.0, noise)?;
        }
        Ok(())
    }

    /// Adds the noise of a field with one element `<noise>` for each component.
    fn noise(&self, field: &str, components: &[Option<&Element>], scale: f64, out: &mut String) -> Result {
        let is_noise = |tag: &&Element| {
            let kind = tag.attribute("type").or(tag.text_of("type")).unwrap_or("none");
            kind.starts_with("gaussian")
        };
        let components: Vec<Option<&Element>> = components.iter().map(|tag| tag.filter(is_noise)).collect();
        let Some(first) = components.iter().flatten().next() else { return Ok(()) };
        let numbers = |name: &str| -> Result<Option<Vec<f64>>> {
            let each = |tag: &Option<&Element>| {
                Ok(tag.map(|tag| tag.finite(name)).transpose()?.flatten().unwrap_or(0.0).max(0.0) * scale)
            };
            let all = components.iter().map(each).collect::<Result<Vec<f64>>>()?;
            Ok(Some(all).filter(|all| all.iter().any(|x| *x > 0.0)))
        };
        let list = |all: &[f64]| match all {
            [one] => format!("{one:?}"),
            all => format!("[{}]", all.iter().map(|x| format!("{x:?}")).collect::<Vec<_>>().join(", ")),
        };
        let mut keys = Vec::new();
        if let Some(sigma) = numbers("stddev")? {
            // Each component has a list of its own, since a plain list is a polynomial.
            let each: Vec<String> = sigma.iter().map(|x| format!("[{x:?}]")).collect();
            keys.push(match sigma.as_slice() {
                [one] => format!("sigma = {one:?}"),
                _ => format!("sigma = [{}]", each.join(", ")),
            });
        }
        if let Some(bias) = numbers("bias_stddev")? {
            keys.push(format!("shift_sigma = {}", list(&bias)));
        }
        let time = first.finite("dynamic_bias_correlation_time")?.filter(|time| *time > 0.0);
        if let (Some(walk), Some(time)) = (numbers("dynamic_bias_stddev")?, time) {
            keys.push(format!("walk = {{ sigma = {}, tau_s = {time:?} }}", list(&walk)));
        }
        if let Some(step) = numbers("precision")? {
            keys.push(format!("step = {}", list(&step)));
        }
        let means = ["mean", "bias_mean"];
        if components.iter().flatten().any(|tag| means.iter().any(|m| !matches!(tag.finite(m), Ok(None | Some(0.0))))) {
            let text = "a constant error of a sensor (`mean`, `bias_mean`) is left out".to_owned();
            self.findings.warn(FindingKind::Noise, first.line, text);
        }
        if !keys.is_empty() {
            out.push_str(&format!("{field} = {{ {} }}\n", keys.join(", ")));
        }
        Ok(())
    }
}

/// Returns the direction of a magnetic field, or the default one.
pub fn magnetic_field(world: Option<&Element>) -> Result<[f64; 3]> {
    let stated = world.map(|world| world.numbers("magnetic_field")).transpose()?.flatten();
    Ok(stated.filter(|field| Vector3::from(*field).norm() > 0.0).unwrap_or(DEFAULT_FIELD))
}
