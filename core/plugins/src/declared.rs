//! The declarations of plugins: copies of their tables, whose texts, lists and values can be read without `unsafe`.
//!
//! The contract requires everything that a declared table points to be valid until the plugin is shut down. The only
//! tables that are taken on trust are a library's descriptor, those that a plugin's `extension` returns, and models
//! that a plugin reads; all others are reached from these.

use std::{
    ffi::{CStr, c_char},
    marker::PhantomData,
    ops::Deref,
};

use tatu_plugin_api::{abi::*, safe::ValueRef};

use crate::{
    border,
    tables::{self, Table},
    texts,
};

/// A copy of a table that a plugin has declared, with zeros for missing fields. The texts and lists that the table
/// points to are valid for `'a`.
pub struct Declared<'a, T> {
    given: *const T,
    copy: T,
    lifetime: PhantomData<&'a ()>,
}

impl<T> Deref for Declared<'_, T> {
    type Target = T;
    fn deref(&self) -> &T {
        &self.copy
    }
}

impl<T: Table> Declared<'_, T> {
    /// Copies a table; returns `None` for null.
    ///
    /// # Safety
    /// `given` must be null or a table of a plugin that, with everything that it points to, conforms to the contract
    /// and is valid for the lifetime of the result.
    pub unsafe fn at(given: *const T) -> Option<Self> {
        // SAFETY: the caller guarantees that the table is null or valid.
        unsafe { tables::read(given) }.map(|copy| Declared { given, copy, lifetime: PhantomData })
    }

    /// Returns the address of the plugin's own table.
    pub fn given(&self) -> *const T {
        self.given
    }
}

/// A table with the list of what a plugin offers of one kind.
///
/// # Safety
/// The contract must require that a plugin's answer for [`ID`](Self::ID) is null or a table of this type.
pub unsafe trait Extension: Table {
    /// The id for which plugins return this table.
    const ID: &'static CStr;
}

macro_rules! extensions {
    ($($table:ty = $id:expr),*) => {
        $(
            // SAFETY: the header states this type of table for the id.
            unsafe impl Extension for $table {
                const ID: &'static CStr = $id;
            }
        )*
    };
}
extensions!(
    tatu_ext_command = TATU_COMMAND,
    tatu_ext_sensor = TATU_SENSOR,
    tatu_ext_actuator = TATU_ACTUATOR,
    tatu_ext_part = TATU_PART,
    tatu_ext_model = TATU_MODEL,
    tatu_ext_importer = TATU_IMPORTER,
    tatu_ext_script = TATU_SCRIPT,
    tatu_ext_service = TATU_SERVICE,
    tatu_ext_event = TATU_EVENT
);

