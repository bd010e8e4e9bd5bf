//! Tests of the cost of library functions: docs/reference/script-costs.md must have a row for each function, and no
//! call may run for long without checking the budget.
#![allow(missing_docs)]

mod common;
use std::{cell::Cell, collections::BTreeSet};

use common::*;
use tatu_plugin_api::abi::*;

thread_local! {
    static TICKS: Cell<u64> = const { Cell::new(0) };
}

fn tick(_: &TestHost, _: &mut tatu_call) -> tatu_status {
    TICKS.set(TICKS.get() + 1);
    TATU_OK
}
fn names(h: &TestHost, frame: &mut tatu_call) -> tatu_status {
    for i in 0..frame.n_args {
        h.calls.borrow_mut().push(arg(frame, i).as_str().unwrap().to_string());
    }
    TATU_OK
}

fn host() -> &'static TestHost {
    let h = TestHost::new();
    h.command("tick", tick);
    h.command("names", names);
    h
}

const COSTS_PAGE: &str = include_str!("../../../../docs/reference/script-costs.md");

/// Returns the functions in the page's table.
fn rows() -> BTreeSet<String> {
    let first = |line: &'static str| line.strip_prefix("| ").and_then(|l| l.split(" | ").next());
    let table = COSTS_PAGE.split("\n## ").find(|part| part.starts_with("Functions\n")).unwrap();
    let names = table.lines().filter_map(first).flat_map(|cell| cell.split('`').skip(1).step_by(2));
    names.map(str::to_owned).collect()
}

#[test]
fn every_function_is_listed_on_the_costs_page() {
    let mut there = BTreeSet::new();
    for dialect in ["", "3.2"] {
        let h = host();
        let s = h.script(1);
        let text = "function init()
            local seen = {}
            local function walk(prefix, t)
                if seen[t] then return end
                seen[t] = true
                for k, v in pairs(t) do
                    if type(v) == 'function' then names(prefix .. k) end
                    if type(v) == 'table' and k ~= '_G' and k ~= 'loaded' then walk(prefix .. k .. '.', v) end
                end
            end
            walk('', _G)
            local file = io.open('costs.txt', 'w')
            for _, name in ipairs{'read', 'write', 'lines', 'close', 'flush', 'seek', 'setvbuf'} do
                assert(file[name])
                names('file:' .. name)
            end
            file:close()
        end";
        let dir = std::env::temp_dir().join(format!("tatu-costs-{}", std::process::id()));
        std::fs::create_dir_all(&dir).unwrap();
        *h.folder.borrow_mut() = dir.display().to_string();
        s.load(text, "t.lua", dialect).unwrap();
        s.init().unwrap();
        std::fs::remove_dir_all(dir).unwrap();
        let calls = h.calls.borrow();
        there.extend(calls.iter().filter(|n| !["init", "names", "tick"].contains(&n.as_str())).cloned());
    }
    let rows = rows();
    let without: Vec<_> = there.difference(&rows).collect();
    assert!(without.is_empty(), "without a row in script-costs.md: {without:?}");
    let gone: Vec<_> = rows.difference(&there).collect();
    assert!(gone.is_empty(), "rows for functions that do not exist: {gone:?}");
}

/// Instruction budget of a call in the tests below.
const BUDGET: u64 = 4_000_000;

