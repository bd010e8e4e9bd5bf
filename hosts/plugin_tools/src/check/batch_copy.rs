//! Copies of the batches of sensors, with which their plugin can be called again: for some of the sensors, or with
//! other inputs. Inputs are in read-only memory before guard pages.

use std::{cell::RefCell, ffi::c_void, ops::Range};

use tatu_core::plugins::{SensorKind, guarded_copy::GuardedCopy};
use tatu_plugin_api::abi::*;

use super::finding::error;

/// Number of words before and after each output, which must not change.
const MARGIN: usize = 64;
const MARGIN_WORD: u64 = 0xA5C3_96F0_A5C3_96F0;

/// The inputs of sensors, which can be changed.
#[derive(Clone)]
pub struct BatchInputs {
    pub time: f64,
    pub step: u64,
    pub dt: f64,
    pub gravity: [f64; 3],
    pub beams: BeamInputs,
    pub pixels: PixelInputs,
    pub contacts: ContactInputs,
    pub targets: TargetInputs,
    pub motion: MotionInputs,
}

/// Inputs per beam.
#[derive(Clone)]
pub struct BeamInputs {
    pub first_beam: Vec<u64>,
    pub distance: Option<Vec<f64>>,
    pub point: Option<Vec<[f64; 3]>>,
    pub normal: Option<Vec<[f64; 3]>>,
    pub object: Option<Vec<tatu_object>>,
    pub color: Option<Vec<[u8; 3]>>,
    pub primitive: Option<Vec<u32>>,
    pub hit_twist: Option<Vec<[f64; 6]>>,
}

/// Inputs per pixel.
#[derive(Clone)]
pub struct PixelInputs {
    pub first_pixel: Vec<u64>,
    pub depth: Option<Vec<f32>>,
    pub pixel_color: Option<Vec<[u8; 3]>>,
    pub pixel_cosine: Option<Vec<f32>>,
    pub pixel_object: Option<Vec<tatu_object>>,
}

/// Inputs per contact.
#[derive(Clone)]
pub struct ContactInputs {
    pub first_contact: Vec<u64>,
    pub contact: Option<Vec<tatu_contact>>,
    pub friction: Option<Vec<[f64; 3]>>,
}

/// Inputs per target.
#[derive(Clone)]
pub struct TargetInputs {
    pub first_target: Vec<u64>,
    pub target: Option<Vec<tatu_object>>,
    pub target_pose: Option<Vec<[f64; 7]>>,
    pub target_twist: Option<Vec<[f64; 6]>>,
}

/// Inputs per sensor.
#[derive(Clone)]
pub struct MotionInputs {
    pub pose: Option<Vec<[f64; 7]>>,
    pub twist: Option<Vec<[f64; 6]>>,
    pub acceleration: Option<Vec<[f64; 6]>>,
    pub joint: Option<Vec<[f64; 3]>>,
    pub wrench: Option<Vec<[f64; 6]>>,
}

/// What the plugin wrote for one sensor: the bytes of its fields, its state block and its status.
#[derive(Clone, PartialEq)]
pub struct SensorOutput {
    pub fields: Vec<Vec<u8>>,
    pub state: Vec<u8>,
    pub status: tatu_status,
}

/// Copies `range` of an array that is null or has at least that many elements.
///
/// # Safety
/// See above.
unsafe fn part<T: Clone>(first: *const T, range: Range<usize>) -> Option<Vec<T>> {
    // SAFETY: the caller guarantees that an array that is not null has all elements of the range.
    (!first.is_null()).then(|| unsafe { std::slice::from_raw_parts(first.add(range.start), range.len()) }.to_vec())
}

/// Returns the range of beams, pixels or contacts of sensors, by the array of first indices, and these indices relative
/// to the first sensor.
///
/// # Safety
/// The array must be null or have an element for each sensor of the batch, and one more.
unsafe fn span(first: *const u64, sensors: &Range<usize>) -> (Range<usize>, Vec<u64>) {
    // SAFETY: as required of the caller.
    match unsafe { part(first, sensors.start..sensors.end + 1) } {
        Some(all) => {
            let (begin, end) = (all[0], all[all.len() - 1]);
            (begin as usize..end as usize, all.iter().map(|i| i - begin).collect())
        }
        None => (0..0, Vec::new()),
    }
}

