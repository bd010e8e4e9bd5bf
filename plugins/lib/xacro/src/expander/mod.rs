//! Expands the elements of a file.
//!
//! The state, and what expressions see of it, are in this file.
//!
//! - `text`: texts with `${...}` and `$(...)`;
//! - `property`, `call`, `include`: what the elements of these names do;
//! - `elements`: all elements.

mod call;
mod elements;
mod include;
mod property;
mod text;

use std::{
    collections::{BTreeMap, BTreeSet},
    rc::Rc,
};

use crate::{
    error::{Fault, Origin, Result, fail},
    expression::context::{Context, Severity},
    files::{Files, relative_to},
    limits::{Budget, Limits},
    notes::Notes,
    scopes::{MacroTables, Property, TOP, Tables},
    source::{Attribute, Element, Node, SourceFile},
    value::Value,
    yaml,
};

/// The tables in which names are looked up first.
#[derive(Clone, Copy)]
struct Scope {
    properties: usize,
    macros: usize,
}

/// What an element has become so far.
#[derive(Default)]
struct PartialElement {
    attributes: Vec<Attribute>,
    children: Vec<Node>,
}

/// The state of an expansion.
pub(crate) struct Expander<'a> {
    files: &'a mut dyn Files,
    pub sources: Vec<SourceFile>,
    /// Files that were parsed, by path.
    parsed: BTreeMap<String, Rc<Element>>,
    pub budget: Budget,
    properties: Tables,
    macros: MacroTables,
    scope: Scope,
    /// Values of `$(arg NAME)`.
    pub arguments: BTreeMap<String, String>,
    /// Arguments that the file declares or uses.
    pub known_arguments: BTreeSet<String>,
    pub notes: Notes,
    /// The files that are being read, the innermost last.
    stack: Vec<String>,
    /// Properties whose values are being evaluated, with their tables.
    resolving: Vec<(usize, Rc<str>)>,
    /// Where the text stands that is being evaluated.
    origin: Origin,
    files_read: usize,
}

impl<'a> Expander<'a> {
    pub fn new(limits: Limits, arguments: BTreeMap<String, String>, files: &'a mut dyn Files) -> Self {
        Expander {
            files,
            sources: Vec::new(),
            parsed: BTreeMap::new(),
            budget: Budget::new(limits),
            properties: Tables::new(),
            macros: MacroTables::new(),
            scope: Scope { properties: TOP, macros: TOP },
            arguments,
            known_arguments: BTreeSet::new(),
            notes: Notes::default(),
            stack: Vec::new(),
            resolving: Vec::new(),
            origin: Origin { file: 0, offset: 0 },
            files_read: 0,
        }
    }

    /// Records a note at the text that is being evaluated.
    fn add_note(&mut self, kind: &str, message: &str) {
        self.notes.add(kind, message, Some(self.origin));
    }

    /// Reads a file within the bounds.
    fn read_file(&mut self, path: &str) -> Result<Vec<u8>> {
        self.files_read += 1;
        if self.files_read > self.budget.limits.files {
            fail!("more than {} files are read", self.budget.limits.files);
        }
        let bytes = match self.files.read(path) {
            Ok(bytes) => bytes,
            Err(reason) => {
                let mut fault = Fault::new(format!("{path} cannot be read: {reason}"));
                fault.is_missing_file = true;
                return Err(fault);
            }
        };
        if bytes.len() > self.budget.limits.file_bytes {
            fail!("{path} has more than {} bytes", self.budget.limits.file_bytes);
        }
        self.budget.spend(1 + bytes.len() / 8)?;
        Ok(bytes)
    }

    /// The value of a property in the tables that are visible from one.
    fn find_property(&mut self, from: usize, name: &str) -> Result<Option<Value>> {
        // A name may be looked up in as many tables as there are.
        self.budget.spend(self.properties.len() / 16)?;
        let Some((table, property)) = self.properties.find(from, name) else { return Ok(None) };
        let (text, origin) = match property {
            Property::Value(value) => return Ok(Some(value.clone())),
            Property::Lazy(text, origin) => (text.clone(), *origin),
        };
        let name: Rc<str> = name.into();
        if let Some(start) = self.resolving.iter().position(|(t, n)| *t == table && *n == name) {
            let mut chain: Vec<&str> = self.resolving[start..].iter().map(|(_, name)| &**name).collect();
            chain.push(&name);
            fail!(
                "the property is defined by itself: {}; with lazy_eval=\"false\", its earlier value is used",
                chain.join(" -> ")
            );
        }
        self.budget.enter_property()?;
        self.resolving.push((table, name.clone()));
        let outer = (self.scope, self.origin);
        self.scope.properties = table;
        self.origin = origin;
        let value = self.value_of(&text);
        (self.scope, self.origin) = outer;
        self.resolving.pop();
        self.budget.leave_property();
        let value = crate::literal::literal(
            value.map_err(|f| f.at(origin).within(|| format!("the property `{name}` is used here"), self.origin))?,
        );
        self.properties.set(table, &name, Property::Value(value.clone()));
        Ok(Some(value))
    }
}

impl Context for Expander<'_> {
    fn budget(&mut self) -> &mut Budget {
        &mut self.budget
    }

    fn property(&mut self, name: &str) -> Result<Option<Value>> {
        self.find_property(self.scope.properties, name)
    }

    fn property_in(&mut self, table: usize, name: &str) -> Result<Option<Value>> {
        self.find_property(table, name)
    }

    fn argument(&mut self, name: &str) -> Result<Value> {
        self.known_arguments.insert(name.to_owned());
        match self.arguments.get(name) {
            Some(value) => Ok(Value::text(value.as_str())),
            None => fail!("the argument `{name}` has no value: give one ({name}:=...), or a default in <xacro:arg>"),
        }
    }

    fn file_name(&mut self, name: &str) -> String {
        self.stack.last().map_or_else(|| name.to_owned(), |file| relative_to(file, name))
    }

    fn load_yaml(&mut self, name: &str) -> Result<Value> {
        let path = self.file_name(name);
        let bytes = self.read_file(&path)?;
        let Ok(text) = String::from_utf8(bytes) else { fail!("{path} is no text in UTF-8: save it in this encoding") };
        match yaml::load(&text, self) {
            Ok(value) => Ok(value.wrapped()),
            Err(fault) => fail!("{path}, {}", fault.message),
        }
    }

    fn say(&mut self, severity: Severity, text: &str) {
        let kind = match severity {
            Severity::Message => "message",
            Severity::Warning => "warning",
            Severity::Error => "error",
        };
        let message = format!("the file reports, as {kind}: {}", crate::error::excerpt(text));
        self.add_note(&message, &message);
    }

    fn note(&mut self, kind: &'static str, text: &str) {
        self.add_note(kind, text);
    }
}
