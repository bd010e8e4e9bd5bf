//! The memory that a script will touch when it is called, asked for while another one runs.
//!
//! One of a thousand scripts finds nothing of its state in the processor's caches, and would wait for some hundred lines
//! of memory, most of them one after the other. What a call needs is found by going the way that Lua will go: from the
//! functions to their constants, and from the names among these to what they stand for. Where that is mistaken, the
//! processor reads in vain, and nothing else happens.

mod objects;

use std::cell::RefCell;

use mlua::ffi::*;
use tatu_plugin_api::{abi::TATU_FIND_CALLBACK, safe::fetch};

use crate::{
    alloc::Slot,
    callbacks, collect,
    state::{Script, State, reg, registry},
};
use objects::{At, CALL, List, NODE, Objects, PROTOTYPE, TABLE_BYTES, TEXT_BYTES, VALUE, Value};

/// Bytes of a line.
const LINE: usize = 64;
/// Most lines asked for: twice what a call of a small script touches.
const MOST: usize = 256;
/// Bytes of a list, of code and of constants, from their beginnings on.
const PART: usize = 16 * LINE;
/// The call after which memory is looked at first: the text has run, and so have its callbacks.
const SETTLED: u64 = 4;
/// Whenever it has been put in order so many times, it is looked at again.
const AGAIN: u64 = 16;
/// Places of the registry that each call looks at.
const PLACES: [i64; 3] = [reg::CHUNK, reg::BORROWED, reg::TOLD];

/// Neighbouring lines.
#[derive(Clone, Copy)]
struct Run {
    first: usize,
    lines: usize,
}

/// What the next call will touch.
#[derive(Default)]
pub(crate) struct Ahead(RefCell<Vec<Run>>);

impl Ahead {
    /// Asks the processor for it.
    pub(crate) fn fetch(&self) {
        for run in self.0.borrow().iter() {
            for line in 0..run.lines {
                fetch((run.first + line * LINE) as *const u8);
            }
        }
    }
}

/// Looks at a script's memory, after its first calls and from time to time.
pub(crate) fn learn(s: &Script) {
    let calls = s.entries.get();
    let orders = calls / collect::EVERY;
    let again = orders <= 1 || orders.is_multiple_of(AGAIN) || s.ahead.0.borrow().is_empty();
    if calls != SETTLED && !(collect::is_time(s) && again) {
        return;
    }
    let callbacks: Vec<_> = {
        let text = s.text.borrow();
        text.names.iter().filter(|(how, _)| *how == TATU_FIND_CALLBACK).map(|(_, name)| name.clone()).collect()
    };
    let rules = s.text.borrow().rules.clone();
    let mut finder = Finder::new(&s.slot);
    // SAFETY: protected.
    let _ = s.protect(&mut |l| unsafe {
        finder.look(l, s);
        for name in &callbacks {
            callbacks::callback(l, &rules, name);
            if lua_iscfunction(l, -1) == 0 {
                finder.function(lua_topointer(l, -1));
            }
            lua_settop(l, 0);
        }
        lua_pushglobaltable(l);
        finder.names(lua_topointer(l, -1));
    });
    *s.ahead.0.borrow_mut() = finder.runs();
}

/// Finds lines.
struct Finder<'a> {
    objects: Objects<'a>,
    lines: Vec<usize>,
    /// Functions and tables that have been looked at.
    seen: Vec<At>,
    /// Texts that functions have as constants: names, most of them.
    names: Vec<At>,
}

impl<'a> Finder<'a> {
    fn new(slot: &'a Slot) -> Self {
        Finder { objects: Objects(slot), lines: Vec::with_capacity(MOST), seen: Vec::new(), names: Vec::new() }
    }

    /// What every call touches.
    ///
    /// # Safety
    /// Protected; a few free places on the stack.
    unsafe fn look(&mut self, l: *mut lua_State, s: &State) {
        self.note((&raw const *s).cast(), size_of::<State>());
        // The thread, what all threads share, the stack, and the calls on it.
        self.note(s.main.cast(), 6 * LINE);
        for to in self.objects.words(s.main.cast(), 2..=6) {
            self.note(to, 3 * LINE);
        }
        for call in self.objects.calls(s.main.cast()) {
            self.note(call, CALL);
        }
        let places = lua_topointer(l, LUA_REGISTRYINDEX);
        self.table(places);
        for place in PLACES {
            let (way, _) = self.objects.way_to_number(places, place as usize);
            self.go(&way);
        }
        registry(l, reg::TOLD);
        self.table(lua_topointer(l, -1));
        registry(l, reg::BORROWED);
        self.table(lua_topointer(l, -1));
        registry(l, reg::CHUNK);
        self.function(lua_topointer(l, -1));
        lua_settop(l, 0);
    }