impl BatchInputs {
    /// Copies the inputs of some sensors of a batch.
    ///
    /// # Safety
    /// The batch must conform to the header.
    pub unsafe fn of(kind: &SensorKind, batch: &tatu_sensor_batch, sensors: Range<usize>) -> Self {
        // Arrays of inputs that the kind does not declare have no elements.
        let declared = kind.raw.inputs;
        fn only<T>(is_declared: u32, first: *const T) -> *const T {
            if is_declared != 0 { first } else { std::ptr::null() }
        }
        let per_beam = TATU_IN_DISTANCE
            | TATU_IN_POINT
            | TATU_IN_NORMAL
            | TATU_IN_OBJECT
            | TATU_IN_COLOR
            | TATU_IN_PRIMITIVE
            | TATU_IN_HIT_TWIST;
        let per_beam = if kind.in_physics() { 0 } else { declared & per_beam };
        // SAFETY: the caller guarantees that the arrays have the lengths that the header states.
        unsafe {
            let (beams, first_beam) = span(only(per_beam, batch.first_beam), &sensors);
            let (pixels, first_pixel) = span(only(per_beam | declared & TATU_IN_COSINE, batch.first_pixel), &sensors);
            let (contacts, first_contact) = span(only(declared & TATU_IN_CONTACTS, batch.first_contact), &sensors);
            let (targets, first_target) = span(only(declared & TATU_IN_TARGETS, batch.first_target), &sensors);
            BatchInputs {
                time: batch.time,
                step: batch.step,
                dt: batch.dt,
                gravity: batch.gravity,
                beams: BeamInputs {
                    first_beam,
                    distance: part(only(declared & TATU_IN_DISTANCE, batch.distance), beams.clone()),
                    point: part(only(declared & TATU_IN_POINT, batch.point.cast()), beams.clone()),
                    normal: part(only(declared & TATU_IN_NORMAL, batch.normal.cast()), beams.clone()),
                    object: part(only(declared & TATU_IN_OBJECT, batch.object), beams.clone()),
                    color: part(only(declared & TATU_IN_COLOR, batch.color.cast()), beams.clone()),
                    primitive: part(only(declared & TATU_IN_PRIMITIVE, batch.primitive), beams.clone()),
                    hit_twist: part(only(declared & TATU_IN_HIT_TWIST, batch.hit_twist.cast()), beams),
                },
                pixels: PixelInputs {
                    first_pixel,
                    depth: part(only(declared & TATU_IN_DISTANCE, batch.depth), pixels.clone()),
                    pixel_color: part(only(declared & TATU_IN_COLOR, batch.pixel_color.cast()), pixels.clone()),
                    pixel_cosine: part(only(declared & TATU_IN_COSINE, batch.pixel_cosine), pixels.clone()),
                    pixel_object: part(only(declared & TATU_IN_OBJECT, batch.pixel_object), pixels),
                },
                contacts: ContactInputs {
                    first_contact,
                    contact: part(only(declared & TATU_IN_CONTACTS, batch.contact), contacts.clone()),
                    friction: part(only(declared & TATU_IN_CONTACTS, batch.friction.cast()), contacts),
                },
                targets: TargetInputs {
                    first_target,
                    target: part(only(declared & TATU_IN_TARGETS, batch.target), targets.clone()),
                    target_pose: part(only(declared & TATU_IN_TARGETS, batch.target_pose.cast()), targets.clone()),
                    target_twist: part(only(declared & TATU_IN_TARGETS, batch.target_twist.cast()), targets),
                },
                motion: MotionInputs {
                    pose: part(only(declared & TATU_IN_POSE, batch.pose.cast()), sensors.clone()),
                    twist: part(only(declared & TATU_IN_TWIST, batch.twist.cast()), sensors.clone()),
                    acceleration: part(
                        only(declared & TATU_IN_ACCELERATION, batch.acceleration.cast()),
                        sensors.clone(),
                    ),
                    joint: part(only(declared & TATU_IN_JOINT, batch.joint.cast()), sensors.clone()),
                    wrench: part(only(declared & TATU_IN_WRENCH, batch.wrench.cast()), sensors),
                },
            }
        }
    }
}

/// Memory that ends at guard pages, for the arrays of a batch.
#[derive(Default)]
struct Pages(Vec<GuardedCopy>);

impl Pages {
    fn add<T, U>(&mut self, all: &[T], name: &str) -> *const U {
        // SAFETY: the elements are numbers or tables without padding; their bytes are copied.
        let bytes = unsafe { std::slice::from_raw_parts(all.as_ptr().cast::<u8>(), size_of_val(all)) };
        let copy = GuardedCopy::new(bytes, &format!("the array `{name}` of its batch, which is read-only"));
        let first = copy.first().cast();
        self.0.push(copy);
        first
    }
    fn add_given<T, U>(&mut self, all: Option<&Vec<T>>, name: &str) -> *const U {
        all.map_or(std::ptr::null(), |all| self.add(all, name))
    }
}

/// A buffer for the elements of a field, between words that must not change.
struct FieldBuffer {
    words: Vec<u64>,
    bytes: usize,
}

