//! Tests of sockets in scripts: the behaviour that users of LuaSocket expect, permissions, and replays without the
//! peer.

use std::{
    io::{Read, Write},
    net::TcpListener,
    process::Command,
    time::Duration,
};

use serde_json::Value;

use crate::{kit::served_scene::ServedScene, kit::*};

/// Functions for test scripts, such as `is`, which compares the results of a call, including nil.
const SCRIPT_PREAMBLE: &str = r#"
local function told(...)
    local out, t = {}, table.pack(...)
    for i = 1, t.n do
        local v = t[i]
        out[i] = type(v) == 'string' and string.format('%q', v):gsub('\n', 'n') or math.type(v) and string.format('%g', v) or tostring(v)
    end
    return table.concat(out, ' ')
end
function is(expected, ...)
    local found = told(...)
    print(found)
    if found ~= expected then error('expected ' .. expected .. '; found ' .. found, 2) end
end
local function pair(socket)
    local server = assert(socket.bind('127.0.0.1', 0))
    local c = assert(socket.connect(server:getsockname()))
    local a = assert(server:accept())
    a:settimeout(0.05)
    c:settimeout(0.05)
    local function send(data) c:send(data) socket.sleep(0.02) end
    return a, c, send, server
end
"#;

/// Creates a scene with a script that runs once, in `init`.
fn scene(script: &str) -> TestFolder {
    let place = TestFolder::new();
    place.write(
        "script.lua",
        &format!("{SCRIPT_PREAMBLE}\nfunction sysCall_init()\nlocal socket = require 'socket'\n{script}\nend\n"),
    );
    place
        .write("scene.toml", "format = 1\n[[object]]\nkind = \"dummy\"\nalias = \"talker\"\nscript = \"script.lua\"\n");
    place
}

const ALLOW_NET: [&str; 2] = ["--allow", "net=127.0.0.1:*"];

/// Runs a scene with sockets, and replays its log without sockets. Both results must be equal.
#[track_caller]
fn twice(place: &TestFolder, more: &[&str]) -> Value {
    let args = [&["--steps", "3", "--log", "run.log", "--trace", "one.jsonl"][..], &ALLOW_NET, more].concat();
    let done = place.run(&args).good().json();
    let again = place.tatu(&["run", "--replay", "run.log", "--json", "--trace", "two.jsonl"]).good().json();
    assert_eq!(done["hash"], again["hash"]);
    assert_eq!(place.read("one.jsonl"), place.read("two.jsonl"));
    done
}

#[track_caller]
fn check_script(script: &str) {
    twice(&scene(script), &[]);
}

#[test]
fn receive_patterns_return_lines_bytes_and_the_rest() {
    check_script(
        r#"
        local a, c, send = pair(socket)
        send("ab\rc\r\n\nxyz")
        is('"abc" nil nil', a:receive())
        is('"" nil nil', a:receive '*l')
        is('nil "timeout" "xyz"', a:receive '*line')
        is('nil "timeout" ""', a:receive '*l')
        send("w\n")
        is('"xyzw" nil nil', a:receive('*l', 'xyz'))

        send('0123456789')
        is('"0123" nil nil', a:receive(4))
        is('true', a:dirty())
        is('"" nil nil', a:receive(0))
        is('nil "timeout" "456789"', a:receive('20'))
        is('nil "timeout" ""', a:receive(0))

        is('5 nil nil', c:send('hello', 2))
        is('3 nil nil', c:send('hello', 2, 3))
        is('0 nil nil', c:send(''))
        is('6 nil nil', c:send('hello', 7))
        is('2 nil nil', c:send('hello', -4, -4))
        is('nil "timeout" "elloele"', a:receive '*a')
        c:send('12')
        is('"a12" nil nil', a:receive(3, 'a'))
        is('"abcd" nil nil', a:receive(3, 'abcd'))
        local a, c, send = pair(socket)
        send('hello')
        a:receive(3)
        is('3 5', (a:getstats()), (select(2, c:getstats())))

        c:send('tail')
        is('1', c:close())
        is('1', c:close())
        is('"lotail" nil nil', a:receive '*a')
        is('nil "closed" ""', a:receive '*a')
        is('nil "closed" ""', a:receive(1))
        is('nil "closed" ""', c:receive())
        is('nil "closed" 0', c:send('x'))
        "#,
    );
}

