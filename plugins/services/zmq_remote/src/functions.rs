//! Functions of clients, which clients pass by name in the arguments of a call. They can be called only while their
//! client waits for an answer; other calls are deferred until the next request of the client.

use std::collections::{BTreeMap, VecDeque};

use tatu_plugin_api::safe::{Result, Value};

/// Suffix that marks a string as the name of a function.
const MARK: &[u8] = b"@func";
/// Maximum number of stored functions per client. If there are more, the oldest is removed.
const MOST: usize = 1000;
/// Maximum number of deferred calls per client. If there are more, the oldest is dropped.
const MOST_WAITING: usize = 1000;

/// A function of a client, which the world can call.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub struct Function {
    /// The key of the client.
    pub client: String,
    /// Name of the function, by which the client identifies it.
    pub name: String,
}

/// A deferred call: the name of the function, and the arguments.
pub type Later = (String, Vec<Value>);

/// All functions that clients have passed. The world identifies each of them by a number.
#[derive(Default)]
pub struct Functions {
    /// The functions, by number.
    known: BTreeMap<u32, Function>,
    numbers: BTreeMap<Function, u32>,
    /// The deferred calls, by the key of the client.
    later: BTreeMap<String, VecDeque<Later>>,
    made: u32,
}

impl Functions {
    /// Returns the function with a number, or `None` if it has been removed.
    pub fn get(&self, number: u32) -> Option<&Function> {
        self.known.get(&number)
    }

    /// Returns the number of a function, and stores the function if it is new.
    fn number(&mut self, client: &str, name: String) -> u32 {
        let function = Function { client: client.to_owned(), name };
        if let Some(number) = self.numbers.get(&function) {
            return *number;
        }
        let mut own = self.known.iter().filter(|(_, f)| f.client == client).map(|(n, _)| *n);
        if let Some(first) = own.next()
            && own.count() + 1 >= MOST
        {
            self.forget(first);
        }
        self.made = self.made.wrapping_add(1);
        self.known.insert(self.made, function.clone());
        self.numbers.insert(function, self.made);
        self.made
    }

    fn forget(&mut self, number: u32) {
        if let Some(function) = self.known.remove(&number) {
            self.numbers.remove(&function);
        }
    }

    /// Removes the functions of a client that has disconnected.
    pub fn gone(&mut self, client: &str) {
        self.known.retain(|_, f| f.client != client);
        self.numbers.retain(|f, _| f.client != client);
        self.later.remove(client);
    }

    /// Defers a call until the next request of the client.
    pub fn put_off(&mut self, function: Function, args: Vec<Value>) {
        let later = self.later.entry(function.client).or_default();
        if later.len() >= MOST_WAITING {
            later.pop_front();
        }
        later.push_back((function.name, args));
    }

    /// Removes and returns the deferred calls of a client's functions.
    pub fn take_later(&mut self, client: &str) -> VecDeque<Later> {
        self.later.remove(client).unwrap_or_default()
    }

    /// Replaces marked names of functions by function values, including those in lists and maps. `make` returns the
    /// function value for a number.
    pub fn bind(&mut self, client: &str, value: &mut Value, make: &dyn Fn(u32) -> Result<Value>) -> Result<()> {
        match value {
            Value::Text(text) => {
                if let Some(name) = text.strip_suffix(MARK) {
                    *value = make(self.number(client, String::from_utf8_lossy(name).into_owned()))?;
                }
                Ok(())
            }
            Value::List(all) => all.iter_mut().try_for_each(|v| self.bind(client, v, make)),
            Value::Map(all) => all.iter_mut().try_for_each(|(_, v)| self.bind(client, v, make)),
            _ => Ok(()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn functions_are_found_wherever_they_stand() {
        let mut all = Functions::default();
        let mut value = Value::Map(vec![
            (Value::text("callback"), Value::text("f_7f@func")),
            (
                Value::text("other"),
                Value::List(vec![Value::text("g@func"), Value::text("f_7f@func"), Value::text("@fun")]),
            ),
        ]);
        all.bind("a", &mut value, &|n| Ok(Value::Func(n.into()))).unwrap();
        let Value::Map(entries) = &value else { panic!("{value:?}") };
        assert_eq!(entries[0].1, Value::Func(1));
        assert_eq!(entries[1].1, Value::List(vec![Value::Func(2), Value::Func(1), Value::text("@fun")]));
        assert_eq!(all.get(2), Some(&Function { client: "a".into(), name: "g".into() }));
        all.gone("a");
        assert_eq!(all.get(2), None);
    }

    #[test]
    fn the_oldest_of_many_is_forgotten() {
        let mut all = Functions::default();
        for i in 0..MOST + 10 {
            all.number("a", i.to_string());
            all.number("b", "one".into());
        }
        assert!(all.get(1).is_none() && all.get(2).is_some());
        assert_eq!(all.known.len(), MOST + 1);
    }
}
