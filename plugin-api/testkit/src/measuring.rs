//! Measures with sensors without a host, with parameters and inputs that the test specifies.

use std::{ffi::c_void, ptr::null};

use tatu_plugin_api::{
    abi::*,
    safe::{Beams, Change, Form, Host, Instance, Owned, Param, Params, Readout, Sample, Sensor, Value, World},
};

use crate::{Inputs, Readings, Result, inputs::counts, random, targets::TargetLists};

/// Creates a sensor with these parameters, and measures once. All other parameters have their defaults.
///
/// # Errors
/// Fails if a parameter or an input does not fit its declaration, or the sensor fails.
pub fn measure<S: Sensor>(params: &[(&str, Value)], inputs: Inputs) -> Result<Readings> {
    SensorBench::<S>::new(params)?.measure(inputs)
}

/// Measures like [`measure`], but with several sensors with the same parameters in one batch, as in a scene. Returns
/// the readings in the order of `inputs`.
///
/// # Errors
/// Fails like [`measure`].
pub fn measure_all<S: Sensor>(params: &[(&str, Value)], inputs: Vec<Inputs>) -> Result<Vec<Readings>> {
    let made: Result<Vec<_>> = inputs.iter().map(|_| SensorBench::<S>::new(params)).collect();
    let mut benches = made?;
    batch(&mut benches.iter_mut().collect::<Vec<_>>(), inputs)
}

/// A sensor without a host, for a sequence of measurements between which its state is retained.
pub struct SensorBench<S: Sensor> {
    sensor: S,
    values: Vec<Value>,
    state: Vec<f64>,
}

impl<S: Sensor> SensorBench<S> {
    /// Creates a sensor with these parameters; all others have their defaults.
    ///
    /// # Errors
    /// Fails if a parameter does not fit its declaration, or the sensor rejects it.
    pub fn new(params: &[(&str, Value)]) -> Result<Self> {
        let values = Param::fill(&S::params(), params)?;
        Ok(SensorBench { sensor: create(&values)?, values, state: vec![0.0; S::STATE] })
    }

    /// Returns the sensor.
    pub fn sensor(&self) -> &S {
        &self.sensor
    }

    /// Changes a parameter, as a script would: the sensor applies the value, or is recreated if it requests that. Its
    /// state is retained.
    ///
    /// # Errors
    /// Fails if there is no such parameter, the value does not fit its declaration, or the sensor rejects the value.
    pub fn set(&mut self, key: &str, value: impl Into<Value>) -> Result {
        let declared = S::params();
        let mut given: Vec<(&str, Value)> = declared
            .iter()
            .map(Param::key)
            .zip(self.values.iter().cloned())
            .filter(|(_, v)| *v != Value::Nil)
            .collect();
        given.push((key, value.into()));
        let values = Param::fill(&declared, &given)?;
        let changed = declared.iter().position(|p| p.key() == key).map_or(0, |at| 1 << at.min(63));
        let mut owned = Owned::default();
        let taken = self.sensor.configure(&Params::new(&owned.values(&values), &declared), changed)?;
        if taken == Change::Rebuild {
            self.sensor = create(&values)?;
        }
        self.values = values;
        Ok(())
    }

    /// Measures once.
    ///
    /// # Errors
    /// Fails if an input does not fit its declaration, or the sensor fails.
    pub fn measure(&mut self, inputs: Inputs) -> Result<Readings> {
        let all = batch(&mut [self], vec![inputs])?;
        all.into_iter().next().ok_or_else(|| crate::Error::new("the sensor returned no reading"))
    }
}

fn create<S: Sensor>(values: &[Value]) -> Result<S> {
    let (declared, host) = (S::params(), Host::without_services());
    let mut owned = Owned::default();
    let instance = Instance { owner: 1, id: 1, seed: 1 };
    Ok(S::create(&World::nowhere(&host), instance, &Params::new(&owned.values(values), &declared))?)
}

/// Inputs and outputs of one sensor in a batch.
struct BatchMember {
    inputs: Inputs,
    readings: Readings,
    rays: Vec<[f64; 6]>,
    /// Number of beams and number of pixels.
    counts: (usize, usize),
}

impl BatchMember {
    fn of<S: Sensor>(sensor: &S, beams: &Beams, inputs: Inputs) -> Result<Self> {
        let directions: &[[f64; 3]] = if let Form::Rays(d) = &beams.form { d } else { &[] };
        let mut rays: Vec<[f64; 6]> = Vec::new();
        if beams.aimed {
            rays.extend(directions.iter().map(|[x, y, z]| [0.0, 0.0, 0.0, *x, *y, *z]));
            aim(sensor, &inputs, &mut rays)?;
        }
        let aimed: Vec<[f64; 3]> = rays.iter().map(|[.., x, y, z]| [*x, *y, *z]).collect();
        let directions = if beams.aimed { &aimed } else { directions };
        let inputs = inputs.completed(S::INPUTS, beams, directions)?;
        let readings = Readings::empty(&S::fields(), beams, inputs.targets.len())?;
        Ok(BatchMember { inputs, readings, rays, counts: counts(beams) })
    }
}

