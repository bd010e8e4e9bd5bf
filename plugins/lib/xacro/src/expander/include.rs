//! `<xacro:include>`.

use std::rc::Rc;

use super::{Expander, PartialElement};
use crate::{
    error::{Result, fail},
    expression::context::Context,
    files::{is_pattern, matching},
    literal::condition,
    scopes::{MacroEntry, Property},
    source::{Element, parse},
    value::{Namespace, Value},
};

impl Expander<'_> {
    pub(super) fn include(&mut self, element: &Element, into: &mut PartialElement) -> Result<()> {
        self.check_attributes(element, &["filename", "ns", "optional"]);
        let (name, origin) = self.required(element, "filename")?;
        let mut scope = self.scope;
        if let Some(space) = element.attribute("ns").filter(|space| !space.value.is_empty()) {
            let space = self.text_at(&space.value, space.origin)?;
            scope.macros = self.macros.add(None);
            scope.properties = self.properties.add(self.scope.properties, true);
            let entry = MacroEntry::Space { macros: scope.macros, properties: scope.properties };
            self.macros.set(self.scope.macros, &space, entry);
            let namespace = Value::Namespace(Namespace::Table(scope.properties));
            self.properties.set(self.scope.properties, &space, Property::Value(namespace));
        }
        let is_optional = match element.attribute("optional") {
            Some(optional) => condition(&Value::Text(optional.value.clone()), &optional.value, &mut self.budget)
                .map_err(|fault| fault.at(optional.origin))?,
            None => false,
        };
        if element.elements().next().is_some() {
            self.notes.add("children of include", "elements in <xacro:include> are ignored", Some(element.origin));
        }
        let path = self.text_at(name, origin)?;
        let path = self.file_name(&path);
        let paths = if is_pattern(&path) {
            let found = match matching(&path, self.budget.limits.items, self.files) {
                Ok(found) => found,
                Err(message) => fail!("{message}"),
            };
            if found.is_empty() {
                let message = format!("no file matches {path}");
                self.notes.add("include without files", &message, Some(origin));
            }
            found
        } else {
            vec![path]
        };
        for path in paths {
            match self.include_file(&path, scope, into) {
                Err(fault) if is_optional && fault.is_missing_file => {}
                Err(fault) if fault.is_missing_file => return Err(fault.at(origin)),
                Err(fault) => return Err(fault.within(|| format!("{path} is included here"), origin)),
                Ok(()) => {}
            }
        }
        Ok(())
    }

    fn include_file(&mut self, path: &str, scope: super::Scope, into: &mut PartialElement) -> Result<()> {
        if self.stack.len() >= self.budget.limits.include_depth {
            fail!("files are included deeper than {}: does a file include itself?", self.budget.limits.include_depth);
        }
        let root = self.root_of(path)?;
        self.stack.push(path.to_owned());
        let outer = std::mem::replace(&mut self.scope, scope);
        let mut made = PartialElement::default();
        let result = self.expand_children(&root.children, &mut made);
        self.scope = outer;
        self.stack.pop();
        // A file that is missing within is not the one that is optional here.
        result.map_err(|mut fault| {
            fault.is_missing_file = false;
            fault
        })?;
        self.import_namespaces(&root, into)?;
        self.take_contents(made, into, root.origin);
        Ok(())
    }

    /// The root element of a file.
    fn root_of(&mut self, path: &str) -> Result<Rc<Element>> {
        if let Some(root) = self.parsed.get(path) {
            return Ok(root.clone());
        }
        let bytes = self.read_file(path)?;
        let root = self.parse_source(path, &bytes)?;
        self.parsed.insert(path.to_owned(), root.clone());
        Ok(root)
    }

    /// Parses a file and adds it to the sources.
    pub(super) fn parse_source(&mut self, name: &str, bytes: &[u8]) -> Result<Rc<Element>> {
        let (file, root) = parse(name, bytes, self.sources.len() as u32);
        // The prefix of xacro itself does not appear in the result.
        for prefix in file.undeclared.iter().filter(|prefix| *prefix != "xacro") {
            let message = format!("the prefix `{prefix}:` is not declared by xmlns:{prefix}");
            let origin = root.as_ref().ok().map(|root| root.origin);
            self.notes.add(&message, &message, origin);
        }
        self.sources.push(file);
        root
    }
}
