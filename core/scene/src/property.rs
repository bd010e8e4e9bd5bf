//! Declarations of properties. One row states everything about a property: its key, type, unit, range, default and
//! meaning, the effect of a change, and where the value is stored.
//!
//! Each kind of object has a table of rows beside the struct that stores its values, written with [`properties`]:
//!
//! ```text
//! properties! { PROPERTIES: Shape, PropertyOwner::Kind(ObjectKind::Shape) =>
//!     "shape.friction" number from 0.0 = 1.0, Rebuild friction: "Friction coefficient.";
//! }
//! ```
//!
//! - the key, and the type: `bool`, `int`, `number`, `text`, `numbers` (with their count, if it is fixed), `list`,
//!   `map`, `object`, or a type that scene files write in a form of its own (`mesh`, `parts`, `texture`, `data`,
//!   `drive`, `noise`);
//! - optionally, in this order: `in "unit"`; `of (choices)` for a text; the range, `from` and `to` with their bounds,
//!   `above` and `below` without them (numbers must always be finite); `= default`, which is `none` for an empty value;
//! - the [`ChangeEffect`] of a change, and the place of the value: a field, a path of fields in parentheses, closures
//!   in braces, or `_` if a higher layer reads and sets the property.

mod declaration;
mod stored;
mod tables;

pub(crate) use declaration::PropertyAccess;
pub use declaration::{ChangeEffect, DefaultValue, FileForm, PropertyOwner, PropertySpec};
pub(crate) use stored::{StoredValue, copy_numbers, numbers_of, refusal_as_text, refuse, text_of, unexpected, words};
pub(crate) use tables::{access, default_of, get_of, properties, set_of, type_of};
