//! Tests of ZeroMQ sockets in scripts: two scripts of one scene, peers with the real library from PyPI, permissions,
//! replays without the peer, and snapshots.

use std::{
    io::Write,
    net::TcpListener,
    path::Path,
    process::{Child, Command, Stdio},
    time::Duration,
};

use crate::kit::{
    served_scene::{self, ServedScene},
    *,
};

/// Permissions for all sockets on this machine.
const ALLOW_LOCAL: [&str; 4] = ["--allow", "net=127.0.0.1:*", "--allow", "net=ipc:*"];

/// Creates a scene with one object per script.
fn scene(scripts: &[&str]) -> TestFolder {
    let folder = TestFolder::new();
    let mut text = "format = 1\n".to_owned();
    for (i, script) in scripts.iter().enumerate() {
        folder.write(&format!("script{i}.lua"), script);
        text += &format!("[[object]]\nkind = \"dummy\"\nalias = \"d{i}\"\nscript = \"script{i}.lua\"\n");
    }
    folder.write("scene.toml", &text);
    folder
}

/// Runs a scene with sockets, and replays its log without permission, without its files and without its peers. Returns
/// what the scripts have printed, which must be equal.
#[track_caller]
fn run_and_replay(folder: &TestFolder, steps: &str) -> String {
    let args = [&["--steps", steps, "--log", "run.log", "--trace", "one.jsonl"][..], &ALLOW_LOCAL].concat();
    let done = folder.run(&args).good();
    let again = folder.tatu(&["run", "--replay", "run.log", "--json", "--trace", "two.jsonl"]).good();
    assert_eq!(done.json()["hash"], again.json()["hash"]);
    assert_eq!(folder.read("one.jsonl"), folder.read("two.jsonl"));
    assert_eq!(done.err, again.err);
    done.err
}

/// Returns a port that is not in use.
fn free_port() -> u16 {
    TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap().port()
}

/// The client of CoppeliaSim's example, as a thread, and its server, as a coroutine that a callback resumes.
#[test]
fn thread_and_coroutine_of_one_scene_exchange_requests() {
    let port = free_port();
    let client = format!(
        "function sysCall_thread()\n\
           simZMQ = require 'simZMQ'\n\
           local context = simZMQ.ctx_new()\n\
           local requester = simZMQ.socket(context, simZMQ.REQ)\n\
           simZMQ.connect(requester, 'tcp://localhost:{port}')\n\
           for i = 1, 10 do\n\
             simZMQ.send(requester, 'Hello', 0)\n\
             local rc, data = simZMQ.recv(requester, 0)\n\
             print('answer', rc, data)\n\
             sim.setObjectPosition(sim.getObject('/d0'), {{0, 0, tonumber(data)}})\n\
           end\n\
           simZMQ.close(requester)\n\
           simZMQ.ctx_term(context)\n\
         end\n"
    );
    let server = format!(
        "function sysCall_init() corout = coroutine.create(coroutineMain) end\n\
         function sysCall_actuation()\n\
           if coroutine.status(corout) ~= 'dead' then\n\
             local ok, message = coroutine.resume(corout)\n\
             if message then error(debug.traceback(corout, message), 2) end\n\
           end\n\
         end\n\
         function coroutineMain()\n\
           context = simZMQ.ctx_new()\n\
           responder = simZMQ.socket(context, simZMQ.REP)\n\
           local rc = simZMQ.bind(responder, 'tcp://*:{port}')\n\
           if rc ~= 0 then error('failed bind') end\n\
           while true do\n\
             local rc, data = simZMQ.recv(responder, 0)\n\
             simZMQ.send(responder, string.format('%.2f', sim.getSimulationTime()), 0)\n\
           end\n\
         end\n\
         function sysCall_cleanup() simZMQ.close(responder) simZMQ.ctx_term(context) end\n"
    );
    let printed = run_and_replay(&scene(&[&client, &server]), "5000");
    // How much simulated time passes meanwhile depends on how long the sockets take.
    assert_eq!(printed.matches("answer\t").count(), 10, "{printed}");
}

