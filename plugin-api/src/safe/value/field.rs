//! Declarations of the fields that readings consist of.

use std::marker::PhantomData;

use crate::abi::*;
use crate::safe::value::table_arena::TableArena;

mod sealed {
    pub trait Sealed {}
}

/// A type that the elements of a field can have.
pub trait Element: sealed::Sealed + Copy {
    /// The element type in the ABI, `TATU_ELEM_*`.
    const ELEM: u32;
}

macro_rules! elements {
    ($($of:ty = $elem:ident),*) => {
        $(impl sealed::Sealed for $of {}
        impl Element for $of {
            const ELEM: u32 = $elem;
        })*
    };
}

elements! {
    f64 = TATU_ELEM_F64, f32 = TATU_ELEM_F32, i32 = TATU_ELEM_I32, u16 = TATU_ELEM_U16, u8 = TATU_ELEM_U8,
    tatu_object = TATU_ELEM_OBJECT
}

/// Refers to a declared field of a sensor by its index, with the type of its elements. Created by
/// [`fields!`](crate::fields).
#[derive(Debug)]
pub struct TypedField<T> {
    index: usize,
    holds: PhantomData<fn() -> T>,
}

impl<T> Clone for TypedField<T> {
    fn clone(&self) -> Self {
        *self
    }
}
impl<T> Copy for TypedField<T> {}

impl<T: Element> TypedField<T> {
    /// Returns a reference to the field with this index, from 0 in the order of declaration.
    pub const fn nth(index: usize) -> Self {
        TypedField { index, holds: PhantomData }
    }
    /// Returns the index of the field.
    pub const fn index(self) -> usize {
        self.index
    }
}

/// Declares the fields of a sensor: for each field the name of a constant, the type of the elements, and the
/// declaration, which states the field's name in readings. Defines the constants, with which `measure` writes the
/// fields, and `declared_fields()`, which returns all declarations.
///
/// ```
/// # use tatu_plugin_api::{fields, safe::*};
/// struct Lamp;
///
/// fields! {
///     Lamp {
///         LEVEL: f64 = Field::new("lamp.level").unit("1").nothing("0").text("Reflected light, 0 to 1.");
///         SEEN: i32 = Field::new("lamp.seen").nothing("0").text("Whether light is detected.");
///     }
/// }
///
/// fn write(out: &mut Readout<'_>) {
///     out.set(Lamp::LEVEL, 0.5);
///     out.set(Lamp::SEEN, 1);
/// }
/// # assert_eq!(Lamp::declared_fields().len(), 2);
/// ```
#[macro_export]
macro_rules! fields {
    ($sensor:ty { $($name:ident: $holds:ty = $field:expr;)* }) => {
        impl $sensor {
            $crate::fields!(@constants 0usize; $($name: $holds;)*);

            fn declared_fields() -> ::std::vec::Vec<$crate::safe::Field> {
                ::std::vec![$($field.holds::<$holds>()),*]
            }
        }
    };
    (@constants $n:expr; $name:ident: $holds:ty; $($rest:tt)*) => {
        const $name: $crate::safe::TypedField<$holds> = $crate::safe::TypedField::nth($n);
        $crate::fields!(@constants $n + 1usize; $($rest)*);
    };
    (@constants $n:expr;) => {};
}

/// The declaration of a field of a sensor's readings.
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
    /// Declares a field for [`fields!`](crate::fields), which sets its element type. Its name is `<schema>.<field>`.
    pub fn new(name: &'static str) -> Self {
        Self::of(name, 0)
    }
    /// Sets the type of the elements.
    pub fn holds<T: Element>(mut self) -> Self {
        self.elem = T::ELEM;
        self
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
    /// Returns the name, `<schema>.<field>`.
    pub fn name(&self) -> &'static str {
        self.name
    }
    /// Returns the type of the elements, `TATU_ELEM_*`.
    pub fn elem(&self) -> u32 {
        self.elem
    }
    /// Returns the declared shape, which [`Field::dims`] sets.
    pub fn shape(&self) -> [u32; 3] {
        self.dims
    }
    /// Sets the shape, outermost dimension first, which [`Field::shape`] returns. 0 stands for the number of beams or
    /// pixels, [`TATU_DIM_ROWS`] and [`TATU_DIM_COLUMNS`] for the number of rows and columns of the image, and
    /// [`TATU_DIM_OWN`] + k for [`Beams::own`](crate::safe::Beams::own)`[k]`. Unused dimensions are 1.
    pub fn dims(mut self, dims: [u32; 3]) -> Self {
        self.dims = dims;
        self
    }
    /// Sets the shape to one element per beam or pixel.
    pub fn per_beam(self) -> Self {
        self.dims([0, 1, 1])
    }
    /// Sets the shape to one element per target, for kinds with `TATU_IN_TARGETS`.
    pub fn per_target(self) -> Self {
        self.dims([TATU_DIM_TARGETS, 1, 1])
    }
    /// Sets the shape to `n` elements in one dimension.
    pub fn elements(self, n: u32) -> Self {
        self.dims([n, 1, 1])
    }
    /// Sets the unit, such as "m"; "1" for dimensionless fields.
    pub fn unit(mut self, unit: &'static str) -> Self {
        self.unit = Some(unit);
        self
    }
    /// Sets the name of the field that is 0 where this one contains no measurement; by default, the schema defines it.
    pub fn valid(mut self, field: &'static str) -> Self {
        self.valid = Some(field);
        self
    }
    /// Sets the value that stands for "no measurement", such as "0" or "0 0 0", to which no noise is added; by default,
    /// the schema defines it.
    pub fn nothing(mut self, numbers: &'static str) -> Self {
        self.nothing = Some(numbers);
        self
    }
    /// Sets the description: one sentence, which states the value for "no measurement".
    pub fn text(mut self, text: &'static str) -> Self {
        self.text = text;
        self
    }
    pub(crate) fn to_table(&self, keep: &mut TableArena) -> *const tatu_field {
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
