//! Readings of sensors without a host.

use std::ffi::c_void;

use tatu_plugin_api::{
    abi::*,
    safe::{Beams, Field, Form},
};

use crate::{Error, Result, inputs::counts};

/// The fields of one measurement, by name.
#[derive(Debug, Clone)]
pub struct Readings {
    fields: Vec<FieldBuffer>,
    /// The state after the measurement, `Sensor::STATE` values.
    pub state: Vec<f64>,
}

#[derive(Debug, Clone)]
struct FieldBuffer {
    name: &'static str,
    elem: u32,
    len: u64,
    /// The elements, in words of 8 bytes.
    words: Vec<u64>,
}

impl Readings {
    /// Creates zeroed fields, whose sizes may depend on the sensor's beams and on the number of its targets.
    pub(crate) fn empty(fields: &[Field], beams: &Beams, n_targets: usize) -> Result<Self> {
        let buffer = |f: &Field| {
            let len = f.shape().iter().map(|d| elements(*d, beams, n_targets)).product();
            let each = size(f.elem()).ok_or_else(|| {
                Error::new(format!("the field `{}` has the unknown element type {}", f.name(), f.elem()))
            })?;
            Ok(FieldBuffer { name: f.name(), elem: f.elem(), len, words: vec![0; (len * each).div_ceil(8) as usize] })
        };
        Ok(Readings { fields: fields.iter().map(buffer).collect::<Result<_>>()?, state: Vec::new() })
    }

    /// Returns the address and the number of elements of each field.
    pub(crate) fn places(&mut self) -> (Vec<*mut c_void>, Vec<u64>) {
        let place = |b: &mut FieldBuffer| b.words.as_mut_ptr().cast();
        (self.fields.iter_mut().map(place).collect(), self.fields.iter().map(|b| b.len).collect())
    }

    /// Returns an error if a field contains NaN, as the host does.
    pub(crate) fn checked(self) -> Result<Self> {
        match self.fields.iter().find(|b| b.numbers().iter().any(|x| x.is_nan())) {
            Some(b) => Err(Error::new(format!("the sensor broke the contract: its field `{}` contains NaN", b.name))),
            None => Ok(self),
        }
    }

    fn buffer(&self, field: &str) -> Result<&FieldBuffer> {
        self.fields.iter().find(|b| b.name == field).ok_or_else(|| {
            let known: Vec<&str> = self.fields.iter().map(|b| b.name).collect();
            Error::new(format!("there is no field `{field}`\n  expected: one of {}", known.join(", ")))
        })
    }

    /// Returns all numbers of a field of any element type.
    ///
    /// # Errors
    /// Fails if there is no such field.
    pub fn f64s(&self, field: &str) -> Result<Vec<f64>> {
        self.buffer(field).map(FieldBuffer::numbers)
    }

    /// Returns the value of a field with a single element.
    ///
    /// # Errors
    /// Fails if there is no such field, or its number of elements is not 1.
    pub fn f64(&self, field: &str) -> Result<f64> {
        match self.f64s(field)?.as_slice() {
            [one] => Ok(*one),
            all => {
                Err(Error::new(format!("`{field}` has {} elements, but `f64` needs 1\n  help: use `f64s`", all.len())))
            }
        }
    }

    /// Returns the objects of a field.
    ///
    /// # Errors
    /// Fails if there is no such field, or its elements are not objects.
    pub fn objects(&self, field: &str) -> Result<Vec<tatu_object>> {
        match self.buffer(field)? {
            FieldBuffer { elem: TATU_ELEM_OBJECT, words, .. } => Ok(words.clone()),
            _ => Err(Error::new(format!("the elements of the field `{field}` are not objects"))),
        }
    }
}

impl FieldBuffer {
    fn numbers(&self) -> Vec<f64> {
        let bytes: Vec<u8> = self.words.iter().flat_map(|w| w.to_ne_bytes()).collect();
        let n = self.len as usize;
        match self.elem {
            TATU_ELEM_F64 => self.words.iter().map(|w| f64::from_bits(*w)).collect(),
            TATU_ELEM_OBJECT => self.words.iter().map(|w| *w as f64).collect(),
            TATU_ELEM_F32 => bytes.as_chunks().0.iter().take(n).map(|b| f32::from_ne_bytes(*b).into()).collect(),
            TATU_ELEM_I32 => bytes.as_chunks().0.iter().take(n).map(|b| i32::from_ne_bytes(*b).into()).collect(),
            TATU_ELEM_U16 => bytes.as_chunks().0.iter().take(n).map(|b| u16::from_ne_bytes(*b).into()).collect(),
            _ => bytes.iter().take(n).map(|b| f64::from(*b)).collect(),
        }
    }
}

/// Returns the size of an element, bytes.
fn size(elem: u32) -> Option<u64> {
    match elem {
        TATU_ELEM_F64 | TATU_ELEM_OBJECT => Some(8),
        TATU_ELEM_F32 | TATU_ELEM_I32 => Some(4),
        TATU_ELEM_U16 => Some(2),
        TATU_ELEM_U8 => Some(1),
        _ => None,
    }
}

/// Returns the number of elements along one dimension of a field.
fn elements(dim: u32, beams: &Beams, n_targets: usize) -> u64 {
    let image = match &beams.form {
        Form::Image { columns, rows, .. } | Form::Parallel { columns, rows, .. } => [*rows, *columns],
        _ => [0, 0],
    };
    let (n_beams, n_pixels) = counts(beams);
    match dim {
        0 => (n_beams + n_pixels) as u64,
        TATU_DIM_ROWS => image[0].into(),
        TATU_DIM_COLUMNS => image[1].into(),
        TATU_DIM_TARGETS => n_targets as u64,
        d if (TATU_DIM_OWN..TATU_DIM_OWN + 4).contains(&d) => beams.own[(d - TATU_DIM_OWN) as usize].into(),
        d => d.into(),
    }
}