#[test]
fn subscriber_of_one_scene_receives_matching_messages_by_a_file() {
    let publisher = "function sysCall_init()\n\
           publisher = simZMQ.socket(simZMQ.ctx_singleton(), simZMQ.PUB)\n\
           assert(simZMQ.bind(publisher, 'ipc://ENDPOINT') == 0)\n\
         end\n\
         function sysCall_actuation()\n\
           assert(simZMQ.send(publisher, 'other', 0) == 5)\n\
           simZMQ.send(publisher, 'pose', simZMQ.SNDMORE)\n\
           simZMQ.send(publisher, sim.packDoubleTable{1, 2, 3}, 0)\n\
         end\n";
    let subscriber = "function sysCall_init()\n\
           subscriber = simZMQ.socket(simZMQ.ctx_singleton(), simZMQ.SUB)\n\
           assert(simZMQ.setsockopt(subscriber, simZMQ.SUBSCRIBE, 'po') == 0)\n\
           assert(simZMQ.connect(subscriber, 'ipc://ENDPOINT') == 0)\n\
         end\n\
         function sysCall_sensing()\n\
           while simZMQ.poll({subscriber}, {simZMQ.POLLIN}, 0) > 0 do\n\
             local rc, topic = simZMQ.recv(subscriber, simZMQ.DONTWAIT)\n\
             assert(topic == 'pose' and select(2, simZMQ.getsockopt_int(subscriber, simZMQ.RCVMORE)) == 1)\n\
             local rc, data = simZMQ.recv(subscriber, simZMQ.DONTWAIT)\n\
             local numbers = sim.unpackDoubleTable(data)\n\
             assert(rc == 24 and numbers[3] == 3 and select(2, simZMQ.getsockopt_int(subscriber, simZMQ.RCVMORE)) == 0)\n\
             if not received then print('received') end\n\
             received = true\n\
           end\n\
           if not received then sim.wait(0) end\n\
         end\n";
    let folder = TestFolder::new();
    let endpoint = folder.path().join("feed").display().to_string();
    let scripts = [publisher, subscriber].map(|script| script.replace("ENDPOINT", &endpoint));
    let scene = scene(&[&scripts[0], &scripts[1]]);
    let printed = run_and_replay(&scene, "3000");
    assert_eq!(printed.matches("received").count(), 1, "{printed}");
    assert!(!Path::new(&endpoint).exists(), "the file of the socket remains");
}

/// Runs a script in `init`, and replays the run.
#[track_caller]
fn check_init(script: &str) {
    let text = format!(
        "local function is(expected, ...)\n\
           local out, t = {{}}, table.pack(...)\n\
           for i = 1, t.n do out[i] = tostring(t[i]) end\n\
           local found = table.concat(out, ' ')\n\
           if found ~= expected then error('expected ' .. expected .. '; found ' .. found, 2) end\n\
         end\n\
         function sysCall_init()\n\
           local zmq = require 'simZMQ'\n\
           local context = zmq.ctx_new()\n\
           local function pair(one, two, endpoint)\n\
             local a, b = zmq.socket(context, one), zmq.socket(context, two)\n\
             assert(zmq.bind(a, endpoint or 'tcp://*:*') == 0)\n\
             local rc, at = zmq.getsockopt(a, zmq.LAST_ENDPOINT, 256)\n\
             assert(zmq.connect(b, at) == 0)\n\
             return a, b, at\n\
           end\n\
           {script}\n\
           print('done')\n\
         end\n"
    );
    let printed = run_and_replay(&scene(&[&text]), "2");
    assert!(printed.contains("done"), "{printed}");
}