/// Defines methods that read pointers of declared tables, each with one of the readers below.
macro_rules! accessors {
    ($($table:ident { $($field:ident: $reader:path => $result:ty;)* })*) => {
        $(impl<'a> Declared<'a, $table> {
            $(
                #[doc = concat!("Reads what `", stringify!($table), "::", stringify!($field), "` points to.")]
                pub fn $field(&self) -> $result {
                    // SAFETY: the field is one of a declared table, so it is null, empty or valid for `'a`.
                    unsafe { $reader(self.copy.$field) }
                }
            )*
        })*
    };
}
accessors! {
    tatu_plugin_t {
        id: label => Option<String>;
        name: text => Option<String>;
        version: text => Option<String>;
        licence: text => Option<String>;
        needs: list => Vec<Declared<'a, tatu_need>>;
    }
    tatu_need { id: string => Option<&'a CStr>; }
    tatu_ext_sensor { kinds: list => Vec<Declared<'a, tatu_sensor>>; }
    tatu_sensor {
        id: label => Option<String>;
        text: text => Option<String>;
        life: Declared::at => Option<Declared<'a, tatu_life>>;
        params: list => Vec<Declared<'a, tatu_param>>;
        fields: list => Vec<Declared<'a, tatu_field>>;
        schemas: labels => Vec<String>;
        presets: list => Vec<Declared<'a, tatu_preset>>;
    }
    tatu_preset {
        id: label => Option<String>;
        text: text => Option<String>;
        settings: text => Option<String>;
    }
    tatu_field {
        name: label => Option<String>;
        unit: text => Option<String>;
        text: text => Option<String>;
        valid: text => Option<String>;
        nothing: text => Option<String>;
    }
    tatu_param {
        key: label => Option<String>;
        unit: text => Option<String>;
        text: text => Option<String>;
        choices: texts => Vec<String>;
        keys: list => Vec<Declared<'a, tatu_param>>;
        fallback: ValueRef::new => ValueRef<'a>;
    }
    tatu_ext_actuator { kinds: list => Vec<Declared<'a, tatu_actuator>>; }
    tatu_actuator {
        id: label => Option<String>;
        text: text => Option<String>;
        life: Declared::at => Option<Declared<'a, tatu_life>>;
        params: list => Vec<Declared<'a, tatu_param>>;
        commands: list => Vec<Declared<'a, tatu_param>>;
        fields: list => Vec<Declared<'a, tatu_field>>;
        schemas: labels => Vec<String>;
    }
    tatu_ext_part { kinds: list => Vec<Declared<'a, tatu_part>>; }
    tatu_part {
        id: label => Option<String>;
        text: text => Option<String>;
        life: Declared::at => Option<Declared<'a, tatu_life>>;
        params: list => Vec<Declared<'a, tatu_param>>;
        commands: list => Vec<Declared<'a, tatu_param>>;
        fields: list => Vec<Declared<'a, tatu_field>>;
        schemas: labels => Vec<String>;
        presets: list => Vec<Declared<'a, tatu_preset>>;
        events: texts => Vec<String>;
    }
    tatu_ext_model { models: list => Vec<Declared<'a, tatu_model>>; }
    tatu_model {
        id: label => Option<String>;
        text: text => Option<String>;
        category: label => Option<String>;
        licence: text => Option<String>;
        mounts: labels => Vec<String>;
        params: list => Vec<Declared<'a, tatu_param>>;
        slots: labels => Vec<String>;
        slot_infos: list => Vec<Declared<'a, tatu_model_slot>>;
        numbers: list => Vec<Declared<'a, tatu_model_number>>;
    }
    tatu_model_slot {
        alias: label => Option<String>;
        mount: label => Option<String>;
        text: text => Option<String>;
    }
    tatu_model_number {
        name: label => Option<String>;
        value: ValueRef::new => ValueRef<'a>;
        unit: text => Option<String>;
        source: text => Option<String>;
    }
    tatu_ext_importer { importers: list => Vec<Declared<'a, tatu_importer>>; }
    tatu_importer {
        id: label => Option<String>;
        text: text => Option<String>;
        suffixes: labels => Vec<String>;
        params: list => Vec<Declared<'a, tatu_param>>;
    }
    tatu_ext_script { languages: list => Vec<Declared<'a, tatu_language>>; }
    tatu_language {
        id: label => Option<String>;
        text: text => Option<String>;
        suffixes: labels => Vec<String>;
        life: Declared::at => Option<Declared<'a, tatu_life>>;
        permission: label => Option<String>;
        params: list => Vec<Declared<'a, tatu_param>>;
    }
    tatu_ext_command {
        per_world: Declared::at => Option<Declared<'a, tatu_life>>;
        commands: list => Vec<Declared<'a, tatu_command>>;
        constants: list => Vec<Declared<'a, tatu_constant>>;
        preludes: list => Vec<Declared<'a, tatu_prelude>>;
        kind_marks: list => Vec<Declared<'a, tatu_kind_mark>>;
    }
    tatu_command {
        names: list => Vec<Declared<'a, tatu_name>>;
        params: list => Vec<Declared<'a, tatu_param>>;
        returns: list => Vec<Declared<'a, tatu_param>>;
        text: text => Option<String>;
        example: text => Option<String>;
        notes: text => Option<String>;
        subject: text => Option<String>;
        no_wait: text => Option<String>;
    }
    tatu_name {
        name: label => Option<String>;
        on_error_until: text => Option<String>;
    }
    tatu_constant { name: label => Option<String>; }
    tatu_prelude {
        language: text => Option<String>;
        module: text => Option<String>;
        text: border::bytes => &'a [u8];
    }
    tatu_kind_mark {
        language: text => Option<String>;
        kind: text => Option<String>;
        word: text => Option<String>;
    }
    tatu_ext_service { services: list => Vec<Declared<'a, tatu_service>>; }
    tatu_service {
        id: label => Option<String>;
        text: text => Option<String>;
        life: Declared::at => Option<Declared<'a, tatu_life>>;
        params: list => Vec<Declared<'a, tatu_param>>;
        events: texts => Vec<String>;
    }
    tatu_ext_event {
        events: list => Vec<Declared<'a, tatu_event>>;
        listens: texts => Vec<String>;
    }
    tatu_event {
        name: label => Option<String>;
        text: text => Option<String>;
        fields: list => Vec<Declared<'a, tatu_param>>;
    }
}

impl<'a> Declared<'a, tatu_name> {
    /// Returns the values that a call by this name returns instead of raising an error.
    pub fn on_error(&self) -> &'a [ValueRef<'a>] {
        // SAFETY: the table was declared by a plugin, so `on_error` points to `n_on_error` values that are valid for
        // `'a`, or is null.
        unsafe { ValueRef::slice(self.copy.on_error, self.copy.n_on_error as usize) }
    }
}

// The readers of accessors. The argument of each must be null, or point to what its name says, valid for the lifetime of
// the result.

unsafe fn string<'a>(s: *const c_char) -> Option<&'a CStr> {
    // SAFETY: `s` is not null, and the caller guarantees that it is NUL-terminated and valid for `'a`.
    (!s.is_null()).then(|| unsafe { CStr::from_ptr(s) })
}

/// Reads a text, with control characters escaped for display.
unsafe fn text(s: *const c_char) -> Option<String> {
    // SAFETY: the caller guarantees that `s` is null or a string.
    unsafe { string(s) }.map(|s| texts::clean(&s.to_string_lossy()).into_owned())
}

/// Reads a name, in the form of [`texts::label`]; `names` checks whether it is valid.
unsafe fn label(s: *const c_char) -> Option<String> {
    // SAFETY: the caller guarantees that `s` is null or a string.
    unsafe { string(s) }.map(|s| texts::label(s.to_bytes()))
}

unsafe fn texts(list: *const *const c_char) -> Vec<String> {
    // SAFETY: the caller guarantees that `list` is null or a list of strings.
    unsafe { elements(list, |s| text(s)) }
}

unsafe fn labels(list: *const *const c_char) -> Vec<String> {
    // SAFETY: the caller guarantees that `list` is null or a list of strings.
    unsafe { elements(list, |s| label(s)) }
}

unsafe fn list<'a, T: Table>(list: *const *const T) -> Vec<Declared<'a, T>> {
    // SAFETY: the caller guarantees that `list` is null or a list of tables that are valid for `'a`.
    unsafe { elements(list, |table| Declared::at(table)) }
}

/// Reads the elements of a null-terminated list, but at most 65536, in case the terminator is missing.
unsafe fn elements<T, R>(list: *const *const T, read: impl Fn(*const T) -> Option<R>) -> Vec<R> {
    let mut out = Vec::new();
    if list.is_null() {
        return out;
    }
    for i in 0..65536 {
        // SAFETY: no null pointer was found before index `i`, so the element is within the list, which the caller
        // guarantees to be valid during this call.
        let element = unsafe { *list.add(i) };
        if element.is_null() {
            break;
        }
        out.extend(read(element));
    }
    out
}
