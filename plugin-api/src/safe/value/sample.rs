//! Input and output of a measurement: one sensor of a batch.

use std::ffi::c_void;

use crate::abi::*;
use crate::safe::value::field::{Element, Field, TypedField};

/// The input of one sensor of a batch.
pub struct Sample<'a> {
    batch: &'a tatu_sensor_batch,
    i: usize,
    /// Whether rays have been aimed and cast.
    cast: bool,
}

impl<'a> Sample<'a> {
    /// The input of instance `i` of a batch: for a host, or what stands in for one in tests.
    ///
    /// # Safety
    /// The batch is valid for `'a` as `tatu/sensor.h` describes it, and has this instance.
    pub unsafe fn new(batch: &'a tatu_sensor_batch, i: usize) -> Self {
        Sample { batch, i, cast: true }
    }
    /// The same while rays are being aimed, without the rays.
    pub fn before_the_cast(&self) -> Sample<'a> {
        Sample { cast: false, ..*self }
    }
    /// The value of this instance in an array that has one for each; `None` where there is no such array.
    fn own<T: Copy>(&self, array: *const T) -> Option<T> {
        // SAFETY: the host's arrays are null or have one for each instance.
        (!array.is_null()).then(|| unsafe { *array.add(self.i) })
    }
    /// The part of this instance in an array of parts, whose end offsets are in another array.
    fn part<T>(&self, ends: *const u64, array: *const T) -> &'a [T] {
        if ends.is_null() || array.is_null() {
            return &[];
        }
        // SAFETY: the host gives n + 1 ends, and its arrays hold all parts of the batch.
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
    /// Simulation time, s.
    pub fn time(&self) -> f64 {
        self.batch.time
    }
    /// The sensor.
    pub fn sensor(&self) -> tatu_object {
        self.own(self.batch.sensor).unwrap_or_default()
    }
    /// Per beam: distance, m; infinity: no hit. Requires `TATU_IN_DISTANCE`.
    pub fn distances(&self) -> &'a [f64] {
        self.per_beam(self.batch.distance)
    }
    /// Per beam: point, sensor frame, m. `TATU_IN_POINT`.
    pub fn points(&self) -> &'a [[f64; 3]] {
        self.per_beam(self.batch.point.cast())
    }
    /// Per beam: unit normal, sensor frame. `TATU_IN_NORMAL`.
    pub fn normals(&self) -> &'a [[f64; 3]] {
        self.per_beam(self.batch.normal.cast())
    }
    /// Per beam: the object hit. `TATU_IN_OBJECT`.
    pub fn objects(&self) -> &'a [tatu_object] {
        self.per_beam(self.batch.object)
    }
    /// Per beam: red green blue. `TATU_IN_COLOR`.
    pub fn colors(&self) -> &'a [[u8; 3]] {
        self.per_beam(self.batch.color.cast())
    }
    /// Per beam: which triangle or face. `TATU_IN_PRIMITIVE`.
    pub fn primitives(&self) -> &'a [u32] {
        self.per_beam(self.batch.primitive)
    }

    /// Per pixel, the lowest row first: depth along +z, m; infinity: no hit. `TATU_IN_DISTANCE`.
    pub fn depths(&self) -> &'a [f32] {
        self.per_pixel(self.batch.depth)
    }
    /// Per pixel: red green blue. `TATU_IN_COLOR`.
    pub fn pixel_colors(&self) -> &'a [[u8; 3]] {
        self.per_pixel(self.batch.pixel_color.cast())
    }
    /// Per pixel: cosine of the angle between line of sight and normal. `TATU_IN_COSINE`.
    pub fn pixel_cosines(&self) -> &'a [f32] {
        self.per_pixel(self.batch.pixel_cosine)
    }
    /// Per pixel: the object hit. `TATU_IN_OBJECT`.
    pub fn pixel_objects(&self) -> &'a [tatu_object] {
        self.per_pixel(self.batch.pixel_object)
    }

    /// Per beam: where it begins and points, in the sensor's frame; empty if they are not aimed.
    pub fn rays(&self) -> &'a [[f64; 6]] {
        // SAFETY: nobody changes them after the cast.
        if self.cast { unsafe { self.rays_to_aim() } } else { &[] }
    }
    /// # Safety
    /// They are not aliased meanwhile.
    pub(crate) unsafe fn rays_to_aim(&self) -> &'a mut [[f64; 6]] {
        let rays = self.own(self.batch.rays).unwrap_or(std::ptr::null_mut());
        let ends = self.batch.first_beam;
        if rays.is_null() || ends.is_null() {
            return &mut [];
        }
        // SAFETY: 6 numbers for each ray of this instance; the caller promises the rest.
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
        // SAFETY: null, or the host's generator, which is valid for this call. Without one `out` is left as it is.
        if let Some(random) = unsafe { self.batch.random.as_ref() }
            && let Some(fill) = fill(random)
        {
            // SAFETY: `out` has room for the count that is passed.
            unsafe { fill(random, self.i as u32, first, out.len() as u64, out.as_mut_ptr()) };
        }
    }
    /// Uniform random numbers in [0, 1): those of this sensor's measurement from index `first` on.
    pub fn uniform(&self, first: u64, out: &mut [f64]) {
        self.draw(|r| r.uniform, first, out);
    }
    /// Random numbers of the normal distribution, mean 0, standard deviation 1.
    pub fn normal(&self, first: u64, out: &mut [f64]) {
        self.draw(|r| r.normal, first, out);
    }

    /// The sensor's pose in the world: x y z (m), quaternion x y z w. `None` without `TATU_IN_POSE` in its inputs.
    pub fn pose(&self) -> Option<[f64; 7]> {
        self.own(self.batch.pose.cast())
    }
    /// The twist of its mount: m/s, then rad/s, world. `None` without `TATU_IN_TWIST` in its inputs.
    pub fn twist(&self) -> Option<[f64; 6]> {
        self.own(self.batch.twist.cast())
    }
}

