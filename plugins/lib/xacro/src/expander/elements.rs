//! Elements, one after the other.

use std::rc::Rc;

use super::{Expander, PartialElement};
use crate::{
    error::{Origin, Result, fail},
    source::{Attribute, Element, Node},
};

impl Expander<'_> {
    /// Expands a file; returns its root element.
    pub fn expand_file(&mut self, name: &str, bytes: &[u8]) -> Result<Rc<Element>> {
        if bytes.len() > self.budget.limits.file_bytes {
            fail!("{name} has more than {} bytes", self.budget.limits.file_bytes);
        }
        self.budget.spend(1 + bytes.len() / 8)?;
        let root = self.parse_source(name, bytes)?;
        self.stack.push(name.to_owned());
        let expanded = self.expand_plain(&root)?;
        self.stack.pop();
        let Some(namespace) = root.attribute("xacro:targetNamespace").filter(|space| !space.value.is_empty()) else {
            return Ok(expanded);
        };
        let mut attributes = expanded.attributes.clone();
        set_attribute(&mut attributes, Attribute { name: "xmlns".into(), ..namespace.clone() });
        let (name, origin) = (expanded.name.clone(), expanded.origin);
        Ok(Rc::new(Element { name, attributes, children: expanded.children.clone(), origin }))
    }

    pub(super) fn expand_children(&mut self, children: &[Node], into: &mut PartialElement) -> Result<()> {
        for child in children {
            match child {
                Node::Element(element) => {
                    self.budget.enter().map_err(|fault| fault.at(element.origin))?;
                    let outer = std::mem::replace(&mut self.origin, element.origin);
                    let result = self.expand_element(element, into).map_err(|fault| fault.at(element.origin));
                    self.origin = outer;
                    self.budget.leave();
                    result?;
                }
                Node::Text(text, origin) => {
                    let text = self.text_at(text, *origin)?;
                    if !text.trim().is_empty() {
                        into.children.push(Node::Text(resolvable(text), *origin));
                    }
                }
            }
        }
        Ok(())
    }

    fn expand_element(&mut self, element: &Rc<Element>, into: &mut PartialElement) -> Result<()> {
        match &*element.name {
            "xacro:insert_block" => self.insert_block(element, into),
            "xacro:include" => self.include(element, into),
            "xacro:property" => self.define_property(element),
            "xacro:macro" => self.define_macro(element),
            "xacro:arg" => self.declare_argument(element),
            "xacro:element" => self.expand_named(element, into),
            "xacro:attribute" => {
                let (name, origin) = self.required(element, "name")?;
                let name = self.text_at(name, origin)?;
                let (value, origin) = self.required(element, "value")?;
                let value = self.text_at(value, origin)?;
                check_name(&name, "an attribute")?;
                set_attribute(&mut into.attributes, Attribute { name, value: resolvable(value), origin });
                Ok(())
            }
            "xacro:if" | "xacro:unless" => {
                self.check_attributes(element, &["value"]);
                self.required(element, "value")?;
                if self.switch(element, "value", false)? == (&*element.name == "xacro:if") {
                    let mut made = PartialElement::default();
                    self.expand_children(&element.children, &mut made)?;
                    self.take_contents(made, into, element.origin);
                }
                Ok(())
            }
            name if name.starts_with("xacro:") => self.call_macro(element, into),
            name => {
                if matches!(name, "macro" | "insert_block") {
                    let message = format!("<{name}> is not expanded: current versions of xacro expect <xacro:{name}>");
                    self.notes.add("element without prefix", &message, Some(element.origin));
                }
                let made = self.expand_plain(element)?;
                into.children.push(Node::Element(made));
                Ok(())
            }
        }
    }

    /// Expands an element that stays, with its attributes and children.
    fn expand_plain(&mut self, element: &Element) -> Result<Rc<Element>> {
        let mut made = PartialElement::default();
        for attribute in &element.attributes {
            if attribute.name.starts_with("xacro:") || &*attribute.name == "xmlns:xacro" {
                continue;
            }
            let value = self.text_at(&attribute.value, attribute.origin)?;
            made.attributes.push(Attribute { value: resolvable(value), ..attribute.clone() });
        }
        self.expand_children(&element.children, &mut made)?;
        let PartialElement { attributes, children } = made;
        Ok(Rc::new(Element { name: element.name.clone(), attributes, children, origin: element.origin }))
    }

    /// `<xacro:element xacro:name="...">`: an element whose name is evaluated.
    fn expand_named(&mut self, element: &Element, into: &mut PartialElement) -> Result<()> {
        let (name, origin) = self.required(element, "xacro:name")?;
        let name = self.text_at(name, origin)?;
        check_name(&name, "an element")?;
        if &*name == "xacro:element" {
            fail!("<xacro:element> cannot make an element of its own kind");
        }
        let is_other = |attribute: &&Attribute| &*attribute.name != "xacro:name";
        let named = Element {
            name,
            attributes: element.attributes.iter().filter(is_other).cloned().collect(),
            children: element.children.clone(),
            origin: element.origin,
        };
        self.expand_element(&Rc::new(named), into)
    }

    fn insert_block(&mut self, element: &Element, into: &mut PartialElement) -> Result<()> {
        self.check_attributes(element, &["name"]);
        let (name, _) = self.required(element, "name")?;
        let table = self.scope.properties;
        if let Some(block) = self.properties.find_block(table, &format!("**{name}")).cloned() {
            let mut made = PartialElement::default();
            self.expand_children(&block.children, &mut made)?;
            self.take_contents(made, into, element.origin);
        } else if let Some(block) = self.properties.find_block(table, &format!("*{name}")).cloned() {
            let made = self.expand_plain(&block)?;
            into.children.push(Node::Element(made));
        } else {
            fail!(
                "the block `{name}` is not defined: expected a parameter *{name} or **{name} of the macro, or a property with content"
            );
        }
        Ok(())
    }

    /// Moves what an element without trace in the result contains to the element around it.
    pub(super) fn take_contents(&mut self, mut made: PartialElement, into: &mut PartialElement, origin: Origin) {
        for attribute in made.attributes {
            if attribute.name.starts_with("xmlns") {
                add_namespace(&mut into.attributes, attribute);
            } else {
                let message = "<xacro:attribute> directly in a macro, a condition or a block has no effect, as in xacro: \
                               the condition belongs into its value";
                self.notes.add("attribute without element", message, Some(origin));
            }
        }
        into.children.append(&mut made.children);
    }

    /// Adds the declarations of namespaces of an element without trace to the element around it.
    pub(super) fn import_namespaces(&mut self, from: &Element, into: &mut PartialElement) -> Result<()> {
        for attribute in &from.attributes {
            if attribute.name.starts_with("xmlns:") && &*attribute.name != "xmlns:xacro" {
                let value = self.text_at(&attribute.value, attribute.origin)?;
                add_namespace(&mut into.attributes, Attribute { value, ..attribute.clone() });
            }
        }
        Ok(())
    }
}

