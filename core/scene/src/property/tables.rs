//! The macro with which tables of properties are written; the top of `property.rs` describes its language.

use std::any::Any;

use tatu_plugin_api::safe::Value;

use super::declaration::SetOutcome;

pub(crate) fn get_of<T: 'static>(of: &dyn Any, get: impl Fn(&T) -> Value) -> Option<Value> {
    of.downcast_ref().map(get)
}

pub(crate) fn set_of<T: 'static>(
    of: &mut dyn Any,
    value: &Value,
    set: impl Fn(&mut T, &Value) -> Result<bool, String>,
) -> SetOutcome {
    of.downcast_mut().map(|of| set(of, value))
}

/// Returns the place of a value, as for [`properties`].
macro_rules! access {
    ($type:ty, _) => {
        $crate::property::PropertyAccess::NONE
    };
    ($type:ty, $field:ident) => {
        $crate::property::access!($type, ($field))
    };
    ($type:ty, ($($path:tt)+)) => {
        $crate::property::PropertyAccess {
            get: |of| of.downcast_ref::<$type>().map(|of| $crate::property::StoredValue::value(&of.$($path)+)),
            set: |of, value| {
                of.downcast_mut::<$type>().map(|of| $crate::property::StoredValue::store(&mut of.$($path)+, value))
            },
            read: |of, out| {
                of.downcast_ref::<$type>().and_then(|of| $crate::property::StoredValue::read(&of.$($path)+, out))
            },
            write: |of, numbers| {
                of.downcast_mut::<$type>().and_then(|of| $crate::property::StoredValue::write(&mut of.$($path)+, numbers))
            },
        }
    };
    ($type:ty, { get $get:expr }) => {
        $crate::property::PropertyAccess {
            get: |of| $crate::property::get_of::<$type>(of, $get),
            ..$crate::property::PropertyAccess::NONE
        }
    };
    ($type:ty, { set $set:expr }) => {
        $crate::property::PropertyAccess {
            set: |of, value| $crate::property::set_of::<$type>(of, value, $set),
            ..$crate::property::PropertyAccess::NONE
        }
    };
    ($type:ty, { get $get:expr, set $set:expr }) => {
        $crate::property::PropertyAccess {
            get: |of| $crate::property::get_of::<$type>(of, $get),
            set: |of, value| $crate::property::set_of::<$type>(of, value, $set),
            ..$crate::property::PropertyAccess::NONE
        }
    };
    ($type:ty, { number $field:ident, set $set:expr }) => {
        $crate::property::PropertyAccess {
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
        (TATU_BOOL, FileForm::Plain)
    };
    (int) => {
        (TATU_I64, FileForm::Plain)
    };
    (number) => {
        (TATU_F64, FileForm::Plain)
    };
    (text) => {
        (TATU_TEXT, FileForm::Plain)
    };
    (numbers) => {
        (TATU_F64S, FileForm::Plain)
    };
    (list) => {
        (TATU_LIST, FileForm::Plain)
    };
    (map) => {
        (TATU_MAP, FileForm::Plain)
    };
    (object) => {
        (TATU_OBJECT, FileForm::Plain)
    };
    (mesh) => {
        (TATU_I64, FileForm::Mesh)
    };
    (parts) => {
        (TATU_LIST, FileForm::Parts)
    };
    (texture) => {
        (TATU_MAP, FileForm::Texture)
    };
    (data) => {
        (TATU_MAP, FileForm::Data)
    };
    (drive) => {
        (TATU_MAP, FileForm::Drive)
    };
    (noise) => {
        (TATU_TEXT, FileForm::Noise)
    };
}
pub(crate) use type_of;

/// Returns a default, as for [`properties`].
macro_rules! default_of {
    (bool $x:tt) => {
        DefaultValue::Bool($x)
    };
    (int $x:tt) => {
        DefaultValue::Int($x)
    };
    (number $x:tt) => {
        DefaultValue::Float($x)
    };
    (numbers none) => {
        DefaultValue::Floats(&[])
    };
    (numbers $x:tt) => {
        DefaultValue::Floats(&$x)
    };
    (list none) => {
        DefaultValue::List
    };
    (parts none) => {
        DefaultValue::List
    };
    (text none) => {
        DefaultValue::Text("")
    };
    (noise none) => {
        DefaultValue::Text("")
    };
    (text $x:tt) => {
        DefaultValue::Text($x)
    };
    ($map:ident none) => {
        DefaultValue::Map
    };
}
pub(crate) use default_of;

/// Declares a table of properties, which are stored in a struct.
macro_rules! properties {
    ($name:ident: $type:ty, $owner:expr => $(
        $key:literal $kind:ident $($count:literal)? $(in $unit:literal)? $(of $choices:tt)?
        $(from $from:tt)? $(above $above:tt)? $(to $to:tt)? $(below $below:tt)? $(= $default:tt)?,
        $effect:ident $access:tt: $text:literal;
    )*) => {
        #[allow(unused_parens, reason = "a bound of several tokens stands in parentheses")]
        pub(crate) const $name: &[$crate::property::PropertySpec] = {
            use tatu_plugin_api::abi::*;
            #[allow(unused_imports, reason = "not every table uses all of them")]
            use $crate::property::{ChangeEffect, DefaultValue, FileForm, PropertyOwner, PropertySpec, access, default_of, type_of};
            &[$(PropertySpec {
                key: $key,
                owner: $owner,
                kind: type_of!($kind).0,
                $(count: $count,)?
                $(unit: Some($unit),)?
                $(choices: $choices,)?
                range: {
                    #[allow(unused_mut, reason = "not every row has a range")]
                    let mut range: (f64, f64) = PropertySpec::NONE.range;
                    $(range.0 = $from;)?
                    $(range.0 = f64::next_up($above);)?
                    $(range.1 = $to;)?
                    $(range.1 = f64::next_down($below);)?
                    range
                },
                $(default_value: default_of!($kind $default),)?
                effect: ChangeEffect::$effect,
                file_form: type_of!($kind).1,
                text: $text,
                access: access!($type, $access),
                ..PropertySpec::NONE
            }),*]
        };
    };
}
pub(crate) use properties;
