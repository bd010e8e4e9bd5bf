//! Tests of callbacks in all styles, dialects, waits, and the scripts of the course.
#![allow(missing_docs)]

mod common;
use common::*;
use tatu_plugin_api::{abi::*, safe::Value};

const PRELUDE: &str = r#"
local told = ...
return {
    functions = "sysCall_%s",
    rerun = {
        variable = "sim_call_type",
        values = {init = 0, cleanup = 1, actuation = 2, sensing = 3, thread = 4},
        needs = {thread = {"sim_childscriptcall_threaded"}},
        extra = {sim_current_script_id = "script"},
    },
    api = {"sim"},
    dialect = told.has("sim_call_type") and "3.2" or "4.9",
}"#;

/// Implements any command: records its name and arguments, and returns values that suit the course's scripts.
fn any(h: &TestHost, name: &str, frame: &mut tatu_call) -> tatu_status {
    let args: Vec<_> = (0..frame.n_args)
        .map(|i| match arg(frame, i).to_value().unwrap() {
            Value::Text(t) => String::from_utf8_lossy(&t).into_owned(),
            Value::Int(i) => i.to_string(),
            v => format!("{v:?}"),
        })
        .collect();
    h.calls.borrow_mut().push(format!("{name}({})", args.join(", ")));
    let array = |v: &'static [f64]| {
        let mut raw = num(0.0);
        raw.tag = TATU_F64S;
        raw.u.s = tatu_span_t { ptr: v.as_ptr().cast(), len: v.len() as u64 };
        raw
    };
    match name {
        "simReadProximitySensor" | "simHandleProximitySensor" => {
            ret(frame, int(1));
            ret(frame, num(0.3));
            ret(frame, array(&[0.1, 0.2, 0.3]));
        }
        "simGetSimulatorMessage" => {
            let first = h.time.get() == 0.0;
            h.time.set(h.time.get() + 0.05);
            ret(frame, int(if first { 6 } else { -1 }));
            if first {
                let mut keys = num(0.0);
                keys.tag = TATU_I64S;
                keys.u.s = tatu_span_t { ptr: [2007i64, 0, 0, 0].as_ptr().cast(), len: 4 };
                ret(frame, keys);
            }
        }
        "simGetObjectPosition" | "simGetObjectOrientation" => ret(frame, array(&[0.5, 1.5, 2.5])),
        "simGetObjectName" | "simPackFloats" => {
            let mut text = num(0.0);
            text.tag = TATU_TEXT;
            text.u.s = tatu_span_t { ptr: "robot".as_ptr().cast(), len: 5 };
            ret(frame, text);
        }
        "simGetFloatSignal" => ret(frame, num(0.25)),
        _ => ret(frame, int(11)),
    }
    TATU_OK
}

macro_rules! commands {
    ($h:ident, $($name:ident)*) => {
        $({
            fn one(h: &TestHost, frame: &mut tatu_call) -> tatu_status {
                any(h, stringify!($name), frame)
            }
            $h.command(stringify!($name), one);
        })*
    };
}

fn wait(h: &TestHost, frame: &mut tatu_call) -> tatu_status {
    if frame.wait_token == 0 {
        return h.fail(frame, TATU_ERR_UNSUPPORTED, "only threads can wait", "");
    }
    h.tokens.borrow_mut().push(frame.wait_token);
    TATU_WAIT
}

fn host() -> &'static TestHost {
    let h = TestHost::new();
    h.preludes.borrow_mut().push((String::new(), PRELUDE.to_owned()));
    h.preludes
        .borrow_mut()
        .push(("math.extra".to_owned(), "return {name = ..., twice = function(x) return 2 * x end}".to_owned()));
    commands!(h, simAuxiliaryConsoleOpen simAuxiliaryConsolePrint simAuxiliaryConsoleShow simGetFloatSignal
        simSetFloatSignal simGetObjectHandle simGetObjectAssociatedWithScript simGetObjectName simTubeOpen simTubeWrite
        simSetJointPosition simHandleProximitySensor simReadProximitySensor simPackFloats simGetSimulatorMessage
        simAddStatusbarMessage simSetJointTargetPosition simSetJointForce simSetJointTargetVelocity
        simGetObjectPosition simGetObjectOrientation);
    for (i, name) in ["initialization", "cleanup", "actuation", "sensing", "threaded"].iter().enumerate() {
        h.constant(&format!("sim_childscriptcall_{name}"), int(i as i64));
    }
    h.constant("sim_message_keypress", int(6));
    h.constant("sim_handle_self", int(-4));
    h.command("wait", wait);
    h.command("show", |h, frame| any(h, "show", frame));
    h
}

