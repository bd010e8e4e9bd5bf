//! Functions of clients, which clients pass by name in the arguments of a call. They can be called only while their
//! client waits for an answer; other calls are deferred until the next request of the client.

use std::collections::{BTreeMap, VecDeque};

use tatu_plugin_api::safe::{Result, Value};

/// Suffix that marks a string as the name of a function.
const FUNCTION_SUFFIX: &[u8] = b"@func";
/// Maximum number of stored functions per client. If there are more, the oldest is removed.
const MAX_FUNCTIONS: usize = 1000;
/// Maximum number of deferred calls per client. If there are more, the oldest is dropped.
const MAX_DEFERRED_CALLS: usize = 1000;

/// A function of a client, which the world can call.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub struct ClientFunction {
    /// The key of the client.
    pub client: String,
    /// Name of the function, by which the client identifies it.
    pub name: String,
}

/// A deferred call: the name of the function, and the arguments.
pub type DeferredCall = (String, Vec<Value>);

/// All functions that clients have passed. The world identifies each of them by a number.
#[derive(Default)]
pub struct FunctionTable {
    /// The functions, by number.
    functions: BTreeMap<u32, ClientFunction>,
    numbers: BTreeMap<ClientFunction, u32>,
    /// The deferred calls, by the key of the client.
    deferred: BTreeMap<String, VecDeque<DeferredCall>>,
    last_number: u32,
}

impl FunctionTable {
    /// Returns the function with a number, or `None` if it has been removed.
    pub fn get(&self, number: u32) -> Option<&ClientFunction> {
        self.functions.get(&number)
    }

    /// Returns the number of a function, and stores the function if it is new.
    fn number(&mut self, client: &str, name: String) -> u32 {
        let function = ClientFunction { client: client.to_owned(), name };
        if let Some(number) = self.numbers.get(&function) {
            return *number;
        }
        let mut own = self.functions.iter().filter(|(_, f)| f.client == client).map(|(n, _)| *n);
        if let Some(first) = own.next()
            && own.count() + 1 >= MAX_FUNCTIONS
        {
            self.forget(first);
        }
        self.last_number = self.last_number.wrapping_add(1);
        self.functions.insert(self.last_number, function.clone());
        self.numbers.insert(function, self.last_number);
        self.last_number
    }

    fn forget(&mut self, number: u32) {
        if let Some(function) = self.functions.remove(&number) {
            self.numbers.remove(&function);
        }
    }

    /// Removes the functions of a client that has disconnected.
    pub fn remove_client(&mut self, client: &str) {
        self.functions.retain(|_, f| f.client != client);
        self.numbers.retain(|f, _| f.client != client);
        self.deferred.remove(client);
    }

    /// Defers a call until the next request of the client.
    pub fn defer_call(&mut self, function: ClientFunction, args: Vec<Value>) {
        let later = self.deferred.entry(function.client).or_default();
        if later.len() >= MAX_DEFERRED_CALLS {
            later.pop_front();
        }
        later.push_back((function.name, args));
    }

    /// Removes and returns the deferred calls of a client's functions.
    pub fn take_deferred(&mut self, client: &str) -> VecDeque<DeferredCall> {
        self.deferred.remove(client).unwrap_or_default()
    }

    /// Replaces marked names of functions by function values, including those in lists and maps. `make` returns the
    /// function value for a number.
    pub fn bind(&mut self, client: &str, value: &mut Value, make: &dyn Fn(u32) -> Result<Value>) -> Result<()> {
        match value {
            Value::Text(text) => {
                if let Some(name) = text.strip_suffix(FUNCTION_SUFFIX) {
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
    fn nested_function_names_are_bound() {
        let mut all = FunctionTable::default();
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
        assert_eq!(all.get(2), Some(&ClientFunction { client: "a".into(), name: "g".into() }));
        all.remove_client("a");
        assert_eq!(all.get(2), None);
    }

    #[test]
    fn oldest_function_is_removed_at_the_limit() {
        let mut all = FunctionTable::default();
        for i in 0..MAX_FUNCTIONS + 10 {
            all.number("a", i.to_string());
            all.number("b", "one".into());
        }
        assert!(all.get(1).is_none() && all.get(2).is_some());
        assert_eq!(all.functions.len(), MAX_FUNCTIONS + 1);
    }
}
