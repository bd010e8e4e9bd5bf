//! Tables of properties and of macros: those of the file, of each call of a macro, and of each include with `ns`.

use std::{collections::BTreeMap, rc::Rc};

use crate::{error::Origin, parameters::Parameter, source::Element, value::Value};

/// A property.
#[derive(Clone, Debug)]
pub(crate) enum Property {
    Value(Value),
    /// A text that is evaluated when the property is used first.
    Lazy(Rc<str>, Origin),
}

/// What a table contains, by name; names of blocks begin with `*`, or `**` if only what is in them is inserted.
#[derive(Debug, Default)]
pub(crate) struct Table {
    pub properties: BTreeMap<Rc<str>, Property>,
    pub blocks: BTreeMap<Rc<str>, Rc<Element>>,
    pub parent: Option<usize>,
    /// Whether it belongs to an include with `ns`, so that it is skipped as the scope of a caller.
    pub is_namespace: bool,
}

/// All tables of properties. A table is older than those that see it, so that a chain of parents ends.
#[derive(Debug)]
pub(crate) struct Tables {
    list: Vec<Table>,
}

/// The table of the file.
pub(crate) const TOP: usize = 0;

impl Tables {
    pub fn new() -> Self {
        Tables { list: vec![Table::default()] }
    }

    pub fn add(&mut self, parent: usize, is_namespace: bool) -> usize {
        self.list.push(Table { parent: Some(parent), is_namespace, ..Table::default() });
        self.list.len() - 1
    }

    pub fn len(&self) -> usize {
        self.list.len()
    }

    /// Forgets the tables that were added after there were `len`.
    pub fn truncate(&mut self, len: usize) {
        self.list.truncate(len.max(1));
    }

    pub fn get(&self, table: usize) -> Option<&Table> {
        self.list.get(table)
    }

    pub fn get_mut(&mut self, table: usize) -> Option<&mut Table> {
        self.list.get_mut(table)
    }

    /// The tables that are visible from one, from the inside out.
    fn chain(&self, from: usize) -> impl Iterator<Item = usize> {
        std::iter::successors(Some(from), |table| self.get(*table)?.parent.filter(|parent| parent < table))
    }

    /// The table in which a property is found, and the property.
    pub fn find(&self, from: usize, name: &str) -> Option<(usize, &Property)> {
        self.chain(from).find_map(|table| Some((table, self.get(table)?.properties.get(name)?)))
    }

    pub fn find_block(&self, from: usize, name: &str) -> Option<&Rc<Element>> {
        self.chain(from).find_map(|table| self.get(table)?.blocks.get(name))
    }

    /// Sets a property in one table.
    pub fn set(&mut self, table: usize, name: &str, property: Property) {
        if let Some(table) = self.get_mut(table) {
            table.properties.insert(name.into(), property);
        }
    }

    /// Removes a property from all tables that are visible from one.
    pub fn remove(&mut self, from: usize, name: &str) {
        let tables: Vec<usize> = self.chain(from).collect();
        for table in tables {
            if let Some(table) = self.get_mut(table) {
                table.properties.remove(name);
            }
        }
    }

    /// The table of whoever called the macro to which a table belongs.
    pub fn caller(&self, table: usize) -> Option<usize> {
        let mut at = self.get(table)?.parent?;
        if !self.get(table)?.is_namespace {
            while self.get(at)?.is_namespace {
                at = self.get(at)?.parent?;
            }
        }
        Some(at)
    }
}

/// A macro.
#[derive(Debug)]
pub(crate) struct Macro {
    pub body: Rc<Element>,
    pub parameters: Vec<Parameter>,
}

/// What a name of a macro stands for.
#[derive(Clone, Debug)]
pub(crate) enum MacroEntry {
    Macro(Rc<Macro>),
    /// An include with `ns`: its tables of macros and of properties.
    Space {
        macros: usize,
        properties: usize,
    },
}

/// The macros of a table, and the table around it.
type MacroTable = (BTreeMap<Rc<str>, MacroEntry>, Option<usize>);

/// All tables of macros.
#[derive(Debug)]
pub(crate) struct MacroTables {
    list: Vec<MacroTable>,
}

impl MacroTables {
    pub fn new() -> Self {
        MacroTables { list: vec![(BTreeMap::new(), None)] }
    }

    pub fn add(&mut self, parent: Option<usize>) -> usize {
        self.list.push((BTreeMap::new(), parent));
        self.list.len() - 1
    }

    pub fn len(&self) -> usize {
        self.list.len()
    }

    pub fn truncate(&mut self, len: usize) {
        self.list.truncate(len.max(1));
    }

    pub fn set(&mut self, table: usize, name: &str, entry: MacroEntry) {
        if let Some((entries, _)) = self.list.get_mut(table) {
            entries.insert(name.into(), entry);
        }
    }

    pub fn find(&self, from: usize, name: &str) -> Option<&MacroEntry> {
        let parent = |table: &usize| self.list.get(*table)?.1.filter(|parent| parent < table);
        std::iter::successors(Some(from), parent).find_map(|table| self.list.get(table)?.0.get(name))
    }
}