fn load(h: &'static TestHost, text: &str) -> TestScript {
    let s = h.script(1);
    s.load(text, "t.lua", "").unwrap();
    s
}

#[test]
fn functions_are_callbacks() {
    let h = host();
    let s = h.script(1);
    let text = "local n = 0
        show(_G['sim_' .. 'call_type'])
        function sysCall_init(a) n = n + 1 show('init', n, _G['sim_' .. 'call_type'], a) return 5 end
        function sysCall_actuation() n = n + 1 show('act', n) end
        local t = {} function helper() return 'h' end robot = {go = function(x) return x end}";
    assert_eq!(s.load(text, "t.lua", "").unwrap(), "4.9");
    assert_eq!(s.find(TATU_FIND_CALLBACK, "actuation"), 0);
    assert_eq!(s.callback("init", &[Value::Int(9)]).unwrap().1, [Value::Int(5)]);
    assert_eq!(s.find(TATU_FIND_CALLBACK, "sensing"), 0);
    s.callback("actuation", &[]).unwrap();
    assert_eq!(*h.calls.borrow(), ["show(0)", "show(init, 1, Nil, 9)", "show(act, 2)"]);
    assert_eq!(s.function("helper", &[]).unwrap(), [Value::text("h")]);
    assert_eq!(s.function("robot.go", &[Value::Int(3)]).unwrap(), [Value::Int(3)]);
    assert_eq!(s.find(TATU_FIND_FUNCTION, "robot.stop"), 0);
    assert_eq!(s.find(TATU_FIND_FUNCTION, "show"), 0);
}

#[test]
fn old_script_is_run_again_for_each_callback() {
    let h = host();
    let s = h.script(1);
    let text = "local l = (l or 0) + 1  g = (g or 0) + 1
        show(sim_call_type, l, g, sim_current_script_id, ...)
        if sim_call_type==sim_childscriptcall_sensing then return 1, 'two' end";
    assert_eq!(s.load(text, "t.lua", "").unwrap(), "3.2");
    s.callback("init", &[Value::Int(8)]).unwrap();
    assert_ne!(s.find(TATU_FIND_CALLBACK, "actuation"), 0);
    assert_eq!(s.find(TATU_FIND_CALLBACK, "suspend"), 0);
    assert_eq!(s.find(TATU_FIND_CALLBACK, "thread"), 0);
    assert_eq!(s.callback("sensing", &[]).unwrap().1, [Value::Int(1), Value::text("two")]);
    assert_eq!(*h.calls.borrow(), ["show(0, 1, 1, 77, 8)", "show(3, 1, 2, 77)"]);
    // A script with neither branches nor functions runs once.
    let s = load(h, "show('once')");
    s.init().unwrap();
    assert_eq!(s.find(TATU_FIND_CALLBACK, "actuation"), 0);
    // A script of the old style is called again after it has failed.
    let s = load(h, "if sim_call_type==2 then error 'x' end");
    s.init().unwrap();
    for _ in 0..2 {
        assert_eq!(s.callback("actuation", &[]).unwrap_err().text, "x");
    }
    let s = load(h, "function sysCall_cleanup() show('cleanup') end error 'broken'");
    assert_eq!(s.init().unwrap_err().text, "broken");
    s.callback("cleanup", &[]).unwrap();
}