    /// What the names stand for: globals, and behind them commands.
    fn names(&mut self, globals: At) {
        self.note(globals, TABLE_BYTES);
        let mut tables = vec![globals];
        // What a name stands for may bring others.
        let mut next = 0;
        while let Some(name) = self.names.get(next).copied().filter(|_| !self.is_full()) {
            next += 1;
            if let Some(Value::Table(table)) = self.named(globals, name, true) {
                tables.push(table);
            }
        }
        for table in tables.into_iter().skip(1) {
            let mut next = 0;
            while let Some(name) = self.names.get(next).copied().filter(|_| !self.is_full()) {
                next += 1;
                self.named(table, name, false);
            }
        }
    }

    /// What a name stands for in a table, or behind it. `surely`: it is looked for there, whether it is there or not.
    fn named(&mut self, table: At, name: At, surely: bool) -> Option<Value> {
        let (way, found) = self.objects.way_to_text(table, name);
        if found || surely {
            self.go(&way);
        }
        if found {
            return self.end_of(&way);
        }
        let metatable = self.objects.metatable(table);
        if metatable.is_null() {
            return None;
        }
        // Its only entry is the table behind.
        let entry = self.objects.nodes(metatable);
        let Value::Table(behind) = self.objects.value(entry) else { return None };
        let (way, found) = self.objects.way_to_text(behind, name);
        if !found {
            return None;
        }
        self.note(metatable, TABLE_BYTES);
        self.note(entry, NODE);
        self.note(behind, TABLE_BYTES);
        self.go(&way);
        self.end_of(&way)
    }

    /// The value that a way leads to, looked at.
    fn end_of(&mut self, way: &[At]) -> Option<Value> {
        let value = self.objects.value(*way.last()?);
        self.value(value);
        Some(value)
    }

    /// What is at hand when a value is.
    fn value(&mut self, value: Value) {
        match value {
            Value::Table(at) => self.table(at),
            Value::Function(at) => self.function(at),
            Value::Command(at) => self.note(at, 32 + VALUE),
            Value::Text(_) | Value::Other => {}
        }
    }

    /// Code, constants and variables from outside.
    fn function(&mut self, at: At) {
        if at.is_null() || self.is_full() || !self.is_new(at) {
            return;
        }
        let objects = self.objects;
        let prototype = objects.prototype(at);
        self.note(at, 32);
        self.note(prototype, PROTOTYPE);
        self.part(objects.code(prototype));
        let (constants, bytes) = objects.constants(prototype);
        self.part((constants, bytes));
        for offset in (0..bytes.min(PART)).step_by(VALUE) {
            if let Value::Text(text) = objects.value(constants.wrapping_byte_add(offset)) {
                self.note(text, TEXT_BYTES);
                if !self.names.contains(&text) {
                    self.names.push(text);
                }
            }
        }
        for variable in objects.variables(at) {
            self.note(variable, 40);
            if let value @ (Value::Function(_) | Value::Command(_)) = objects.of_variable(variable) {
                self.value(value);
            }
        }
    }

    /// A table and its list.
    fn table(&mut self, at: At) {
        if !at.is_null() && !self.is_full() && self.is_new(at) {
            self.note(at, TABLE_BYTES);
            self.part(self.objects.list(at));
        }
    }

    /// Functions that hold functions that hold functions are followed no further than this.
    fn is_full(&self) -> bool {
        self.lines.len() >= MOST
    }

    fn is_new(&mut self, at: At) -> bool {
        let new = !self.seen.contains(&at);
        if new {
            self.seen.push(at);
        }
        new
    }

    fn go(&mut self, way: &[At]) {
        for node in way {
            self.note(*node, NODE);
        }
    }

    fn part(&mut self, (at, bytes): List) {
        self.note(at, bytes.min(PART));
    }

    /// Notes some bytes.
    fn note(&mut self, at: At, bytes: usize) {
        if at.is_null() {
            return;
        }
        let (first, end) = (at as usize & !(LINE - 1), (at as usize).saturating_add(bytes));
        for line in (first..end).step_by(LINE) {
            if !self.is_full() && !self.lines.contains(&line) {
                self.lines.push(line);
            }
        }
    }

    fn runs(mut self) -> Vec<Run> {
        self.lines.sort_unstable();
        let mut runs: Vec<Run> = Vec::new();
        for line in self.lines {
            match runs.last_mut() {
                Some(run) if run.first + run.lines * LINE == line => run.lines += 1,
                _ => runs.push(Run { first: line, lines: 1 }),
            }
        }
        runs
    }
}