/// Calls that would run forever, or for a very long time.
const HOSTILE_CALLS: &[&str] = &[
    "table.remove(setmetatable({}, {__len = function() return 1e15 end}), 1)",
    "table.insert(setmetatable({}, {__len = function() return 1e15 end}), 1, 0)",
    "table.concat(setmetatable({}, {__index = function() return '' end}), '', 1, 1e15)",
    "table.concat(setmetatable({}, {__index = rawlen}), '', 1, 1e15)",
    "table.move({}, 1, 2^53, 2)",
    "table.move(setmetatable({}, {__index = rawlen}), 1, 2^53, 2, setmetatable({}, {__newindex = rawequal}))",
    "table.sort(setmetatable({}, {__len = function() return 2^31 - 2 end, __index = function(_, i) return -i end}))",
    "table.sort(setmetatable({}, {__len = function() return 2^31 - 2 end, __index = rawlen, __newindex = rawequal}))",
    "load(function() return ' ' end)",
    "load(math.random)",
    "load(os.time)",
    "load(function() return '--' end)",
    "local s = ('a'):rep(30) s:find(('a?'):rep(30) .. s .. 'b')",
    "('a'):rep(200):gsub(('a-'):rep(20) .. 'b', '')",
    "('x'):rep(1e5):find('[' .. ('y'):rep(1e5) .. ']')",
    "('x'):rep(1e5):find('%f[' .. ('y'):rep(1e5) .. ']')",
    "for _ in ('x'):rep(1e5):gmatch('[' .. ('y'):rep(1e5) .. ']') do end",
    "local t = {} for i = 1, 3e4 do t[i] = i end for i = 1, 3e4 do t[i] = nil end while true do next(t) end",
    "local t = {} for i = 0, 5000 do t[i * 8191] = i end while true do local x = t[8191 * 9999] end",
    "local t = {} for i = 1, 1999 do t = setmetatable({}, {__index = t}) end while true do local x = t.x end",
    "local t = {} for i = 1, 1999 do t = setmetatable({}, {__newindex = t}) end while true do t.x = nil end",
    "local function f(...) while true do select('#', ...) end end f(table.unpack({}, 1, 2e5))",
    "local function f(...) return f(...) end f(table.unpack({}, 1, 2e5))",
    "local function f(...) return ... end local t = {} while true do (f)(table.unpack(t, 1, 2e5)) end",
    "local function f(...) while true do local a = ... local b, c = (...), ... end end f(table.unpack({}, 1, 2e5))",
    "local function deep(n) if n > 0 then return 1 + deep(n - 1) end while true do pcall(error) end end deep(1e5)",
    "local function deep(n) if n > 0 then return 1 + deep(n - 1) end while true do debug.traceback() end end deep(1e5)",
    "local function deep(n) if n > 0 then return 1 + deep(n - 1) end while true do debug.getinfo(99999) end end deep(1e5)",
    "load('goto a ' .. ('goto b ::c::'):rep(1) .. (' do goto z end'):rep(30000) .. ' ::a:: ::b:: ::z::')
     while true do load((' do goto z end'):rep(3000) .. ' ::z::') end",
    "local t = {} for i = 1, 3000 do t[i] = '::l' .. i .. '::' end t = table.concat(t) while true do load(t) end",
    "local t = 'if x then ' .. ('elseif x then '):rep(3000) .. 'end' while true do load(t) end",
    "local t = 'return ' .. ('x and '):rep(3000) .. 'x' while true do load(t) end",
    "local s = ('0'):rep(1e6) while true do local x = s + 0 end",
    "local s = (' '):rep(1e6) while true do tonumber(s) end",
    "local s = ('0'):rep(1e6) while true do tonumber(s, 10) end",
    "local a, b = ('x'):rep(1e6) .. 'y', ('x'):rep(1e6) .. 'y' while true do local x = a == b end",
    "local a, b = ('x'):rep(1e6) .. 'y', ('x'):rep(1e6) .. 'y' while true do local x = a < b end",
    "local a, b = ('\\0'):rep(1e6) .. 'y', ('\\0'):rep(1e6) .. 'y' while true do local x = a <= b end",
    "local a, b = ('x'):rep(1e6) .. 'y', ('x'):rep(1e6) .. 'y' local t = {[a] = 1} while true do local x = t[b] end",
    "local a, b = ('x'):rep(1e6) .. 'y', ('x'):rep(1e6) .. 'y' local t = {[a] = 1} while true do rawget(t, b) end",
    "local f = load('local a = nil ' .. ('a = a '):rep(3000) .. 'while true do pcall(function() end) a.x() end') while true do pcall(f) end",
    "local f = load(('x'):rep(1e6) .. '()') while true do pcall(f) end",
    "while true do local x = 1e308 % 1e-308 end",
    "while true do math.fmod(1e308, 1e-308) end",
    "local f = utf8.codes(('a') .. ('\\x80'):rep(1e6)) local s = 'a' .. ('\\x80'):rep(1e6) while true do f(s, 1) end",
    "while true do local x = y_that_is_nowhere end",
    "local ok = pcall(pcall, table.remove, setmetatable({}, {__len = os.time}), 1) while true do end",
    "table.sort(setmetatable({}, {__len = function() return 1e9 end, __index = rawlen, __newindex = rawequal}), pcall)",
    "xpcall(table.remove, table.remove, setmetatable({}, {__len = function() return 1e15 end}), 1)",
    "coroutine.wrap(table.remove)(setmetatable({}, {__len = function() return 1e15 end}), 1)",
    "coroutine.wrap(function() local c <close> = setmetatable({}, {__close = function() while true do end end}) error(1) end)()",
    "string.rep('x', 1e9)",
    "string.rep('', 1e6, 'x') string.rep('x', 1e9)",
    "string.pack('c2000000000', '')",
    "string.format(('%99d'):rep(1e7), 1)",
    "print(string.rep('x', 2e8), string.rep('y', 2e8))",
];