fn add_namespace(attributes: &mut Vec<Attribute>, attribute: Attribute) {
    if !attributes.iter().any(|known| known.name == attribute.name) {
        attributes.push(attribute);
    }
}

fn set_attribute(attributes: &mut Vec<Attribute>, attribute: Attribute) {
    match attributes.iter_mut().find(|known| known.name == attribute.name) {
        Some(known) => *known = attribute,
        None => attributes.push(attribute),
    }
}

/// Refuses names that XML does not have.
fn check_name(name: &str, of: &str) -> Result<()> {
    let is_start = |c: char| c.is_alphabetic() || c == '_';
    let is_part = |part: &str| {
        part.starts_with(is_start) && part.chars().all(|c| c.is_alphanumeric() || matches!(c, '_' | '-' | '.'))
    };
    let parts: Vec<&str> = name.split(':').collect();
    if parts.len() > 2 || !parts.iter().all(|part| is_part(part)) {
        fail!("`{}` cannot be the name of {of}", crate::error::excerpt(name));
    }
    Ok(())
}

/// Makes `file://$(find NAME)/...` a name that is resolved like `package://NAME/...`.
fn resolvable(text: std::rc::Rc<str>) -> Rc<str> {
    if text.contains("file://package://") { text.replace("file://package://", "package://").into() } else { text }
}
