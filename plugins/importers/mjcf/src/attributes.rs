//! Attributes of an element, with those that its default class adds.

use std::collections::BTreeMap;

use tatu_plugin_api::safe::{Fail, Result};

use crate::xml::{Element, Place};

/// Attributes that a class sets for one kind of element, with their places.
pub type Record = BTreeMap<String, (String, Place)>;

/// Attributes that are arrays, of which an element can set only the first numbers.
const PARTIAL: [&str; 8] = ["size", "friction", "gear", "gainprm", "biasprm", "dynprm", "solref", "solimp"];

/// Largest magnitude of a number; infinite values are replaced by it.
const MAX_NUMBER: f64 = 1e12;

/// The attributes of an element and of its class.
#[derive(Clone, Copy)]
pub struct Attributes<'a> {
    pub element: &'a Element,
    class: Option<&'a Record>,
}

/// Returns the text of an array of which the first numbers are `own`, and the others those of `base`.
pub fn completed(name: &str, own: &str, base: Option<&str>) -> String {
    let Some(base) = base.filter(|_| PARTIAL.contains(&name)) else { return own.to_owned() };
    let count = words(own).count();
    words(own).chain(words(base).skip(count)).collect::<Vec<_>>().join(" ")
}

fn words(text: &str) -> impl Iterator<Item = &str> {
    text.split(|c: char| c.is_whitespace() || c == ',').filter(|w| !w.is_empty())
}

/// Parses the numbers in a text; `None` if a word is not a number.
pub fn parse_numbers(text: &str) -> Option<Vec<f64>> {
    let number =
        |word: &str| word.parse::<f64>().ok().filter(|x| !x.is_nan()).map(|x| x.clamp(-MAX_NUMBER, MAX_NUMBER));
    words(text).map(number).collect()
}

impl<'a> Attributes<'a> {
    pub fn new(element: &'a Element, class: Option<&'a Record>) -> Self {
        Attributes { element, class }
    }
    /// Returns the text of an attribute, of the element or its class.
    pub fn text(&self, name: &str) -> Option<String> {
        let base = self.class.and_then(|c| c.get(name)).map(|(value, _)| value.as_str());
        match self.element.attribute(name) {
            Some(own) => Some(completed(name, own, base)),
            None => base.map(str::to_owned),
        }
    }
    /// Returns whether the element or its class sets an attribute.
    pub fn has(&self, name: &str) -> bool {
        self.element.attribute(name).is_some() || self.class.is_some_and(|c| c.contains_key(name))
    }
    /// Builds the error for an invalid value, at the line that sets it.
    pub fn invalid(&self, name: &str, expected: &str) -> Fail {
        let place = match self.class.and_then(|c| c.get(name)).filter(|_| self.element.attribute(name).is_none()) {
            Some((_, place)) => place,
            None => &self.element.place,
        };
        let (tag, value) = (&self.element.name, self.text(name).unwrap_or_default());
        place.fail(format!("`{name}` of <{tag}> is \"{value}\"; expected {expected}"))
    }
    /// Returns the numbers in an attribute, or `None` if it is missing.
    pub fn numbers(&self, name: &str) -> Result<Option<Vec<f64>>> {
        let Some(text) = self.text(name) else { return Ok(None) };
        parse_numbers(&text).map(Some).ok_or_else(|| self.invalid(name, "numbers"))
    }
    /// Returns the `N` numbers in an attribute, or `None` if it is missing.
    pub fn array<const N: usize>(&self, name: &str) -> Result<Option<[f64; N]>> {
        let Some(numbers) = self.numbers(name)? else { return Ok(None) };
        numbers.try_into().map(Some).map_err(|_| self.invalid(name, &format!("{N} numbers")))
    }
    /// Returns `default` with its first numbers replaced by those of an attribute.
    pub fn partial<const N: usize>(&self, name: &str, mut default: [f64; N]) -> Result<[f64; N]> {
        if let Some(numbers) = self.numbers(name)? {
            if numbers.len() > N {
                return Err(self.invalid(name, &format!("at most {N} numbers")));
            }
            default[..numbers.len()].copy_from_slice(&numbers);
        }
        Ok(default)
    }
    /// Returns the first number in an attribute, or `default` if it is missing.
    pub fn number(&self, name: &str, default: f64) -> Result<f64> {
        match self.numbers(name)?.as_deref() {
            None => Ok(default),
            Some([first, ..]) => Ok(*first),
            Some([]) => Err(self.invalid(name, "a number")),
        }
    }
    /// Returns a number that is not negative.
    pub fn positive(&self, name: &str, default: f64) -> Result<f64> {
        let number = self.number(name, default)?;
        if number < 0.0 { Err(self.invalid(name, "a number that is not negative")) } else { Ok(number) }
    }
    /// Returns an integer, such as a bit mask.
    pub fn integer(&self, name: &str, default: i64) -> Result<i64> {
        self.number(name, default as f64).map(|x| x as i64)
    }
    /// Returns a truth value; `None` if it is missing or `auto`.
    pub fn switch(&self, name: &str) -> Result<Option<bool>> {
        match self.text(name).as_deref() {
            None | Some("auto") => Ok(None),
            Some("true" | "enable") => Ok(Some(true)),
            Some("false" | "disable") => Ok(Some(false)),
            Some(_) => Err(self.invalid(name, "true or false")),
        }
    }
}