#[test]
fn hostile_calls_end_with_an_error() {
    let h = host();
    for text in HOSTILE_CALLS {
        let s = h.script(1);
        s.budget.set((BUDGET, 0));
        s.load(&format!("function init()\n{text}\nend"), "t.lua", "").unwrap();
        let e = s.init().expect_err(text);
        assert!([TATU_ERR_BUDGET, TATU_ERR_MEMORY].contains(&e.code), "{text}: {e:?}");
        assert!(e.code == TATU_ERR_MEMORY || e.text.contains("used up its 4000000 instructions"), "{text}: {e:?}");
        // Work that a single instruction performs in C is checked against the budget only at the next instruction.
        assert!(s.used.get() < 3 * BUDGET, "{text}: {}", s.used.get());
        // Other scripts can still run.
        let other = h.load("function f() return 1 end");
        other.init().unwrap();
        other.function("f", &[]).unwrap();
    }
}

/// Code that creates a large string or table, a call with it, and the maximum number of such calls within the budget.
const LARGE_CALLS: &[(&str, &str, u64)] = &[
    ("s = ('x'):rep(1e6)", "s:upper()", 17),
    ("s = ('x'):rep(1e6)", "s:lower()", 17),
    ("s = ('x'):rep(1e6)", "s:reverse()", 17),
    ("s = ('x'):rep(1e6)", "utf8.len(s)", 17),
    ("s = ('\\x80'):rep(1e6)", "utf8.offset(s, 0, 1e6)", 17),
    ("s = ('x'):rep(1e6)", "utf8.offset(s, 999999)", 17),
    ("s = ('x'):rep(1e6)", "utf8.offset(s, -999999)", 17),
    ("s = ('x'):rep(1e5)", "utf8.codepoint(s, 1, 1e5)", 170),
    ("s = ('x'):rep(1e5)", "s:byte(1, 1e5)", 170),
    ("a = {} for i = 1, 1e5 do a[i] = 65 end", "string.char(table.unpack(a))", 170),
    ("a = {} for i = 1, 1e5 do a[i] = 65 end", "utf8.char(table.unpack(a))", 2),
    ("s = ('x'):rep(1e6)", "s:find('y', 1, true)", 70),
    ("s = ('x'):rep(1e6) p = ('x'):rep(5e5) .. 'y'", "s:find(p, 1, true)", 30),
    ("s = ('x'):rep(1e6)", "s:find('[y]')", 20),
    ("s = ('x'):rep(1e6)", "s:match('y')", 70),
    ("s = ('x'):rep(1e6)", "s:gsub('y', '')", 20),
    ("s = ('x'):rep(1e6)", "s:rep(10)", 26),
    ("s = ('x'):rep(1e6)", "s:sub(2)", 256),
    ("s = ('x'):rep(1e6)", "local x = s .. s", 128),
    ("s = ('x'):rep(1e6)", "string.format('%q', s)", 4),
    ("s = ('x'):rep(1e6)", "string.format('%s', s)", 256),
    ("s = ('x'):rep(1e6)", "string.format('%.3s', s)", 256),
    ("s = ('x'):rep(1e6)", "string.format(s)", 17),
    ("s = ('i'):rep(1e6)", "string.packsize(s)", 4),
    ("s = ('x'):rep(1e6)", "string.packsize(s)", 4),
    ("s = ('x'):rep(1e6)", "string.pack('z', s)", 256),
    ("s = ('x'):rep(1e6)", "string.pack('c2000000', s)", 128),
    ("s = ('x'):rep(1e6)", "pcall(string.unpack, 'z', s)", 256),
    ("s = '\"' .. ('x'):rep(1e6) .. '\"'", "load('return ' .. s)", 17),
    ("s = ('1'):rep(1e6)", "tonumber(s)", 17),
    ("s = ('x'):rep(1e6) .. '1'", "rawequal(s, ('x'):rep(1e6) .. '1')", 128),
    ("a = {} for i = 1, 1e5 do a[i] = i end", "table.insert(a, 1, 0)", 90),
    ("a = {} for i = 1, 1e5 do a[i] = i end", "table.remove(a, 1)", 90),
    ("a = {} for i = 1, 1e5 do a[i] = '' end", "table.concat(a)", 170),
    ("a = {} for i = 1, 1e5 do a[i] = i end", "table.move(a, 1, 1e5, 2)", 90),
    ("a = {} for i = 1, 1e5 do a[i] = i end", "table.unpack(a)", 170),
    ("a = {} for i = 1, 1e5 do a[i] = i end", "table.sort(a)", 9),
    ("a = {} for i = 1, 1e5 do a[i] = i end", "table.pack(table.unpack(a))", 90),
    ("a = {} for i = 1, 1e5 do a[i] = i end", "select('#', table.unpack(a))", 90),
    ("a = {} for i = 1, 1e5 do a[i] = i end", "math.max(table.unpack(a))", 90),
    ("a = {} for i = 1, 1e5 do a[i] = {} end", "collectgarbage()", 40),
    ("s = ('%d'):rep(1e6)", "os.date(s)", 4),
    ("s = ('x'):rep(1e6)", "print(s)", 17),
    ("s = ('x'):rep(1e6)", "io.write(s)", 17),
    ("s = ('\\n'):rep(1e5)", "io.write(s)", 2),
    ("s = ('x'):rep(1e6)", "pcall(require, s)", 17),
    ("s = 'x'", "pcall(require, s)", 800),
    ("s = 'x'", "pcall(dofile, s)", 800),
    ("s = 'x'", "loadfile(s)", 800),
    ("s = 'x'", "io.open(s)", 800),
    ("s = 1.5", "tostring(s)", 130_000),
    ("s = 1.5", "local x = s .. ''", 130_000),
    ("s = 1e308", "string.format('%99.99f', s)", 26_000),
    ("s = coroutine", "s.create(print)", 8_000),
    ("s = coroutine", "s.wrap(print)", 8_000),
    ("s = print", "s()", 40_000),
];