#[test]
fn failed_calls_return_minus_one_and_set_the_error() {
    check_init(
        r#"
        is('-1 88', zmq.send('nothing', 'x', 0), zmq.errnum())
        is('-1 nil', zmq.recv('nothing', 0))
        is('-1', zmq.close('nothing'))
        is('-1 14', zmq.ctx_term('nothing'), zmq.errnum())
        is(' 14', zmq.socket('nothing', zmq.REQ), zmq.errnum())
        is(' 22', zmq.socket(context, 99), zmq.errnum())
        local rep, req, at = pair(zmq.REP, zmq.REQ)
        is('-1 98', zmq.bind(zmq.socket(context, zmq.REP), at), zmq.errnum())
        is('-1 22', zmq.connect(req, 'nothing'), zmq.errnum())
        is('-1 93', zmq.connect(req, 'inproc://a'), zmq.errnum())
        is('-1 2', zmq.disconnect(req, 'tcp://127.0.0.1:1'), zmq.errnum())
        is('-1 nil', zmq.recv(rep, zmq.DONTWAIT))
        is('true Resource temporarily unavailable', zmq.errnum() == zmq.EAGAIN, zmq.strerror(zmq.errnum()))
        is('-1 true', zmq.send(rep, 'x', zmq.DONTWAIT), zmq.errnum() == zmq.EFSM)
        is('-1 nil', zmq.recv(req, zmq.DONTWAIT))
        is('true', zmq.errnum() == zmq.EFSM)
        is('-1 true', zmq.setsockopt(req, zmq.SUBSCRIBE, ''), zmq.errnum() == zmq.EINVAL)
        is('-1 true', zmq.proxy(rep, req, ''), zmq.errnum() == zmq.ENOTSUP)
        is('0 0', zmq.close(req), zmq.close(rep))
        is('-1 88', zmq.close(req), zmq.errnum())

        zmq.__raiseErrors(true)
        local ok, message = pcall(zmq.close, req)
        is('false true', ok, tostring(message):find('Socket operation on non-socket', 1, true) ~= nil)
        zmq.__raiseErrors(false)
        is('-1', zmq.close(req))
        "#,
    );
}

#[test]
fn options_limit_how_long_a_call_waits() {
    check_init(
        r#"
        local pull, push = pair(zmq.PULL, zmq.PUSH)
        is('0', zmq.setsockopt(pull, zmq.RCVTIMEO, sim.packInt32Table{30}))
        is('0 30', zmq.getsockopt_int(pull, zmq.RCVTIMEO))
        is('-1 nil', zmq.recv(pull, 0))
        is('true', zmq.errnum() == zmq.EAGAIN)
        is('0', (zmq.poll({pull}, {zmq.POLLIN}, 10)))
        is('4', zmq.send(push, 'data', 0))
        local rc, ready = zmq.poll({push, pull}, {zmq.POLLIN, zmq.POLLIN}, -1)
        is('1 0 1', rc, ready[1], ready[2])
        is('4 da', zmq.recv(pull, 0, 2))
        is('0', zmq.setsockopt(push, zmq.LINGER, 0))
        is('0 7', zmq.getsockopt_int(pull, zmq.TYPE))
        local idle = zmq.socket(context, zmq.PUSH)
        is('0', zmq.setsockopt(idle, zmq.SNDTIMEO, sim.packInt32Table{10}))
        is('-1 true', zmq.send(idle, 'x', 0), zmq.errnum() == zmq.EAGAIN)
        is('-1 22', zmq.setsockopt(idle, zmq.RCVTIMEO, 'abc'), zmq.errnum())
        "#,
    );
}

#[test]
fn message_objects_carry_parts_through_a_router() {
    check_init(
        r#"
        local router, dealer = pair(zmq.ROUTER, zmq.DEALER)
        zmq.close(dealer)
        dealer = zmq.socket(context, zmq.DEALER)
        is('0', zmq.setsockopt(dealer, zmq.IDENTITY, 'me'))
        local _, at = zmq.getsockopt(router, zmq.LAST_ENDPOINT, 256)
        is('0', zmq.connect(dealer, at))
        local m = zmq.msg_new()
        is('0 3', zmq.msg_init_size(m, 3), zmq.msg_size(m))
        is('3', zmq.msg_send(m, dealer, zmq.SNDMORE))
        is('1', zmq.send(dealer, '2', 0))
        is('2', zmq.msg_recv(m, router, 0))
        is('me 1', zmq.msg_data(m), zmq.msg_more(m))
        is('3', zmq.msg_recv(m, router, 0))
        is('true 1', zmq.msg_data(m) == '\0\0\0', zmq.msg_get(m, zmq.MORE))
        is('1', zmq.msg_recv(m, router, 0))
        is('2 0', zmq.msg_data(m), zmq.msg_more(m))
        local n = zmq.msg_new()
        is('0 2 0', zmq.msg_move(n, m), zmq.msg_data(n), zmq.msg_size(m))
        is('2 4', zmq.send(router, 'me', zmq.SNDMORE), zmq.send(router, 'back', 0))
        is('4 back', zmq.recv(dealer, 0))
        zmq.msg_destroy(m)
        is('nil 14', zmq.msg_data(m), zmq.errnum())
        "#,
    );
}

