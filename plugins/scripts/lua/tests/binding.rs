//! Tests of commands, constants, namespaces, conversion of values, functions, and errors.
#![allow(missing_docs)]

mod common;
use common::*;
use tatu_plugin_api::{abi::*, safe::Value};

fn echo(_: &TestHost, frame: &mut tatu_call) -> tatu_status {
    for i in 0..frame.n_args {
        ret(frame, arg(frame, i).raw());
    }
    TATU_OK
}
fn show(h: &TestHost, frame: &mut tatu_call) -> tatu_status {
    let all: Vec<_> = (0..frame.n_args).map(|i| format!("{:?}", arg(frame, i).to_value().unwrap())).collect();
    h.calls.borrow_mut().push(all.join(" "));
    TATU_OK
}
fn missing(h: &TestHost, frame: &mut tatu_call) -> tatu_status {
    h.fail(frame, TATU_ERR_MISSING, "no object `/x`", "look at the tree")
}
fn objects(_: &TestHost, frame: &mut tatu_call) -> tatu_status {
    let mut v = int(0);
    v.tag = TATU_OBJECT;
    v.u.u = (9 << 20) | 42;
    ret(frame, v);
    TATU_OK
}
fn callback(h: &TestHost, frame: &mut tatu_call) -> tatu_status {
    let s = h.running();
    let f = arg(frame, 0).as_func().unwrap();
    assert_eq!(f >> 32, 5);
    let args: Vec<_> = (1..frame.n_args).map(|i| arg(frame, i).to_value().unwrap()).collect();
    match s.call_func(f as u32, &args) {
        Ok((_, values)) => {
            for v in values {
                if let Value::Int(i) = v {
                    ret(frame, int(i));
                }
            }
            TATU_OK
        }
        Err(e) => h.fail(frame, e.code, &e.text, ""),
    }
}
fn keep(h: &TestHost, frame: &mut tatu_call) -> tatu_status {
    let s = h.running();
    h.last_kept_func.set(s.keep(arg(frame, 0).as_func().unwrap() as u32));
    TATU_OK
}
fn recurse(h: &TestHost, frame: &mut tatu_call) -> tatu_status {
    let s = h.running();
    match s.function("down", &[arg(frame, 0).to_value().unwrap()]) {
        Ok(v) => {
            if let [Value::Int(i)] = v[..] {
                ret(frame, int(i));
            }
            TATU_OK
        }
        Err(e) => h.fail(frame, e.code, &e.text, ""),
    }
}

fn host() -> &'static TestHost {
    let h = TestHost::new();
    h.command("echo", echo);
    h.command("show", show);
    h.command("robot.arm.echo", echo);
    h.command("getMissing", missing);
    h.command("objects", objects);
    h.command("callback", callback);
    h.command("keep", keep);
    h.command("recurse", recurse);
    h.constant("robot.speed", num(1.5));
    h.constant("limit", int(7));
    h.preludes.borrow_mut().push((String::new(), "return {api = {'get', 'robot.'}}".to_owned()));
    h
}

#[test]
fn names_are_resolved_at_first_use() {
    let h = host();
    let s = h.load(
        "assert(limit == 7 and robot.speed == 1.5 and robot.arm.echo(3) == 3)
         assert(nothing == nil and robot.nothing == nil and not simROS)
         assert(robot == robot and require 'robot' == robot and require('robot.arm') == robot.arm)
         local n = 0 for k in pairs(_G) do assert(k ~= 'echo') n = n + 1 end
         assert(echo == echo and rawget(_G, 'echo') == nil)
         function later() return added and added(4) end",
    );
    s.init().unwrap();
    assert_eq!(s.function("later", &[]).unwrap(), [Value::Nil]);
    h.command("added", echo);
    assert_eq!(s.function("later", &[]).unwrap(), [Value::Int(4)]);
}