impl FieldBuffer {
    fn new(bytes: usize) -> Self {
        let mut words = vec![MARGIN_WORD; 2 * MARGIN + bytes.div_ceil(8)];
        words[MARGIN..MARGIN + bytes.div_ceil(8)].fill(0);
        FieldBuffer { words, bytes }
    }
    fn first(&mut self) -> *mut c_void {
        self.words[MARGIN..].as_mut_ptr().cast()
    }
    fn contents(&self) -> Vec<u8> {
        let end = MARGIN + self.bytes.div_ceil(8);
        let bytes = self.words[MARGIN..end].iter().flat_map(|w| w.to_ne_bytes());
        bytes.take(self.bytes).collect()
    }
    fn is_whole(&self) -> bool {
        let end = MARGIN + self.bytes.div_ceil(8);
        self.words[..MARGIN].iter().chain(&self.words[end..]).all(|w| *w == MARGIN_WORD)
    }
}

/// The random numbers of a part of a batch.
struct ShiftedRandom {
    original: *const tatu_random,
    first: u32,
}

type Draw = unsafe extern "C" fn(*const tatu_random, u32, u64, u64, *mut f64);

unsafe fn draw(
    table: *const tatu_random,
    choose: fn(&tatu_random) -> Option<Draw>,
    i: u32,
    at: [u64; 2],
    out: *mut f64,
) {
    // SAFETY: the plugin passes the table of its batch, whose `ctx` is the shift, and memory for the numbers.
    unsafe {
        let shift = &*(*table).ctx.cast::<ShiftedRandom>();
        if let Some(draw) = choose(&*shift.original) {
            draw(shift.original, i.saturating_add(shift.first), at[0], at[1], out);
        }
    }
}
unsafe extern "C" fn uniform(table: *const tatu_random, i: u32, first: u64, n: u64, out: *mut f64) {
    // SAFETY: the arguments are those of the plugin.
    unsafe { draw(table, |t| t.uniform, i, [first, n], out) };
}
unsafe extern "C" fn normal(table: *const tatu_random, i: u32, first: u64, n: u64, out: *mut f64) {
    // SAFETY: the arguments are those of the plugin.
    unsafe { draw(table, |t| t.normal, i, [first, n], out) };
}

/// Number of bytes of the stack that are overwritten.
const SCRIBBLE_BYTES: usize = 32 << 10;

/// Overwrites the stack below the caller's frame, where the frames of the previously called function were.
#[inline(never)]
pub fn scribble(byte: u8) {
    let mut room = [0u8; SCRIBBLE_BYTES];
    room.fill(byte);
    std::hint::black_box(&mut room);
}

/// Sizes of the elements of fields, bytes.
pub fn element_bytes(elem: u32) -> usize {
    match elem {
        TATU_ELEM_F64 | TATU_ELEM_OBJECT => 8,
        TATU_ELEM_F32 | TATU_ELEM_I32 => 4,
        TATU_ELEM_U16 => 2,
        _ => 1,
    }
}

/// A batch, the size of its state blocks, and the function to call with parts of it.
pub struct BatchCall<'a> {
    pub kind: &'a SensorKind,
    pub batch: &'a tatu_sensor_batch,
    pub run: RefCell<&'a mut dyn FnMut(&tatu_sensor_batch) -> tatu_status>,
}

