//! Input and output of a measurement of one sensor in a batch.

use std::ffi::c_void;

use crate::abi::*;
use crate::safe::value::{
    field::{Element, Field, TypedField},
    target::{Target, TargetArrays},
};

/// The input of one sensor of a batch.
pub struct Sample<'a> {
    batch: &'a tatu_sensor_batch,
    i: usize,
    /// Whether the rays have been aimed and cast.
    cast: bool,
}

impl<'a> Sample<'a> {
    /// Creates the input of instance `i` of a batch. For hosts, and for tests without a host.
    ///
    /// # Safety
    /// `batch` must be valid for `'a`, as described in `tatu/sensor.h`, and `i` must be less than its `n`.
    pub unsafe fn new(batch: &'a tatu_sensor_batch, i: usize) -> Self {
        Sample { batch, i, cast: true }
    }
    /// Returns a copy of the sample without rays, for use while they are being aimed.
    pub fn before_the_cast(&self) -> Sample<'a> {
        Sample { cast: false, ..*self }
    }
    /// Returns this instance's element of an array with one element per instance, or `None` if there is no such array.
    fn own<T: Copy>(&self, array: *const T) -> Option<T> {
        // SAFETY: the host's arrays are null or have one element per instance, and `i` is below `n`.
        (!array.is_null()).then(|| unsafe { *array.add(self.i) })
    }
    /// Returns this instance's part of an array in which the parts of all instances follow each other; part `i` extends
    /// from `ends[i]` to `ends[i + 1]`.
    fn part<T>(&self, ends: *const u64, array: *const T) -> &'a [T] {
        if ends.is_null() || array.is_null() {
            return &[];
        }
        // SAFETY: `ends` has n + 1 entries, and `array` contains all parts of the batch, so the range is within it.
        unsafe {
            let (from, to) = (*ends.add(self.i) as usize, *ends.add(self.i + 1) as usize);
            std::slice::from_raw_parts(array.add(from), to - from)
        }
    }
    fn per_beam<T>(&self, array: *const T) -> &'a [T] {
        self.part(self.batch.first_beam, array)
    }
    fn per_pixel<T>(&self, array: *const T) -> &'a [T] {
        self.part(self.batch.first_pixel, array)
    }
    /// Returns the simulation time, s.
    pub fn time(&self) -> f64 {
        self.batch.time
    }
    /// Returns the duration of the last step, s: a physics step with [`Sensor::EVERY_PHYSICS_STEP`], otherwise a step
    /// of the world.
    ///
    /// [`Sensor::EVERY_PHYSICS_STEP`]: crate::safe::Sensor::EVERY_PHYSICS_STEP
    pub fn dt(&self) -> f64 {
        self.batch.dt
    }
    /// Returns gravity in the world frame, m/s^2.
    pub fn gravity(&self) -> [f64; 3] {
        self.batch.gravity
    }
    /// Returns the sensor's object.
    pub fn sensor(&self) -> tatu_object {
        self.own(self.batch.sensor).unwrap_or_default()
    }
    /// Returns for each beam the distance, m, or infinity if nothing was hit. Requires `TATU_IN_DISTANCE`.
    pub fn distances(&self) -> &'a [f64] {
        self.per_beam(self.batch.distance)
    }
    /// Returns for each beam the point that was hit, sensor frame, m. Requires `TATU_IN_POINT`.
    pub fn points(&self) -> &'a [[f64; 3]] {
        self.per_beam(self.batch.point.cast())
    }
    /// Returns for each beam the unit normal, sensor frame. Requires `TATU_IN_NORMAL`.
    pub fn normals(&self) -> &'a [[f64; 3]] {
        self.per_beam(self.batch.normal.cast())
    }
    /// Returns for each beam the object that was hit. Requires `TATU_IN_OBJECT`.
    pub fn objects(&self) -> &'a [tatu_object] {
        self.per_beam(self.batch.object)
    }
    /// Returns for each beam the colour of the surface, unshaded: red, green, blue. Requires `TATU_IN_COLOR`.
    pub fn colors(&self) -> &'a [[u8; 3]] {
        self.per_beam(self.batch.color.cast())
    }
    /// Returns for each beam the index of the triangle or face that was hit. Requires `TATU_IN_PRIMITIVE`.
    pub fn primitives(&self) -> &'a [u32] {
        self.per_beam(self.batch.primitive)
    }

    /// Returns for each beam the twist of the object that was hit, world frame: m/s, then rad/s; zeros if nothing was
    /// hit. Requires `TATU_IN_HIT_TWIST`.
    pub fn hit_twists(&self) -> &'a [[f64; 6]] {
        self.per_beam(self.batch.hit_twist.cast())
    }

    /// Returns the targets that the scene lists for the sensor, in the order of the list; `None` stands for an object that
    /// does not exist, for instance because it has been removed. Requires `TATU_IN_TARGETS`.
    pub fn targets(&self) -> impl ExactSizeIterator<Item = Option<Target>> + use<'a> {
        let b = self.batch;
        let arrays =
            TargetArrays { first: b.first_target, object: b.target, pose: b.target_pose, twist: b.target_twist };
        // SAFETY: the arrays are those of a batch that is valid for `'a`, and `i` is below its `n`.
        unsafe { arrays.of::<'a>(self.i) }
    }

    /// Returns for each pixel, the lowest row first, the depth along +z, m, or infinity if nothing was hit. Requires
    /// `TATU_IN_DISTANCE`.
    pub fn depths(&self) -> &'a [f32] {
        self.per_pixel(self.batch.depth)
    }
    /// Returns for each pixel the shaded colour: red, green, blue. Requires `TATU_IN_COLOR`.
    pub fn pixel_colors(&self) -> &'a [[u8; 3]] {
        self.per_pixel(self.batch.pixel_color.cast())
    }
    /// Returns for each pixel the cosine of the angle between line of sight and normal. Requires `TATU_IN_COSINE`.
    pub fn pixel_cosines(&self) -> &'a [f32] {
        self.per_pixel(self.batch.pixel_cosine)
    }
    /// Returns for each pixel the object that was hit. Requires `TATU_IN_OBJECT`.
    pub fn pixel_objects(&self) -> &'a [tatu_object] {
        self.per_pixel(self.batch.pixel_object)
    }

    /// Returns for each beam its origin and direction in the sensor's frame; empty if the beams are not aimed.
    pub fn rays(&self) -> &'a [[f64; 6]] {
        // SAFETY: after the cast, the rays are only read, so no mutable reference to them exists.
        if self.cast { unsafe { self.rays_to_aim() } } else { &[] }
    }
    /// Returns the rays of this instance, for [`Sensor::aim`](crate::safe::Sensor::aim) to change.
    ///
    /// # Safety
    /// No other reference to the rays may exist while the returned slice is used.
    pub(crate) unsafe fn rays_to_aim(&self) -> &'a mut [[f64; 6]] {
        let rays = self.own(self.batch.rays).unwrap_or(std::ptr::null_mut());
        let ends = self.batch.first_beam;
        if rays.is_null() || ends.is_null() {
            return &mut [];
        }
        // SAFETY: there are 6 numbers for each ray of this instance; the caller guarantees that they are not aliased.
        unsafe {
            let n = *ends.add(self.i + 1) - *ends.add(self.i);
            std::slice::from_raw_parts_mut(rays.cast(), n as usize)
        }
    }

    fn draw(
        &self,
        fill: impl Fn(&tatu_random) -> Option<unsafe extern "C" fn(*const tatu_random, u32, u64, u64, *mut f64)>,
        first: u64,
        out: &mut [f64],
    ) {
        // SAFETY: `random` is null, or the host's generator, which is valid during the call. Without one, `out` is
        // unchanged.
        if let Some(random) = unsafe { self.batch.random.as_ref() }
            && let Some(fill) = fill(random)
        {
            // SAFETY: `out` has room for the number of values requested.
            unsafe { fill(random, self.i as u32, first, out.len() as u64, out.as_mut_ptr()) };
        }
    }
    /// Fills `out` with uniformly distributed random numbers in [0, 1): those of this measurement, from index `first`.
    pub fn uniform(&self, first: u64, out: &mut [f64]) {
        self.draw(|r| r.uniform, first, out);
    }
    /// Fills `out` with normally distributed random numbers, with mean 0 and standard deviation 1, of this measurement,
    /// from index `first`.
    pub fn normal(&self, first: u64, out: &mut [f64]) {
        self.draw(|r| r.normal, first, out);
    }

    /// Returns the sensor's pose in the world frame: x y z (m), quaternion x y z w; or `None` without `TATU_IN_POSE` in
    /// its inputs.
    pub fn pose(&self) -> Option<[f64; 7]> {
        self.own(self.batch.pose.cast())
    }
    /// Returns the twist of the sensor's mount in the world frame: m/s, then rad/s; or `None` without `TATU_IN_TWIST`
    /// in its inputs.
    pub fn twist(&self) -> Option<[f64; 6]> {
        self.own(self.batch.twist.cast())
    }
    /// Returns the acceleration of the sensor's origin in the world frame, without gravity: m/s^2, then rad/s^2; or
    /// `None` without `TATU_IN_ACCELERATION` in its inputs.
    pub fn acceleration(&self) -> Option<[f64; 6]> {
        self.own(self.batch.acceleration.cast())
    }
    /// Returns position (rad or m), velocity and effort (N m or N) of the observed joint, zeros if there is none; or
    /// `None` without `TATU_IN_JOINT` in its inputs.
    pub fn joint(&self) -> Option<[f64; 3]> {
        self.own(self.batch.joint.cast())
    }
    /// Returns the force (N) and the torque (N m, about the sensor's origin) of the observed force sensor, in the
    /// sensor's frame, zeros if there is none; or `None` without `TATU_IN_WRENCH` in its inputs.
    pub fn wrench(&self) -> Option<[f64; 6]> {
        self.own(self.batch.wrench.cast())
    }
    /// Returns the contacts of the observed shape, which is the second one of each. Requires `TATU_IN_CONTACTS`.
    pub fn contacts(&self) -> &'a [tatu_contact] {
        self.part(self.batch.first_contact, self.batch.contact)
    }
    /// Returns for each contact the friction on the observed shape, world frame, N. Requires `TATU_IN_CONTACTS`.
    pub fn frictions(&self) -> &'a [[f64; 3]] {
        self.part(self.batch.first_contact, self.batch.friction.cast())
    }
    /// Rotates a direction from the world frame to the sensor's frame. Requires `TATU_IN_POSE`, without which `v` is
    /// returned unchanged.
    pub fn to_sensor(&self, v: [f64; 3]) -> [f64; 3] {
        let [_, _, _, x, y, z, w] = self.pose().unwrap_or([0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0]);
        let cross = |a: [f64; 3], b: [f64; 3]| {
            [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
        };
        let axis = [-x, -y, -z];
        let t = cross(axis, v).map(|c| 2.0 * c);
        let u = cross(axis, t);
        [v[0] + w * t[0] + u[0], v[1] + w * t[1] + u[1], v[2] + w * t[2] + u[2]]
    }
}

