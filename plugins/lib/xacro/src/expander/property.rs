//! `<xacro:property>` and `<xacro:arg>`.

use std::rc::Rc;

use super::Expander;
use crate::{
    error::{Origin, Result, fail},
    expression::{is_global, lexer::is_identifier},
    literal::{condition, literal},
    scopes::{Property, TOP},
    source::Element,
    value::Value,
};

impl Expander<'_> {
    /// An attribute that an element must have.
    pub(super) fn required<'e>(&self, element: &'e Element, name: &str) -> Result<(&'e Rc<str>, Origin)> {
        match element.attribute(name) {
            Some(attribute) => Ok((&attribute.value, attribute.origin)),
            None => fail!("<{}> has no attribute `{name}`", element.name),
        }
    }

    /// Notes attributes that an element does not have in xacro.
    pub(super) fn check_attributes(&mut self, element: &Element, known: &[&str]) {
        let is_unknown = |name: &str| !known.contains(&name) && !name.starts_with("xmlns");
        if let Some(unknown) = element.attributes.iter().find(|attribute| is_unknown(&attribute.name)) {
            let message = format!("<{}> has no attribute `{}`, which is ignored", element.name, unknown.name);
            self.notes.add(&message, &message, Some(unknown.origin));
        }
    }

    /// Whether an attribute says true; a text with `${...}` is evaluated.
    pub(super) fn switch(&mut self, element: &Element, name: &str, default: bool) -> Result<bool> {
        let Some(attribute) = element.attribute(name) else { return Ok(default) };
        let value = self.value_at(&attribute.value, attribute.origin)?;
        condition(&value, &attribute.value, &mut self.budget).map_err(|fault| fault.at(attribute.origin))
    }

    pub(super) fn define_property(&mut self, element: &Rc<Element>) -> Result<()> {
        self.check_attributes(element, &["name", "value", "default", "remove", "scope", "lazy_eval"]);
        let (name, name_origin) = self.required(element, "name")?;
        let name = self.text_at(name, name_origin)?;
        if !is_identifier(&name) || name.starts_with("__") {
            fail!("`{name}` cannot be the name of a property: expected letters, digits and `_`, and no word of Python");
        }
        let table = self.scope.properties;
        let removes = self.switch(element, "remove", false)?;
        let (value, default) = (element.attribute("value"), element.attribute("default"));
        if usize::from(removes) + usize::from(value.is_some()) + usize::from(default.is_some()) > 1 {
            fail!("the property `{name}` has several of value, default and remove: expected one");
        }
        if removes {
            self.properties.remove(table, &name);
            return Ok(());
        }
        if default.is_some() && (self.properties.find(table, &name).is_some() || is_global(&name)) {
            return Ok(());
        }
        let mut is_lazy = self.switch(element, "lazy_eval", true)?;
        let target = match element.attribute("scope").map(|scope| (&*scope.value, scope.origin)) {
            Some((_, origin)) if default.is_some() => {
                self.notes.add(
                    "default with scope",
                    &format!("the property `{name}` has a default: scope is ignored"),
                    Some(origin),
                );
                table
            }
            Some(("global", _)) => {
                is_lazy = false;
                TOP
            }
            Some(("parent", _)) => {
                is_lazy = false;
                match self.properties.caller(table) {
                    Some(caller) => caller,
                    None => fail!("scope=\"parent\" is only possible in a macro"),
                }
            }
            Some((other, origin)) => {
                let message = format!("scope=\"{other}\" is unknown and ignored: expected parent or global");
                self.notes.add("unknown scope", &message, Some(origin));
                table
            }
            None => table,
        };
        match value.or(default) {
            Some(attribute) if is_lazy => {
                self.set_property(target, &name, Value::Text(attribute.value.clone()), Some(attribute.origin));
            }
            Some(attribute) => {
                let value = self.value_at(&attribute.value, attribute.origin)?;
                self.set_property(target, &name, value, None);
            }
            None => self.set_block(target, &format!("**{name}"), element),
        }
        Ok(())
    }

    /// Sets a property. If its value is a text and it is `lazy`, it is evaluated when it is used.
    pub(super) fn set_property(&mut self, table: usize, name: &str, value: Value, lazy: Option<Origin>) {
        if is_global(name) {
            let message = format!("the name `{name}` hides what xacro has under this name");
            self.notes.add(&message, &message, Some(lazy.unwrap_or(self.origin)));
        }
        let property = match (literal(value), lazy) {
            (Value::Text(text), Some(origin)) => Property::Lazy(text, origin),
            (value, _) => Property::Value(value),
        };
        self.properties.set(table, name, property);
    }

    /// Sets a block; the name begins with `*` or `**`.
    pub(super) fn set_block(&mut self, table: usize, name: &str, block: &Rc<Element>) {
        if let Some(table) = self.properties.get_mut(table) {
            table.blocks.insert(name.into(), block.clone());
        }
    }

    pub(super) fn declare_argument(&mut self, element: &Element) -> Result<()> {
        self.check_attributes(element, &["name", "default"]);
        let (name, _) = self.required(element, "name")?;
        let (default, origin) = self.required(element, "default")?;
        self.known_arguments.insert(name.to_string());
        if !self.arguments.contains_key(&**name) {
            let value = self.text_at(default, origin)?;
            self.arguments.insert(name.to_string(), value.to_string());
        }
        Ok(())
    }
}