#[test]
fn each_dialect_has_its_library() {
    let h = host();
    let s = h.script(1);
    let old = "function sysCall_init()
        assert(unpack({1, 2}) == 1 and table.getn({1, 2}) == 2 and table.maxn({[7.5] = 1}) == 7.5)
        assert(loadstring('return 3')() == 3 and math.pow(2, 3) == 8 and math.mod(7, 4) == 3)
        assert(math.log10(1000) == 3 and math.atan2(1, 0) > 1.5 and math.cosh(0) == 1 and math.ldexp(1, 3) == 8)
        assert(string.gfind('ab', 'b')() == 'b' and string.format('%d|%5.1f|%s', 3.7, 2.25, 'x') == '3|  2.2|x')
        assert(string.format('%x %c', 255.9, 65.2) == 'ff A' and ('abc'):sub(1.9, 2.1) == 'ab')
        local r = math.random(1.5, 6.9) assert(r >= 1 and r <= 6)
        assert(tostring(5.0) == '5' and string.format('%s', 10 / 2) == '5' and tostring(0.5) == '0.5')
        local f = loadstring('x = 1 return x') local env = {} setfenv(f, env)
        assert(f() == 1 and env.x == 1 and x == nil and getfenv(f) == env and getfenv(1) == _G)
        local n = 0 table.foreach({1, 2, k = 3}, function() n = n + 1 end) assert(n == 3)
        table.foreachi({4}, function(i, v) assert(i == 1 and v == 4) end)
        assert(undefined == nil)
    end";
    assert_eq!(s.load(old, "t.lua", "3.6").unwrap(), "3.6");
    s.init().unwrap();
    let modern = "function sysCall_init()
        assert(getn == nil and table.getn == nil and loadstring == nil and unpack({4}) == 4)
        assert(math.pow(2, 3) == 8 and math.atan2(1, 0) > 1.5 and 7 // 2 == 3 and tostring(5.0) == '5.0')
        assert(not pcall(string.format, '%d', 3.7))
    end";
    for dialect in ["", "4.10", "lua"] {
        let s = h.script(1);
        s.load(modern, "t.lua", dialect).unwrap();
        s.init().unwrap();
    }
}

#[test]
fn library_has_no_access_to_the_system() {
    let h = host();
    h.time.set(3661.5);
    let dir = std::env::temp_dir().join(format!("tatu-lua-{}", std::process::id()));
    std::fs::create_dir_all(dir.join("sub")).unwrap();
    *h.folder.borrow_mut() = dir.display().to_string();
    std::fs::write(dir.join("sub/mod.lua"), "#!x\nlocal m = {...} function m.f() return 6 end return m").unwrap();
    std::fs::write(dir.join("bad.lua"), "x = = 1").unwrap();
    let s = load(
        h,
        "function sysCall_init()
            assert(os.clock() == 3661.5 and os.time() == 1420074061 and os.date('!%F %T') == '2015-01-01 01:01:01')
            assert(os.date('*t').hour == 1 and os.time({year = 2015, month = 1, day = 1, hour = 0}) == 1420070400)
            assert(os.getenv('HOME') == nil and os.execute == nil and os.exit == nil and os.remove == nil)
            assert(io.popen == nil and package.loadlib == nil and string.dump == nil and debug.sethook == nil)
            assert(not load('\\27Lua') and load('return ...')(4) == 4 and not loadfile('nothing.lua'))
            print('a', 1, nil, true) io.write('x', 1, ' ') io.write('y\\nz')
            local f = assert(io.open('out.txt', 'w')) f:write('one\\n', 2, ' ', 0.5, '\\nlast') f:close()
            f = assert(io.open('out.txt', 'a')) f:write('!') f:close()
            local lines = {} for l in io.lines('out.txt') do lines[#lines + 1] = l end
            assert(#lines == 3 and lines[2] == '2 0.5' and lines[3] == 'last!')
            f = io.open('out.txt') assert(f:read('L') == 'one\\n' and f:read('n', 'n') == 2)
            assert(f:seek('set', 4) == 4 and f:read(1) == '2' and f:read('a') == ' 0.5\\nlast!' and f:read('a') == '')
            assert(f:read('l') == nil and io.type(f) == 'file' and f:close() and io.type(f) == 'closed file')
            assert(not pcall(f.read, f))
            local ok, why = io.open('/etc/passwd') assert(not ok and why:find('allowed'), why)
            ok, why = io.open('none.txt') assert(not ok and why:find('none.txt'), why)
            assert(require('sub.mod').f() == 6 and require 'sub.mod' == require 'sub.mod' and require('sub.mod')[1] == 'sub.mod')
            assert(require('math.extra').twice(4) == 8 and require 'math' == math)
            ok, why = pcall(require, 'nothing.there') assert(not ok and why:find('nothing/there.lua'), why)
            ok, why = pcall(require, 'bad') assert(not ok and why:find('bad.lua:1:'), why)
            assert(not pcall(setmetatable, 1, {}) and getmetatable(setmetatable({}, {__gc = print})).__gc == print)
            local a, b = {}, {} assert(tostring(a) == tostring(a) and tostring(a) ~= tostring(b))
            assert(string.format('%p', a) == tostring(a):match('0x%x+') and tostring(print):match('^function: 0x0000'))
            assert(not string.format('%s %s', a, coroutine.create(print)):find('0x[1-9a-f]'))
            local t = {5, 3, 9, 1} table.sort(t) assert(table.concat(t, ' ') == '1 3 5 9')
            local t = {} for i = 1, 500 do t[i] = (i * 7919) % 503 end table.sort(t, function(x, y) return x > y end)
            for i = 2, 500 do assert(t[i - 1] >= t[i]) end
            assert(#table.move({1, 2, 3}, 1, 3, 2) == 4)
            assert(select('#', xpcall(function(...) return ... end, print, 1, 2)) == 3)
            local ok, m = xpcall(error, function(m) return m .. '!' end, 'x') assert(not ok and m == 'x!')
            for i, v in ipairs({7}) do assert(i == 1 and v == 7) end
            local mt = {__pairs = function() return function(_, k) if not k then return 1, 2 end end end}
            for k, v in pairs(setmetatable({}, mt)) do assert(v == 2) end
            assert(('hello world'):find('o w') == 5 and ('a.b'):find('.', 1, true) == 2 and ('x'):find('', 10) == nil)
            assert(('key = 12'):match('^(%w+)%s*=%s*(%d+)$') == 'key' and ('abc'):match('()c') == 3 and ('abc'):find('b', -1) == nil)
            local n = 0 for k, v in ('a=1, b=2'):gmatch('(%w+)=(%w+)') do n = n + v end assert(n == 3)
            local all = {} for x in ('abc'):gmatch('') do all[#all + 1] = x end assert(#all == 4)
            assert(('abc'):gsub('%w', '%0%0') == 'aabbcc' and ('abc'):gsub('', '-') == '-a-b-c-' and select(2, ('aaa'):gsub('a', 'b', 2)) == 2)
            assert(('$x $y'):gsub('%$(%w)', {x = 1}) == '1 $y' and ('ab'):gsub('(a)(b)', '%2%1%%') == 'ba%')
            assert(('ab'):gsub('.', function(c) return c == 'a' and c:upper() end) == 'Ab' and not pcall(string.gsub, 'x', 'x', '%y'))
            assert(('  x '):gsub('^%s+', '') == 'x ' and not pcall(string.rep) and not pcall(string.find, 'a', '('))
            assert(collectgarbage('count') > 10 and collectgarbage() == 0)
        end",
    );
    s.init().unwrap();
    drop(s);
    let lines = h.lines();
    assert!(lines.contains(&"a\t1\tnil\ttrue".to_owned()), "{lines:?}");
    assert!(lines.contains(&"x1 y".to_owned()) && lines.contains(&"z".to_owned()));
    std::fs::remove_dir_all(dir).unwrap();
}

/// `print` completes a line that `io.write` has begun, and no output is lost, not even before an error.
#[test]
fn output_of_write_and_print_is_logged_in_order() {
    let h = host();
    let s = load(
        h,
        "function sysCall_init()
            io.write('a ') print('b') print('c') io.write('d\\n', 'e', '\\n') io.stdout:write('f') print()
            io.write(('x'):rep(3000000)) print('y') io.write('before')
            error('then')
        end",
    );
    s.init().unwrap_err();
    let lines = h.lines();
    assert_eq!(lines[..5], ["a b", "c", "d", "e", "f"], "{lines:?}");
    let (x, rest) = (&lines[5], &lines[6..]);
    assert_eq!((x.len(), rest), (3_000_000, &["y".to_owned(), "before".to_owned()][..]));
    drop(s);
    assert_eq!(h.lines().len(), 8);
}

#[test]
fn thread_callback_waits_and_resumes() {
    let h = host();
    let s = load(
        h,
        "function sysCall_thread(...)
            local ok, a, b = pcall(function() return wait(1) end)
            show('first', ok, a, b)
            local t = setmetatable({}, {__add = function() return (wait(2)) end})
            show('second', t + 1)
            local ok, e = pcall(wait)
            show('third', ok, e)
            for v in function() return wait() end do show('loop', v) end
            return 'end', ...
        end
        function sysCall_actuation() return pcall(wait) end
        function sorted() return wait() end",
    );
    s.init().unwrap();
    let last = || *h.tokens.borrow().last().unwrap();
    let (status, _) = s.callback("thread", &[Value::Int(4)]).unwrap();
    assert_eq!(status, TATU_WAIT);
    let first = last();
    assert_eq!(s.resume(first, None, &[Value::Int(7), Value::text("b")]).unwrap().0, TATU_WAIT);
    assert_eq!(s.resume(first, None, &[]).unwrap_err().code, TATU_ERR_GONE);
    // Other callbacks run in the meantime; they cannot wait.
    let (_, values) = s.callback("actuation", &[]).unwrap();
    assert_eq!(values, [Value::Bool(false), Value::text("only threads can wait")]);
    assert_eq!(s.resume(last(), None, &[Value::Int(5)]).unwrap().0, TATU_WAIT);
    assert_eq!(s.resume(last(), Some("went away"), &[]).unwrap().0, TATU_WAIT);
    assert_eq!(s.resume(last(), None, &[Value::Int(1)]).unwrap().0, TATU_WAIT);
    let (status, values) = s.resume(last(), None, &[]).unwrap();
    assert_eq!((status, values), (TATU_OK, vec![Value::text("end"), Value::Int(4)]));
    assert_eq!(
        *h.calls.borrow(),
        ["show(first, Bool(true), 7, b)", "show(second, 5)", "show(third, Bool(false), went away)", "show(loop, 1)"]
    );
    // Errors in a thread have a position. A plain yield is an error, because no code would resume the thread.
    let s = load(h, "function sysCall_thread()\n wait()\n error 'late' end");
    s.init().unwrap();
    s.callback("thread", &[]).unwrap();
    let e = s.resume(last(), None, &[]).unwrap_err();
    assert_eq!((e.text.as_str(), e.line), ("late", 3), "{e:?}");
    assert!(e.traceback.contains("sysCall_thread"), "{e:?}");
    let s = load(h, "function sysCall_thread()\n wait() end");
    s.init().unwrap();
    s.callback("thread", &[]).unwrap();
    let e = s.resume(last(), Some("no signal"), &[]).unwrap_err();
    assert_eq!((e.code, e.text.as_str(), e.line), (TATU_ERR_MISSING, "no signal", 2));
    let s = load(h, "function sysCall_thread() coroutine.yield(1, 2) end");
    s.init().unwrap();
    assert_eq!(s.callback("thread", &[]).unwrap_err().code, TATU_ERR_SCRIPT);
}

#[test]
fn coroutine_of_a_script_waits_and_resumes() {
    let h = host();
    let s = load(
        h,
        "local co
        function sysCall_init() co = coroutine.create(function(x) local a, b = wait() local c = wait() return a, b, c end) end
        function sysCall_actuation() return coroutine.resume(co, 1) end",
    );
    s.init().unwrap();
    let act = || s.callback("actuation", &[]).unwrap().1;
    let last = || *h.tokens.borrow().last().unwrap();
    assert_eq!(act(), [Value::Bool(true)]);
    assert_eq!(act(), [Value::Bool(true)]);
    assert_eq!(h.tokens.borrow().len(), 1);
    assert_eq!(s.resume(last(), None, &[Value::Int(3), Value::Nil]).unwrap().0, TATU_OK);
    assert_eq!(act(), [Value::Bool(true)]);
    assert_eq!(h.tokens.borrow().len(), 2);
    s.resume(last(), None, &[Value::Int(9)]).unwrap();
    assert_eq!(act(), [Value::Bool(true), Value::Int(3), Value::Nil, Value::Int(9)]);
}

#[test]
fn old_threaded_script_runs_as_a_coroutine() {
    let h = host();
    let s = load(h, "if sim_call_type==sim_childscriptcall_threaded then show('a') wait() show('b') end");
    s.init().unwrap();
    assert_eq!(s.callback("thread", &[]).unwrap().0, TATU_WAIT);
    let token = *h.tokens.borrow().last().unwrap();
    assert_eq!(s.resume(token, None, &[]).unwrap().0, TATU_OK);
    assert_eq!(*h.calls.borrow(), ["show(a)", "show(b)"]);
}

#[test]
#[cfg_attr(no_shared, ignore = "needs ../shared, data that is not part of the repository")]
fn scripts_of_the_course_run() {
    let seeds = concat!(env!("CARGO_MANIFEST_DIR"), "/../../../../shared/seeds/scripts");
    let entries = std::fs::read_dir(seeds).unwrap();
    let dir = std::env::temp_dir().join(format!("tatu-lua-seeds-{}", std::process::id()));
    std::fs::create_dir_all(&dir).unwrap();
    let mut names: Vec<_> = entries.map(|e| e.unwrap().path()).collect();
    names.sort();
    for path in names {
        let h = host();
        *h.folder.borrow_mut() = dir.display().to_string();
        let s = h.script(1);
        let text = std::fs::read_to_string(&path).unwrap();
        assert_eq!(s.load(&text, &path.display().to_string(), "").unwrap(), "3.2");
        s.init().unwrap();
        // The script must have exactly the callbacks for which it has a branch.
        let has = |callback: &&str| {
            let there = s.find(TATU_FIND_CALLBACK, callback) != 0;
            let said = text.contains(&format!("sim_childscriptcall_{callback}"));
            // Some scripts have an empty branch for the cleanup.
            assert!(there == said || said && *callback == "cleanup", "{path:?}: {callback}");
            there
        };
        for _ in 0..3 {
            for callback in ["actuation", "sensing"].iter().filter(|c| has(c)) {
                s.callback(callback, &[]).unwrap();
            }
        }
        if has(&"cleanup") {
            s.callback("cleanup", &[]).unwrap();
        }
        let calls = h.calls.borrow();
        assert!(calls.len() > 4, "{path:?}: {calls:?}");
        if path.ends_with("manta_keyboard_statusbar.lua") {
            assert!(calls.contains(&"simAddStatusbarMessage(Tecla: 2007)".to_owned()), "{calls:?}");
        }
        if path.ends_with("pioneer_console.lua") {
            assert!(calls.contains(&"simAuxiliaryConsolePrint(11, 16)".to_owned()));
            assert!(calls.contains(&"simAuxiliaryConsolePrint(11, 0.3000)".to_owned()));
        }
        if path.ends_with("pioneer_braitenberg.lua") {
            assert!(calls.contains(&"simGetObjectHandle(Pioneer_p3dx_ultrasonicSensor16)".to_owned()));
        }
    }
    let log = std::fs::read_to_string(dir.join("usensors-log.log")).unwrap();
    assert_eq!(log.lines().count(), 6);
    assert!(std::fs::read_to_string(dir.join("dados-sensor.log")).unwrap().starts_with("(-90.0000;0.3000,) "));
    std::fs::remove_dir_all(dir).unwrap();
}
