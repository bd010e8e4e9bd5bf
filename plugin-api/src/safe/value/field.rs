//! Declarations of the fields of readings.

use crate::abi::*;
use crate::safe::value::keep::Keep;

/// The declaration of one field of a sensor's readings.
#[derive(Debug, Clone)]
pub struct Field {
    name: &'static str,
    pub(crate) elem: u32,
    pub(crate) dims: [u32; 3],
    unit: Option<&'static str>,
    valid: Option<&'static str>,
    nothing: Option<&'static str>,
    text: &'static str,
}

impl Field {
    fn of(name: &'static str, elem: u32) -> Self {
        Field { name, elem, dims: [1; 3], unit: None, valid: None, nothing: None, text: "" }
    }
    /// Declares a field of 64-bit floats. Its name is `<schema>.<field>`.
    pub fn f64(name: &'static str) -> Self {
        Self::of(name, TATU_ELEM_F64)
    }
    /// Declares a field of 32-bit integers.
    pub fn i32(name: &'static str) -> Self {
        Self::of(name, TATU_ELEM_I32)
    }
    /// Declares a field of 32-bit floats.
    pub fn f32(name: &'static str) -> Self {
        Self::of(name, TATU_ELEM_F32)
    }
    /// Declares a field of unsigned 16-bit integers.
    pub fn u16(name: &'static str) -> Self {
        Self::of(name, TATU_ELEM_U16)
    }
    /// Declares a field of bytes.
    pub fn u8(name: &'static str) -> Self {
        Self::of(name, TATU_ELEM_U8)
    }
    /// Declares a field of objects.
    pub fn object(name: &'static str) -> Self {
        Self::of(name, TATU_ELEM_OBJECT)
    }
    /// Sets the shape, outermost dimension first. 0 means the number of beams or pixels; [`TATU_DIM_ROWS`] and
    /// [`TATU_DIM_COLUMNS`] mean those of the image.
    pub fn dims(mut self, dims: [u32; 3]) -> Self {
        self.dims = dims;
        self
    }
    /// Sets the unit.
    pub fn unit(mut self, unit: &'static str) -> Self {
        self.unit = Some(unit);
        self
    }
    /// Sets the field that is 0 where this one is invalid; the default is that of its schema.
    pub fn valid(mut self, field: &'static str) -> Self {
        self.valid = Some(field);
        self
    }
    /// Sets the value that means "nothing", such as "0" or "0 0 0"; the default is that of its schema. Noise does not
    /// change it.
    pub fn nothing(mut self, numbers: &'static str) -> Self {
        self.nothing = Some(numbers);
        self
    }
    /// Sets the description, one sentence, with the meaning of "nothing".
    pub fn text(mut self, text: &'static str) -> Self {
        self.text = text;
        self
    }
    pub(crate) fn keep(&self, keep: &mut Keep) -> *const tatu_field {
        let raw = tatu_field {
            size: size_of::<tatu_field>() as u32,
            elem: self.elem,
            dims: self.dims,
            flags: 0,
            name: keep.text(self.name),
            unit: self.unit.map_or(std::ptr::null(), |u| keep.text(u)),
            text: keep.text(self.text),
            valid: self.valid.map_or(std::ptr::null(), |v| keep.text(v)),
            nothing: self.nothing.map_or(std::ptr::null(), |n| keep.text(n)),
        };
        keep.table(raw)
    }
}
