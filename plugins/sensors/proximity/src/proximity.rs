//! The sensor kind "proximity".

use std::f64::consts::TAU;

use tatu_plugin_api::{
    abi::{TATU_IN_DISTANCE, TATU_IN_NORMAL, TATU_IN_OBJECT, TATU_IN_POINT, tatu_object},
    fields,
    safe::{Beams, Field, Instance, Param, Params, Readout, Result, Sample, Sensor, SharedWorld},
};

use crate::settings::{ProximitySettings, params};

/// The plugin, which has no state.
pub struct ProximityPlugin;

/// The checked parameters of a sensor.
#[derive(Debug, Clone, PartialEq)]
#[repr(C)]
pub struct ProximitySensor {
    // Every measurement uses the first two fields. `repr(C)` keeps them first, so that they share a cache line with
    // what the plugin API stores before the sensor.
    min_range: f64,
    /// Number of beams that must hit a surface for a detection.
    min_hits: usize,
    beams: Beams,
    /// Full opening angle of the cone of random rays, rad; `None` for all other volumes.
    random_cone_angle: Option<f64>,
}

impl ProximitySettings {
    fn check(self) -> Result<ProximitySensor> {
        let beams = self.beams()?;
        Ok(ProximitySensor {
            min_range: self.min_range,
            min_hits: if beams.aimed { self.samples_needed as usize } else { 1 },
            random_cone_angle: beams.aimed.then_some(self.angle.min(TAU)),
            beams,
        })
    }
}

/// The nearest surface point that the beams hit.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Echo {
    distance: f64,
    point: [f64; 3],
    normal: [f64; 3],
    object: tatu_object,
}

/// Returns the echo to report. If the *nearest* point is closer than `min_range`, there is no echo, as with a real
/// sonar, which is blinded by objects that are too close.
fn echo_to_report(echo: Option<Echo>, min_range: f64) -> Option<Echo> {
    echo.filter(|e| e.distance.is_finite() && e.distance >= min_range)
}

/// Returns the nearest echo (the first one of equally near echoes), or `None` if there are fewer than `needed`.
fn nearest_echo(sample: &Sample<'_>, needed: usize) -> Option<Echo> {
    let met = || sample.distances().iter().enumerate().filter(|(_, d)| d.is_finite());
    let (i, distance) = met().min_by(|a, b| a.1.total_cmp(b.1))?;
    if needed > 1 && met().count() < needed {
        return None;
    }
    Some(Echo {
        distance: *distance,
        point: *sample.points().get(i)?,
        normal: *sample.normals().get(i)?,
        object: *sample.objects().get(i)?,
    })
}

/// Maps two numbers from 0 to 1 to a direction in the cone around +z with the full opening `angle`. Uniform numbers
/// yield directions that are uniformly distributed over the solid angle of the cone.
fn direction_in_cone(angle: f64, [along, around]: [f64; 2]) -> [f64; 3] {
    let cosine = 1.0 - along * (1.0 - libm::cos(angle / 2.0));
    let sine = (1.0 - cosine * cosine).max(0.0).sqrt();
    let (s, c) = libm::sincos(TAU * around);
    [sine * c, sine * s, cosine]
}

fields! {
    ProximitySensor {
        DETECTED: i32 = Field::new("proximity.detected").text("Whether a surface is detected: 1 or 0.");
        DISTANCE: f64 = Field::new("proximity.distance")
            .unit("m")
            .text("Distance from the sensor's origin to the nearest point; 0: no detection.");
        POINT: f64 = Field::new("proximity.point")
            .elements(3)
            .unit("m")
            .text("The nearest point in the sensor's frame, at the noisy `distance`; 0 0 0: no detection.");
        OBJECT: tatu_object = Field::new("proximity.object").text("The detected object; 0: no detection.");
        NORMAL: f64 = Field::new("proximity.normal")
            .elements(3)
            .unit("1")
            .text("Unit normal at the point, towards the sensor, in the sensor's frame; 0 0 0: no detection.");
    }
}

impl Sensor for ProximitySensor {
    type Plugin = ProximityPlugin;
    const ID: &'static str = "proximity";
    const TEXT: &'static str = "Detects the nearest surface along a ray or in a volume, like V-REP's sensors.";
    const SCHEMAS: &'static [&'static str] = &["proximity/1"];
    const INPUTS: u32 = TATU_IN_DISTANCE | TATU_IN_POINT | TATU_IN_NORMAL | TATU_IN_OBJECT;

    fn params() -> Vec<Param> {
        params()
    }

    fn fields() -> Vec<Field> {
        Self::declared_fields()
    }

    fn create(_: &SharedWorld<'_>, _: Instance, params: &Params<'_>) -> Result<Self> {
        ProximitySettings::read(params)?.check()
    }

    fn beams(&self) -> Result<Beams> {
        Ok(self.beams.clone())
    }

    /// Chooses new random rays for each measurement.
    fn aim(&self, sample: &Sample<'_>, rays: &mut [[f64; 6]]) -> Result {
        let Some(angle) = self.random_cone_angle else { return Ok(()) };
        let mut drawn = vec![0.0; 2 * rays.len()];
        sample.uniform(0, &mut drawn);
        for (ray, two) in rays.iter_mut().zip(drawn.chunks_exact(2)) {
            ray[3..].copy_from_slice(&direction_in_cone(angle, [two[0], two[1]]));
        }
        Ok(())
    }

    fn measure(&self, sample: &Sample<'_>, out: &mut Readout<'_>) -> Result {
        // The host zeroes the fields, so nothing is written without a detection.
        if let Some(echo) = echo_to_report(nearest_echo(sample, self.min_hits), self.min_range) {
            out.set(Self::DETECTED, 1);
            out.set(Self::DISTANCE, echo.distance);
            out.slice(Self::POINT).copy_from_slice(&echo.point);
            out.set(Self::OBJECT, echo.object);
            out.slice(Self::NORMAL).copy_from_slice(&echo.normal);
        }
        Ok(())
    }

    /// Moves the point to the noisy distance, or clears all fields if the noise has removed the detection.
    fn finish(&self, _: &Sample<'_>, out: &mut Readout<'_>) -> Result {
        if out.slice(Self::DETECTED)[0] == 0 {
            // Clear a detection that the noise has removed; without an echo, the fields are already zero.
            if out.slice(Self::OBJECT)[0] != 0 || out.slice(Self::DISTANCE)[0] != 0.0 {
                for field in [Self::DISTANCE, Self::POINT, Self::NORMAL] {
                    out.slice(field).fill(0.0);
                }
                out.slice(Self::OBJECT).fill(0);
            }
            return Ok(());
        }
        let distance = out.slice(Self::DISTANCE)[0];
        let point = out.slice(Self::POINT);
        let before = point.iter().map(|x| x * x).sum::<f64>().sqrt();
        if before > 0.0 && (before - distance).abs() > NOISE_FREE_TOLERANCE * before {
            point.iter_mut().for_each(|x| *x *= distance / before);
        }
        Ok(())
    }
}

/// Relative tolerance for comparing the reported distance with the norm of the detected point. Equality within this
/// tolerance means that no noise was added.
const NOISE_FREE_TOLERANCE: f64 = 1e-9;

#[cfg(test)]
mod tests;
