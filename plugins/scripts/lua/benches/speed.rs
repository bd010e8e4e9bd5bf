//! Benchmarks of calls, states and library functions: `cargo bench -p tatu-scripts-lua`.
#![allow(missing_docs)]

#[path = "../tests/common/mod.rs"]
mod common;
use std::time::Instant;

use common::*;
use tatu_plugin_api::{abi::*, safe::Value};

fn read(_: &TestHost, frame: &mut tatu_call) -> tatu_status {
    let x = arg(frame, 0).as_i64().unwrap_or(0);
    ret(frame, num(x as f64 * 0.5));
    TATU_OK
}
fn table(_: &TestHost, frame: &mut tatu_call) -> tatu_status {
    static POINT: [f64; 3] = [1.0, 2.0, 3.0];
    let mut v = num(0.0);
    v.tag = TATU_F64S;
    v.u.s = tatu_span_t { ptr: POINT.as_ptr().cast(), len: 3 };
    ret(frame, v);
    TATU_OK
}
fn return_nothing(_: &TestHost, _: &mut tatu_call) -> tatu_status {
    TATU_OK
}

fn main() {
    let h = TestHost::new();
    h.command("read", read);
    h.command("robot.read", read);
    h.command("point", table);
    h.command("nothing", return_nothing);
    let s = h.load(
        "local n = 2000000
         function empty() for i = 1, n do end end
         local function g(i) return i end
         function lua() for i = 1, n do g(i) end end
         function noop() for i = 1, n do nothing() end end
         function global() for i = 1, n do read(7) end end
         local l = read
         function localized() for i = 1, n do l(7) end end
         function dotted() for i = 1, n do robot.read(7) end end
         function get_point() for i = 1, n do point() end end
         local t = {1.5, 2.5, 3.5}
         function set_point() for i = 1, n do nothing(t) end end
         function text() for i = 1, n do nothing('some text') end end
         local line = 'sensor_12 = 3.25'
         function pattern() for i = 1, n do line:match('^(%w+_%d+)%s*=%s*(.*)$') end end
         function format() for i = 1, n do string.format('%.4f %d', 0.5, i) end end
         function callback() end",
    );
    s.budget.set((u64::MAX, 0));
    s.init().unwrap();
    for name in
        ["empty", "lua", "noop", "global", "localized", "dotted", "get_point", "set_point", "text", "pattern", "format"]
    {
        let mut best = f64::MAX;
        for _ in 0..5 {
            let start = Instant::now();
            s.function(name, &[]).unwrap();
            best = best.min(start.elapsed().as_secs_f64() / 2e6 * 1e9);
        }
        println!("{name:12} {best:6.1} ns");
    }
    let id = s.find(TATU_FIND_FUNCTION, "callback");
    let start = Instant::now();
    for _ in 0..200_000 {
        s.call_id(id, &[Value::Int(1)]).unwrap();
    }
    println!("call in      {:6.1} ns", start.elapsed().as_secs_f64() / 2e5 * 1e9);
    let start = Instant::now();
    let states: Vec<_> = (0..200).map(|i| h.script(i)).collect();
    println!("new state    {:6.1} us", start.elapsed().as_secs_f64() / 200.0 * 1e6);
    if let Ok(status) = std::fs::read_to_string("/proc/self/statm") {
        let pages = |s: &str| s.split(' ').nth(1).and_then(|n| n.parse::<f64>().ok()).unwrap_or(0.0);
        let before = pages(&status);
        let more: Vec<_> = (0..1000).map(|i| h.script(i)).collect();
        for s in &more {
            s.load("function init() end", "t.lua", "").unwrap();
            s.init().unwrap();
        }
        let after = pages(&std::fs::read_to_string("/proc/self/statm").unwrap());
        println!("memory       {:6.1} KiB per state", (after - before) * 4.0 / 1000.0);
    }
    let start = Instant::now();
    drop(states);
    println!("end of one   {:6.1} us", start.elapsed().as_secs_f64() / 200.0 * 1e6);
}
