//! Tests of the limits of a script: instructions, memory, call depth.
#![allow(missing_docs)]

mod common;
use common::*;
use tatu_plugin_api::{abi::*, safe::Value};

/// Scripts that contain endless loops.
const ENDLESS_SCRIPTS: &[&str] = &[
    "while true do end",
    "while true do pcall(function() while true do end end) end",
    "while true do pcall(error) end",
    "local function f() return f() end f()",
    "coroutine.wrap(function() while true do end end)()",
    "while true do coroutine.wrap(function() pcall(function() while true do end end) end)() end",
    "while true do coroutine.resume(coroutine.create(function() for i = 1, 100 do end end)) end",
    "while true do coroutine.close(coroutine.create(print)) end",
    "xpcall(function() while true do end end, function() while true do end end)",
    "xpcall(function() error 'x' end, function() while true do end end)",
    "local t = setmetatable({}, {__index = function(t, k) while true do end end}) return t.x",
    "local t = setmetatable({}, {__close = function() while true do end end}) do local c <close> = t end",
    "local c <close> = setmetatable({}, {__close = function() while true do end end}) error 'x'",
    "table.sort({3, 2, 1}, function(a, b) while true do end end)",
    "('x'):rep(100):gsub('.', function() while true do end end)",
    "local t = setmetatable({}, {__gc = function() while true do end end}) t = nil collectgarbage() while true do end",
    "while true do load('return 1')() end",
    "goto a ::b:: goto c ::a:: goto b ::c:: while true do end",
    "echo(setmetatable({}, {__index = function() while true do end end})) while true do end",
    "tostring(setmetatable({}, {__tostring = function() while true do end end}))",
    "callback(function() while true do end end)",
    "while true do pcall(callback, function() while true do end end) end",
    "('a'):rep(30):find(('a?'):rep(30) .. ('a'):rep(30) .. 'b')",
    "while true do pcall(string.match, ('a'):rep(50), ('a*'):rep(20) .. 'b') end",
    "('a'):rep(200):gsub(('a-'):rep(20) .. 'b', '')",
    "for x in ('a'):rep(200):gmatch(('.-'):rep(20) .. 'b') do end",
    "local t = {} for i = 1, 10000 do t[i] = i end while true do table.insert(t, 1, 0) table.remove(t, 1) end",
    "while true do ('x'):rep(1e7) end",
    "while true do table.sort({5, 4, 3, 2, 1, 5, 4, 3, 2, 1}) end",
    "local t = {} t[1e9] = 1 while true do table.move(t, 1, 4e7, 2) end",
    "while true do collectgarbage() end",
    "error(setmetatable({}, {__tostring = function() while true do end end}))",
];

fn echo(_: &TestHost, frame: &mut tatu_call) -> tatu_status {
    for i in 0..frame.n_args {
        ret(frame, arg(frame, i).raw());
    }
    TATU_OK
}
fn callback(h: &TestHost, frame: &mut tatu_call) -> tatu_status {
    let s = h.running();
    match s.call_func(arg(frame, 0).as_func().unwrap() as u32, &[]) {
        Ok(_) => TATU_OK,
        Err(e) => h.fail(frame, e.code, &e.text, ""),
    }
}

fn host() -> &'static TestHost {
    let h = TestHost::new();
    h.command("echo", echo);
    h.command("callback", callback);
    h
}

#[test]
fn endless_loops_exhaust_the_budget() {
    let h = host();
    for text in ENDLESS_SCRIPTS {
        let s = h.script(1);
        s.budget.set((200_000, 0));
        s.load(&format!("function init()\n{text}\nend"), "t.lua", "").unwrap();
        let e = s.init().expect_err(text);
        assert_eq!(e.code, TATU_ERR_BUDGET, "{text}: {e:?}");
        assert!(e.text.contains("used up its 200000 instructions"), "{text}: {e:?}");
        assert_eq!(e.file, "t.lua", "{text}: {e:?}");
        // A call that begins within the budget completes and is charged fully: filling 10 MB costs about 160,000
        // instructions, and allocating them costs the same.
        assert!(s.used.get() < 600_000, "{text}: {}", s.used.get());
        // The script is not called any more.
        assert_eq!(s.init().unwrap_err().code, TATU_ERR_BUDGET);
        assert_eq!(s.find(TATU_FIND_FUNCTION, "nothing"), 0);
    }
}

#[test]
fn budgets_are_per_call() {
    let s = host().script(1);
    s.budget.set((50_000, 0));
    s.load("function f() for i = 1, 10000 do end return 1 end", "t.lua", "").unwrap();
    s.init().unwrap();
    let mut total = 0;
    for _ in 0..50 {
        s.function("f", &[]).unwrap();
        total += s.used.get();
    }
    assert!((450_000..600_000).contains(&total), "{total}");
    // A budget of 0 means that there is no limit.
    s.budget.set((0, 0));
    s.load("function f() for i = 1, 1000000 do end return 1 end", "t.lua", "").unwrap();
    s.init().unwrap();
    assert_eq!(s.function("f", &[]).unwrap(), [Value::Int(1)]);
}

