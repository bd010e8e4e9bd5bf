//! The elements of a field as numbers, whatever their type.

use tatu_plugin_api::abi::*;

/// Elements to be read.
#[derive(Clone, Copy)]
pub(super) enum Numbers<'a> {
    F64(&'a [f64]),
    F32(&'a [f32]),
    I32(&'a [i32]),
    U16(&'a [u16]),
    U8(&'a [u8]),
}

/// Elements to be changed.
pub(super) enum NumbersMut<'a> {
    F64(&'a mut [f64]),
    F32(&'a mut [f32]),
    I32(&'a mut [i32]),
    U16(&'a mut [u16]),
    U8(&'a mut [u8]),
}

impl<'a> Numbers<'a> {
    /// The `n` elements of a type that begin at `at`; `None`: they are no numbers.
    ///
    /// # Safety
    /// They are there, aligned, and nobody writes to them while this lives.
    pub unsafe fn at(at: *const u64, elem: u32, n: usize) -> Option<Self> {
        use std::slice::from_raw_parts as slice;
        // SAFETY: as promised.
        unsafe {
            Some(match elem {
                TATU_ELEM_F64 => Numbers::F64(slice(at.cast(), n)),
                TATU_ELEM_F32 => Numbers::F32(slice(at.cast(), n)),
                TATU_ELEM_I32 => Numbers::I32(slice(at.cast(), n)),
                TATU_ELEM_U16 => Numbers::U16(slice(at.cast(), n)),
                TATU_ELEM_U8 => Numbers::U8(slice(at.cast(), n)),
                _ => return None,
            })
        }
    }

    /// Copies elements from `first` on.
    pub fn load(&self, first: usize, out: &mut [f64]) {
        fn copy<T: Copy + Into<f64>>(from: &[T], out: &mut [f64]) {
            out.iter_mut().zip(from).for_each(|(o, x)| *o = (*x).into());
        }
        match self {
            Numbers::F64(v) => copy(&v[first..], out),
            Numbers::F32(v) => copy(&v[first..], out),
            Numbers::I32(v) => copy(&v[first..], out),
            Numbers::U16(v) => copy(&v[first..], out),
            Numbers::U8(v) => copy(&v[first..], out),
        }
    }

    /// Whether an element is 0.
    pub fn is_zero(&self, i: usize) -> bool {
        match self {
            Numbers::F64(v) => v[i] == 0.0,
            Numbers::F32(v) => v[i] == 0.0,
            Numbers::I32(v) => v[i] == 0,
            Numbers::U16(v) => v[i] == 0,
            Numbers::U8(v) => v[i] == 0,
        }
    }
}

impl<'a> NumbersMut<'a> {
    /// # Safety
    /// As [`Numbers::at`], and nobody reads them either.
    pub unsafe fn at(at: *mut u64, elem: u32, n: usize) -> Option<Self> {
        use std::slice::from_raw_parts_mut as slice;
        // SAFETY: as promised.
        unsafe {
            Some(match elem {
                TATU_ELEM_F64 => NumbersMut::F64(slice(at.cast(), n)),
                TATU_ELEM_F32 => NumbersMut::F32(slice(at.cast(), n)),
                TATU_ELEM_I32 => NumbersMut::I32(slice(at.cast(), n)),
                TATU_ELEM_U16 => NumbersMut::U16(slice(at.cast(), n)),
                TATU_ELEM_U8 => NumbersMut::U8(slice(at.cast(), n)),
                _ => return None,
            })
        }
    }

    pub fn len(&self) -> usize {
        match self {
            NumbersMut::F64(v) => v.len(),
            NumbersMut::F32(v) => v.len(),
            NumbersMut::I32(v) => v.len(),
            NumbersMut::U16(v) => v.len(),
            NumbersMut::U8(v) => v.len(),
        }
    }

    /// Parts of `n` elements, the last one of what is left.
    pub fn parts(self, n: usize) -> Vec<NumbersMut<'a>> {
        match self {
            NumbersMut::F64(v) => v.chunks_mut(n).map(NumbersMut::F64).collect(),
            NumbersMut::F32(v) => v.chunks_mut(n).map(NumbersMut::F32).collect(),
            NumbersMut::I32(v) => v.chunks_mut(n).map(NumbersMut::I32).collect(),
            NumbersMut::U16(v) => v.chunks_mut(n).map(NumbersMut::U16).collect(),
            NumbersMut::U8(v) => v.chunks_mut(n).map(NumbersMut::U8).collect(),
        }
    }

    /// To read.
    pub fn view(&self) -> Numbers<'_> {
        match self {
            NumbersMut::F64(v) => Numbers::F64(v),
            NumbersMut::F32(v) => Numbers::F32(v),
            NumbersMut::I32(v) => Numbers::I32(v),
            NumbersMut::U16(v) => Numbers::U16(v),
            NumbersMut::U8(v) => Numbers::U8(v),
        }
    }

    /// Puts numbers where `put` says so, from `first` on. Integers take the nearest that they can hold, halves to even.
    pub fn store(&mut self, first: usize, from: &[f64], put: &[bool]) {
        fn copy<T: Copy>(to: &mut [T], from: &[f64], put: &[bool], cast: impl Fn(f64) -> T) {
            for ((to, x), put) in to.iter_mut().zip(from).zip(put) {
                *to = if *put { cast(*x) } else { *to };
            }
        }
        match self {
            NumbersMut::F64(v) => copy(&mut v[first..], from, put, |x| x),
            NumbersMut::F32(v) => copy(&mut v[first..], from, put, |x| x as f32),
            // Casts to integers stop at the ends of their range.
            NumbersMut::I32(v) => copy(&mut v[first..], from, put, |x| rounded(x) as i32),
            NumbersMut::U16(v) => copy(&mut v[first..], from, put, |x| rounded(x) as u16),
            NumbersMut::U8(v) => copy(&mut v[first..], from, put, |x| rounded(x) as u8),
        }
    }

    /// Makes an element 0.
    pub fn clear(&mut self, i: usize) {
        match self {
            NumbersMut::F64(v) => v[i] = 0.0,
            NumbersMut::F32(v) => v[i] = 0.0,
            NumbersMut::I32(v) => v[i] = 0,
            NumbersMut::U16(v) => v[i] = 0,
            NumbersMut::U8(v) => v[i] = 0,
        }
    }
}

/// The nearest whole number, halves to the even one. Two additions, which compilers do on several at once, and which are
/// the same everywhere: the sum has no room for fractions.
#[inline(always)]
pub(super) fn rounded(x: f64) -> f64 {
    const ROOM: f64 = 6_755_399_441_055_744.0; // 1.5 * 2^52
    let y = (x + ROOM) - ROOM;
    // Beyond this there are no fractions.
    if x.abs() < 2_251_799_813_685_248.0 { y } else { x }
}