#[test]
fn calls_are_charged_for_their_work() {
    let h = host();
    for (before, call, most) in LARGE_CALLS {
        let s = h.script(1);
        s.budget.set((0, 0));
        s.load(&format!("{before}\nfunction f()\nwhile true do tick() {call} end\nend"), "t.lua", "").unwrap();
        s.init().unwrap();
        s.budget.set((BUDGET, 0));
        TICKS.set(0);
        let e = s.function("f", &[]).expect_err(call);
        assert_eq!(e.code, TATU_ERR_BUDGET, "{call}: {e:?}");
        assert!(TICKS.get() <= *most, "{call}: {} calls", TICKS.get());
        assert!(TICKS.get() >= 1, "{call}");
    }
}

/// A collection terminates for weak tables whose values refer to each other's keys in the worst order.
#[test]
fn collection_of_weak_tables_terminates() {
    let h = host();
    let s = h.load(
        "function f()
            local weak, keys = {__mode = 'k'}, {}
            for i = 1, 20000 do keys[i] = {} end
            local tables = {}
            for i = 1, 10000 do
                tables[i] = setmetatable({}, weak)
            end
            for i = 1, 9999 do tables[i][keys[i]] = keys[i + 1] tables[10000 - i][keys[10000 + i]] = keys[i] end
            keys = {keys[1]}
            collectgarbage()
            return 1
        end",
    );
    s.init().unwrap();
    s.function("f", &[]).unwrap();
}
