//! Builds what is attached to bodies: sites with their sensors, cameras and lights.

use std::f64::consts::{FRAC_PI_2, PI};

use nalgebra::{Isometry3, Vector3};
use tatu_plugin_api::safe::{Result, Value};

use super::{ModelBuilder, Placed};
use crate::model::{Sensor, Site};

/// Ratio of width and height of pictures, by which the vertical angle of view becomes the horizontal one.
const ASPECT: f64 = 4.0 / 3.0;
/// Range of a range finder, m.
const RANGE_M: f64 = 10.0;

impl<'b> ModelBuilder<'_, 'b> {
    /// Builds the sites, cameras and lights of a body whose pose below `parent` is `pose`.
    pub(super) fn parts(&mut self, body: usize, parent: &Placed<'b>, pose: &Isometry3<f64>) -> Result {
        let is_world = body == 0;
        let body = &self.model.bodies[body];
        for site in &body.sites {
            let placed = self.attached("dummy", parent, &site.name, &(pose * site.pose))?;
            self.sensors(site, &placed, is_world)?;
        }
        for camera in &body.cameras {
            // MuJoCo's cameras look along -z.
            let turned = pose * camera.pose * Isometry3::rotation(Vector3::y() * PI);
            let placed = self.attached("camera", parent, &camera.name, &turned)?;
            let angle = 2.0 * libm::atan(libm::tan(camera.angle.clamp(1e-3, 3.0) / 2.0) * ASPECT);
            placed.node.set("camera.angle", angle)?;
        }
        for light in &body.lights {
            let placed = self.attached("light", parent, &light.name, &(pose * light.pose))?;
            let form = if light.directional { "directional" } else { "spot" };
            placed
                .node
                .set("light.form", form)?
                .set("light.color", light.diffuse.map(|x| x.clamp(0.0, 1.0)))?
                .set("light.angle", light.cutoff.clamp(0.01, FRAC_PI_2))?;
        }
        Ok(())
    }

    fn sensors(&mut self, site: &Site, placed: &Placed<'b>, is_world: bool) -> Result {
        let here: Vec<&Sensor> = self.sensors.get(site.name.as_str()).cloned().unwrap_or_default();
        // One sensor measures what gyroscopes and accelerometers at the same site do.
        let mut inertial = false;
        for sensor in here {
            let device = match sensor.kind.as_str() {
                "gyro" | "accelerometer" if inertial => continue,
                "gyro" | "accelerometer" => "imu",
                "touch" => "contact",
                "rangefinder" => "proximity",
                "magnetometer" => "compass",
                _ => continue,
            };
            inertial |= device == "imu";
            let node = self.attached("sensor", placed, &sensor.name, &Isometry3::identity())?.node.device(device)?;
            match device {
                "contact" => {
                    let [x, y, z] = site.size;
                    node.set("contact.region", Value::Floats(vec![-x, -y, -z, x, y, z]))?;
                }
                "proximity" => {
                    self.report.note(&sensor.place, format!("range finders have a range of {RANGE_M} m"));
                    node.set("proximity.range", RANGE_M)?;
                    if !is_world {
                        // The shape that carries the site; what hangs from it is ignored, too.
                        node.set("sensor.ignored", Value::List(vec![Value::text("../..")]))?;
                    }
                }
                _ => {}
            }
        }
        Ok(())
    }

    /// Reports the sensors that have no counterpart.
    pub(super) fn other_sensors(&mut self) {
        for sensor in &self.model.sensors {
            match sensor.kind.as_str() {
                "gyro" | "accelerometer" | "touch" | "rangefinder" | "magnetometer" if !sensor.site.is_empty() => {}
                kind => self.report.warn(
                    &sensor.place,
                    format!("sensors of the kind `{kind}` are omitted: read the properties of their objects"),
                ),
            }
        }
    }
}