#[test]
fn values_are_passed_in_both_directions() {
    let h = host();
    let s = h.load(
        "function f(...) return echo(...) end
         function g() show({1, 2.5}, {1, 2}, {}, {1, 'a'}, {x = 1}, {{1}, {2.0}}, 'text', nil, true, nil) end
         function holes() local t = {} t[3] = 3 t[2] = 2 t[1] = 1 show(t) t[5] = 5 show(t) end
         function h() return math.type(echo(2.0)), math.type(echo(2)), objects(), #echo({4, 5, 6}) end
         function many(...) return select('#', echo(...)) end",
    );
    s.init().unwrap();
    let values = [
        Value::Nil,
        Value::Bool(true),
        Value::Int(i64::MAX),
        Value::Float(-0.5),
        Value::text(b"a\0b\xff"),
        Value::Floats(vec![1.0, 2.5]),
        Value::Ints(vec![3, 4]),
        Value::List(vec![Value::Int(1), Value::text("x")]),
        Value::Map(vec![(Value::text("k"), Value::List(vec![Value::Floats(vec![0.5]), Value::Bool(false)]))]),
    ];
    assert_eq!(s.function("f", &values).unwrap(), values);
    s.function("g", &[]).unwrap();
    assert_eq!(
        h.calls.borrow()[0],
        "Floats([1.0, 2.5]) Ints([1, 2]) List([]) List([Int(1), Text([97])]) Map([(Text([120]), Int(1))]) \
         List([Ints([1]), Floats([2.0])]) Text([116, 101, 120, 116]) Nil Bool(true) Nil"
    );
    s.function("holes", &[]).unwrap();
    assert_eq!(h.calls.borrow()[1], "Ints([1, 2, 3])");
    assert!(h.calls.borrow()[2].starts_with("Map"));
    assert_eq!(
        s.function("h", &[]).unwrap(),
        [Value::text("float"), Value::text("integer"), Value::Int(42), Value::Int(3)]
    );
    let thirty: Vec<_> = (0..30).map(Value::Int).collect();
    assert_eq!(s.function("many", &thirty).unwrap(), [Value::Int(30)]);
    assert_eq!(h.arena_blocks(), 0);
}

#[test]
fn calls_yield_the_requested_number_of_results() {
    let h = host();
    let s = h.load(
        "function few(...) local a = echo(...) local b, c = echo(...) echo(...) return a, b, c end
         function more(...) local a, b, c, d = echo(...) return a, b, c, d == nil, select('#', echo(...)), #{echo(...)} end
         function through(...) local t = setmetatable({}, {__index = echo, __call = echo}) local _, x = t(...) return x end
         function inner(...) local a = coroutine.wrap(function(...) local b, c = echo(...) return c end)(...) return a end",
    );
    s.init().unwrap();
    let values = [Value::Int(1), Value::Float(0.5), Value::Floats(vec![1.0, 2.0, 3.0])];
    let [one, half, point] = values.clone();
    assert_eq!(s.function("few", &values).unwrap(), [one.clone(), one.clone(), half.clone()]);
    let all = [one.clone(), half.clone(), point.clone(), Value::Bool(true), Value::Int(3), Value::Int(3)];
    assert_eq!(s.function("more", &values).unwrap(), all);
    // The called table itself is passed as the first argument.
    assert_eq!(s.function("through", &values).unwrap(), [one]);
    assert_eq!(s.function("inner", &values).unwrap(), [half]);
}

#[test]
fn value_that_cannot_be_passed_is_named_by_its_path() {
    let h = host();
    let s = h.load(
        "function cycle() local t = {a = {1, {}}} t.a[2].b = t\n echo(1, t) end
         function thread() echo(coroutine.create(print)) end
         function deep() local t = {} for i = 1, 40 do t = {t} end echo(t) end
         function key() echo({[{}] = 1}) end",
    );
    s.init().unwrap();
    let e = s.function("cycle", &[]).unwrap_err();
    assert_eq!(
        (e.code, e.text.as_str(), e.line),
        (TATU_ERR_ARGUMENT, "argument 2, at .a[2].b: the table contains itself", 2)
    );
    let e = s.function("thread", &[]).unwrap_err();
    assert_eq!(e.text, "argument 1: a thread cannot be passed");
    let e = s.function("deep", &[]).unwrap_err();
    assert!(e.text.ends_with("the table is nested more than 32 levels deep"), "{e:?}");
    let e = s.function("key", &[]).unwrap_err();
    assert!(e.text.contains("is not a string, number or boolean"), "{e:?}");
}