/// The output of a sensor: its fields, in the order of declaration.
pub struct Readout<'a> {
    /// Address and number of elements of each.
    places: &'a [*mut c_void],
    lengths: &'a [u64],
    fields: &'a [Field],
    state: &'a mut [f64],
}

impl<'a> Readout<'a> {
    /// The output of instance `i` of a batch: for a host, or what stands in for one in tests.
    ///
    /// # Safety
    /// The batch is valid for `'a` as `tatu/sensor.h` describes it, and has this instance, whose fields (of the types in
    /// `fields`) and state block of `state` numbers nobody else uses.
    pub unsafe fn new(batch: &'a tatu_sensor_batch, i: usize, fields: &'a [Field], state: usize) -> Self {
        let state: &mut [f64] = match state {
            0 => &mut [],
            // SAFETY: one block per instance, of as many numbers as declared, aligned to them.
            n => unsafe { std::slice::from_raw_parts_mut((*batch.state.add(i)).cast(), n) },
        };
        let n = batch.n_fields as usize;
        if n == 0 {
            return Readout { places: &[], lengths: &[], fields, state };
        }
        // SAFETY: one place and one length per instance and field.
        unsafe {
            let places = std::slice::from_raw_parts(batch.fields.add(i * n), n);
            Readout { places, lengths: std::slice::from_raw_parts(*batch.lengths.add(i), n), fields, state }
        }
    }
}

impl Readout<'_> {
    fn of_number<T: Element>(&mut self, k: usize) -> &mut [T] {
        let elem = T::ELEM;
        let declared = self.fields.get(k).filter(|f| f.elem == elem);
        let (Some(_), Some(place), Some(n)) = (declared, self.places.get(k), self.lengths.get(k)) else {
            return &mut [];
        };
        // SAFETY: the host gives each field room for as many elements of the declared type, to this instance alone.
        unsafe { std::slice::from_raw_parts_mut(place.cast(), *n as usize) }
    }
    /// Writes a field of one element. Of a field with several it writes the first, of an empty one nothing.
    pub fn set<T: Element>(&mut self, field: TypedField<T>, value: T) {
        if let Some(first) = self.slice(field).first_mut() {
            *first = value;
        }
    }
    /// The elements of a field, in the order of its shape, to be read and written.
    pub fn slice<T: Element>(&mut self, field: TypedField<T>) -> &mut [T] {
        self.of_number(field.index())
    }
    /// The state of this sensor: [`Sensor::STATE`](crate::safe::Sensor::STATE) numbers.
    pub fn state(&mut self) -> &mut [f64] {
        self.state
    }
    /// Field `k`, from 0 in the order of declaration, declared with [`Field::f64`]; empty if it has another type. By name:
    /// [`fields!`](crate::fields).
    pub fn f64(&mut self, k: usize) -> &mut [f64] {
        self.of_number(k)
    }
    /// Field `k`, declared with [`Field::i32`].
    pub fn i32(&mut self, k: usize) -> &mut [i32] {
        self.of_number(k)
    }
    /// Field `k`, declared with [`Field::f32`].
    pub fn f32(&mut self, k: usize) -> &mut [f32] {
        self.of_number(k)
    }
    /// Field `k`, declared with [`Field::u16`].
    pub fn u16(&mut self, k: usize) -> &mut [u16] {
        self.of_number(k)
    }
    /// Field `k`, declared with [`Field::u8`].
    pub fn u8(&mut self, k: usize) -> &mut [u8] {
        self.of_number(k)
    }
    /// Field `k`, declared with [`Field::object`].
    pub fn object(&mut self, k: usize) -> &mut [tatu_object] {
        self.of_number(k)
    }
}