#[test]
fn ends_refusals_and_taken_ports_have_the_words_of_luasocket() {
    check_script(
        r#"
        local a, c, send = pair(socket)
        send('12345')
        c:close()
        is('nil "closed" "12345"', a:receive(8))
        is('1 nil nil', a:send 'x')
        socket.sleep(0.05)
        is('nil "closed" 0', a:send 'x')

        local a, c, send, server = pair(socket)
        local ip, port, family = server:getsockname()
        is('"127.0.0.1" true "inet"', ip, math.type(port) == 'integer', family)
        is('true', select(2, c:getpeername()) == port)
        is('nil "Transport endpoint is not connected"', server:getpeername())
        is('1', c:shutdown 'send')
        is('nil "closed" ""', a:receive())
        is('6 nil nil', a:send "still\n")
        is('"still" nil nil', c:receive())
        is('nil "closed" 0', c:send 'x')

        server:settimeout(0)
        is('nil "timeout"', server:accept())
        is('nil "address already in use"', socket.bind('127.0.0.1', port))
        is('1', server:close())
        is('nil "closed"', server:accept())
        local late = socket.tcp()
        is('nil "connection refused"', late:connect('127.0.0.1', port))
        is('"tcp{client}" nil "closed" ""', late.class, late:receive())
        is('nil "Bad file descriptor"', late:getsockname())
        is('nil "Bad file descriptor"', socket.tcp():listen(1))
        "#,
    );
}

#[test]
fn datagrams_are_truncated_and_have_a_sender() {
    check_script(
        r#"
        local u, v = socket.udp(), socket.udp()
        u:settimeout(0.05)
        is('1', u:setsockname('127.0.0.1', 0))
        local ip, port = u:getsockname()
        is('5', v:sendto('hello', ip, port))
        local _, sender = v:getsockname()
        local data, from, at = u:receivefrom()
        is('"hello" "127.0.0.1" true', data, from, at == sender)
        v:sendto('0123456789', ip, port)
        is('"0123"', u:receive(4))
        is('nil "timeout"', u:receive())
        is('nil "timeout"', u:receivefrom())
        is('1', v:setpeername(ip, port))
        is('"udp{connected}"', v.class)
        is('1', v:send 'x')
        is('"x"', u:receive())
        v:send ''
        is('""', u:receive())
        is('1', u:close())
        is('nil "refused"', u:sendto('x', ip, port))
        is('nil "closed"', u:receive())
        "#,
    );
}