#[test]
fn errors_have_code_position_and_traceback() {
    let h = host();
    let s = h.load(
        "function command()\n  getMissing(1)\nend
         function caught() local ok, m = pcall(getMissing) return ok, m, echo(1) end
         function again() local ok, m = pcall(getMissing)\n error(m, 0) end
         function other() pcall(getMissing) local t = nil\n return t.x end
         function object() error({code = 5}) end
         function unknown() getNothing() end
         function unknown_field() robot.fly() end
         function plain() fly() end
         function in_coroutine() local co = coroutine.wrap(function()\n error 'inside' end) co() end",
    );
    s.init().unwrap();
    let fail = |name: &str| s.function(name, &[]).unwrap_err();
    let e = fail("command");
    assert_eq!((e.code, e.text.as_str(), e.help.as_str()), (TATU_ERR_MISSING, "no object `/x`", "look at the tree"));
    assert_eq!((e.file.as_str(), e.line), ("test.lua", 2));
    assert!(e.traceback.contains("test.lua:2: in function 'command'"), "{e:?}");
    let values = s.function("caught", &[]).unwrap();
    assert_eq!(values[1], Value::text("no object `/x` (look at the tree)"), "{values:?}");
    assert_eq!(fail("again").code, TATU_ERR_MISSING);
    let e = fail("other");
    assert_eq!((e.code, e.line), (TATU_ERR_SCRIPT, 8));
    assert_eq!(e.text, "attempt to index a nil value (local 't')");
    let e = fail("object");
    assert!(e.text.starts_with("table: 0x0000000"), "{e:?}");
    let e = fail("unknown");
    assert_eq!((e.code, e.text.as_str()), (TATU_ERR_UNKNOWN, "there is no command `getNothing`"));
    assert_eq!(fail("unknown_field").text, "there is no command `robot.fly`");
    assert_eq!(fail("plain").code, TATU_ERR_SCRIPT);
    let e = fail("in_coroutine");
    assert_eq!((e.text.as_str(), e.line), ("inside", 14), "{e:?}");
    let e = s.load("x = = 1", "bad.lua", "").unwrap_err();
    assert_eq!((e.text.as_str(), e.file.as_str(), e.line), ("unexpected symbol near '='", "bad.lua", 1));
    let long = format!("{}bad.lua", "folder/".repeat(20));
    let e = s.load("\n\nx = = 1", &long, "").unwrap_err();
    assert_eq!((e.file.as_str(), e.line), (long.as_str(), 3));
    s.load("\n\nfunction f() error 'x' end", &long, "").unwrap();
    s.init().unwrap();
    let e = s.function("f", &[]).unwrap_err();
    assert_eq!((e.file.as_str(), e.line, e.text.as_str()), (long.as_str(), 3, "x"));
}

#[test]
fn borrowed_and_retained_functions_are_called() {
    let h = host();
    let s = h.load(
        "function f() return callback(function(a, b) return a + b end, 3, 4) end
         function g() local n = 0 keep(function() n = n + 1 return n end) end
         function bad() callback(function() error 'inner' end) end
         function result() return function() return 'x' end end",
    );
    s.init().unwrap();
    assert_eq!(s.function("f", &[]).unwrap(), [Value::Int(7)]);
    let e = s.function("bad", &[]).unwrap_err();
    assert_eq!((e.code, e.text.as_str()), (TATU_ERR_SCRIPT, "inner"));
    s.function("g", &[]).unwrap();
    let kept = h.last_kept_func.get();
    assert_ne!(kept, 0);
    assert_eq!(s.call_func(kept, &[]).unwrap().1, [Value::Int(1)]);
    assert_eq!(s.call_func(kept, &[]).unwrap().1, [Value::Int(2)]);
    s.drop_func(kept);
    assert_eq!(s.call_func(kept, &[]).unwrap_err().code, TATU_ERR_GONE);
    assert_eq!(s.keep(1), 0);
    let Value::Func(f) = s.function("result", &[]).unwrap()[0] else {
        panic!("not a function");
    };
    let kept = s.keep(f as u32);
    s.function("f", &[]).unwrap();
    assert_eq!(s.call_func(kept, &[]).unwrap().1, [Value::text("x")]);
    assert_eq!(s.call_func(f as u32, &[]).unwrap_err().code, TATU_ERR_GONE);
}

#[test]
fn calls_into_a_script_nest_ten_levels_deep() {
    let h = host();
    let s = h.load(
        "function down(n) if n == 0 then return 0 end
           local co = coroutine.wrap(function(m) return recurse(m) end)
           return 1 + co(n - 1) end
         function crash(n) if n == 0 then error 'bottom' end return recurse(n - 1) end",
    );
    s.init().unwrap();
    assert_eq!(s.function("down", &[Value::Int(10)]).unwrap(), [Value::Int(10)]);
    s.load("function down(n) if n == 0 then error 'bottom' end return (recurse(n - 1)) end", "t.lua", "").unwrap();
    s.init().unwrap();
    let e = s.function("down", &[Value::Int(10)]).unwrap_err();
    assert_eq!((e.code, e.text.as_str()), (TATU_ERR_SCRIPT, "bottom"));
    assert_eq!(h.arena_blocks(), 0);
}
