//! Declarations of parameters, and access to their values.

use std::borrow::Cow;

use crate::abi::*;
use crate::safe::{
    Fail, Owned, Result, Value, ValueRef,
    value::{owned::type_name, table_arena::TableArena},
};

/// The declaration of a parameter (of a command, sensor, model or service, for example), of a result of a command, or
/// of a field of an event.
#[derive(Debug, Clone)]
pub struct Param {
    pub(crate) key: String,
    pub(crate) kind: u32,
    pub(crate) count: u32,
    pub(crate) flags: u32,
    pub(crate) unit: Option<Cow<'static, str>>,
    pub(crate) lowest: f64,
    pub(crate) highest: f64,
    pub(crate) fallback: Value,
    pub(crate) choices: Vec<Cow<'static, str>>,
    pub(crate) keys: Vec<Param>,
    pub(crate) text: String,
}

impl Param {
    fn of(kind: u32, key: &str) -> Self {
        Param {
            key: key.into(),
            kind,
            count: 0,
            flags: 0,
            unit: None,
            lowest: f64::NEG_INFINITY,
            highest: f64::INFINITY,
            fallback: Value::Nil,
            choices: Vec::new(),
            keys: Vec::new(),
            text: String::new(),
        }
    }
    /// Declares a number.
    pub fn float(key: &str) -> Self {
        Self::of(TATU_F64, key)
    }
    /// Declares an integer.
    pub fn int(key: &str) -> Self {
        Self::of(TATU_I64, key)
    }
    /// Declares a boolean.
    pub fn bool(key: &str) -> Self {
        Self::of(TATU_BOOL, key)
    }
    /// Declares a text.
    pub fn string(key: &str) -> Self {
        Self::of(TATU_TEXT, key)
    }
    /// Declares bytes.
    pub fn bytes(key: &str) -> Self {
        Self::of(TATU_BYTES, key)
    }
    /// Declares an array of `count` numbers, or of any length if `count` is 0.
    pub fn floats(key: &str, count: u32) -> Self {
        Param { count, ..Self::of(TATU_F64S, key) }
    }
    /// Declares an array of `count` integers, or of any length if `count` is 0.
    pub fn ints(key: &str, count: u32) -> Self {
        Param { count, ..Self::of(TATU_I64S, key) }
    }
    /// Declares a function of a script.
    pub fn func(key: &str) -> Self {
        Self::of(TATU_FUNC, key)
    }
    /// Declares a map. Any keys are allowed, unless [`Param::keys`] declares them.
    pub fn map(key: &str) -> Self {
        Self::of(TATU_MAP, key)
    }
    /// Declares the keys of a map of options. Each entry is checked and converted to its declared type, and a missing
    /// entry gets its default. An undeclared key is an error, whose message suggests the most similar declared key.
    pub fn keys(mut self, keys: impl IntoIterator<Item = Param>) -> Self {
        self.keys = keys.into_iter().collect();
        self
    }
    /// Declares a list.
    pub fn list(key: &str) -> Self {
        Self::of(TATU_LIST, key)
    }
    /// Declares an object; the handle of an object is also accepted.
    pub fn object(key: &str) -> Self {
        Self::of(TATU_OBJECT, key)
    }
    /// Declares a parameter that accepts a value of any type.
    pub fn any(key: &str) -> Self {
        Self { flags: TATU_PARAM_ANY, ..Self::of(TATU_NIL, key) }
    }
    /// Sets the parameter's unit, such as "m", "rad" or "Hz"; `tatu_param.unit` in `tatu/core.h` lists all units.
    pub fn unit(mut self, unit: impl Into<Cow<'static, str>>) -> Self {
        self.unit = Some(unit.into());
        self
    }
    /// Sets the bounds, both of which are allowed values.
    pub fn range(mut self, lowest: f64, highest: f64) -> Self {
        (self.lowest, self.highest) = (lowest, highest);
        self
    }
    /// Sets the default value. The parameter may then be omitted; [`Param::optional`] is not needed.
    pub fn default(mut self, value: impl Into<Value>) -> Self {
        self.fallback = value.into();
        self
    }
    /// Sets the allowed texts.
    pub fn choices(mut self, choices: &'static [&'static str]) -> Self {
        self.choices = choices.iter().map(|c| Cow::Borrowed(*c)).collect();
        self
    }
    /// Sets the allowed texts, for texts that are determined at run time.
    pub fn choices_of(mut self, choices: Vec<String>) -> Self {
        self.choices = choices.into_iter().map(Cow::Owned).collect();
        self
    }
    /// Allows the parameter to be omitted or to be nil.
    pub fn optional(mut self) -> Self {
        self.flags |= TATU_PARAM_OPTIONAL;
        self
    }
    /// Accepts any number of arguments; only for the last parameter of a command.
    pub fn rest(mut self) -> Self {
        self.flags |= TATU_PARAM_REST | TATU_PARAM_OPTIONAL;
        self
    }
    /// Declares that the text names a program, as a setting of a script language: a relative path with a folder reaches
    /// the plugin as an absolute path, relative to the scene file that states it, otherwise to the working folder.
    pub fn program(mut self) -> Self {
        self.flags |= TATU_PARAM_PROGRAM;
        self
    }
    /// Makes the host recreate the instance when the parameter changes.
    pub fn rebuilds(mut self) -> Self {
        self.flags |= TATU_PARAM_REBUILDS;
        self
    }
    /// Sets the parameter's description, one sentence.
    pub fn text(mut self, text: impl Into<String>) -> Self {
        self.text = text.into();
        self
    }

    /// Returns the key.
    pub fn key(&self) -> &str {
        &self.key
    }

    /// Returns a value for each declared parameter, in the order of declaration: the value that is given for its key,
    /// or its default. Integers are converted to floats where a float is declared. For tests without a host: it checks
    /// only keys, types, counts and ranges of numbers.
    ///
    /// # Errors
    /// Fails if a key is not declared, a value does not fit its declaration, or a value without a default is missing.
    pub fn fill(declared: &[Param], given: &[(&str, Value)]) -> Result<Vec<Value>> {
        if let Some((key, _)) = given.iter().find(|(key, _)| declared.iter().all(|p| p.key != *key)) {
            let known: Vec<&str> = declared.iter().map(|p| p.key.as_str()).collect();
            let known = if known.is_empty() { "none".to_owned() } else { known.join(", ") };
            return Err(Fail::argument(format!("there is no parameter `{key}`; the declared parameters are: {known}")));
        }
        let value = |p: &Param| match given.iter().rev().find(|(key, _)| p.key == *key) {
            Some((_, value)) => p.fit(value.clone()),
            None if p.fallback == Value::Nil && p.flags & TATU_PARAM_OPTIONAL == 0 => {
                Err(Fail::argument(format!("the parameter `{}` is missing, and has no default", p.key)))
            }
            None => Ok(p.fallback.clone()),
        };
        declared.iter().map(value).collect()
    }

    /// Converts a value to the declared type; fails if it does not fit the declaration.
    fn fit(&self, value: Value) -> Result<Value> {
        let value = match (self.kind, value) {
            (TATU_F64, Value::Int(i)) => Value::Float(i as f64),
            (TATU_F64S, Value::Ints(v)) => Value::Floats(v.into_iter().map(|i| i as f64).collect()),
            (_, value) => value,
        };
        let mut room = Owned::default();
        let view = room.value(&value);
        let any = self.flags & TATU_PARAM_ANY != 0;
        if !any && view.tag() != self.kind {
            let (wanted, found) = (type_name(self.kind), type_name(view.tag()));
            return Err(Fail::argument(format!("parameter `{}`: expected {wanted}, found {found}", self.key)));
        }
        if self.count != 0 && view.len() != self.count as usize {
            return Err(Fail::argument(format!(
                "parameter `{}`: expected {} elements, found {}",
                self.key,
                self.count,
                view.len()
            )));
        }
        match view.as_f64() {
            Some(x) if !(self.lowest..=self.highest).contains(&x) => Err(Fail::argument(format!(
                "parameter `{}`: {x} is not within {} to {}",
                self.key, self.lowest, self.highest
            ))),
            _ => Ok(value),
        }
    }

    pub(crate) fn to_table(&self, keep: &mut TableArena) -> *const tatu_param {
        let keys: Vec<_> = self.keys.iter().map(|p| p.to_table(keep)).collect();
        let raw = tatu_param {
            size: size_of::<tatu_param>() as u32,
            type_: self.kind,
            count: self.count,
            flags: self.flags,
            key: keep.text(&self.key),
            unit: self.unit.as_deref().map_or(std::ptr::null(), |u| keep.text(u)),
            lowest: self.lowest,
            highest: self.highest,
            fallback: keep.value(&self.fallback),
            choices: if self.choices.is_empty() { std::ptr::null() } else { keep.texts(&self.choices) },
            text: keep.text(&self.text),
            keys: if keys.is_empty() { std::ptr::null() } else { keep.list(keys) },
        };
        keep.table(raw)
    }
}

