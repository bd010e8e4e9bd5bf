//! Inputs of a measurement, and default values for inputs that a test does not specify.

use tatu_plugin_api::{
    abi::*,
    safe::{Beams, Form, Target},
};

use crate::{Error, Random, Result};

/// The inputs of one sensor. By default no beam hits anything, and the sensor is at rest at the origin. Arrays have one
/// element per beam, or per pixel of an image, lowest row first. An empty array is filled with default values.
///
/// The defaults of points, normals and objects are derived from the distances along rays: each point is at this
/// distance along its ray, its normal points back along the ray, and the object has the id 1.
#[derive(Debug, Clone, PartialEq)]
pub struct Inputs {
    /// Per beam: distance, m; infinity: no hit.
    pub distance: Vec<f64>,
    /// Per beam: point that was hit, m, in the sensor's frame.
    pub point: Vec<[f64; 3]>,
    /// Per beam: unit normal of the surface in the sensor's frame, towards the sensor.
    pub normal: Vec<[f64; 3]>,
    /// Per beam: object that was hit; 0: no hit.
    pub object: Vec<tatu_object>,
    /// Per beam: red, green, blue of the surface.
    pub color: Vec<[u8; 3]>,
    /// Per beam: index of the triangle or face of the object.
    pub primitive: Vec<u32>,
    /// Per pixel: depth along the sensor's +z, m; infinity: no hit.
    pub depth: Vec<f32>,
    /// Per pixel: red, green, blue, shaded.
    pub pixel_color: Vec<[u8; 3]>,
    /// Per pixel: cosine of the angle between line of sight and normal; 0: no hit.
    pub pixel_cosine: Vec<f32>,
    /// Per pixel: object that was hit; 0: no hit.
    pub pixel_object: Vec<tatu_object>,
    /// Pose of the sensor in the world: x y z (m), quaternion x y z w.
    pub pose: [f64; 7],
    /// Linear (m/s), then angular velocity (rad/s) of the sensor, world frame.
    pub twist: [f64; 6],
    /// Linear (m/s^2), then angular acceleration (rad/s^2) of the sensor, without gravity, world frame.
    pub acceleration: [f64; 6],
    /// Position (rad or m), velocity and effort (N m or N) of the observed joint.
    pub joint: [f64; 3],
    /// Force (N) and torque (N m) of the observed force sensor, in the sensor's frame.
    pub wrench: [f64; 6],
    /// Contacts of the observed shape, which is the second shape of each contact.
    pub contacts: Vec<tatu_contact>,
    /// Per contact: friction on the observed shape, N, world frame; if empty, there is no friction.
    pub frictions: Vec<[f64; 3]>,
    /// The sensor's targets; `None` stands for an object that does not exist.
    pub targets: Vec<Option<Target>>,
    /// Duration of a step, s. In a batch, the value of the first sensor is used.
    pub dt: f64,
    /// Gravity, m/s^2, world frame. In a batch, the value of the first sensor is used.
    pub gravity: [f64; 3],
    /// Simulation time, s. In a batch, the value of the first sensor is used.
    pub time: f64,
    /// Index of the step, from 0. In a batch, the value of the first sensor is used.
    pub step: u64,
    /// Source of the sensor's random numbers.
    pub random: Random,
}

impl Default for Inputs {
    fn default() -> Self {
        Inputs {
            distance: Vec::new(),
            point: Vec::new(),
            normal: Vec::new(),
            object: Vec::new(),
            color: Vec::new(),
            primitive: Vec::new(),
            depth: Vec::new(),
            pixel_color: Vec::new(),
            pixel_cosine: Vec::new(),
            pixel_object: Vec::new(),
            pose: [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0],
            twist: [0.0; 6],
            acceleration: [0.0; 6],
            joint: [0.0; 3],
            wrench: [0.0; 6],
            contacts: Vec::new(),
            frictions: Vec::new(),
            targets: Vec::new(),
            dt: 0.005,
            gravity: [0.0, 0.0, -9.81],
            time: 0.0,
            step: 0,
            random: Random::Still,
        }
    }
}

