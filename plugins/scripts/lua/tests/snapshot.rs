//! Tests of saved and restored states: everything that a script can observe is the same, in the same order, and saving
//! does not affect the script.
#![allow(clippy::undocumented_unsafe_blocks, reason = "the test acts as the host")]

mod common;

use common::{TestHost, TestScript, num, ret};
use proptest::prelude::*;
use tatu_plugin_api::abi::*;

/// Saves the state of a script; returns the text of the error if it fails.
fn saved(s: &TestScript) -> Result<Vec<u8>, String> {
    s.save().map_err(|e| e.text)
}

/// Creates a script with the same source and restores the state in `bytes`.
fn restored_copy(host: &'static TestHost, text: &str, bytes: &[u8]) -> TestScript {
    let s = host.load(text);
    s.restore(bytes).unwrap_or_else(|e| panic!("{e:?}"));
    s
}

/// Compares the results of `look` in a script and in its restored copy, now and after several calls of `go` in both.
#[track_caller]
fn assert_copy_behaves_alike(text: &str) {
    let host = TestHost::new();
    host.command("robot.read", |_, frame| {
        ret(frame, num(1.25));
        TATU_OK
    });
    let s = host.load(text);
    s.init().unwrap();
    for _ in 0..3 {
        s.function("go", &[]).unwrap();
    }
    let bytes = saved(&s).unwrap_or_else(|e| panic!("{e}"));
    assert!(saved(&s).unwrap() == bytes, "saving must not change the state");
    let copy = restored_copy(host, text, &bytes);
    assert!(saved(&copy).unwrap() == bytes, "the saved state of a copy must be identical");
    for i in 0..20 {
        assert_eq!(s.function("look", &[]).unwrap(), copy.function("look", &[]).unwrap(), "round {i}");
        let (a, b) = (s.function("go", &[]).unwrap(), copy.function("go", &[]).unwrap());
        assert_eq!(a, b, "round {i}");
    }
}

/// Returns the reason that a state cannot be saved.
#[track_caller]
fn refusal(text: &str) -> String {
    let s = TestHost::new().load(text);
    s.init().unwrap();
    saved(&s).expect_err("the state must not be saved")
}

#[test]
fn values_of_every_type() {
    assert_copy_behaves_alike(
        "a, b, c, d, e, f = nil, true, 7, 2.0, 'te\\0xt', -0.0
        nan, inf, big = 0/0, math.huge, math.maxinteger
        function look() return tostring(a), b, c, d, e, 1/f, tostring(nan), inf, big, math.type(c), math.type(d) end
        function go() c = c + 1 d = d * 1.5 e = e .. '!' return c, d, e end",
    );
}

#[test]
fn shared_and_cyclic_tables() {
    assert_copy_behaves_alike(
        "local inner = {n = 1}
        t = {inner, inner, x = inner}
        t.t = t
        setmetatable(t, {__index = function(_, k) return 'no ' .. tostring(k) end, __len = function() return 42 end})
        function look() return t[1] == t[2], t.x == t[1], t.t == t, t.missing, #t, getmetatable(t).__len == nil end
        function go() t[1].n = t[1].n + 1 t[#t + 1] = inner.n return t[2].n, inner.n end",
    );
}

#[test]
fn functions_share_their_variables() {
    assert_copy_behaves_alike(
        "local function counter()
            local n = 0
            return function() n = n + 1 return n end, function() return n end
        end
        up, get = counter()
        up2, get2 = counter()
        local function fact(n) return n < 2 and 1 or n * fact(n - 1) end
        local class = {} class.__index = class
        function class.new(v) return setmetatable({v = v}, class) end
        function class:add(x) self.v = self.v + x return self.v end
        object = class.new(3)
        local later
        function look() return get(), get2(), fact(5), object.v, later end
        function go() later = (later or 0) + up() return up(), object:add(2), later end",
    );
}

#[test]
fn errors_in_restored_functions_still_name_their_lines() {
    assert_copy_behaves_alike(
        "local deep = {f = function()
            local x = nil
            return x.y
        end}
        function look() return select(2, pcall(deep.f)) end
        function go() return debug.getinfo(deep.f, 'S').linedefined, debug.getinfo(deep.f, 'S').source end",
    );
}

#[test]
fn random_sequence_continues_after_restore() {
    assert_copy_behaves_alike(
        "math.randomseed(99)
        function look() return tostring(math.random) end
        function go() return math.random(), math.random(100) end",
    );
}