/// The values of an instance's declared parameters, accessed by key.
pub struct Params<'a> {
    values: &'a [ValueRef<'a>],
    declared: &'a [Param],
}

impl<'a> Params<'a> {
    /// Wraps values in the order of their declarations, as a host passes them; see [`Param::fill`].
    pub fn new(values: &'a [ValueRef<'a>], declared: &'a [Param]) -> Self {
        Params { values, declared }
    }
    /// Returns the value of a parameter, or nil if it has neither a value nor a default.
    pub fn get(&self, key: &str) -> Result<ValueRef<'a>> {
        let i = self
            .declared
            .iter()
            .position(|p| p.key == key)
            .ok_or_else(|| Fail::new(format!("the plugin reads the parameter `{key}`, but does not declare it")))?;
        Ok(self.values.get(i).copied().unwrap_or(ValueRef::NIL))
    }
    fn want<T>(&self, key: &str, what: &str, read: impl FnOnce(ValueRef<'a>) -> Option<T>) -> Result<T> {
        let v = self.get(key)?;
        read(v)
            .ok_or_else(|| Fail::argument(format!("parameter `{key}`: expected {what}, found {}", type_name(v.tag()))))
    }
    /// Returns the value of a parameter as a number.
    pub fn f64(&self, key: &str) -> Result<f64> {
        self.want(key, "a number", ValueRef::as_f64)
    }
    /// Returns the value of a parameter as an integer.
    pub fn i64(&self, key: &str) -> Result<i64> {
        self.want(key, "an integer", ValueRef::as_i64)
    }
    /// Returns the value of a parameter as a boolean.
    pub fn bool(&self, key: &str) -> Result<bool> {
        self.want(key, "true or false", ValueRef::as_bool)
    }
    /// Returns the value of a parameter as a text.
    pub fn string(&self, key: &str) -> Result<String> {
        self.want(key, "a text", |v| v.as_str().map(|s| s.into_owned()))
    }
    /// Returns the value of a parameter as exactly `N` numbers.
    pub fn array<const N: usize>(&self, key: &str) -> Result<[f64; N]> {
        self.want(key, &format!("{N} numbers"), ValueRef::array)
    }
}