/// The output of a sensor or actuator: the buffers of its fields, in the order of declaration, and its state.
pub struct Readout<'a> {
    /// Address of each field; `lengths` contains the numbers of elements.
    places: &'a [*mut c_void],
    lengths: &'a [u64],
    fields: &'a [Field],
    state: &'a mut [f64],
}

impl<'a> Readout<'a> {
    /// Creates the output of instance `i` of a batch. For hosts, and for tests without a host.
    ///
    /// # Safety
    /// The batch must be valid for `'a`, as described in `tatu/sensor.h`, and `i` must be less than its `n`. The types
    /// of the fields must be those in `fields`, and the state block must contain `state` numbers. Nothing else may use
    /// the fields and the state block within `'a`.
    pub unsafe fn new(batch: &'a tatu_sensor_batch, i: usize, fields: &'a [Field], state: usize) -> Self {
        let state: &mut [f64] = match state {
            0 => &mut [],
            // SAFETY: there is one block per instance, of the declared number of 8-byte aligned values, which nothing
            // else uses.
            n => unsafe { std::slice::from_raw_parts_mut((*batch.state.add(i)).cast(), n) },
        };
        // SAFETY: there is one address and one length for each field of each instance, and `i` is below the batch's
        // `n`.
        unsafe { Readout::at((batch.fields, batch.lengths, batch.n_fields), i, fields, state) }
    }