impl BatchCall<'_> {
    /// The place of findings.
    pub fn place(&self) -> String {
        format!("sensor `{}`", self.kind.id)
    }

    fn state_of(&self, i: usize) -> Option<*mut u8> {
        // SAFETY: the host's batch has a pointer for each sensor, null if there is no state.
        let state = (!self.batch.state.is_null()).then(|| unsafe { *self.batch.state.add(i) })?;
        (!state.is_null()).then_some(state.cast())
    }

    /// Copies the state block of a sensor.
    pub fn state(&self, i: usize) -> Vec<u8> {
        let n = self.kind.life.state_bytes as usize;
        // SAFETY: the block has this size, and no other call uses it.
        self.state_of(i).map_or_else(Vec::new, |s| unsafe { std::slice::from_raw_parts(s, n) }.to_vec())
    }

    /// Overwrites the state block of a sensor.
    pub fn set_state(&self, i: usize, bytes: &[u8]) {
        if let Some(s) = self.state_of(i) {
            // SAFETY: the block has at least this size, and no other call uses it.
            unsafe { std::ptr::copy_nonoverlapping(bytes.as_ptr(), s, bytes.len()) };
        }
    }

    fn field_bytes(&self, i: usize, k: usize) -> usize {
        // SAFETY: the host's batch has the number of elements of each field of each sensor.
        let n = unsafe { *(*self.batch.lengths.add(i)).add(k) };
        n as usize * element_bytes(self.kind.fields[k].elem)
    }

    /// Calls the function for some sensors with these inputs and separate outputs. Returns what it wrote for each of
    /// them, or `None` if it failed.
    pub fn call(&self, sensors: Range<usize>, inputs: &BatchInputs) -> Option<Vec<SensorOutput>> {
        let (n, n_fields) = (sensors.len(), self.kind.fields.len());
        let mut pages = Pages::default();
        let all = sensors.clone().flat_map(|i| (0..n_fields).map(move |k| (i, k)));
        let mut buffers: Vec<FieldBuffer> = all.map(|(i, k)| FieldBuffer::new(self.field_bytes(i, k))).collect();
        let fields: Vec<*mut c_void> = buffers.iter_mut().map(FieldBuffer::first).collect();
        let mut status = vec![TATU_OK; n + 2 * MARGIN];
        let shift = ShiftedRandom { original: self.batch.random, first: sensors.start as u32 };
        let random = tatu_random {
            size: size_of::<tatu_random>() as u32,
            reserved: n as u32,
            ctx: (&raw const shift).cast_mut().cast(),
            uniform: Some(uniform),
            normal: Some(normal),
        };
        let (b, at) = (self.batch, sensors.start);
        fn tail<T>(first: *const T, at: usize) -> *const T {
            if first.is_null() { first } else { first.wrapping_add(at) }
        }
        let firsts = |pages: &mut Pages, all: &Vec<u64>, name: &str| match all.is_empty() {
            true => std::ptr::null(),
            false => pages.add(all, name),
        };
        let batch = tatu_sensor_batch {
            n: n as u32,
            time: inputs.time,
            step: inputs.step,
            dt: inputs.dt,
            gravity: inputs.gravity,
            data: tail(b.data, at),
            state: tail(b.state, at),
            sensor: tail(b.sensor, at),
            rays: tail(b.rays, at),
            lengths: tail(b.lengths, at),
            fields: fields.as_ptr(),
            status: status[MARGIN..].as_mut_ptr(),
            random: &raw const random,
            first_beam: firsts(&mut pages, &inputs.beams.first_beam, "first_beam"),
            first_pixel: firsts(&mut pages, &inputs.pixels.first_pixel, "first_pixel"),
            first_contact: firsts(&mut pages, &inputs.contacts.first_contact, "first_contact"),
            distance: pages.add_given(inputs.beams.distance.as_ref(), "distance"),
            point: pages.add_given(inputs.beams.point.as_ref(), "point"),
            normal: pages.add_given(inputs.beams.normal.as_ref(), "normal"),
            object: pages.add_given(inputs.beams.object.as_ref(), "object"),
            color: pages.add_given(inputs.beams.color.as_ref(), "color"),
            primitive: pages.add_given(inputs.beams.primitive.as_ref(), "primitive"),
            hit_twist: pages.add_given(inputs.beams.hit_twist.as_ref(), "hit_twist"),
            depth: pages.add_given(inputs.pixels.depth.as_ref(), "depth"),
            pixel_color: pages.add_given(inputs.pixels.pixel_color.as_ref(), "pixel_color"),
            pixel_cosine: pages.add_given(inputs.pixels.pixel_cosine.as_ref(), "pixel_cosine"),
            pixel_object: pages.add_given(inputs.pixels.pixel_object.as_ref(), "pixel_object"),
            pose: pages.add_given(inputs.motion.pose.as_ref(), "pose"),
            twist: pages.add_given(inputs.motion.twist.as_ref(), "twist"),
            acceleration: pages.add_given(inputs.motion.acceleration.as_ref(), "acceleration"),
            joint: pages.add_given(inputs.motion.joint.as_ref(), "joint"),
            wrench: pages.add_given(inputs.motion.wrench.as_ref(), "wrench"),
            contact: pages.add_given(inputs.contacts.contact.as_ref(), "contact"),
            friction: pages.add_given(inputs.contacts.friction.as_ref(), "friction"),
            first_target: firsts(&mut pages, &inputs.targets.first_target, "first_target"),
            target: pages.add_given(inputs.targets.target.as_ref(), "target"),
            target_pose: pages.add_given(inputs.targets.target_pose.as_ref(), "target_pose"),
            target_twist: pages.add_given(inputs.targets.target_twist.as_ref(), "target_twist"),
            size: b.size,
            n_fields: b.n_fields,
            reserved: 0,
        };
        // What the plugin reads from its stack before it writes there differs from the call of the host.
        scribble(0xc3);
        let answer = (self.run.borrow_mut())(&batch);
        if let Some(at) = buffers.iter().position(|b| !b.is_whole()) {
            let name = &self.kind.fields[at % n_fields].name;
            error(&self.place(), format!("it writes outside of the field `{name}`"));
        }
        if answer < 0 {
            return None;
        }
        let own = &status[MARGIN..MARGIN + n];
        let output = |j: usize| SensorOutput {
            fields: buffers[j * n_fields..(j + 1) * n_fields].iter().map(FieldBuffer::contents).collect(),
            state: self.state(at + j),
            status: own[j],
        };
        Some((0..n).map(output).collect())
    }
}
