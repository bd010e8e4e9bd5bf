//! `<xacro:macro>` and calls of macros.

use std::rc::Rc;

use super::{Expander, PartialElement, Scope};
use crate::{
    error::{Fault, Result, fail},
    literal::literal,
    parameters,
    scopes::{Macro, MacroEntry},
    source::Element,
    value::Value,
};

/// Maximum number of parameters of a macro.
const MAX_PARAMETERS: usize = 256;

impl Expander<'_> {
    pub(super) fn define_macro(&mut self, element: &Rc<Element>) -> Result<()> {
        self.check_attributes(element, &["name", "params"]);
        let (full_name, origin) = self.required(element, "name")?;
        let name = full_name.strip_prefix("xacro:").unwrap_or(full_name);
        if name.len() < full_name.len() {
            let message = format!("the name of the macro {full_name} should be written without `xacro:`");
            self.notes.add("macro with prefix", &message, Some(origin));
        }
        if name == "call" || name.contains('.') {
            return Err(Fault::new(format!("`{name}` cannot be the name of a macro")).at(origin));
        }
        let parameters = match element.attribute("params") {
            Some(params) => parameters::parse(&params.value).map_err(|fault| fault.at(params.origin))?,
            None => Vec::new(),
        };
        if parameters.len() > MAX_PARAMETERS {
            fail!("the macro `{name}` has more than {MAX_PARAMETERS} parameters");
        }
        self.budget.spend(parameters.len())?;
        let defined = Macro { body: element.clone(), parameters };
        self.macros.set(self.scope.macros, name, MacroEntry::Macro(Rc::new(defined)));
        Ok(())
    }

    /// The macro of a name, which may begin with namespaces and dots, and the tables that it sees.
    fn find_macro(&self, full_name: &str) -> Result<(Rc<Macro>, Scope)> {
        if let Some(MacroEntry::Macro(found)) = self.macros.find(self.scope.macros, full_name) {
            return Ok((found.clone(), self.scope));
        }
        let mut scope = self.scope;
        let mut rest = full_name;
        while let Some((space, name)) = rest.split_once('.') {
            let Some(MacroEntry::Space { macros, properties }) = self.macros.find(scope.macros, space) else { break };
            scope = Scope { macros: *macros, properties: *properties };
            rest = name;
        }
        match self.macros.find(scope.macros, rest) {
            Some(MacroEntry::Macro(found)) if scope.macros != self.scope.macros => Ok((found.clone(), scope)),
            _ => fail!(
                "the macro `{full_name}` is unknown: it must be defined, or its file included, before it is called"
            ),
        }
    }

    /// Expands `<xacro:NAME>`, or `<xacro:call macro="NAME">`.
    pub(super) fn call_macro(&mut self, element: &Element, into: &mut PartialElement) -> Result<()> {
        let called = match &*element.name {
            "xacro:call" => {
                let (name, origin) = self.required(element, "macro")?;
                self.text_at(name, origin)?
            }
            name => name.strip_prefix("xacro:").unwrap_or(name).into(),
        };
        let (found, scope) = self.find_macro(&called)?;
        let is_call = &*element.name == "xacro:call";
        let within =
            |fault: Box<Fault>| fault.within(|| format!("the macro `{called}` is called here"), element.origin);
        let (values, blocks) = self.arguments_of(element, &called, &found, is_call)?;

        let (properties_len, macros_len) = (self.properties.len(), self.macros.len());
        let inner = Scope {
            properties: self.properties.add(scope.properties, false),
            macros: self.macros.add(Some(scope.macros)),
        };
        for (name, value) in values {
            self.set_property(inner.properties, name, value, None);
        }
        for (name, block) in blocks {
            self.set_block(inner.properties, name, &block);
        }
        let outer = std::mem::replace(&mut self.scope, inner);
        let mut made = PartialElement::default();
        let result = self.expand_children(&found.body.children, &mut made);
        self.scope = outer;
        self.properties.truncate(properties_len);
        self.macros.truncate(macros_len);
        result.map_err(within)?;
        self.import_namespaces(&found.body, into)?;
        self.take_contents(made, into, element.origin);
        Ok(())
    }

    /// Evaluates the parameters of a call: values and blocks by name.
    #[allow(clippy::type_complexity, reason = "two lists of pairs are clear")]
    fn arguments_of<'m>(
        &mut self,
        element: &Element,
        called: &str,
        found: &'m Macro,
        is_call: bool,
    ) -> Result<(Vec<(&'m str, Value)>, Vec<(&'m str, Rc<Element>)>)> {
        // A call makes two tables, and compares each attribute with each parameter.
        self.budget.spend(8 + found.parameters.len() * (1 + element.attributes.len() / 8))?;
        let mut values: Vec<(&str, Value)> = Vec::new();
        let mut blocks = Vec::new();
        for attribute in &element.attributes {
            let name = &*attribute.name;
            if name.starts_with("xmlns") || (is_call && name == "macro") {
                continue;
            }
            let Some(parameter) = found.parameters.iter().find(|parameter| parameter.name == name) else {
                let known: Vec<&str> = found.parameters.iter().map(|parameter| parameter.name.as_str()).collect();
                let known = if known.is_empty() { "none".to_owned() } else { known.join(", ") };
                let message = format!("the macro `{called}` has no parameter `{name}`: expected {known}");
                return Err(Fault::new(message).at(attribute.origin));
            };
            values.push((parameter.name.as_str(), literal(self.value_at(&attribute.value, attribute.origin)?)));
        }

        let mut made = PartialElement::default();
        self.expand_children(&element.children, &mut made)?;
        let given = Element {
            name: element.name.clone(),
            attributes: Vec::new(),
            children: made.children,
            origin: element.origin,
        };
        let mut elements = given.elements();
        for parameter in found.parameters.iter().filter(|parameter| parameter.is_block()) {
            match elements.next() {
                Some(block) => blocks.push((parameter.name.as_str(), block.clone())),
                None => fail!("the macro `{called}` needs an element for its parameter `{}`", parameter.name),
            }
        }
        if let Some(unused) = elements.next() {
            let message = format!("the macro `{called}` has no parameter for the element <{}>", unused.name);
            return Err(Fault::new(message).at(unused.origin));
        }

        let mut missing = Vec::new();
        for parameter in found.parameters.iter().filter(|parameter| !parameter.is_block()) {
            let name = parameter.name.as_str();
            if values.iter().any(|(given, _)| *given == name) {
                continue;
            }
            let forwarded = match parameter.is_forwarded {
                true => self.find_property(self.scope.properties, name).map_err(|fault| fault.at(element.origin))?,
                false => None,
            };
            let value = match (forwarded, &parameter.default) {
                (Some(value), _) => value,
                (None, Some(default)) => self.value_at(default, element.origin)?,
                (None, None) => {
                    missing.push(name);
                    continue;
                }
            };
            values.push((name, literal(value)));
        }
        if !missing.is_empty() {
            fail!("the macro `{called}` needs a value for {}", missing.join(", "));
        }
        Ok((values, blocks))
    }
}