#[test]
fn select_returns_readable_and_writable_sockets() {
    check_script(
        r#"
        local a, c, send, server = pair(socket)
        local r, w, e = socket.select({a}, {a}, 0)
        is('0 1 nil', #r, #w, e)
        send("l1\nl2\n")
        r, w, e = socket.select({server, a}, nil, 0)
        is('1 true 1 0 nil', #r, r[1] == a, r[a], #w, e)
        a:receive()
        r, w, e = socket.select({a}, nil, 5)
        is('1 nil', #r, e)
        a:receive()
        r, w, e = socket.select({a}, nil, 0)
        is('0 0 "timeout"', #r, #w, e)
        local before = socket.gettime()
        r, w, e = socket.select(nil, nil, 0.05)
        is('0 0 "timeout" true', #r, #w, e, socket.gettime() - before > 0.045)
        local late = socket.connect(server:getsockname())
        r = socket.select({server}, nil, 1)
        is('true true', r[1] == server, server:accept() ~= nil)
        is('"127.0.0.1" "127.0.0.1"', socket.dns.toip(socket.dns.gethostname()), select(2, socket.dns.toip('127.0.0.1')).ip[1])
        "#,
    );
}

#[test]
fn wrong_calls_raise_the_errors_of_luasocket() {
    check_script(
        r#"
        local a, c = pair(socket)
        local function fails(text, f, ...)
            local good, found = pcall(f, ...)
            if good or not tostring(found):find(text, 1, true) then error('expected ' .. text .. '; found ' .. tostring(found), 2) end
        end
        fails("bad argument #1 to 'receive' (invalid receive pattern)", function() a:receive('*n') end)
        fails("bad argument #1 to 'receive' (invalid receive pattern)", function() a:receive(-1) end)
        fails("bad argument #1 to 'send' (string expected, got nil)", function() a:send(nil) end)
        fails("bad argument #1 to 'settimeout' (number expected, got string)", function() a:settimeout('soon') end)
        fails("bad argument #1 to 'setoption' (unsupported option `foo')", function() a:setoption('foo', true) end)
        fails("bad argument #2 to 'setoption' (boolean expected, got number)", function() a:setoption('keepalive', 1) end)
        fails("calling 'receive' on bad self (tcp{client} expected)", function() socket.tcp():receive() end)
        fails("LuaSocket's tcp6 is not provided", socket.tcp6)
        fails("fields of LuaSocket objects cannot be set", function() a.mine = 1 end)
        fails("port expected", socket.connect, '127.0.0.1', 70000)
        fails("the module `socket.http` of the original is not available", require, 'socket.http')
        is('1', a:setoption('tcp-nodelay', true))
        is('true true', require 'socket.core' == socket, _G.socket == socket)
        is('nil', a.unknown)
        local guarded = socket.protect(function() return socket.try(nil, 'e') end)
        is('nil "e"', guarded())
        is('3 4', socket.skip(1, 2, 3, 4))
        local sink = socket.sink('close-when-done', c)
        sink('through a sink')
        sink(nil)
        local source = socket.source('until-closed', a)
        is('"through a sink" nil', source(), source())
        "#,
    );
}

#[test]
fn sockets_that_are_not_allowed_are_denied() {
    let place = scene(
        r#"
        is('nil "permission denied"', socket.connect('127.0.0.1', 9))
        is('nil "permission denied"', socket.bind('*', 9))
        is('nil "permission denied"', socket.udp():sendto('x', '127.0.0.1', 9))
        is('nil "permission denied"', socket.dns.toip('localhost'))
        is('true', socket.gettime() == socket.gettime())
        "#,
    );
    let done = place.run(&["--steps", "1"]).good();
    done.reports(&["a script was denied access to 127.0.0.1:9", "--allow net=127.0.0.1:9"]);
    let other = scene("is('nil \"permission denied\"', socket.connect('127.0.0.1', 9))");
    other.run(&["--steps", "1", "--allow", "net=127.0.0.1:8"]).good();
    other.run(&["--steps", "1", "--allow", "net=anywhere"]).refused(&["net=HOST:PORT", "net=127.0.0.1:*"]);
}

#[test]
fn a_scene_may_request_access_that_only_the_user_grants() {
    let place = scene("is('true', socket.bind('127.0.0.1', 0) ~= nil)");
    let text = place.read("scene.toml");
    place.write("scene.toml", &text.replace("[[object]]", "[permissions]\nnet = [\"127.0.0.1:*\"]\n[[object]]"));
    let done = place.run(&["--steps", "1"]);
    assert_eq!(done.code, 1);
    done.reports(&["its scripts request access outside the run", "--allow net=127.0.0.1:*"]);
    let granted = place.run(&[&["--steps", "1"][..], &ALLOW_NET].concat()).good();
    assert!(!granted.err.contains("--allow"), "{}", granted.err);
    place.write("scene.toml", &text.replace("[[object]]", "[permissions]\nnet = [7]\n[[object]]"));
    place.run(&[]).refused(&["E102", "HOST:PORT", "scene.toml:3"]);
    place.write("scene.toml", &text.replace("[[object]]", "[permissions]\nnett = true\n[[object]]"));
    place.run(&[]).refused(&["E101", "nett", "net"]);
}

/// Starts a thread with a server that answers `answers` lines with one number each, and then exits.
fn server(answers: u32) -> (u16, std::thread::JoinHandle<()>) {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let port = listener.local_addr().unwrap().port();
    let thread = std::thread::spawn(move || {
        let (mut stream, _) = listener.accept().unwrap();
        for i in 0..answers {
            let mut line = Vec::new();
            while !line.ends_with(b"\n") {
                let mut byte = [0];
                // The connection has ended, whether it was closed properly or not.
                if !matches!(stream.read(&mut byte), Ok(1)) {
                    return;
                }
                line.push(byte[0]);
            }
            if stream.write_all(format!("{}\n", f64::from(i) * 0.25).as_bytes()).is_err() {
                return;
            }
        }
    });
    (port, thread)
}

/// Creates a scene with a threaded script that requests the speed of a wheel from the server in every step, as scripts
/// of 2015 do.
fn driven(port: u16) -> TestFolder {
    let place = TestFolder::new();
    let script = format!(
        "simSetThreadSwitchTiming(200)\n\
         local wheel = simGetObjectHandle('Pioneer_p3dx_leftMotor')\n\
         require \"socket\"\n\
         while simGetSimulationState() ~= sim_simulation_advancing_abouttostop do\n\
           local client = socket.tcp()\n\
           simSetThreadIsFree(true)\n\
           local result = client:connect('127.0.0.1', {port})\n\
           simSetThreadIsFree(false)\n\
           if result == 1 then\n\
             while true do\n\
               client:send(simGetSimulationTime() .. '\\n')\n\
               local line = client:receive()\n\
               if not line then break end\n\
               simSetJointTargetVelocity(wheel, tonumber(line))\n\
               simSwitchThread()\n\
             end\n\
           end\n\
           client:close()\n\
           print('nobody')\n\
         end\n"
    );
    place.write("drive.lua", &script);
    place.write(
        "scene.toml",
        "format = 1\n[[object]]\nkind = \"shape\"\nalias = \"floor\"\nprimitive = \"plane\"\nrespondable = true\n\
         [[model]]\nmodel = \"pioneer_p3dx\"\nscript = \"drive.lua\"\n",
    );
    place
}

#[test]
fn answers_of_a_server_are_replayed_without_it() {
    let (port, thread) = server(20);
    let place = driven(port);
    let args = [&["--steps", "40", "--log", "run.log", "--trace", "one.jsonl"][..], &ALLOW_NET].concat();
    let done = place.run(&args).good().json();
    thread.join().unwrap();
    // The server has exited, and the replay has no permissions.
    let again = place.tatu(&["run", "--replay", "run.log", "--json", "--trace", "two.jsonl"]).good().json();
    assert_eq!(done["hash"], again["hash"]);
    assert_eq!(place.read("one.jsonl"), place.read("two.jsonl"));
    assert!(place.read("run.log").contains("\"observed\":\"socket\""));
    // Without the server, which drives the robot, the result differs.
    let still = place.run(&["--steps", "40"]).good().json();
    assert_ne!(still["hash"], done["hash"]);
    // If the received data is missing in the log, an error is reported.
    let log = place.read("run.log");
    let cut = sealed_anew(&log, |line| line.replace("luasocket.receive", "luasocket.accept"));
    place.write("cut.log", &cut);
    let other = place.tatu(&["run", "--replay", "cut.log", "--json"]);
    assert_eq!(other.code, 1, "{}", other.err);
    other.reports(&["the recorded run made a different socket call here"]);
}

#[test]
fn a_restored_world_has_closed_sockets() {
    let (port, thread) = server(8);
    let place = driven(port);
    let args = [&["--steps", "6", "--snapshot-at", "0.2", "snap"][..], &ALLOW_NET].concat();
    place.run(&args).good();
    thread.join().unwrap();
    let done = place.run(&[&["--from", "snap", "--steps", "4"][..], &ALLOW_NET].concat()).good();
    assert!(done.err.contains("nobody"), "{}", done.err);
}

#[test]
fn an_endless_socket_wait_ends_with_the_run() {
    let place = TestFolder::new();
    place.write(
        "scene.toml",
        "format = 1\n[[object]]\nkind = \"dummy\"\nalias = \"waiter\"\nscript = { text = \"function sysCall_actuation() \
         require 'socket'.bind('127.0.0.1', 0):accept() end\" }\n",
    );
    let file = place.path().join("scene.toml");
    let more = [&ALLOW_NET[..], &["--watchdog", "1"]].concat();
    let mut served = ServedScene::with("jsonl", file.to_str().unwrap(), &more);
    served.connect().write_all(b"{\"id\":1,\"request\":\"start\"}\n").unwrap();
    // This is longer than the watchdog's limit for a call that does not return.
    std::thread::sleep(Duration::from_secs(3));
    assert!(served.is_there(), "the watchdog has ended a run that waits");
    assert!(served.interrupt(), "an interrupt does not end the wait");
}

/// Creates a scene with a script in the style of V-REP's BubbleRob tutorial, on a Pioneer: its thread starts a program
/// and queries it in every step.
fn bubblerob(port: u16) -> TestFolder {
    let place = TestFolder::new();
    let script = format!(
        r#"
simSetThreadSwitchTiming(200)
local left = simGetObjectHandle('Pioneer_p3dx_leftMotor')
local right = simGetObjectHandle('Pioneer_p3dx_rightMotor')
local nose = simGetObjectHandle('Pioneer_p3dx_ultrasonicSensor5')
local result = simLaunchExecutable('bubbleRobServer', {port}, 0)
if result == -1 then
    simDisplayDialog('Error', 'not started', sim_dlgstyle_ok, true, nil, {{0.8, 0, 0, 0, 0, 0}}, {{0.5, 0, 0, 1, 1, 1}})
end
while result ~= -1 and simGetSimulationState() ~= sim_simulation_advancing_abouttostop do
    local socket = require("socket")
    local client = socket.tcp()
    simSetThreadIsFree(true)
    local connected = client:connect('127.0.0.1', {port})
    simSetThreadIsFree(false)
    if connected == 1 then
        while simGetSimulationState() ~= sim_simulation_advancing_abouttostop do
            local seen, distance = simReadProximitySensor(nose)
            local data = simPackFloats({{seen > 0 and distance or 0, simGetSimulationTime()}})
            client:send(string.char(59, 57, math.mod(#data, 256), math.floor(#data / 256), 0, 0) .. data)
            local header = client:receive(6)
            local answer = header and client:receive(string.byte(header, 3) + 256 * string.byte(header, 4))
            if not answer then break end
            local speeds = simUnpackFloats(answer)
            print(speeds[1], speeds[2])
            simSetJointTargetVelocity(left, speeds[1])
            simSetJointTargetVelocity(right, speeds[2])
            simSwitchThread()
        end
    end
    client:close()
end
"#
    );
    place.write("green.lua", &script);
    place.write(
        "scene.toml",
        "format = 1\n[permissions]\nexec = true\nnet = [\"127.0.0.1:*\"]\n\
         [[object]]\nkind = \"shape\"\nalias = \"floor\"\nprimitive = \"plane\"\nrespondable = true\n\
         [[object]]\nkind = \"shape\"\nalias = \"box\"\nsize_m = [0.4, 0.4, 0.6]\nposition_m = [1.5, 0, 0.3]\nrespondable = true\n\
         [[model]]\nmodel = \"pioneer_p3dx\"\nscript = \"green.lua\"\n",
    );
    place
}

/// Returns a port that is not in use.
fn free_port() -> u16 {
    TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap().port()
}

#[track_caller]
fn drives_and_is_repeated(place: &TestFolder, allow: &str) -> RunOutput {
    let args = ["--seconds", "8", "--log", "run.log", "--trace", "one.jsonl", "--allow", allow];
    let done = place.run(&args).good();
    assert!(done.err.contains("7\t7"), "{}", done.err);
    assert!(done.err.contains("-3.5\t-1.75"), "the box was not detected: {}", done.err);
    let again = place.tatu(&["run", "--replay", "run.log", "--json", "--trace", "two.jsonl"]).good().json();
    assert_eq!(done.json()["hash"], again["hash"]);
    assert_eq!(place.read("one.jsonl"), place.read("two.jsonl"));
    done
}

#[test]
fn the_server_of_bubblerob_is_started_or_substituted() {
    let place = bubblerob(free_port());
    let refused = place.run(&["--seconds", "1"]).good();
    refused.reports(&["bubbleRobServer", "--allow exec", "--allow net=127.0.0.1:*"]);
    let built_in = drives_and_is_repeated(&place, "net=127.0.0.1:*");
    built_in.reports(&["bubbleRobServer does not exist; the built-in substitute listens"]);

    // A program of the user, which needs some time before it listens.
    let place = bubblerob(free_port());
    let server = "#!/usr/bin/env python3\nimport socket, struct, sys, time\ntime.sleep(0.3)\n\
                  s = socket.create_server(('127.0.0.1', int(sys.argv[1]))).accept()[0]\nend = -9\n\
                  while True:\n  d, t = struct.unpack('<6xff', s.recv(14, socket.MSG_WAITALL))\n  end = t + 1 if d else end\n\
                  \x20 s.sendall(struct.pack('<BBHHff', 59, 57, 8, 0, *((-3.5, -1.75) if t < end else (7, 7))))\n";
    place.write("bubbleRobServer", server);
    succeed(Command::new("chmod").arg("+x").arg(place.path().join("bubbleRobServer")));
    let own = drives_and_is_repeated(&place, "exec,net=127.0.0.1:*");
    assert!(!own.err.contains("built-in"), "{}", own.err);
}