#[test]
fn sockets_without_permission_are_refused_with_help() {
    let script = |call: &str| {
        format!(
            "function sysCall_init() local s = simZMQ.socket(simZMQ.ctx_new(), simZMQ.REQ) print('socket', #s > 0) \
             {call} end"
        )
    };
    for (call, allow, expected) in [
        ("simZMQ.connect(s, 'tcp://localhost:5555')", "exec", "--allow net=127.0.0.1:5555"),
        ("simZMQ.bind(s, 'tcp://*:5555')", "net=127.0.0.1:1", "--allow net=127.0.0.1:5555"),
        ("simZMQ.bind(s, 'ipc:///run/never')", "net=127.0.0.1:*", "--allow net=ipc:*"),
        ("simZMQ.connect(s, 'tcp://10.0.0.1:5555')", "net=*:*", "is not an address of this machine"),
        ("simZMQ.bind(s, 'tcp://eth0:5555')", "net=*:*", "use tcp://127.0.0.1:PORT"),
    ] {
        let done = scene(&[&script(call)]).run(&["--steps", "1", "--allow", allow, "--log", "run.log"]);
        assert_eq!(done.code, 1, "{call}: {}", done.err);
        assert!(done.out.contains(expected), "{call}: {}", done.out);
        assert!(done.err.contains("socket\ttrue"), "{call}: {}", done.err);
    }
}

#[test]
fn log_with_a_different_call_is_refused() {
    let folder = scene(&[
        "function sysCall_init() s = simZMQ.socket(simZMQ.ctx_new(), simZMQ.PULL) simZMQ.bind(s, 'tcp://*:*') end\n\
         function sysCall_actuation() simZMQ.recv(s, simZMQ.DONTWAIT) end",
    ]);
    folder.run(&[&["--steps", "3", "--log", "run.log"][..], &ALLOW_LOCAL].concat()).good();
    let log = folder.read("run.log");
    assert!(log.contains("\"observed\":\"zmq\""), "{log}");
    folder.write("cut.log", &sealed_anew(&log, |line| line.replace("[\\\"simZMQ.recv", "[\\\"simZMQ.send")));
    let done = folder.tatu(&["run", "--replay", "cut.log", "--json"]);
    assert_eq!(done.code, 1, "{}", done.err);
    done.reports(&["the recorded run made a different call of simZMQ here"]);
}

#[test]
fn restored_world_has_closed_sockets() {
    let folder = scene(&[
        "function sysCall_init() s = simZMQ.socket(simZMQ.ctx_new(), simZMQ.PULL) simZMQ.bind(s, 'tcp://*:*') end\n\
         function sysCall_actuation() print('result', simZMQ.recv(s, simZMQ.DONTWAIT), simZMQ.errnum()) end",
    ]);
    let args = [&["--steps", "6", "--snapshot-at", "0.2", "snap"][..], &ALLOW_LOCAL].concat();
    let done = folder.run(&args).good();
    assert!(done.err.contains("result\t-1\t11"), "{}", done.err);
    let done = folder.run(&[&["--from", "snap", "--steps", "2"][..], &ALLOW_LOCAL].concat()).good();
    assert!(done.err.contains("result\t-1\t88"), "{}", done.err);
}

