//! Compares the units of declarations with what the plugin computes.
//!
//! If a reading is declared in the unit of an input, and changes by 1000 or by 180 / pi for each unit by which the input
//! changes, it is in another unit. The same applies to the forces of actuators and their commands, and to the beams of
//! a sensor and its parameters.

use std::f64::consts::PI;

use tatu_core::plugins::{ParameterSpec, SensorKind, units as declared_units};
use tatu_plugin_api::{abi::*, safe::Value};
use toml_edit::Document;

use super::{
    batch_copy::{BatchCall, BatchInputs, SensorOutput},
    finding::error,
    judge,
};

/// Factors between units that are confused, the tolerance with which they are recognized, and their descriptions.
const FACTORS: [(f64, f64, &str); 13] = [
    (1000.0, 1e-2, "1000, as if it was in thousandths"),
    (0.001, 1e-3, "1/1000, as if it was in thousands"),
    (100.0, 1e-2, "100, as if it was in hundredths"),
    (1e6, 1e-2, "1,000,000, as if it was in millionths"),
    (1e-6, 1e-3, "1/1,000,000, as if it was in millions"),
    (180.0 / PI, 1e-2, "180/pi, as if it was in degrees"),
    (PI / 180.0, 1e-3, "pi/180, as if degrees were converted to radians"),
    (3.6, 1e-3, "3.6, as if it was in km/h"),
    (1.0 / 3.6, 1e-3, "1/3.6, as if km/h were converted to m/s"),
    (30.0 / PI, 1e-3, "30/pi, as if it was in revolutions per minute"),
    (PI / 30.0, 1e-3, "pi/30, as if revolutions per minute were converted to rad/s"),
    (9.806_65, 1e-3, "9.81, the standard gravity"),
    (1.0 / 9.806_65, 1e-3, "1/9.81, as if it was in multiples of the standard gravity"),
];

/// Describes a factor between two units, if the ratio is such a factor.
pub fn confused(ratio: f64) -> Option<&'static str> {
    let is = |(factor, tolerance, _): &&(f64, f64, &str)| (ratio / factor - 1.0).abs() < *tolerance;
    FACTORS.iter().find(is).map(|(_, _, text)| *text)
}

/// A change of inputs: their unit, their description, and the function that makes the change for a number.
struct Change {
    unit: &'static str,
    name: &'static str,
    /// The size of the change.
    size: f64,
    apply: fn(&mut BatchInputs, f64),
}

fn each6(all: &mut Option<Vec<[f64; 6]>>, at: usize, by: f64) {
    all.iter_mut().flatten().for_each(|x| x[at] += by);
}

const CHANGES: [Change; 13] = [
    Change { unit: "m", name: "distance", size: 0.05, apply: move_hits },
    Change {
        unit: "m",
        name: "position",
        size: 0.5,
        apply: |b, by| b.motion.pose.iter_mut().flatten().for_each(|p| p[0] += by),
    },
    Change {
        unit: "m",
        name: "height",
        size: 0.5,
        apply: |b, by| b.motion.pose.iter_mut().flatten().for_each(|p| p[2] += by),
    },
    Change { unit: "rad", name: "heading", size: 0.02, apply: turn },
    Change {
        unit: "rad",
        name: "joint position",
        size: 0.05,
        apply: |b, by| b.motion.joint.iter_mut().flatten().for_each(|j| j[0] += by),
    },
    Change {
        unit: "rad/s",
        name: "joint velocity",
        size: 0.5,
        apply: |b, by| b.motion.joint.iter_mut().flatten().for_each(|j| j[1] += by),
    },
    Change { unit: "m/s", name: "velocity", size: 0.5, apply: |b, by| each6(&mut b.motion.twist, 0, by) },
    Change { unit: "rad/s", name: "angular velocity", size: 0.5, apply: |b, by| each6(&mut b.motion.twist, 5, by) },
    Change { unit: "m/s^2", name: "acceleration", size: 0.5, apply: |b, by| each6(&mut b.motion.acceleration, 0, by) },
    Change {
        unit: "rad/s^2",
        name: "angular acceleration",
        size: 0.5,
        apply: |b, by| each6(&mut b.motion.acceleration, 5, by),
    },
    Change { unit: "N", name: "force", size: 5.0, apply: |b, by| each6(&mut b.motion.wrench, 0, by) },
    Change { unit: "N m", name: "torque", size: 1.0, apply: |b, by| each6(&mut b.motion.wrench, 5, by) },
    Change { unit: "s", name: "time", size: 0.5, apply: |b, by| b.time += by },
];

