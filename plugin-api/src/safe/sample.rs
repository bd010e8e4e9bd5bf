//! What a measure of a sensor gets and fills: one sensor of a batch.

use super::sensor::Field;
use crate::abi::*;

/// What one sensor of a batch sees.
pub struct Sample<'a> {
    pub(super) batch: &'a tatu_sensor_batch,
    pub(super) i: usize,
}

impl<'a> Sample<'a> {
    pub(super) fn beams(&self) -> (usize, usize) {
        // SAFETY: `first_beam` has n + 1 entries.
        unsafe { (*self.batch.first_beam.add(self.i) as usize, *self.batch.first_beam.add(self.i + 1) as usize) }
    }
    fn per_beam<T>(&self, ptr: *const T) -> &'a [T] {
        let (from, to) = self.beams();
        if ptr.is_null() || from == to {
            return &[];
        }
        // SAFETY: the host's arrays hold all beams of the batch.
        unsafe { std::slice::from_raw_parts(ptr.add(from), to - from) }
    }
    /// Simulation time, s.
    pub fn time(&self) -> f64 {
        self.batch.time
    }
    /// The sensor.
    pub fn sensor(&self) -> tatu_object {
        // SAFETY: one per instance.
        unsafe { *self.batch.sensor.add(self.i) }
    }
    /// Per beam: distance, m; infinity: nothing. Asked for with `TATU_IN_DISTANCE`.
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
    /// Per beam: the object seen. `TATU_IN_OBJECT`.
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

    fn pixels(&self) -> (usize, usize) {
        if self.batch.first_pixel.is_null() {
            return (0, 0);
        }
        // SAFETY: `first_pixel` has n + 1 entries.
        unsafe { (*self.batch.first_pixel.add(self.i) as usize, *self.batch.first_pixel.add(self.i + 1) as usize) }
    }
    fn per_pixel<T>(&self, ptr: *const T) -> &'a [T] {
        let (from, to) = self.pixels();
        if ptr.is_null() || from == to {
            return &[];
        }
        // SAFETY: the host's arrays hold all pixels of the batch.
        unsafe { std::slice::from_raw_parts(ptr.add(from), to - from) }
    }
    /// Per pixel, the lowest row first: m along +z; infinity: nothing. `TATU_IN_DISTANCE`.
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
    /// Per pixel: the object seen. `TATU_IN_OBJECT`.
    pub fn pixel_objects(&self) -> &'a [tatu_object] {
        self.per_pixel(self.batch.pixel_object)
    }

    /// Per beam: where it begins and points, in the sensor's frame; empty if they are not aimed.
    pub fn rays(&self) -> &'a [[f64; 6]] {
        let (from, to) = self.beams();
        match self.ray_list() {
            // SAFETY: 6 numbers per ray of this instance.
            Some(rays) => unsafe { std::slice::from_raw_parts(rays, to - from) },
            None => &[],
        }
    }
    pub(super) fn ray_list(&self) -> Option<*mut [f64; 6]> {
        // An older host has no such list.
        if (self.batch.size as usize) < size_of::<tatu_sensor_batch>() || self.batch.rays.is_null() {
            return None;
        }
        // SAFETY: one entry per instance.
        let rays = unsafe { *self.batch.rays.add(self.i) };
        (!rays.is_null()).then_some(rays.cast())
    }

    fn draw(
        &self,
        fill: impl Fn(&tatu_random) -> Option<unsafe extern "C" fn(*const tatu_random, u32, u64, u64, *mut f64)>,
        first: u64,
        out: &mut [f64],
    ) {
        // SAFETY: the host's generator, or null from a host that has none: then the numbers stay as they are.
        if let Some(random) = unsafe { self.batch.random.as_ref() }
            && let Some(fill) = fill(random)
        {
            // SAFETY: `out` has as many places as asked for.
            unsafe { fill(random, self.i as u32, first, out.len() as u64, out.as_mut_ptr()) };
        }
    }
    /// Numbers from 0 to below 1: those with the indices from `first` on of this sensor's measure.
    pub fn uniform(&self, first: u64, out: &mut [f64]) {
        self.draw(|r| r.uniform, first, out);
    }
    /// Numbers of the normal distribution, mean 0, standard deviation 1.
    pub fn normal(&self, first: u64, out: &mut [f64]) {
        self.draw(|r| r.normal, first, out);
    }

    /// The sensor's pose in the world. `TATU_IN_POSE`.
    pub fn pose(&self) -> Option<[f64; 7]> {
        // SAFETY: 7 per instance, if asked for.
        (!self.batch.pose.is_null()).then(|| unsafe { *self.batch.pose.cast::<[f64; 7]>().add(self.i) })
    }
    /// The twist of its mount. `TATU_IN_TWIST`.
    pub fn twist(&self) -> Option<[f64; 6]> {
        // SAFETY: 6 per instance, if asked for.
        (!self.batch.twist.is_null()).then(|| unsafe { *self.batch.twist.cast::<[f64; 6]>().add(self.i) })
    }
}

/// Where a sensor writes its fields, in the order of declaration.
pub struct Readout<'a> {
    pub(super) sample: &'a Sample<'a>,
    pub(super) fields: &'a [Field],
    /// Rows and columns of the sensor's image.
    pub(super) image: (u32, u32),
    pub(super) own: [u32; 4],
}

impl Readout<'_> {
    fn slice<T>(&mut self, k: usize, elem: u32) -> &mut [T] {
        let Some(field) = self.fields.get(k).filter(|f| f.elem == elem) else {
            return &mut [];
        };
        let count = |(from, to): (usize, usize)| to - from;
        let all = count(self.sample.beams()) + count(self.sample.pixels());
        let dim = |d: &u32| match *d {
            0 => all,
            TATU_DIM_ROWS => self.image.0 as usize,
            TATU_DIM_COLUMNS => self.image.1 as usize,
            d if (TATU_DIM_OWN..TATU_DIM_OWN + 4).contains(&d) => self.own[(d - TATU_DIM_OWN) as usize] as usize,
            n => n as usize,
        };
        let len: usize = field.dims.iter().map(dim).product();
        // SAFETY: the host gives one buffer per instance and field, as large as declared.
        unsafe {
            let at = *self.sample.batch.fields.add(self.sample.i * self.sample.batch.n_fields as usize + k);
            std::slice::from_raw_parts_mut(at.cast(), len)
        }
    }
    /// Field `k`, declared with [`Field::f64`].
    pub fn f64(&mut self, k: usize) -> &mut [f64] {
        self.slice(k, TATU_ELEM_F64)
    }
    /// Field `k`, declared with [`Field::i32`].
    pub fn i32(&mut self, k: usize) -> &mut [i32] {
        self.slice(k, TATU_ELEM_I32)
    }
    /// Field `k`, declared with [`Field::f32`].
    pub fn f32(&mut self, k: usize) -> &mut [f32] {
        self.slice(k, TATU_ELEM_F32)
    }
    /// Field `k`, declared with [`Field::u16`].
    pub fn u16(&mut self, k: usize) -> &mut [u16] {
        self.slice(k, TATU_ELEM_U16)
    }
    /// Field `k`, declared with [`Field::u8`].
    pub fn u8(&mut self, k: usize) -> &mut [u8] {
        self.slice(k, TATU_ELEM_U8)
    }
    /// Field `k`, declared with [`Field::object`].
    pub fn object(&mut self, k: usize) -> &mut [tatu_object] {
        self.slice(k, TATU_ELEM_OBJECT)
    }
}
