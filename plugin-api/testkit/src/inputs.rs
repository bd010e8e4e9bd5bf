//! What a sensor gets to measure, and what is filled in where a test leaves it out.

use tatu_plugin_api::{
    abi::*,
    safe::{Beams, Form},
};

use crate::{Error, Random, Result};

/// What one sensor gets. All of it may be left out, `..Inputs::default()`: then no beam meets anything, and the sensor
/// rests at the origin. Arrays have an element for each beam, or for each pixel of an image, lowest row first.
///
/// Points, normals and objects that the kind asks for and a test leaves out follow from the distances of rays: a point
/// lies that far along its ray, its normal looks back along it, and the object is number 1.
#[derive(Debug, Clone, PartialEq)]
pub struct Inputs {
    /// Per beam: m; infinity: it meets nothing.
    pub distance: Vec<f64>,
    /// Per beam: m, in the sensor's frame.
    pub point: Vec<[f64; 3]>,
    /// Per beam: unit vectors in the sensor's frame, towards the sensor.
    pub normal: Vec<[f64; 3]>,
    /// Per beam: the object; 0: none.
    pub object: Vec<tatu_object>,
    /// Per beam: red, green, blue of the surface.
    pub color: Vec<[u8; 3]>,
    /// Per beam: which triangle or face of the object.
    pub primitive: Vec<u32>,
    /// Per pixel: m along the sensor's +z; infinity: nothing.
    pub depth: Vec<f32>,
    /// Per pixel: red, green, blue as the light falls.
    pub pixel_color: Vec<[u8; 3]>,
    /// Per pixel: cosine of the angle between line of sight and normal; 0: nothing.
    pub pixel_cosine: Vec<f32>,
    /// Per pixel: the object; 0: none.
    pub pixel_object: Vec<tatu_object>,
    /// The sensor in the world: x y z (m), quaternion x y z w.
    pub pose: [f64; 7],
    /// Its motion: m/s, then rad/s, world.
    pub twist: [f64; 6],
    /// Its acceleration, without gravity: m/s^2, then rad/s^2, world.
    pub acceleration: [f64; 6],
    /// Position (rad or m), velocity and effort (N m or N) of the joint that it feels.
    pub joint: [f64; 3],
    /// Force (N) and torque (N m) of the force sensor that it feels, in the sensor's frame.
    pub wrench: [f64; 6],
    /// Contacts of the shape that it feels, which is the second one of each.
    pub contacts: Vec<tatu_contact>,
    /// For each contact, friction on that shape, N, world; none: no friction.
    pub frictions: Vec<[f64; 3]>,
    /// Duration of a step, s. Of a batch the first counts.
    pub dt: f64,
    /// Gravity, m/s^2, world. Of a batch the first counts.
    pub gravity: [f64; 3],
    /// Simulated time, s. Of a batch the first counts.
    pub time: f64,
    /// Number of the step, from 0. Of a batch the first counts.
    pub step: u64,
    /// Its random numbers.
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
            dt: 0.005,
            gravity: [0.0, 0.0, -9.81],
            time: 0.0,
            step: 0,
            random: Random::Still,
        }
    }
}

/// How many beams and pixels a sensor has.
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
    /// The same with all that the kind asks for, in full length; what it does not ask for must not be given. `directions`:
    /// where rays point.
    pub fn completed(mut self, asks: u32, beams: &Beams, directions: &[[f64; 3]]) -> Result<Self> {
        let (n_beams, n_pixels) = counts(beams);
        let n = |input: u32, n: usize| if asks & input != 0 { n } else { 0 };
        // A volume's one beam points ahead.
        let direction = |i: usize| directions.get(i).copied().unwrap_or([0.0, 0.0, 1.0]);
        let met = |d: f64| d.is_finite();
        let unknown = f64::INFINITY;
        let distance = filled("distance", self.distance, n(TATU_IN_DISTANCE, n_beams), |_| unknown)?;
        // Without distances of its own a kind may ask for points alone.
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
        Ok(self)
    }
}

/// An array of a length; one that was left out is filled.
fn filled<T>(name: &str, given: Vec<T>, n: usize, fill: impl Fn(usize) -> T) -> Result<Vec<T>> {
    match given.len() {
        0 => Ok((0..n).map(fill).collect()),
        len if len == n => Ok(given),
        len if n == 0 => Err(Error::new(format!(
            "the input `{name}` has {len} elements, but the sensor gets none of it\n  expected: the input declared in INPUTS, \
             and beams for it"
        ))),
        len => Err(Error::new(format!("the input `{name}` has {len} elements, and the sensor {n} beams or pixels"))),
    }
}