#[test]
fn the_order_of_pairs_is_part_of_the_state() {
    assert_copy_behaves_alike(
        "t, log = {}, {}
        for i = 1, 50 do t['key' .. (i * 7919) % 101] = i end
        for i = 1, 50, 3 do t['key' .. (i * 7919) % 101] = nil end
        for i = 1, 20 do t[i * 1.5], t[i * 1000] = i, -i end
        t[true] = 'yes'
        local n = 0
        local function digest(x)
            local s = {}
            for k, v in pairs(x) do s[#s + 1] = tostring(k) .. '=' .. tostring(v) end
            return table.concat(s, ' ')
        end
        function look() return digest(t), digest(string), #log, digest(log) end
        function go()
            n = n + 1
            t['new' .. n], t['key' .. n], t[n] = n, nil, 'x'
            log[n] = n
            if n % 3 == 0 then log[n - 1] = nil end
            return digest(t), #log
        end",
    );
}

#[test]
fn lengths_of_arrays_with_holes_are_restored() {
    assert_copy_behaves_alike(
        "lists = {}
        for i = 1, 30 do
            local t = {}
            for k = 1, i do t[k] = k end
            for k = i, i // 2, -2 do t[k] = nil end
            local _ = #t
            lists[i] = t
        end
        function look() local s = '' for i = 1, 30 do s = s .. #lists[i] .. ' ' end return s end
        local n = 0
        function go() n = n + 1 local t = lists[n % 30 + 1] t[#t + 1] = n t[n % 7] = nil return #t end",
    );
}

#[test]
fn changed_library_functions_are_restored() {
    assert_copy_behaves_alike(
        "local format = string.format
        string.shout = function(s) return s:upper() .. '!' end
        string.format = function(...) return '<' .. format(...) .. '>' end
        print = nil
        math.pi = 3
        function look() return ('a'):shout(), string.format('%d', 5), print == nil, math.pi, string.rep('x', 3) end
        function go() math.pi = math.pi + 1 return math.pi, ('b'):shout() end",
    );
}

#[test]
fn commands_and_iterators_are_restored() {
    assert_copy_behaves_alike(
        "read = robot.read
        next_word = ('one two three four five six seven eight nine ten eleven twelve'):gmatch('%a+')
        function look() return read == robot.read, read(), robot.nothing end
        function go() return next_word(), robot.read() end",
    );
}

#[test]
fn functions_of_loaded_sources_are_restored() {
    assert_copy_behaves_alike(
        "local make = load('local n = ... return function() n = n + 1 return n end', '=made')
        f, g = make(10), make(20)
        function look() return debug.getinfo(f, 'S').source end
        function go() return f(), g() end",
    );
}

#[test]
fn printed_object_numbers_are_restored() {
    assert_copy_behaves_alike(
        "a, b = {}, {}
        shown = tostring(b)
        function look() return tostring(b), shown end
        function go() return tostring(a), tostring({}) end",
    );
}

#[test]
fn old_scripts_that_rerun_are_restored() {
    let prelude = "local told = ... return {
        functions = 'on_%s',
        rerun = {variable = 'why', values = {init = 0, actuation = 1}},
        dialect = told.has('why') and '3.2' or '4.9'}";
    let text = "if why == 0 then count, list = 0, {} end
        if why == 1 then count = count + 1 list[#list + 1] = count * 1.5 return count, #list, math.random(7.9) end";
    let host = TestHost::new();
    host.preludes.borrow_mut().push((String::new(), prelude.into()));
    let s = host.load(text);
    s.init().unwrap();
    let actuation = s.find(TATU_FIND_CALLBACK, "actuation");
    s.call_id(actuation, &[]).unwrap();
    let copy = restored_copy(host, text, &saved(&s).unwrap());
    for _ in 0..10 {
        assert_eq!(s.call_id(actuation, &[]).unwrap(), copy.call_id(actuation, &[]).unwrap());
    }
}

#[test]
fn variable_that_cannot_be_saved_is_named() {
    let co = "co = coroutine.create(function() coroutine.yield() end) ";
    for (text, reason) in [
        (format!("{co} coroutine.resume(co)"), "variable `co` is a suspended coroutine"),
        (format!("{co} coroutine.resume(co) a = {{b = {{0, co}}}} co = nil"), "variable `a.b[2]` is a suspended"),
        (co.to_string(), "variable `co` is a coroutine that has not started yet"),
        ("local c = coroutine.wrap(function() end) function f() c() end".into(), "local variable `c` is a coroutine"),
        ("t = setmetatable({}, {__mode = 'k'})".into(), "variable `t` is a weak table"),
        ("set = {} set[{}] = 1 set[{}] = 2".into(), "variable `set` has keys that are tables"),
        (
            "local n = 0 f = load(function() n = n + 1 return ({'return ', 'function() end'})[n] end)()".into(),
            "variable `f` is a function whose source",
        ),
    ] {
        let got = refusal(&text);
        assert!(got.starts_with(reason), "{text}\n{got}");
    }
    // A finished coroutine can be saved.
    assert_copy_behaves_alike(&format!(
        "{co} coroutine.resume(co) coroutine.resume(co) function look() return coroutine.status(co) end
        function go() return coroutine.resume(co) end"
    ));
}

#[test]
fn saving_does_not_change_later_addresses() {
    // The order of keys that are tables depends on their addresses.
    let text = "local function digest() local t, s = {}, {}
            for i = 1, 40 do t[{i}] = i end
            for _, v in pairs(t) do s[#s + 1] = v end
            return table.concat(s, ' ') end
        keep = {}
        function go() keep[#keep + 1] = {digest()} return digest() end";
    let host = TestHost::new();
    let (plain, watched) = (host.load(text), host.load(text));
    plain.init().unwrap();
    watched.init().unwrap();
    for i in 0..20 {
        saved(&watched).unwrap();
        assert_eq!(plain.function("go", &[]).unwrap(), watched.function("go", &[]).unwrap(), "round {i}");
    }
}

#[test]
fn damaged_bytes_are_refused() {
    let text = "t = {1, 2, x = {y = function() return t end}} function go() return #t end";
    let host = TestHost::new();
    let s = host.load(text);
    s.init().unwrap();
    let bytes = saved(&s).unwrap();
    let mut refused = 0;
    for i in 0..bytes.len() {
        for cut in [true, false] {
            let mut bad = bytes.clone();
            if cut {
                bad.truncate(i);
            } else {
                bad[i] ^= 1 << (i % 8);
            }
            let copy = host.load(text);
            refused += usize::from(copy.restore(&bad).is_err());
            // The state must remain usable after a failed restore.
            drop(copy);
        }
    }
    assert!(refused > bytes.len(), "{refused} of {}", 2 * bytes.len());
}

/// An operation on a table: the indices of the table, the key, and the new value.
type TableOperation = (usize, usize, usize);

fn statement((table, key, value): &TableOperation) -> String {
    let keys = ["'a'", "'longer'", "'key_%'", "%", "-%", "%.5", "1", "2", "3", "#T + 1", "true", "false", "'x' .. %"];
    let values = ["nil", "%", "'v%'", "tables[% % #tables + 1]", "1.5", "true", "nil"];
    let number = (table * 31 + key * 7 + value) % 50;
    let key = keys[key % keys.len()].replace('%', &number.to_string());
    let value = values[value % values.len()];
    let value = if value.starts_with("tables") {
        format!("tables[{number} % #tables + 1]")
    } else {
        value.replace('%', &number.to_string())
    };
    let t = format!("tables[{}]", table % 5 + 1);
    format!("{t}[{}] = {value}", key.replace('T', &t))
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(60))]

    /// Restored random graphs of tables have the same content, order and length, also after further changes.
    #[test]
    fn any_graph_of_tables(
        before in proptest::collection::vec((0usize..5, 0usize..200, 0usize..60), 1..150),
        after in proptest::collection::vec((0usize..5, 0usize..200, 0usize..60), 1..60),
    ) {
        let moves = |m: &[TableOperation]| m.iter().map(statement).collect::<Vec<_>>().join("\n");
        let text = format!(
            "tables = {{{{}}, {{}}, {{}}, {{}}, {{}}}}
            local ids = {{}}
            local function id(v)
                if type(v) ~= 'table' then return tostring(v) end
                for i = 1, #tables do if tables[i] == v then return 'T' .. i end end
            end
            function look()
                local s = {{}}
                for i = 1, #tables do
                    s[#s + 1] = '#' .. #tables[i]
                    for k, v in pairs(tables[i]) do s[#s + 1] = tostring(k) .. '=' .. id(v) end
                end
                return table.concat(s, ' ')
            end
            {}
            function go() {} end", moves(&before), moves(&after));
        let host = TestHost::new();
        let s = host.load(&text);
        s.init().unwrap();
        let copy = restored_copy(host, &text, &saved(&s).unwrap());
        prop_assert_eq!(s.function("look", &[]).unwrap(), copy.function("look", &[]).unwrap());
        s.function("go", &[]).unwrap();
        copy.function("go", &[]).unwrap();
        prop_assert_eq!(s.function("look", &[]).unwrap(), copy.function("look", &[]).unwrap());
    }
}
