//! Tests that the output is the same in every process.
#![allow(missing_docs)]

mod common;
use common::*;

const TEXT: &str = "
function init()
    local keys = {}
    for i = 1, 40 do
        local co = coroutine.create(function() end)
        keys[#keys + 1] = {}
        keys[#keys + 1] = function() return i end
        keys[#keys + 1] = co
        keys[#keys + 1] = 'key' .. i
        keys[#keys + 1] = i * 0.37
        keys[#keys + 1] = io.open('none') or io.stdout
    end
    for _, library in ipairs {_G, string, table, math, coroutine, os, io, utf8, debug, getmetatable('')} do
        local names = {}
        for name in pairs(library) do names[#names + 1] = name end
        print(table.concat(names, ' '))
        for _, f in pairs(library) do if type(f) == 'function' then keys[#keys + 1] = f end end
    end
    keys[#keys + 1] = (pairs {})
    keys[#keys + 1] = (ipairs {})
    keys[#keys + 1] = ('x'):gmatch '.'
    keys[#keys + 1] = echo
    keys[#keys + 1] = robot.echo
    local t, index = {}, {}
    for i, k in ipairs(keys) do t[k] = i end
    local order = {}
    for k, i in pairs(t) do order[#order + 1] = i end
    print(table.concat(order, ' '))
    for k in pairs(t) do print(k) end
    for i = 1, 5 do print(math.random(), math.random(100)) end
    math.randomseed() print(math.random(1000))
    math.randomseed(7) print(math.random(1000))
    print(os.time(), os.clock(), os.date(), collectgarbage 'count')
    local list = {}
    for i = 1, 3000 do list[i] = {i % 3, i} end
    for i = 1, 1500 do list[i][1] = 0 end
    table.sort(list, function(a, b) return a[1] < b[1] end)
    local s = 0
    for i, v in ipairs(list) do s = (s * 31 + v[2]) % 1000003 end
    print(s)
    -- Blocks of many sizes are freed and reused; later allocations must get the same addresses in every run.
    local held = {}
    for i = 1, 20000 do
        held[i % 97] = ('x'):rep(i % 700) .. i
        if i % 5 == 0 then held[i % 13] = {i, {}} end
    end
    local late = {}
    for i = 1, 200 do late[{}] = i late[function() return late end] = -i end
    local order = {}
    for _, i in pairs(late) do order[#order + 1] = i end
    print(table.concat(order, ' '))
    print(pcall(error, {}))
    print(string.format('%s %p %s', {}, {}, print))
    print(debug.traceback('x'))
end";

fn run() -> Vec<String> {
    let h = TestHost::new();
    h.command("echo", |_, _| 0);
    h.command("robot.echo", |_, _| 0);
    // Earlier work of the process must not affect the output.
    let other = h.load("x = {} for i = 1, 1000 do x[i] = {} end");
    other.init().unwrap();
    let s = h.script(3);
    s.load(TEXT, "t.lua", "").unwrap();
    s.init().unwrap();
    h.lines()
}

#[test]
#[cfg_attr(not(unix), ignore = "needs reserved address space, which this system lacks")]
fn two_processes_say_the_same() {
    if std::env::var_os("TATU_LUA_CHILD").is_some() {
        let _noise: Vec<_> = (0..std::process::id() % 100).map(|i| vec![0u8; i as usize * 999]).collect();
        println!("BEGIN\n{}\nEND", run().join("\n"));
        return;
    }
    let child = || {
        let out = std::process::Command::new(std::env::current_exe().unwrap())
            .args(["two_processes_say_the_same", "--exact", "--nocapture"])
            .env("TATU_LUA_CHILD", "1")
            .output()
            .unwrap();
        let text = String::from_utf8_lossy(&out.stdout).into_owned();
        assert!(out.status.success(), "{text}\n{}", String::from_utf8_lossy(&out.stderr));
        text.split("BEGIN\n").nth(1).unwrap().split("\nEND").next().unwrap().to_owned()
    };
    let first = child();
    assert!(first.lines().count() > 300, "{first}");
    for _ in 0..3 {
        for (a, b) in first.lines().zip(child().lines()) {
            assert_eq!(a, b);
        }
    }
}
