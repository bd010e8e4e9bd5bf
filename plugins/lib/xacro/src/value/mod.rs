//! Values of expressions, as Python has them. The types, truth and equality are in this file.
//!
//! - `dict`: dictionaries, in order of insertion;
//! - `number`: numbers as text, and operations on them that differ from Rust's;
//! - `text`: values as text.

pub(crate) mod dict;
pub(crate) mod number;
pub(crate) mod text;

use std::{cell::RefCell, cmp::Ordering, rc::Rc};

use crate::{
    error::{Result, fail},
    limits::{Budget, MAX_NESTING},
};
use dict::{DictEntries, EntryKey, SharedDict};
use number::Number;

pub(crate) type Dict = SharedDict<Value>;
pub(crate) type Entries = DictEntries<Value>;

/// A value.
#[derive(Clone, Debug)]
pub(crate) enum Value {
    None,
    Bool(bool),
    Int(i64),
    Float(f64),
    Text(Rc<str>),
    List(List),
    Tuple(Rc<Items>),
    Dict(Dict),
    Range(Range),
    View(Rc<View>),
    /// A function by its name.
    Function(&'static str),
    Namespace(Namespace),
}

/// Items with the greatest depth of lists among them.
#[derive(Debug)]
pub(crate) struct Items {
    pub items: Vec<Value>,
    pub depth: usize,
}

/// A list, which its owners share. Items of a list from YAML (`from_yaml`) are wrapped when they are taken out.
#[derive(Clone, Debug)]
pub(crate) struct List {
    shared: Rc<RefCell<Rc<Items>>>,
    pub from_yaml: bool,
}

/// The numbers of `range()`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Range {
    pub start: i64,
    pub stop: i64,
    pub step: i64,
    pub count: usize,
}

/// What `map`, `zip`, `keys` and the like return: it can be walked through, but is no list.
#[derive(Debug)]
pub(crate) struct View {
    pub kind: &'static str,
    pub items: Items,
}

/// What `name.` is looked up in.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Namespace {
    Math,
    Python,
    Xacro,
    /// Properties of an include with `ns`, by the index of their table.
    Table(usize),
}

impl Items {
    pub fn new(items: Vec<Value>) -> Result<Self> {
        let depth = 1 + items.iter().map(Value::depth).max().unwrap_or(0);
        if depth > MAX_NESTING {
            fail!("lists are nested deeper than {MAX_NESTING}");
        }
        Ok(Items { items, depth })
    }
}

impl List {
    pub fn new(items: Vec<Value>) -> Result<Self> {
        Ok(List { shared: Rc::new(RefCell::new(Rc::new(Items::new(items)?))), from_yaml: false })
    }

    pub fn items(&self) -> Rc<Items> {
        self.shared.borrow().clone()
    }

    /// Replaces the items for all who share the list; they may not contain lists that were not in it.
    pub fn replace(&self, items: Vec<Value>) {
        let depth = self.items().depth;
        self.shared.replace(Rc::new(Items { items, depth }));
    }

    /// A copy that is not shared, with the same items.
    pub fn wrapped(&self) -> Self {
        List { shared: Rc::new(RefCell::new(self.items())), from_yaml: true }
    }
}

impl Value {
    pub fn text(text: impl Into<Rc<str>>) -> Self {
        Value::Text(text.into())
    }

    pub fn list(items: Vec<Value>) -> Result<Self> {
        Ok(Value::List(List::new(items)?))
    }

    pub fn tuple(items: Vec<Value>) -> Result<Self> {
        Ok(Value::Tuple(Rc::new(Items::new(items)?)))
    }

    pub fn view(kind: &'static str, items: Vec<Value>) -> Result<Self> {
        Ok(Value::View(Rc::new(View { kind, items: Items::new(items)? })))
    }

    /// How deep lists are nested in it; 0 for numbers and texts.
    pub fn depth(&self) -> usize {
        match self {
            Value::List(list) => list.items().depth,
            Value::Tuple(items) => items.depth,
            Value::View(view) => view.items.depth,
            Value::Dict(dict) => dict.depth(),
            _ => 0,
        }
    }

    /// The value as items of data from YAML are when they are taken out: dictionaries with names as attributes.
    pub fn wrapped(self) -> Self {
        match self {
            Value::List(list) => Value::List(list.wrapped()),
            Value::Dict(dict) => Value::Dict(dict.wrapped()),
            other => other,
        }
    }