/// Moves all hits away from the sensor.
fn move_hits(b: &mut BatchInputs, by: f64) {
    for k in 0..b.beams.distance.as_ref().map_or(0, Vec::len) {
        let far = b.beams.distance.as_ref().map_or(0.0, |d| d[k]);
        if far.is_finite() && far > 0.0 {
            b.beams.point.iter_mut().for_each(|p| p[k] = p[k].map(|x| x * (far + by) / far));
            b.beams.distance.iter_mut().for_each(|d| d[k] += by);
        }
    }
    b.pixels.depth.iter_mut().flatten().filter(|d| d.is_finite()).for_each(|d| *d += by as f32);
}

/// Turns all sensors about the vertical axis.
fn turn(b: &mut BatchInputs, by: f64) {
    let (s, c) = libm::sincos(0.5 * by);
    for p in b.motion.pose.iter_mut().flatten() {
        let [_, _, _, x, y, z, w] = *p;
        p[3..].copy_from_slice(&[c * x - s * y, c * y + s * x, c * z + s * w, c * w - s * z]);
    }
}

/// Returns the size of a list of numbers.
fn norm(all: impl Iterator<Item = f64>) -> f64 {
    all.map(|x| x * x).sum::<f64>().sqrt()
}

/// Compares the units of a sensor's readings with those of its inputs.
pub fn sensors(call: &BatchCall<'_>, inputs: &BatchInputs, before: &[Vec<u8>]) {
    let kind = call.kind;
    let n = before.len();
    let measure = |changed: &BatchInputs| {
        before.iter().enumerate().for_each(|(i, s)| call.set_state(i, s));
        call.call(0..n, changed)
    };
    let Some(base) = measure(inputs) else { return };
    for change in &CHANGES {
        if !kind.fields.iter().any(|f| f.unit.as_deref() == Some(change.unit)) {
            continue;
        }
        let at = |by: f64| {
            let mut changed = inputs.clone();
            (change.apply)(&mut changed, by);
            measure(&changed)
        };
        // Two changes of different size must agree, so that rounding and limits are not mistaken for a factor.
        let (Some(small), Some(large)) = (at(change.size), at(1.7 * change.size)) else { continue };
        let fields = kind.fields.iter().enumerate();
        for (k, f) in fields.filter(|(_, f)| f.unit.as_deref() == Some(change.unit)) {
            for i in 0..n {
                let ratio = |now: &[SensorOutput], by: f64| {
                    let [was, is] = [&base, now].map(|o| judge::numbers(f.elem, &o[i].fields[k]));
                    let moved: Vec<f64> = was.iter().zip(&is).map(|(a, b)| b - a).filter(|d| *d != 0.0).collect();
                    // For vectors, the size of the difference counts; for lists of beams, that of each element.
                    let count = if f.dims[0] == 0 { moved.len().max(1) as f64 } else { 1.0 };
                    norm(moved.into_iter()) / (by * count.sqrt())
                };
                let (a, b) = (ratio(&small, change.size), ratio(&large, 1.7 * change.size));
                if let (Some(text), Some(_)) = (confused(a), confused(b))
                    && (a / b - 1.0).abs() < 1e-2
                {
                    let place = format!("sensor `{}`", kind.id);
                    let (unit, name) = (change.unit, change.name);
                    let text = format!(
                        "its field `{}` is declared in {unit}, but changes by {a:.6} {unit} per {unit} of {name}, a \
                         factor of {text}",
                        f.name
                    );
                    error(&place, text);
                    break;
                }
            }
        }
    }
}

/// The numbers of a sensor's beams, by which the units of its parameters are tested.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct BeamNumbers {
    /// Lengths, m.
    pub lengths: Vec<f64>,
    /// Angles, rad.
    pub angles: Vec<f64>,
    /// The directions of rays.
    pub directions: Vec<[f64; 3]>,
}

impl BeamNumbers {
    /// Reads the beams.
    ///
    /// # Safety
    /// The table must conform to the header.
    pub unsafe fn of(b: &tatu_beams) -> Self {
        let d = b.dims;
        let (lengths, angles) = match b.form {
            TATU_BEAMS_GRID | TATU_BEAMS_CONE => (vec![], vec![d[0]]),
            TATU_BEAMS_PYRAMID | TATU_BEAMS_CYLINDER => (d.to_vec(), vec![]),
            TATU_BEAMS_DISC => (vec![d[1]], vec![d[0], d[2]]),
            TATU_BEAMS_PARALLEL => (vec![d[0]], vec![]),
            _ => (vec![], vec![]),
        };
        let n = if b.form == TATU_BEAMS_RAYS && !b.directions.is_null() { b.count[0].min(4096) as usize } else { 0 };
        let directions = match n {
            0 => Vec::new(),
            // SAFETY: by the contract there are 3 numbers per ray.
            n => unsafe { std::slice::from_raw_parts(b.directions.cast::<[f64; 3]>(), n) }.to_vec(),
        };
        BeamNumbers {
            lengths: [b.near_m, b.far_m].into_iter().chain(lengths).collect(),
            angles: angles.into_iter().chain([b.max_incidence]).collect(),
            directions,
        }
    }