    /// Creates the output of instance `i` from arrays of addresses and lengths, `n` fields for each instance.
    ///
    /// # Safety
    /// The arrays must be valid for `'a` and include instance `i`, whose fields nothing else may use within `'a`.
    pub(crate) unsafe fn at(
        (places, lengths, n): (*const *mut c_void, *const *const u64, u32),
        i: usize,
        fields: &'a [Field],
        state: &'a mut [f64],
    ) -> Self {
        let n = n as usize;
        if n == 0 || places.is_null() || lengths.is_null() {
            return Readout { places: &[], lengths: &[], fields, state };
        }
        // SAFETY: the caller guarantees that there is one address and one length for each field of this instance.
        unsafe {
            let places = std::slice::from_raw_parts(places.add(i * n), n);
            Readout { places, lengths: std::slice::from_raw_parts(*lengths.add(i), n), fields, state }
        }
    }

    /// Returns an output without fields or state, for tests of actuators.
    pub fn none() -> Readout<'static> {
        Readout { places: &[], lengths: &[], fields: &[], state: &mut [] }
    }
}

impl Readout<'_> {
    fn of_number<T: Element>(&mut self, k: usize) -> &mut [T] {
        let elem = T::ELEM;
        let declared = self.fields.get(k).filter(|f| f.elem == elem);
        let (Some(_), Some(place), Some(n)) = (declared, self.places.get(k), self.lengths.get(k)) else {
            return &mut [];
        };
        // SAFETY: the host gives each field room for `n` elements of the declared type, which `declared` has matched,
        // and nothing else uses it.
        unsafe { std::slice::from_raw_parts_mut(place.cast(), *n as usize) }
    }
    /// Sets the first element of a field; has no effect if the field is empty.
    pub fn set<T: Element>(&mut self, field: TypedField<T>, value: T) {
        if let Some(first) = self.slice(field).first_mut() {
            *first = value;
        }
    }
    /// Returns the elements of a field, in row-major order, for reading and writing.
    pub fn slice<T: Element>(&mut self, field: TypedField<T>) -> &mut [T] {
        self.of_number(field.index())
    }
    /// Returns the state of this sensor: [`Sensor::STATE`](crate::safe::Sensor::STATE) numbers.
    pub fn state(&mut self) -> &mut [f64] {
        self.state
    }
    /// Returns field `k`, from 0 in the order of declaration, declared with [`Field::f64`]; empty if it has a different
    /// type.
    pub fn f64(&mut self, k: usize) -> &mut [f64] {
        self.of_number(k)
    }
    /// Returns field `k`, declared with [`Field::i32`].
    pub fn i32(&mut self, k: usize) -> &mut [i32] {
        self.of_number(k)
    }
    /// Returns field `k`, declared with [`Field::f32`].
    pub fn f32(&mut self, k: usize) -> &mut [f32] {
        self.of_number(k)
    }
    /// Returns field `k`, declared with [`Field::u16`].
    pub fn u16(&mut self, k: usize) -> &mut [u16] {
        self.of_number(k)
    }
    /// Returns field `k`, declared with [`Field::u8`].
    pub fn u8(&mut self, k: usize) -> &mut [u8] {
        self.of_number(k)
    }
    /// Returns field `k`, declared with [`Field::object`].
    pub fn object(&mut self, k: usize) -> &mut [tatu_object] {
        self.of_number(k)
    }
}