#[test]
fn endless_wait_for_a_message_ends_with_the_run() {
    let folder = scene(&["function sysCall_actuation() local s = simZMQ.socket(simZMQ.ctx_new(), simZMQ.PULL) \
         simZMQ.bind(s, 'tcp://*:*') simZMQ.recv(s, 0) end"]);
    let file = folder.path().join("scene.toml");
    let more = [&ALLOW_LOCAL[..], &["--watchdog", "1"]].concat();
    let mut served = ServedScene::with("jsonl", file.to_str().unwrap(), &more);
    served.connect().write_all(b"{\"id\":1,\"request\":\"start\"}\n").unwrap();
    // This is longer than the watchdog's limit for a call that does not return.
    std::thread::sleep(Duration::from_secs(3));
    assert!(served.is_there(), "the watchdog has ended a run that waits");
    assert!(served.interrupt(), "an interrupt does not end the wait");
}

/// Starts a program with the real library.
fn peer(program: &str, arguments: &[&str]) -> Child {
    let python = served_scene::python("pyzmq==27.1.0", "zmq");
    let program = format!(
        "import sys, zmq\n\
         context = zmq.Context()\n\
         def make(kind, endpoint, bind=False):\n\
         \x20 s = context.socket(kind)\n\
         \x20 s.rcvtimeo = s.sndtimeo = 30000\n\
         \x20 (s.bind if bind else s.connect)(endpoint)\n\
         \x20 return s\n\
         {program}\n\
         print('peer done')\n"
    );
    let mut command = Command::new(&python);
    command.args(["-c", &program]).args(arguments).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap()
}

/// Runs a scene whose script talks to a program, and replays it without the program.
#[track_caller]
fn with_peer(mut child: Child, script: &str) {
    let text = format!(
        "function sysCall_init()\n\
           local zmq, make = simZMQ\n\
           local context = zmq.ctx_new()\n\
           function make(kind, endpoint, bind)\n\
             local s = zmq.socket(context, kind)\n\
             local value = sim.packInt32Table{{30000}}\n\
             assert(zmq.setsockopt(s, zmq.RCVTIMEO, value) + zmq.setsockopt(s, zmq.SNDTIMEO, value) == 0)\n\
             assert((bind and zmq.bind or zmq.connect)(s, endpoint) == 0)\n\
             return s\n\
           end\n\
           local function receive(s)\n\
             local rc, data = zmq.recv(s, 0)\n\
             if rc == -1 then error(zmq.strerror(zmq.errnum()), 2) end\n\
             return data\n\
           end\n\
           {script}\n\
           zmq.ctx_term(context)\n\
           print('script done')\n\
         end\n"
    );
    let folder = scene(&[&text]);
    let args = [&["--steps", "2", "--log", "run.log"][..], &ALLOW_LOCAL].concat();
    let done = folder.run(&args);
    if done.code != 0 {
        let _ = child.kill();
    }
    let ended = child.wait_with_output().unwrap();
    let peer_text = String::from_utf8_lossy(&ended.stdout).into_owned() + &String::from_utf8_lossy(&ended.stderr);
    assert!(done.code == 0 && done.err.contains("script done"), "{}{}\npeer: {peer_text}", done.out, done.err);
    assert!(ended.status.success() && peer_text.contains("peer done"), "{peer_text}");
    let again = folder.tatu(&["run", "--replay", "run.log", "--json"]).good();
    assert_eq!((done.json()["hash"].clone(), done.err), (again.json()["hash"].clone(), again.err));
}

