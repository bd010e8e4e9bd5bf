//! Scripts in Lua that call the commands of the plugin under test.

use std::fmt::Write;

use tatu_core::plugins::{CommandEntry, ParameterSpec};
use tatu_plugin_api::{abi::*, safe::Value};

use super::{stage, subject::TestedPlugin};

/// Maximum number of calls to one command in the test `arguments`.
const MAX_CALLS: usize = 160;

/// Returns a script that calls each command twice per step with ordinary arguments, once without those that may be
/// omitted, and reports the results.
pub fn ordinary_script(subject: &TestedPlugin) -> String {
    let mut body = String::new();
    for c in subject.own_commands() {
        let all = valid_arguments(c);
        let needed = c.params.iter().rposition(|p| p.flags & TATU_PARAM_OPTIONAL == 0).map_or(0, |last| last + 1);
        for args in [&all[..], &all[..needed.min(all.len())]] {
            let _ = writeln!(body, "    try({}, 'ordinary', {})", quoted(c.name().as_bytes()), args.join(", "));
        }
    }
    body = body.replace(", )", ")");
    format!("{LUA_HELPERS}\nfunction sysCall_actuation()\n{body}end\n")
}

/// Returns a script like [`ordinary_script`] that calls the commands in reverse order from step `turn` on, so that those
/// which read come before those which write: what a snapshot has lost would be written again otherwise.
pub fn turning_script(subject: &TestedPlugin, turn: usize) -> String {
    let call = |c: &CommandEntry| {
        let args = valid_arguments(c).join(", ");
        format!("try({}, 'ordinary', {args})\n", quoted(c.name().as_bytes())).replace(", )", ")")
    };
    let mut all: Vec<&CommandEntry> = subject.own_commands().collect();
    let forward: String = all.iter().map(|c| call(c).repeat(2)).collect();
    all.reverse();
    // Commands with fewer parameters are more likely to read.
    all.sort_by_key(|c| c.params.len());
    let backward: String = all.iter().map(|c| call(c)).collect();
    format!(
        "{LUA_HELPERS}\nlocal steps = 0\nfunction sysCall_actuation()\n  steps = steps + 1\n  if steps >= {turn} then\n\
         {backward}  else\n{forward}  end\nend\n"
    )
}

/// Returns the script of [`ordinary_script`] with an additional thread, which calls each command with arguments that
/// make counting or waiting commands wait.
pub fn waiting_script(subject: &TestedPlugin) -> String {
    let mut body = String::new();
    for c in subject.own_commands() {
        let number = |p: &ParameterSpec| {
            let free = p.fallback == Value::Nil && p.lowest.is_infinite() && p.flags & TATU_PARAM_ANY == 0;
            if free && matches!(p.kind, TATU_I64 | TATU_F64) { WAIT_ARGUMENT.to_owned() } else { ordinary_value(p) }
        };
        let args: Vec<String> = c.params.iter().filter(|p| p.flags & TATU_PARAM_REST == 0).map(number).collect();
        let _ = writeln!(body, "    try({}, 'waits', {})", quoted(c.name().as_bytes()), args.join(", "));
    }
    format!("{}\nfunction sysCall_thread()\n{}end\n", ordinary_script(subject), body.replace(", )", ")"))
}

/// An argument that makes a command that counts calls, or waits for this many seconds, wait for several steps.
const WAIT_ARGUMENT: &str = "7";

/// Returns a script that calls a command `times` times with ordinary arguments.
pub fn single_command_script(c: &CommandEntry, times: usize) -> String {
    let args = valid_arguments(c).join(", ");
    let call = format!("pcall(f, {args})").replace(", )", ")");
    let name = quoted(c.name().as_bytes());
    format!("{LUA_HELPERS}\nlocal f = find({name})\nfor _ = 1, f and {times} or 0 do {call} end\n")
}