    /// Returns by how much the lengths or the angles of the beams differ.
    fn changes(&self, other: &Self, unit: &str) -> Vec<f64> {
        let differences = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| (a - b).abs()).collect::<Vec<f64>>();
        if unit == "m" {
            return differences(&self.lengths, &other.lengths);
        }
        let turned = |(a, b): (&[f64; 3], &[f64; 3])| {
            let cross = [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
            libm::atan2(norm(cross.into_iter()), a[0] * b[0] + a[1] * b[1] + a[2] * b[2])
        };
        let mut all = differences(&self.angles, &other.angles);
        if self.directions.len() == other.directions.len() {
            all.extend(self.directions.iter().zip(&other.directions).map(turned));
        }
        all
    }
}

/// Reports a parameter whose unit is not that of the beams which follow from it. `beams` are those for some values.
pub fn parameter(sensor: &str, p: &ParameterSpec, beams: &[(f64, BeamNumbers)]) {
    let Some(unit) = p.unit.as_deref().filter(|u| ["m", "rad"].contains(u)) else { return };
    let [(a, first), (b, second), (c, third), ..] = beams else { return };
    let ratios = |by: f64, x: &BeamNumbers, y: &BeamNumbers| -> Vec<f64> {
        x.changes(y, unit).into_iter().map(|d| d / by.abs()).collect()
    };
    let (one, two) = (ratios(b - a, first, second), ratios(c - a, first, third));
    // Half angles and half sizes differ by a factor of 2.
    let factors = [1.0, 2.0, 0.5];
    // Angles are confused with degrees, lengths with decimal multiples. Other factors follow from the geometry of beams.
    let fits = |text: &&str| text.contains("degrees") == (unit == "rad") && !text.contains("km/h");
    let of = |ratio: f64| factors.iter().find_map(|f| confused(ratio * f).filter(fits));
    for (x, y) in one.iter().zip(&two) {
        if let (Some(text), Some(_)) = (of(*x), of(*y))
            && (x / y - 1.0).abs() < 1e-3
        {
            let text = format!(
                "its parameter `{}` is declared in {unit}, but its beams change by {x:.6} {unit} for each {unit}, a \
                 factor of {text}",
                p.key
            );
            return error(&format!("sensor `{sensor}`"), text);
        }
    }
}

/// Angles in degrees that are common as bounds and defaults; in radians, they are several turns.
const DEGREES: [f64; 10] = [15.0, 30.0, 45.0, 60.0, 90.0, 120.0, 135.0, 180.0, 270.0, 360.0];

/// Returns a description of a bound or default that is in degrees although the unit is rad, if there is one.
pub fn degrees_for_radians(p: &ParameterSpec) -> Option<String> {
    if p.unit.as_deref() != Some("rad") {
        return None;
    }
    let is = |x: f64| DEGREES.contains(&x.abs());
    match &p.fallback {
        Value::Float(x) if is(*x) => return Some(format!("its default {x} looks like degrees")),
        Value::Floats(all) if all.iter().any(|x| is(*x)) => return Some("its default looks like degrees".into()),
        _ => {}
    }
    let bound = [p.lowest, p.highest].into_iter().find(|x| is(*x))?;
    Some(format!("its bound {bound} looks like degrees"))
}

/// Ratio of a preset's value to the default above which one of them is in another unit.
const PRESET_RATIO: f64 = 300.0;

/// Reports presets that set a length or an angle to a value that is hundreds of times the default, or a small part of it.
pub fn presets(kind: &SensorKind) {
    for preset in &kind.presets {
        let Ok(settings) = Document::parse(preset.settings.as_str()) else { continue };
        for p in &kind.params {
            let unit = p.unit.as_deref();
            let Some(unit) = unit.filter(|u| ["m", "rad", "m/s", "rad/s"].contains(u)) else { continue };
            let key = declared_units::key_with_unit(&p.key, Some(unit));
            let given = settings.get(&key).and_then(|v| v.as_float().or_else(|| v.as_integer().map(|i| i as f64)));
            let factor = declared_units::factor(&key, &p.key, Some(unit));
            let (Some(given), Some(factor), Value::Float(default)) = (given, factor, &p.fallback) else { continue };
            let value = given * factor;
            let ratio = (value / default).abs();
            if value != 0.0 && ratio.is_finite() && !(1.0 / PRESET_RATIO..=PRESET_RATIO).contains(&ratio) {
                let text = format!(
                    "its preset `{}` sets `{}` to {value} {unit}, {ratio:.4} times its default: one of the two is in \
                     another unit",
                    preset.id, p.key
                );
                error(&format!("sensor `{}`", kind.id), text);
            }
        }
    }
}