#[test]
#[cfg_attr(no_pypi, ignore = "needs python3 with venv and pip, and PyPI")]
fn real_clients_request_push_and_subscribe() {
    let (folder, port) = (TestFolder::new(), free_port());
    let base = format!("ipc://{}/", folder.path().display());
    let program = r#"
ask = make(zmq.REQ, f'tcp://127.0.0.1:{sys.argv[1]}')
feed = context.socket(zmq.SUB)
feed.rcvtimeo = 30000
feed.subscribe(b'state')
feed.connect(sys.argv[2] + 'feed')
work = make(zmq.PUSH, sys.argv[2] + 'work')
dealer = context.socket(zmq.DEALER)
dealer.identity = b'dealer'
dealer.rcvtimeo = 30000
dealer.connect(sys.argv[2] + 'router')
big = bytes(range(256)) * 4000
ask.send_multipart([b'question', big, b''])
assert ask.recv_multipart() == [b'answer', big]
# The publisher repeats its messages until one has arrived.
assert feed.recv_multipart() == [b'state', b'\x00\xff']
work.send(b'arrived')
dealer.send_multipart([b'one', b'two'])
assert dealer.recv_multipart() == [b'three', b'']
for i in range(100):
  ask.send(b'%d' % i)
  assert int(ask.recv()) == 2 * i
"#;
    with_peer(
        peer(program, &[&port.to_string(), &base]),
        &r#"
        local rep = make(zmq.REP, 'tcp://*:PORT', true)
        local pub = make(zmq.PUB, 'BASEfeed', true)
        local pull = make(zmq.PULL, 'BASEwork', true)
        local router = make(zmq.ROUTER, 'BASErouter', true)
        assert(receive(rep) == 'question')
        local big = receive(rep)
        assert(#big == 1024000 and receive(rep) == '')
        assert(zmq.send(rep, 'answer', zmq.SNDMORE) == 6 and zmq.send(rep, big, 0) == #big)
        local arrived
        for attempt = 1, 4000 do
            zmq.send(pub, 'other', 0)
            zmq.send(pub, 'state', zmq.SNDMORE)
            zmq.send(pub, '\0\255', 0)
            arrived = zmq.poll({pull}, {zmq.POLLIN}, 5) == 1
            if arrived then break end
        end
        assert(arrived and receive(pull) == 'arrived')
        assert(receive(router) == 'dealer' and receive(router) == 'one' and receive(router) == 'two')
        zmq.send(router, 'dealer', zmq.SNDMORE)
        zmq.send(router, 'three', zmq.SNDMORE)
        zmq.send(router, '', 0)
        for i = 0, 99 do
            assert(receive(rep) == tostring(i))
            zmq.send(rep, tostring(2 * i), 0)
        end
        "#
        .replace("PORT", &port.to_string())
        .replace("BASE", &base),
    );
}

#[test]
#[cfg_attr(no_pypi, ignore = "needs python3 with venv and pip, and PyPI")]
fn real_servers_answer_publish_and_collect() {
    let (folder, port) = (TestFolder::new(), free_port());
    let base = format!("ipc://{}/", folder.path().display());
    let program = r#"
import time
# The script connects before the ports are open.
time.sleep(0.3)
answer = make(zmq.REP, f'tcp://127.0.0.1:{sys.argv[1]}', True)
feed = make(zmq.XPUB, sys.argv[2] + 'feed', True)
work = make(zmq.PULL, sys.argv[2] + 'work', True)
router = make(zmq.ROUTER, sys.argv[2] + 'router', True)
assert answer.recv_multipart() == [b'question', b'\x00']
answer.send(b'answer')
assert feed.recv() == b'\x01po'
feed.send(b'other')
feed.send_multipart([b'pose', b'1'])
assert [work.recv() for _ in range(1000)] == [b'%d' % i for i in range(1000)]
identity, body = router.recv_multipart()
assert identity == b'script' and body == b'hello'
router.send_multipart([identity, b'back'])
assert feed.recv() == b'\x00po'
"#;
    with_peer(
        peer(program, &[&port.to_string(), &base]),
        &r#"
        local req = make(zmq.REQ, 'tcp://localhost:PORT')
        zmq.send(req, 'question', zmq.SNDMORE)
        zmq.send(req, '\0', 0)
        assert(receive(req) == 'answer')
        local sub = make(zmq.SUB, 'BASEfeed')
        zmq.setsockopt(sub, zmq.SUBSCRIBE, 'po')
        assert(receive(sub) == 'pose' and receive(sub) == '1')
        local push = make(zmq.PUSH, 'BASEwork')
        for i = 0, 999 do assert(zmq.send(push, tostring(i), 0) > 0) end
        local dealer = zmq.socket(context, zmq.DEALER)
        zmq.setsockopt(dealer, zmq.ROUTING_ID, 'script')
        assert(zmq.connect(dealer, 'BASErouter') == 0)
        zmq.send(dealer, 'hello', 0)
        assert(receive(dealer) == 'back')
        zmq.setsockopt(sub, zmq.UNSUBSCRIBE, 'po')
        "#
        .replace("PORT", &port.to_string())
        .replace("BASE", &base),
    );
}