#[test]
fn memory_limit_is_enforced() {
    let h = host();
    let s = h.script(1);
    s.budget.set((0, 4 << 20));
    s.load(
        "function eat() local t = {} for i = 1, 1e7 do t[i] = {i} end end
         function long() return #('x'):rep(1e9) end
         function caught() local ok, m = pcall(eat) return ok, m end
         function co() coroutine.wrap(eat)() end
         function thread() eat() end
         function fine() local n = 0 for i = 1, 2e5 do local t = {i} n = n + #t end return n end",
        "t.lua",
        "",
    )
    .unwrap();
    s.init().unwrap();
    for name in ["eat", "long", "co"] {
        let e = s.function(name, &[]).unwrap_err();
        assert_eq!(e.code, TATU_ERR_MEMORY, "{e:?}");
        assert!(e.text.contains("memory limit of 4194304 bytes"), "{e:?}");
    }
    assert_eq!(s.callback("thread", &[]).unwrap_err().code, TATU_ERR_MEMORY);
    let values = s.function("caught", &[]).unwrap();
    assert_eq!(values, [Value::Bool(false), Value::text("not enough memory")]);
    assert_eq!(s.function("fine", &[]).unwrap(), [Value::Int(200_000)]);
}

/// The allocation that fails is for the stack, so the position of the error is determined while Lua moves the stack.
#[test]
fn a_stack_that_cannot_grow_is_an_error() {
    let h = host();
    for (mb, text) in [
        (1, "function f(n) return 1 + f(n + 1) end"),
        (4, "function f(n) return 1 + f(n + 1) end"),
        (4, "local function g(n) return 1 + g(n + 1) end function f() coroutine.wrap(g)(1) g(1) end"),
        (
            8,
            "t = {} function deep(n) return 1 + deep(n) end
             function f() pcall(function() while true do t[#t + 1] = {} end end) return deep(1) end",
        ),
    ] {
        let s = h.script(1);
        s.budget.set((50_000_000, mb << 20));
        s.load(text, "t.lua", "").unwrap();
        if let Err(e) = s.init().and_then(|_| s.function("f", &[Value::Int(1)]).map(drop)) {
            assert!([TATU_ERR_MEMORY, TATU_ERR_SCRIPT, TATU_ERR_BUDGET].contains(&e.code), "{text}: {e:?}");
            assert_eq!((e.file.as_str(), e.line > 0), ("t.lua", true), "{text}: {e:?}");
        }
    }
}

#[test]
fn excessive_recursion_is_an_error() {
    let h = host();
    let s = h.load(
        "function lua(n) return 1 + lua(n) end
         function c() return pcall(string.gsub, 'x', '.', function() return c() end) end
         function deep() string.gsub('x', '.', deep) end
         function parse() return load('return ' .. ('('):rep(1000) .. '1' .. (')'):rep(1000)) end
         function meta() local t = setmetatable({}, {}) getmetatable(t).__index = function(t, k) return t[k] end return t.x end
         function co() local function f() return coroutine.wrap(f)() end return f() end
         function sort() table.sort({1, 2, 3}, function() sort() end) end
         function text() local t = setmetatable({}, {}) getmetatable(t).__tostring = function(t) return tostring(t) end print(t) end
         function cb() callback(cb) end",
    );
    s.init().unwrap();
    for name in ["lua", "deep", "meta", "co", "sort", "text", "cb"] {
        let e = s.function(name, &[]).unwrap_err();
        assert_eq!(e.code, TATU_ERR_SCRIPT, "{e:?}");
        assert!(e.text.contains("stack overflow") || e.text.contains("C stack"), "{name}: {e:?}");
    }
    s.function("c", &[]).unwrap();
    s.function("parse", &[]).unwrap();
}

#[test]
fn thousand_states_run_with_separate_random_sequences() {
    let h = host();
    let scripts: Vec<_> = (0..1000)
        .map(|i| {
            let s = h.script(i);
            s.load("local n = 0 function f() n = n + 1 return echo(n, math.random(1000000)) end", "t.lua", "").unwrap();
            s.init().unwrap();
            s
        })
        .collect();
    let mut values = Vec::new();
    for s in &scripts {
        values.push(s.function("f", &[]).unwrap());
    }
    values.dedup();
    assert_eq!(values.len(), 1000, "every script has its own random sequence");
    drop(scripts);
    let again = h.script(999);
    again.load("function f() return echo(1, math.random(1000000)) end", "t.lua", "").unwrap();
    again.init().unwrap();
    assert_eq!(again.function("f", &[]).unwrap(), values[999]);
}
