//! Fields of sensor readings, as commands and services read them.

use crate::abi::*;

/// A copy of one field of a sensor's last reading.
#[derive(Debug, Clone)]
pub struct Reading {
    elem: u32,
    dims: [u32; 3],
    time: f64,
    sequence: u64,
    len: usize,
    words: WordBuffer,
}

/// The elements, in words of 8 bytes; stored inline if there are few, as in most readings.
#[derive(Debug, Clone)]
enum WordBuffer {
    Inline([u64; 8]),
    Heap(Vec<u64>),
}

impl Reading {
    /// Copies a field of a reading.
    ///
    /// # Safety
    /// The host must have filled `view`, and the sensor must not have been measured or removed since.
    pub(crate) unsafe fn of(view: &tatu_field_view) -> Self {
        let each = match view.elem {
            TATU_ELEM_F64 | TATU_ELEM_OBJECT => 8,
            TATU_ELEM_F32 | TATU_ELEM_I32 => 4,
            TATU_ELEM_U16 => 2,
            TATU_ELEM_U8 => 1,
            _ => 0,
        };
        let len = if view.ptr.is_null() || each == 0 { 0 } else { view.len as usize };
        let mut words = match (len * each).div_ceil(8) {
            ..=8 => WordBuffer::Inline([0; 8]),
            n => WordBuffer::Heap(vec![0; n]),
        };
        let to = match &mut words {
            WordBuffer::Inline(few) => few.as_mut_ptr(),
            WordBuffer::Heap(many) => many.as_mut_ptr(),
        };
        // SAFETY: `view.ptr` points to `len` elements of `each` bytes, valid until the next measurement, and `to` has
        // room for them.
        unsafe { std::ptr::copy_nonoverlapping(view.ptr.cast::<u8>(), to.cast::<u8>(), len * each) };
        Reading { elem: view.elem, dims: view.dims, time: view.time, sequence: view.sequence, len, words }
    }
    /// Returns the number of measurements since the start or the last reset.
    pub fn sequence(&self) -> u64 {
        self.sequence
    }
    /// Returns the simulation time of the reading, s.
    pub fn time(&self) -> f64 {
        self.time
    }
    /// Returns the shape, outermost dimension first.
    pub fn dims(&self) -> [u32; 3] {
        self.dims
    }
    /// Returns the element type, `TATU_ELEM_*`.
    pub fn elem(&self) -> u32 {
        self.elem
    }
    fn slice<T>(&self, elem: u32) -> &[T] {
        if self.elem != elem {
            return &[];
        }
        let words = match &self.words {
            WordBuffer::Inline(few) => &few[..],
            WordBuffer::Heap(many) => many,
        };
        // SAFETY: `words` live as long as `self`. `of` copied `len` elements of the type that `elem` states into them,
        // which callers match. Any bit pattern is valid for these types, and words are sufficiently aligned.
        unsafe { std::slice::from_raw_parts(words.as_ptr().cast(), self.len) }
    }
    /// Returns the numbers, if they are 64-bit floats; otherwise an empty slice.
    pub fn f64s(&self) -> &[f64] {
        self.slice(TATU_ELEM_F64)
    }
    /// Returns the numbers, if they are 32-bit integers; otherwise an empty slice.
    pub fn i32s(&self) -> &[i32] {
        self.slice(TATU_ELEM_I32)
    }
    /// Returns the numbers, if they are 32-bit floats; otherwise an empty slice.
    pub fn f32s(&self) -> &[f32] {
        self.slice(TATU_ELEM_F32)
    }
    /// Returns the numbers, if they are 16-bit integers; otherwise an empty slice.
    pub fn u16s(&self) -> &[u16] {
        self.slice(TATU_ELEM_U16)
    }
    /// Returns the elements, if they are bytes; otherwise an empty slice.
    pub fn u8s(&self) -> &[u8] {
        self.slice(TATU_ELEM_U8)
    }
    /// Returns the elements, if they are objects; otherwise an empty slice.
    pub fn objects(&self) -> &[tatu_object] {
        self.slice(TATU_ELEM_OBJECT)
    }
}