/// Returns the number of beams and of pixels of a sensor.
pub fn counts(beams: &Beams) -> (usize, usize) {
    match &beams.form {
        Form::None => (0, 0),
        Form::Rays(rays) => (rays.len(), 0),
        Form::Cone { .. } | Form::Volume { .. } => (1, 0),
        Form::Image { columns, rows, .. } | Form::Parallel { columns, rows, .. } => {
            (0, *columns as usize * *rows as usize)
        }
    }
}

impl Inputs {
    /// Fills the arrays that are empty and that the kind requests (`asks`, a sum of `TATU_IN_*`). `directions` are
    /// those of the rays. Fails if an array has the wrong length, or is not empty although the kind does not request
    /// it.
    pub fn completed(mut self, asks: u32, beams: &Beams, directions: &[[f64; 3]]) -> Result<Self> {
        let (n_beams, n_pixels) = counts(beams);
        let n = |input: u32, n: usize| if asks & input != 0 { n } else { 0 };
        // The single beam of a volume points along +z.
        let direction = |i: usize| directions.get(i).copied().unwrap_or([0.0, 0.0, 1.0]);
        let met = |d: f64| d.is_finite();
        let unknown = f64::INFINITY;
        let distance = filled("distance", self.distance, n(TATU_IN_DISTANCE, n_beams), |_| unknown)?;
        // `distance` is empty if the kind requests only points.
        let far = |i: usize| distance.get(i).copied().unwrap_or(unknown);
        let along = |i: usize| if met(far(i)) { direction(i).map(|x| x * far(i)) } else { [0.0; 3] };
        let back = |i: usize| if met(far(i)) { direction(i).map(|x| 0.0 - x) } else { [0.0; 3] };
        self.point = filled("point", self.point, n(TATU_IN_POINT, n_beams), along)?;
        self.normal = filled("normal", self.normal, n(TATU_IN_NORMAL, n_beams), back)?;
        self.object = filled("object", self.object, n(TATU_IN_OBJECT, n_beams), |i| u64::from(met(far(i))))?;
        self.color = filled("color", self.color, n(TATU_IN_COLOR, n_beams), |_| [0; 3])?;
        self.primitive = filled("primitive", self.primitive, n(TATU_IN_PRIMITIVE, n_beams), |_| 0)?;
        let depth = filled("depth", self.depth, n(TATU_IN_DISTANCE, n_pixels), |_| f32::INFINITY)?;
        let seen = |i: usize| depth.get(i).is_some_and(|d| d.is_finite());
        self.pixel_color = filled("pixel_color", self.pixel_color, n(TATU_IN_COLOR, n_pixels), |_| [0; 3])?;
        let facing = |i: usize| if seen(i) { 1.0 } else { 0.0 };
        self.pixel_cosine = filled("pixel_cosine", self.pixel_cosine, n(TATU_IN_COSINE, n_pixels), facing)?;
        let one = |i: usize| u64::from(seen(i));
        self.pixel_object = filled("pixel_object", self.pixel_object, n(TATU_IN_OBJECT, n_pixels), one)?;
        let touches = n(TATU_IN_CONTACTS, self.contacts.len());
        self.contacts = filled("contacts", self.contacts, touches, |_| tatu_contact::default())?;
        self.frictions = filled("frictions", self.frictions, touches, |_| [0.0; 3])?;
        (self.distance, self.depth) = (distance, depth);
        if asks & TATU_IN_TARGETS == 0 && !self.targets.is_empty() {
            return Err(Error::new(
                "input `targets`: the sensor does not receive it\n  expected: TATU_IN_TARGETS in INPUTS",
            ));
        }
        Ok(self)
    }
}

/// Returns `given` if it has `n` elements, or a filled array if it is empty; otherwise fails.
fn filled<T>(name: &str, given: Vec<T>, n: usize, fill: impl Fn(usize) -> T) -> Result<Vec<T>> {
    match given.len() {
        0 => Ok((0..n).map(fill).collect()),
        len if len == n => Ok(given),
        len if n == 0 => Err(Error::new(format!(
            "input `{name}` has {len} elements, but the sensor does not receive it\n  expected: the input is declared \
             in INPUTS, and the sensor has beams for it"
        ))),
        len => Err(Error::new(format!("input `{name}` has {len} elements, but must have {n}"))),
    }
}
