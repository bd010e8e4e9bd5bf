//! The macro with which tables of properties are written; the top of `property.rs` describes its language.

use std::any::Any;

use tatu_plugin_api::safe::Value;

use super::Changed;

pub(crate) fn get_of<T: 'static>(of: &dyn Any, get: impl Fn(&T) -> Value) -> Option<Value> {
    of.downcast_ref().map(get)
}

pub(crate) fn set_of<T: 'static>(
    of: &mut dyn Any,
    value: &Value,
    set: impl Fn(&mut T, &Value) -> Result<bool, String>,
) -> Changed {
    of.downcast_mut().map(|of| set(of, value))
}

/// Returns the place of a value, as for [`properties`].
macro_rules! access {
    ($type:ty, _) => {
        $crate::property::Access::NONE
    };
    ($type:ty, $field:ident) => {
        $crate::property::access!($type, ($field))
    };
    ($type:ty, ($($path:tt)+)) => {
        $crate::property::Access {
            get: |of| of.downcast_ref::<$type>().map(|of| $crate::property::Stored::value(&of.$($path)+)),
            set: |of, value| {
                of.downcast_mut::<$type>().map(|of| $crate::property::Stored::store(&mut of.$($path)+, value))
            },
            read: |of, out| {
                of.downcast_ref::<$type>().and_then(|of| $crate::property::Stored::read(&of.$($path)+, out))
            },
            write: |of, numbers| {
                of.downcast_mut::<$type>().and_then(|of| $crate::property::Stored::write(&mut of.$($path)+, numbers))
            },
        }
    };
    ($type:ty, { get $get:expr }) => {
        $crate::property::Access {
            get: |of| $crate::property::get_of::<$type>(of, $get),
            ..$crate::property::Access::NONE
        }
    };
    ($type:ty, { set $set:expr }) => {
        $crate::property::Access {
            set: |of, value| $crate::property::set_of::<$type>(of, value, $set),
            ..$crate::property::Access::NONE
        }
    };
    ($type:ty, { get $get:expr, set $set:expr }) => {
        $crate::property::Access {
            get: |of| $crate::property::get_of::<$type>(of, $get),
            set: |of, value| $crate::property::set_of::<$type>(of, value, $set),
            ..$crate::property::Access::NONE
        }
    };
    ($type:ty, { number $field:ident, set $set:expr }) => {
        $crate::property::Access {
            set: |of, value| {
                $crate::property::set_of::<$type>(of, value, |of, value| {
                    $set(of, $crate::property::numbers_of(value)?[0]);
                    Ok(true)
                })
            },
            write: |of, numbers| {
                let ([x], Some(of)) = (numbers, of.downcast_mut::<$type>()) else { return None };
                $set(of, *x);
                Some(Ok(true))
            },
            ..$crate::property::access!($type, $field)
        }
    };
}
pub(crate) use access;

/// Returns the type of a value, and its form in scene files, as for [`properties`].
macro_rules! type_of {
    (bool) => {
        (TATU_BOOL, InFiles::Plain)
    };
    (int) => {
        (TATU_I64, InFiles::Plain)
    };
    (number) => {
        (TATU_F64, InFiles::Plain)
    };
    (text) => {
        (TATU_TEXT, InFiles::Plain)
    };
    (numbers) => {
        (TATU_F64S, InFiles::Plain)
    };
    (list) => {
        (TATU_LIST, InFiles::Plain)
    };
    (map) => {
        (TATU_MAP, InFiles::Plain)
    };
    (object) => {
        (TATU_OBJECT, InFiles::Plain)
    };
    (mesh) => {
        (TATU_I64, InFiles::Mesh)
    };
    (parts) => {
        (TATU_LIST, InFiles::Parts)
    };
    (texture) => {
        (TATU_MAP, InFiles::Texture)
    };
    (data) => {
        (TATU_MAP, InFiles::Data)
    };
    (drive) => {
        (TATU_MAP, InFiles::Drive)
    };
    (noise) => {
        (TATU_TEXT, InFiles::Noise)
    };
}
pub(crate) use type_of;

/// Returns a default, as for [`properties`].
macro_rules! usual_of {
    (bool $x:tt) => {
        Usual::Bool($x)
    };
    (int $x:tt) => {
        Usual::Int($x)
    };
    (number $x:tt) => {
        Usual::Float($x)
    };
    (numbers none) => {
        Usual::Floats(&[])
    };
    (numbers $x:tt) => {
        Usual::Floats(&$x)
    };
    (list none) => {
        Usual::List
    };
    (parts none) => {
        Usual::List
    };
    (text none) => {
        Usual::Text("")
    };
    (noise none) => {
        Usual::Text("")
    };
    (text $x:tt) => {
        Usual::Text($x)
    };
    ($map:ident none) => {
        Usual::Map
    };
}
pub(crate) use usual_of;

/// Declares a table of properties, which are stored in a struct.
macro_rules! properties {
    ($name:ident: $type:ty, $of:expr => $(
        $key:literal $kind:ident $($count:literal)? $(in $unit:literal)? $(of $choices:tt)?
        $(from $from:tt)? $(above $above:tt)? $(to $to:tt)? $(below $below:tt)? $(= $usual:tt)?,
        $effect:ident $access:tt: $text:literal;
    )*) => {
        #[allow(unused_parens, reason = "a bound of several tokens stands in parentheses")]
        pub(crate) const $name: &[$crate::property::Property] = {
            use tatu_plugin_api::abi::*;
            #[allow(unused_imports, reason = "not every table uses all of them")]
            use $crate::property::{Effect, InFiles, Of, Property, Usual, access, type_of, usual_of};
            &[$(Property {
                key: $key,
                of: $of,
                kind: type_of!($kind).0,
                $(count: $count,)?
                $(unit: Some($unit),)?
                $(choices: $choices,)?
                range: {
                    #[allow(unused_mut, reason = "not every row has a range")]
                    let mut range: (f64, f64) = Property::NONE.range;
                    $(range.0 = $from;)?
                    $(range.0 = f64::next_up($above);)?
                    $(range.1 = $to;)?
                    $(range.1 = f64::next_down($below);)?
                    range
                },
                $(usual: usual_of!($kind $usual),)?
                effect: Effect::$effect,
                in_files: type_of!($kind).1,
                text: $text,
                access: access!($type, $access),
                ..Property::NONE
            }),*]
        };
    };
}
pub(crate) use properties;
