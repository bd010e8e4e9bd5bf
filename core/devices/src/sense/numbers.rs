//! The words of a field as its elements, and access to elements of any numeric type as `f64`.

use bytemuck::{Pod, cast_slice, cast_slice_mut};
use tatu_plugin_api::abi::*;

/// Elements to read.
#[derive(Clone, Copy)]
pub enum FieldNumbers<'a> {
    F64(&'a [f64]),
    F32(&'a [f32]),
    I32(&'a [i32]),
    U16(&'a [u16]),
    U8(&'a [u8]),
}

/// Elements to modify.
pub enum FieldNumbersMut<'a> {
    F64(&'a mut [f64]),
    F32(&'a mut [f32]),
    I32(&'a mut [i32]),
    U16(&'a mut [u16]),
    U8(&'a mut [u8]),
}

/// Returns the first `n` elements in these words, which may end within a word.
pub fn elements<T: Pod>(words: &[u64], n: usize) -> &[T] {
    &cast_slice(&words[..(n * size_of::<T>()).div_ceil(8)])[..n]
}

/// Like [`elements`], for elements to modify.
fn elements_mut<T: Pod>(words: &mut [u64], n: usize) -> &mut [T] {
    &mut cast_slice_mut(&mut words[..(n * size_of::<T>()).div_ceil(8)])[..n]
}

impl<'a> FieldNumbers<'a> {
    /// Returns the `n` elements of a field whose words begin `words`, or `None` if their type is not a number.
    pub fn of(words: &'a [u64], elem: u32, n: usize) -> Option<Self> {
        Some(match elem {
            TATU_ELEM_F64 => FieldNumbers::F64(elements(words, n)),
            TATU_ELEM_F32 => FieldNumbers::F32(elements(words, n)),
            TATU_ELEM_I32 => FieldNumbers::I32(elements(words, n)),
            TATU_ELEM_U16 => FieldNumbers::U16(elements(words, n)),
            TATU_ELEM_U8 => FieldNumbers::U8(elements(words, n)),
            _ => return None,
        })
    }

    /// Copies as many elements as `out` has, starting at index `first`.
    pub fn load(&self, first: usize, out: &mut [f64]) {
        fn copy<T: Copy + Into<f64>>(from: &[T], out: &mut [f64]) {
            out.iter_mut().zip(from).for_each(|(o, x)| *o = (*x).into());
        }
        match self {
            FieldNumbers::F64(v) => copy(&v[first..], out),
            FieldNumbers::F32(v) => copy(&v[first..], out),
            FieldNumbers::I32(v) => copy(&v[first..], out),
            FieldNumbers::U16(v) => copy(&v[first..], out),
            FieldNumbers::U8(v) => copy(&v[first..], out),
        }
    }

    /// Returns whether an element is 0.
    pub fn is_zero(&self, i: usize) -> bool {
        match self {
            FieldNumbers::F64(v) => v[i] == 0.0,
            FieldNumbers::F32(v) => v[i] == 0.0,
            FieldNumbers::I32(v) => v[i] == 0,
            FieldNumbers::U16(v) => v[i] == 0,
            FieldNumbers::U8(v) => v[i] == 0,
        }
    }
}

impl<'a> FieldNumbersMut<'a> {
    /// Like [`FieldNumbers::of`], for elements to modify.
    pub fn of(words: &'a mut [u64], elem: u32, n: usize) -> Option<Self> {
        Some(match elem {
            TATU_ELEM_F64 => FieldNumbersMut::F64(elements_mut(words, n)),
            TATU_ELEM_F32 => FieldNumbersMut::F32(elements_mut(words, n)),
            TATU_ELEM_I32 => FieldNumbersMut::I32(elements_mut(words, n)),
            TATU_ELEM_U16 => FieldNumbersMut::U16(elements_mut(words, n)),
            TATU_ELEM_U8 => FieldNumbersMut::U8(elements_mut(words, n)),
            _ => return None,
        })
    }

    pub fn len(&self) -> usize {
        match self {
            FieldNumbersMut::F64(v) => v.len(),
            FieldNumbersMut::F32(v) => v.len(),
            FieldNumbersMut::I32(v) => v.len(),
            FieldNumbersMut::U16(v) => v.len(),
            FieldNumbersMut::U8(v) => v.len(),
        }
    }

    /// Splits the elements into parts of `n` elements; the last part may be shorter.
    pub fn parts(self, n: usize) -> Vec<FieldNumbersMut<'a>> {
        match self {
            FieldNumbersMut::F64(v) => v.chunks_mut(n).map(FieldNumbersMut::F64).collect(),
            FieldNumbersMut::F32(v) => v.chunks_mut(n).map(FieldNumbersMut::F32).collect(),
            FieldNumbersMut::I32(v) => v.chunks_mut(n).map(FieldNumbersMut::I32).collect(),
            FieldNumbersMut::U16(v) => v.chunks_mut(n).map(FieldNumbersMut::U16).collect(),
            FieldNumbersMut::U8(v) => v.chunks_mut(n).map(FieldNumbersMut::U8).collect(),
        }
    }

    /// Returns a view for reading.
    pub fn view(&self) -> FieldNumbers<'_> {
        match self {
            FieldNumbersMut::F64(v) => FieldNumbers::F64(v),
            FieldNumbersMut::F32(v) => FieldNumbers::F32(v),
            FieldNumbersMut::I32(v) => FieldNumbers::I32(v),
            FieldNumbersMut::U16(v) => FieldNumbers::U16(v),
            FieldNumbersMut::U8(v) => FieldNumbers::U8(v),
        }
    }

    /// Stores the numbers that `put` selects, starting at element `first`. Elements of integer fields are set to the
    /// nearest value in their range; halves are rounded to even.
    pub fn store(&mut self, first: usize, from: &[f64], put: &[bool]) {
        fn copy<T: Copy>(to: &mut [T], from: &[f64], put: &[bool], cast: impl Fn(f64) -> T) {
            for ((to, x), put) in to.iter_mut().zip(from).zip(put) {
                *to = if *put { cast(*x) } else { *to };
            }
        }
        match self {
            FieldNumbersMut::F64(v) => copy(&mut v[first..], from, put, |x| x),
            FieldNumbersMut::F32(v) => copy(&mut v[first..], from, put, |x| x as f32),
            // Casts to integers saturate.
            FieldNumbersMut::I32(v) => copy(&mut v[first..], from, put, |x| rounded(x) as i32),
            FieldNumbersMut::U16(v) => copy(&mut v[first..], from, put, |x| rounded(x) as u16),
            FieldNumbersMut::U8(v) => copy(&mut v[first..], from, put, |x| rounded(x) as u8),
        }
    }

    /// Sets an element to 0.
    pub fn clear(&mut self, i: usize) {
        match self {
            FieldNumbersMut::F64(v) => v[i] = 0.0,
            FieldNumbersMut::F32(v) => v[i] = 0.0,
            FieldNumbersMut::I32(v) => v[i] = 0,
            FieldNumbersMut::U16(v) => v[i] = 0,
            FieldNumbersMut::U8(v) => v[i] = 0,
        }
    }
}

/// Rounds to the nearest integer, halves to even. An addition and a subtraction suffice, because the intermediate sum
/// is too large to hold a fraction. They can be vectorised, and yield the same result on every platform.
#[inline(always)]
pub fn rounded(x: f64) -> f64 {
    const ROUNDING_OFFSET: f64 = 6_755_399_441_055_744.0; // 1.5 * 2^52
    let y = (x + ROUNDING_OFFSET) - ROUNDING_OFFSET;
    // Larger numbers are returned unchanged. From 2^52 on, they have no fraction; below, at most a half.
    if x.abs() < 2_251_799_813_685_248.0 { y } else { x }
}