/// Returns calls to a command as lines of Lua, with valid arguments, with arguments omitted or added, and with each
/// argument replaced by other values.
pub fn calls(c: &CommandEntry) -> Vec<String> {
    let name = quoted(c.name().as_bytes());
    let good = valid_arguments(c);
    let call = |args: &[String]| match args {
        [] => format!("try({name}, 'bad')"),
        args => format!("try({name}, 'bad', {})", args.join(", ")),
    };
    let mut out = vec![call(&good)];
    // Empty tables, and tables with elements of other types, which pass the host's checks and reach the plugin's code.
    for table in ["{{1, 2}, {3.5, 4}}", "{'a', 'b'}", "{}"] {
        let other = |(g, p): (&String, &ParameterSpec)| match p.kind {
            TATU_LIST | TATU_MAP | TATU_F64S => table.to_owned(),
            _ => g.clone(),
        };
        let with: Vec<String> = good.iter().zip(&c.params).map(other).collect();
        if with != good {
            out.extend((0..=with.len()).rev().map(|n| call(&with[..n])));
        }
    }
    // Pass too few and too many arguments.
    out.extend((0..good.len()).rev().map(|n| call(&good[..n])));
    out.push(call(&[good.clone(), vec!["1".to_owned(), "'x'".to_owned()]].concat()));
    for i in 0..good.len() {
        for other in other_values(&c.params[i]) {
            let mut args = good.clone();
            args[i] = other;
            out.push(call(&args));
        }
    }
    // The command must still work after the invalid calls.
    out.truncate(MAX_CALLS);
    out.push(call(&good));
    out
}

/// Returns ordinary arguments of a command as Lua expressions, with none for a last parameter that accepts any number
/// of arguments.
fn valid_arguments(c: &CommandEntry) -> Vec<String> {
    c.params.iter().filter(|p| p.flags & TATU_PARAM_REST == 0).map(ordinary_value).collect()
}

fn ordinary_value(p: &ParameterSpec) -> String {
    if p.flags & TATU_PARAM_ANY != 0 {
        return "'text'".into();
    }
    if let Some(value) = stage::valid_values(p).first() {
        return lua_expression(value);
    }
    match p.kind {
        TATU_OBJECT => "body".into(),
        TATU_FUNC => "answer".into(),
        TATU_LIST => "{'text', 1, {2, 3}}".into(),
        TATU_MAP if p.keys.is_empty() => "{text = 'text', number = 1.5}".into(),
        TATU_MAP => {
            let keys = p.keys.iter().map(|k| format!("[{}] = {}", quoted(k.key.as_bytes()), ordinary_value(k)));
            format!("{{{}}}", keys.collect::<Vec<_>>().join(", "))
        }
        TATU_BYTES => "'bytes\\0\\255'".into(),
        _ => "1".into(),
    }
}

/// Returns further valid and invalid values for a parameter, as Lua expressions.
fn other_values(p: &ParameterSpec) -> Vec<String> {
    let mut out: Vec<String> = stage::valid_values(p).iter().skip(1).map(lua_expression).collect();
    out.extend(LUA_ODD_VALUES.iter().map(|s| (*s).to_owned()));
    if p.flags & TATU_PARAM_ANY == 0 && p.kind == TATU_F64S && p.count > 0 {
        out.insert(0, format!("{{{}}}", vec!["0/0"; p.count as usize].join(", ")));
    }
    let first: &[&str] = match p.kind {
        TATU_TEXT | TATU_BYTES => LUA_TEXTS,
        TATU_F64S | TATU_LIST | TATU_MAP => LUA_TABLES,
        TATU_I64 | TATU_OBJECT => LUA_OBJECTS,
        TATU_FUNC => LUA_FUNCTIONS,
        _ => LUA_NUMBERS,
    };
    first.iter().map(|s| (*s).to_owned()).chain(out).collect()
}

const LUA_TEXTS: &[&str] =
    &["''", "'12'", "'1.5e3'", "'\\255\\254'", "'a\\0b'", "'/body'", "'a=b,c'", "'{\"a\": [1]}'", "('x'):rep(70000)"];
const LUA_TABLES: &[&str] = &[
    "{}",
    "{1}",
    "{1, 2}",
    "{-1e300, 1e300, 0/0}",
    "{1/0, -1/0}",
    "{'a', 'b'}",
    "{a = 1}",
    "{[1] = 1, [3] = 3}",
    "many",
    "deep",
];
const LUA_OBJECTS: &[&str] =
    &["body", "eye", "hinge", "0", "-1", "1048575", "math.maxinteger", "math.mininteger", "2^53", "0.5"];
const LUA_NUMBERS: &[&str] =
    &["0", "-1", "0/0", "1/0", "-1/0", "1e300", "-1e-300", "math.maxinteger", "math.mininteger"];