    /// Python's name of the type.
    pub fn kind(&self) -> &'static str {
        match self {
            Value::None => "None",
            Value::Bool(_) => "bool",
            Value::Int(_) => "int",
            Value::Float(_) => "float",
            Value::Text(_) => "str",
            Value::List(_) => "list",
            Value::Tuple(_) => "tuple",
            Value::Dict(_) => "dict",
            Value::Range(_) => "range",
            Value::View(view) => view.kind,
            Value::Function(_) => "function",
            Value::Namespace(_) => "namespace",
        }
    }

    pub fn is_true(&self) -> bool {
        match self {
            Value::None => false,
            Value::Bool(b) => *b,
            Value::Int(i) => *i != 0,
            Value::Float(f) => *f != 0.0,
            Value::Text(t) => !t.is_empty(),
            Value::List(list) => !list.items().items.is_empty(),
            Value::Tuple(items) => !items.items.is_empty(),
            Value::Dict(dict) => dict.len() > 0,
            Value::Range(range) => range.count > 0,
            Value::View(view) => !view.items.items.is_empty() || !view.kind.starts_with("dict"),
            Value::Function(_) | Value::Namespace(_) => true,
        }
    }

    /// The value as an integer, if it is one; True and False are 1 and 0.
    pub fn as_int(&self) -> Option<i64> {
        match self {
            Value::Bool(b) => Some(i64::from(*b)),
            Value::Int(i) => Some(*i),
            _ => None,
        }
    }

    /// The value as a number, if it is one.
    pub fn as_float(&self) -> Option<f64> {
        match self {
            Value::Float(f) => Some(*f),
            other => other.as_int().map(|i| i as f64),
        }
    }

    /// The value as a number with its kind, if it is one.
    pub fn as_number(&self) -> Option<Number> {
        match self {
            Value::Float(f) => Some(Number::Float(*f)),
            other => other.as_int().map(Number::Int),
        }
    }

    /// The value as the key of a dictionary.
    pub fn as_key(&self, budget: &mut Budget) -> Result<EntryKey> {
        budget.spend(1)?;
        Ok(match self {
            Value::None => EntryKey::None,
            Value::Bool(b) => EntryKey::Int(i64::from(*b)),
            Value::Int(i) => EntryKey::Int(*i),
            Value::Float(f) => number::exact_int(*f).map_or_else(|| EntryKey::Float(f.to_bits()), EntryKey::Int),
            Value::Text(text) => EntryKey::Text(text.clone()),
            Value::Tuple(items) => {
                EntryKey::Tuple(items.items.iter().map(|item| item.as_key(budget)).collect::<Result<_>>()?)
            }
            other => fail!("a {} cannot be the key of a dictionary", other.kind()),
        })
    }

    pub fn is_equal(&self, other: &Value, budget: &mut Budget) -> Result<bool> {
        budget.spend(1)?;
        Ok(match (self, other) {
            (Value::None, Value::None) => true,
            (Value::Text(a), Value::Text(b)) => {
                budget.spend(a.len().min(b.len()) / 8)?;
                a == b
            }
            (Value::List(a), Value::List(b)) => all_equal(&a.items().items, &b.items().items, budget)?,
            (Value::Tuple(a), Value::Tuple(b)) => all_equal(&a.items, &b.items, budget)?,
            (Value::Dict(a), Value::Dict(b)) => {
                let (a, b) = (a.entries(), b.entries());
                if a.len() != b.len() {
                    return Ok(false);
                }
                for (key, value) in a.iter() {
                    match b.get(key) {
                        Some(other) if value.is_equal(other, budget)? => {}
                        _ => return Ok(false),
                    }
                }
                true
            }
            (Value::Range(a), Value::Range(b)) => {
                a.count == b.count && (a.count == 0 || a.start == b.start && (a.count == 1 || a.step == b.step))
            }
            (Value::Function(a), Value::Function(b)) => a == b,
            (Value::Namespace(a), Value::Namespace(b)) => a == b,
            (Value::View(a), Value::View(b)) => Rc::ptr_eq(a, b),
            (a, b) => compare_numbers(a, b) == Some(Some(Ordering::Equal)),
        })
    }

    /// The order of two values of kinds that have one; `None` with NaN.
    pub fn order(&self, other: &Value, budget: &mut Budget) -> Result<Option<Ordering>> {
        budget.spend(1)?;
        let items = |a: &[Value], b: &[Value], budget: &mut Budget| -> Result<Option<Ordering>> {
            for (a, b) in a.iter().zip(b) {
                if !a.is_equal(b, budget)? {
                    return a.order(b, budget);
                }
            }
            Ok(Some(a.len().cmp(&b.len())))
        };
        match (self, other) {
            (Value::Text(a), Value::Text(b)) => {
                budget.spend(a.len().min(b.len()) / 8)?;
                Ok(Some(a.cmp(b)))
            }
            (Value::List(a), Value::List(b)) => items(&a.items().items, &b.items().items, budget),
            (Value::Tuple(a), Value::Tuple(b)) => items(&a.items, &b.items, budget),
            (a, b) => match compare_numbers(a, b) {
                Some(order) => Ok(order),
                None => fail!("{} and {} cannot be compared by order", a.kind(), b.kind()),
            },
        }
    }
}

/// The order of two numbers: outer `None` if one is no number, inner `None` with NaN.
fn compare_numbers(a: &Value, b: &Value) -> Option<Option<Ordering>> {
    Some(number::compare(a.as_number()?, b.as_number()?))
}

impl Entries {
    /// Sets an entry.
    pub fn set(&mut self, key: Value, value: Value, budget: &mut Budget) -> Result<()> {
        let (lookup, depth) = (key.as_key(budget)?, key.depth().max(value.depth()));
        self.insert(lookup, (key, value), depth, budget)
    }
}

fn all_equal(a: &[Value], b: &[Value], budget: &mut Budget) -> Result<bool> {
    if a.len() != b.len() {
        return Ok(false);
    }
    for (a, b) in a.iter().zip(b) {
        if !a.is_equal(b, budget)? {
            return Ok(false);
        }
    }
    Ok(true)
}
