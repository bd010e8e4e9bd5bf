//! The memory that a script will touch when it is called, asked for while another one runs.
//!
//! One of a thousand scripts finds nothing of its state in the processor's caches, and would wait for some hundred lines
//! of memory, most of them one after the other. What a call needs is found by following addresses from object to object, as
//! Lua 5.4 lays them out; only words that are addresses in the slot are followed. Where that is mistaken, the processor
//! reads in vain, and nothing else happens.

use std::{cell::RefCell, ffi::c_void, ops::RangeInclusive};

use mlua::ffi::*;
use tatu_plugin_api::{abi::TATU_FIND_CALLBACK, safe::fetch};

use crate::{
    alloc::Slot,
    callbacks, collect,
    state::{Script, State, reg, registry},
};

/// Bytes of a line.
const LINE: usize = 64;
/// Most lines asked for: twice what a call of a small script touches.
const MOST: usize = 256;
/// Lines that the globals of a script take: a common library, and two dozens of its own.
const GLOBALS: usize = 24;
/// The call after which memory is looked at first: the text has run, and so have its callbacks.
const SETTLED: u64 = 4;

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

/// Looks at a script's memory, after its first calls and whenever it has been put in order.
pub(crate) fn learn(s: &Script) {
    if !collect::is_time(s) && s.entries.get() != SETTLED {
        return;
    }
    let callbacks: Vec<_> = {
        let text = s.text.borrow();
        text.names.iter().filter(|(how, _)| *how == TATU_FIND_CALLBACK).map(|(_, name)| name.clone()).collect()
    };
    let rules = s.text.borrow().rules.clone();
    let mut finder = Finder { slot: &s.slot, lines: Vec::with_capacity(MOST) };
    // SAFETY: protected.
    let _ = s.protect(&mut |l| unsafe {
        for name in &callbacks {
            callbacks::callback(l, &rules, name);
            finder.function(lua_topointer(l, -1));
            lua_settop(l, 0);
        }
        finder.look(l, s);
    });
    *s.ahead.0.borrow_mut() = finder.runs();
}

/// Finds lines.
struct Finder<'a> {
    slot: &'a Slot,
    lines: Vec<usize>,
}

impl Finder<'_> {
    /// # Safety
    /// Protected; a few free places on the stack.
    unsafe fn look(&mut self, l: *mut lua_State, s: &State) {
        self.note((&raw const *s).cast(), size_of::<State>());
        // The thread, what all threads share, the stack, and the calls on it.
        self.note(s.main.cast(), 6 * LINE);
        self.follow(s.main.cast(), 2..=6, 3, &mut |_, _| ());
        registry(l, reg::CHUNK);
        let text = lua_topointer(l, -1);
        self.function(text);
        // Globals, and behind them the names of commands. What was made after the text is the script's own: its lists too.
        lua_pushglobaltable(l);
        self.table(lua_topointer(l, -1), GLOBALS, &mut |f, entries| {
            f.follow(entries, 0..=GLOBALS * LINE / 8 - 1, 0, &mut |f, value| {
                if value > text {
                    f.note(value.cast(), LINE);
                    f.follow(value, 2..=2, 4, &mut |_, _| ());
                }
            });
        });
        if lua_getmetatable(l, -1) != 0 {
            self.table(lua_topointer(l, -1), 1, &mut |f, entries| {
                f.follow(entries, 0..=8, 1, &mut |f, table| f.table(table, 8, &mut |_, _| ()));
            });
        }
    }

    /// Code, constants and what they refer to, values of variables from outside.
    fn function(&mut self, at: *const c_void) {
        self.note(at.cast(), LINE);
        self.follow(at, 3..=3, 2, &mut |f, prototype| {
            f.follow(prototype, 7..=8, 5, &mut |f, list| f.follow(list, 0..=79, 1, &mut |_, _| ()));
        });
        self.follow(at, 4..=11, 1, &mut |f, variable| f.follow(variable, 1..=3, 1, &mut |_, _| ()));
    }

    /// A table and its entries.
    fn table(&mut self, at: *const c_void, lines: usize, then: &mut dyn FnMut(&mut Self, *const c_void)) {
        self.note(at.cast(), LINE);
        self.follow(at, 3..=3, lines, then);
    }

    /// Notes some bytes.
    fn note(&mut self, at: *const u8, bytes: usize) {
        let (first, end) = (at as usize & !(LINE - 1), at as usize + bytes);
        for line in (first..end).step_by(LINE) {
            if self.lines.len() < MOST && !self.lines.contains(&line) {
                self.lines.push(line);
            }
        }
    }

    /// Notes some lines of what words of an object refer to, and does something with each of these.
    fn follow(
        &mut self,
        at: *const c_void,
        words: RangeInclusive<usize>,
        lines: usize,
        then: &mut dyn FnMut(&mut Self, *const c_void),
    ) {
        for i in words {
            let word = at.cast::<*const c_void>().wrapping_add(i);
            if !self.slot.holds(word.cast(), size_of::<usize>()) {
                return;
            }
            // SAFETY: within the slot; what is there is a number for us, whatever it means.
            let to = unsafe { word.read_volatile() };
            if self.slot.holds(to.cast(), 1) && to.cast::<usize>().is_aligned() {
                self.note(to.cast(), lines * LINE);
                then(self, to);
            }
        }
    }

    fn runs(mut self) -> Vec<Run> {
        self.lines.sort_unstable();
        self.lines.dedup();
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

#[cfg(test)]
mod tests {
    use std::ptr::null_mut;

    use super::*;
    use crate::alloc::lua_alloc;

    /// Three blocks of which each holds the address of the next, and something that is none.
    #[test]
    fn addresses_are_followed_as_far_as_asked_and_only_in_the_slot() {
        let slot = Slot::new(3);
        if !slot.is_mapped() {
            println!("skipped: this system reserves no address space");
            return;
        }
        let elsewhere = [0_usize; 8];
        // SAFETY: blocks of 512 bytes of a slot that lives on.
        let [a, b, c] = unsafe {
            let blocks = [(); 3].map(|()| lua_alloc((&raw const *slot).cast_mut().cast(), null_mut(), 0, 512));
            let [a, b, c] = blocks.map(|block| block.cast::<usize>());
            *a.add(3) = b as usize;
            *a.add(4) = 0xF00D;
            *a.add(5) = elsewhere.as_ptr() as usize;
            *a.add(6) = b as usize + 1;
            *b.add(2) = c as usize;
            [a, b, c]
        };
        let mut finder = Finder { slot: &slot, lines: Vec::new() };
        finder.follow(a.cast(), 0..=7, 2, &mut |f, to| {
            assert_eq!(to, b.cast_const().cast());
            f.follow(to, 2..=2, 1, &mut |_, _| ());
        });
        let line = |p: *mut usize| p as usize & !(LINE - 1);
        assert!([line(b), line(b) + LINE, line(c)].iter().all(|l| finder.lines.contains(l)));
        assert!(finder.lines.len() <= 4);
        // Past the end of what was taken nothing is read.
        finder.follow(c.cast(), 60..=90, 1, &mut |_, _| panic!("there is nothing"));
        let runs = finder.runs();
        assert!(runs.windows(2).all(|w| w[0].first + w[0].lines * LINE < w[1].first));
    }
}