/// Calls [`Sensor::aim`] for one sensor.
fn aim<S: Sensor>(sensor: &S, inputs: &Inputs, rays: &mut [[f64; 6]]) -> Result {
    let sources = [inputs.random.clone()];
    let random = random::table(&sources);
    let raw = tatu_sensor_batch { random: &raw const random, ..null_batch(1, inputs) };
    let (sensor_id, pose, twist) = ([1u64], inputs.pose, inputs.twist);
    let raw = tatu_sensor_batch { sensor: sensor_id.as_ptr(), pose: pose.as_ptr(), twist: twist.as_ptr(), ..raw };
    let targets = TargetLists::of([&inputs.targets[..]]);
    let raw = targets.add_to(S::INPUTS, raw);
    // SAFETY: the batch has one instance and no beams, and its arrays live during the call.
    let sample = unsafe { Sample::new(&raw, 0) };
    Ok(sensor.aim(&sample.before_the_cast(), rays)?)
}

/// Measures with several sensors at once.
fn batch<S: Sensor>(benches: &mut [&mut SensorBench<S>], inputs: Vec<Inputs>) -> Result<Vec<Readings>> {
    let fields = S::fields();
    let mut parts = Vec::new();
    for (bench, inputs) in benches.iter().zip(inputs) {
        let beams = bench.sensor.beams_for(inputs.targets.len())?;
        parts.push(BatchMember::of(&bench.sensor, &beams, inputs)?);
    }
    let Some(first) = parts.first() else { return Ok(Vec::new()) };
    let raw = null_batch(parts.len(), &first.inputs);
    // The batch points to these arrays, which must outlive it.
    let sensors: Vec<tatu_object> = (1..=parts.len() as u64).collect();
    let (beams, pixels) =
        (start_offsets(parts.iter().map(|p| p.counts.0)), start_offsets(parts.iter().map(|p| p.counts.1)));
    let contacts = start_offsets(parts.iter().map(|p| p.inputs.contacts.len()));
    let all = BatchArrays::of(&parts);
    let sources: Vec<_> = parts.iter().map(|p| p.inputs.random.clone()).collect();
    let random = random::table(&sources);
    let states: Vec<*mut c_void> = benches.iter_mut().map(|b| b.state.as_mut_ptr().cast()).collect();
    let (places, lengths): (Vec<_>, Vec<_>) = parts.iter_mut().map(|p| p.readings.places()).unzip();
    let places: Vec<*mut c_void> = places.concat();
    let length_lists: Vec<*const u64> = lengths.iter().map(Vec::as_ptr).collect();
    let rays: Vec<*mut f64> = parts.iter_mut().map(|p| p.rays.as_mut_ptr().cast()).collect();
    let asked = |input: u32| S::INPUTS & input != 0;
    let raw = tatu_sensor_batch {
        n_fields: fields.len() as u32,
        state: states.as_ptr(),
        sensor: sensors.as_ptr(),
        first_beam: beams.as_ptr(),
        distance: ptr_or_null(&all.distance),
        point: ptr_or_null(&all.point).cast(),
        normal: ptr_or_null(&all.normal).cast(),
        object: ptr_or_null(&all.object),
        color: ptr_or_null(&all.color).cast(),
        primitive: ptr_or_null(&all.primitive),
        first_pixel: pixels.as_ptr(),
        depth: ptr_or_null(&all.depth),
        pixel_color: ptr_or_null(&all.pixel_color).cast(),
        pixel_cosine: ptr_or_null(&all.pixel_cosine),
        pixel_object: ptr_or_null(&all.pixel_object),
        pose: if asked(TATU_IN_POSE) { all.pose.as_ptr().cast() } else { null() },
        twist: if asked(TATU_IN_TWIST) { all.twist.as_ptr().cast() } else { null() },
        acceleration: if asked(TATU_IN_ACCELERATION) { all.acceleration.as_ptr().cast() } else { null() },
        joint: if asked(TATU_IN_JOINT) { all.joint.as_ptr().cast() } else { null() },
        wrench: if asked(TATU_IN_WRENCH) { all.wrench.as_ptr().cast() } else { null() },
        first_contact: contacts.as_ptr(),
        contact: ptr_or_null(&all.contact),
        friction: ptr_or_null(&all.friction).cast(),
        fields: places.as_ptr(),
        random: &raw const random,
        rays: if parts.iter().any(|p| !p.rays.is_empty()) { rays.as_ptr() } else { null() },
        lengths: length_lists.as_ptr(),
        ..raw
    };
    let targets = TargetLists::of(parts.iter().map(|p| &p.inputs.targets[..]));
    let raw = targets.add_to(S::INPUTS, raw);
    for (i, bench) in benches.iter().enumerate() {
        // SAFETY: the arrays above are as the header requires: those that the kind requests have one element per beam
        // or pixel, and all others are null. They live until the end of this function, and nothing else uses them; each
        // instance has its own fields and state block.
        let (sample, mut out) = unsafe { (Sample::new(&raw, i), Readout::new(&raw, i, &fields, S::STATE)) };
        bench.sensor.measure(&sample, &mut out)?;
    }
    let done = parts.into_iter().zip(benches.iter()).map(|(part, bench)| {
        let mut readings = part.readings.checked()?;
        readings.state.clone_from(&bench.state);
        Ok(readings)
    });
    done.collect()
}