const LUA_FUNCTIONS: &[&str] =
    &["function() error('refused') end", "function(...) return ... end", "function() return {}, nil, 'x' end"];
const LUA_ODD_VALUES: &[&str] =
    &["nil", "true", "0", "-1.5", "0/0", "''", "'text'", "{}", "{1, 2, 3}", "{a = {b = {}}}", "answer"];

fn lua_expression(value: &Value) -> String {
    match value {
        Value::Nil => "nil".into(),
        Value::Bool(b) => b.to_string(),
        Value::Int(i) => i.to_string(),
        Value::Float(x) => number(*x),
        Value::Text(t) | Value::Bytes(t) => quoted(t),
        Value::Floats(all) => format!("{{{}}}", all.iter().map(|x| number(*x)).collect::<Vec<_>>().join(", ")),
        Value::Ints(all) => format!("{{{}}}", all.iter().map(i64::to_string).collect::<Vec<_>>().join(", ")),
        Value::List(all) => format!("{{{}}}", all.iter().map(lua_expression).collect::<Vec<_>>().join(", ")),
        Value::Map(all) => {
            let pairs = all.iter().map(|(k, v)| format!("[{}] = {}", lua_expression(k), lua_expression(v)));
            format!("{{{}}}", pairs.collect::<Vec<_>>().join(", "))
        }
        _ => "nil".into(),
    }
}

fn number(x: f64) -> String {
    if x.is_finite() {
        format!("{x:?}")
    } else if x.is_nan() {
        "0/0".into()
    } else {
        format!("{}1/0", if x < 0.0 { "-" } else { "" })
    }
}

/// Returns a Lua string literal that represents every byte of a text.
pub fn quoted(text: &[u8]) -> String {
    let mut out = String::from("'");
    for b in text {
        match b {
            b'\'' | b'\\' => {
                out.push('\\');
                out.push(char::from(*b));
            }
            0x20..=0x7e => out.push(char::from(*b)),
            _ => {
                let _ = write!(out, "\\x{b:02x}");
            }
        }
    }
    out + "'"
}

/// Helper functions at the beginning of all scripts: look up objects, call without raising errors, format results.
pub const LUA_HELPERS: &str = r"
-- Commands may copy this script; without this check, each copy would create further copies.
if sim.getInt32Signal('tatu.check') then return end
sim.setInt32Signal('tatu.check', 1)
local body, eye, hinge = sim.getObject('/body'), sim.getObject('/eye'), sim.getObject('/hinge')
local many, deep = {}, {}
for i = 1, 2000 do many[i] = i * 0.5 end
do local d = deep for i = 1, 40 do d.next = {} d = d.next end end
local function answer(...) return 1, 'two', {3} end

local function shown(v, depth)
    if math.type(v) == 'float' then return string.format('%a', v) end
    if type(v) == 'string' then return string.format('%q', #v > 200 and v:sub(1, 200) or v) end
    if type(v) ~= 'table' then return type(v) == 'function' and 'function' or tostring(v) end
    if depth > 6 then return '...' end
    local keys = {}
    for k in pairs(v) do keys[#keys + 1] = k end
    table.sort(keys, function(a, b) return tostring(a) < tostring(b) end)
    for i, k in ipairs(keys) do keys[i] = shown(k, depth + 1) .. ' = ' .. shown(v[k], depth + 1) end
    return '{' .. table.concat(keys, ', ') .. '}'
end

local function put(text) print('@check ' .. text:gsub('[\r\n]', ' ')) end

function find(name)
    local at = _G
    for part in name:gmatch('[^.]+') do at = type(at) == 'table' and at[part] or nil end
    return at
end

function try(name, label, ...)
    local f = find(name)
    if not f then return end
    local got = table.pack(pcall(f, ...))
    local out = {}
    for i = 2, math.min(got.n, 20) do out[#out + 1] = shown(got[i], 0) end
    put(name .. ' ' .. (got[1] and 'gives ' or 'fails with ') .. table.concat(out, ', '))
end

-- The global variables of an example: those of all scripts, and some objects.
function objects()
    local known = {body = body, shape = body, object = body, handle = body, joint = hinge, sensor = eye}
    return setmetatable(known, {__index = _G})
end

function report(f, why)
    if not f then return put('compile: ' .. tostring(why)) end
    local ok, why = pcall(f)
    if not ok then put('raise: ' .. tostring(why)) end
end
";
