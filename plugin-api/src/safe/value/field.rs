//! Fields of readings, as sensors declare them.

use crate::abi::*;
use crate::safe::value::keep::Keep;

/// One field that a sensor fills.
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
    /// Doubles. Name: `<schema>.<field>`.
    pub fn f64(name: &'static str) -> Self {
        Self::of(name, TATU_ELEM_F64)
    }
    /// 32-bit integers.
    pub fn i32(name: &'static str) -> Self {
        Self::of(name, TATU_ELEM_I32)
    }
    /// 32-bit floats.
    pub fn f32(name: &'static str) -> Self {
        Self::of(name, TATU_ELEM_F32)
    }
    /// 16-bit numbers.
    pub fn u16(name: &'static str) -> Self {
        Self::of(name, TATU_ELEM_U16)
    }
    /// Bytes.
    pub fn u8(name: &'static str) -> Self {
        Self::of(name, TATU_ELEM_U8)
    }
    /// Objects.
    pub fn object(name: &'static str) -> Self {
        Self::of(name, TATU_ELEM_OBJECT)
    }
    /// Its name, `<schema>.<field>`.
    pub fn name(&self) -> &'static str {
        self.name
    }
    /// The type of its elements, `TATU_ELEM_*`.
    pub fn elem(&self) -> u32 {
        self.elem
    }
    /// Its shape, as declared.
    pub fn shape(&self) -> [u32; 3] {
        self.dims
    }
    /// Shape, outermost first; 0: as many as there are beams or pixels; [`TATU_DIM_ROWS`] and [`TATU_DIM_COLUMNS`] of
    /// the image.
    pub fn dims(mut self, dims: [u32; 3]) -> Self {
        self.dims = dims;
        self
    }
    /// Unit.
    pub fn unit(mut self, unit: &'static str) -> Self {
        self.unit = Some(unit);
        self
    }
    /// The field that is 0 where this one is invalid; by default as its schema says.
    pub fn valid(mut self, field: &'static str) -> Self {
        self.valid = Some(field);
        self
    }
    /// The value that means "nothing", "0" or "0 0 0"; by default as its schema says. Noise does not change it.
    pub fn nothing(mut self, numbers: &'static str) -> Self {
        self.nothing = Some(numbers);
        self
    }
    /// One sentence, with the meaning of "nothing".
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