/// The arrays of a batch, which are the concatenated arrays of its parts.
struct BatchArrays {
    distance: Vec<f64>,
    point: Vec<[f64; 3]>,
    normal: Vec<[f64; 3]>,
    object: Vec<tatu_object>,
    color: Vec<[u8; 3]>,
    primitive: Vec<u32>,
    depth: Vec<f32>,
    pixel_color: Vec<[u8; 3]>,
    pixel_cosine: Vec<f32>,
    pixel_object: Vec<tatu_object>,
    pose: Vec<[f64; 7]>,
    twist: Vec<[f64; 6]>,
    acceleration: Vec<[f64; 6]>,
    joint: Vec<[f64; 3]>,
    wrench: Vec<[f64; 6]>,
    contact: Vec<tatu_contact>,
    friction: Vec<[f64; 3]>,
}

impl BatchArrays {
    fn of(parts: &[BatchMember]) -> Self {
        fn all<T: Copy>(parts: &[BatchMember], get: impl Fn(&Inputs) -> &[T]) -> Vec<T> {
            parts.iter().flat_map(|p| get(&p.inputs).iter().copied()).collect()
        }
        BatchArrays {
            distance: all(parts, |i| &i.distance),
            point: all(parts, |i| &i.point),
            normal: all(parts, |i| &i.normal),
            object: all(parts, |i| &i.object),
            color: all(parts, |i| &i.color),
            primitive: all(parts, |i| &i.primitive),
            depth: all(parts, |i| &i.depth),
            pixel_color: all(parts, |i| &i.pixel_color),
            pixel_cosine: all(parts, |i| &i.pixel_cosine),
            pixel_object: all(parts, |i| &i.pixel_object),
            pose: parts.iter().map(|p| p.inputs.pose).collect(),
            twist: parts.iter().map(|p| p.inputs.twist).collect(),
            acceleration: parts.iter().map(|p| p.inputs.acceleration).collect(),
            joint: parts.iter().map(|p| p.inputs.joint).collect(),
            wrench: parts.iter().map(|p| p.inputs.wrench).collect(),
            contact: all(parts, |i| &i.contacts),
            friction: all(parts, |i| &i.frictions),
        }
    }
}

/// Returns a pointer to the first element, or null if the array is empty because the kind does not request it.
fn ptr_or_null<T>(all: &[T]) -> *const T {
    if all.is_empty() { null() } else { all.as_ptr() }
}

/// Returns the start offset of each part, followed by the end offset of the last part.
fn start_offsets(lengths: impl Iterator<Item = usize>) -> Vec<u64> {
    let mut out = vec![0];
    lengths.for_each(|n| out.push(out.last().copied().unwrap_or(0) + n as u64));
    out
}

/// Returns a batch of `n` sensors in which all arrays are null.
fn null_batch(n: usize, inputs: &Inputs) -> tatu_sensor_batch {
    tatu_sensor_batch {
        size: size_of::<tatu_sensor_batch>() as u32,
        n: n as u32,
        n_fields: 0,
        reserved: 0,
        time: inputs.time,
        step: inputs.step,
        data: null(),
        state: null(),
        sensor: null(),
        first_beam: null(),
        distance: null(),
        point: null(),
        normal: null(),
        object: null(),
        pose: null(),
        twist: null(),
        fields: null(),
        status: std::ptr::null_mut(),
        color: null(),
        primitive: null(),
        first_pixel: null(),
        depth: null(),
        pixel_color: null(),
        pixel_cosine: null(),
        pixel_object: null(),
        random: null(),
        rays: null(),
        lengths: null(),
        dt: inputs.dt,
        gravity: inputs.gravity,
        acceleration: null(),
        joint: null(),
        first_contact: null(),
        contact: null(),
        friction: null(),
        wrench: null(),
        hit_twist: null(),
        first_target: null(),
        target: null(),
        target_pose: null(),
        target_twist: null(),
    }
}
