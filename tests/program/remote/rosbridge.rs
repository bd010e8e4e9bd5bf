//! Tests of rosbridge with the real client from PyPI, and with invalid messages.

use std::{
    io::{BufRead, BufReader, Read, Write},
    net::TcpStream,
    path::PathBuf,
    process::{Command, Output, Stdio},
    time::Duration,
};

use serde_json::{Value, json};
use tungstenite::{Message, WebSocket, stream::MaybeTlsStream};

use crate::{
    kit::browser::wait_for,
    kit::served_scene::{self, ServedScene, good},
    kit::*,
    plugins::outside::built_for_its_scene,
};

const SCENE: &str = "scenes/first/pioneer_for_ros.toml";

pub type RosbridgeSocket = WebSocket<MaybeTlsStream<TcpStream>>;

fn served() -> ServedScene {
    ServedScene::with("rosbridge", SCENE, &["--realtime"])
}

/// Returns a Python interpreter that has the real client.
pub fn python() -> PathBuf {
    served_scene::python("roslibpy==2.1.0", "roslibpy")
}

/// The beginning of each client program, which connects and defines functions that wait.
pub const CLIENT_PREAMBLE: &str = r#"
import base64, math, os, time
import roslibpy
ros = roslibpy.Ros(host='127.0.0.1', port=PORT)
ros.run(10)
def call(name, /, **args):
    return roslibpy.Service(ros, name, '').call(roslibpy.ServiceRequest(args), timeout=20)
def until(what, f):
    end = time.time() + 30
    while time.time() < end:
        if f():
            return
        time.sleep(0.02)
    raise SystemExit('not within 30 s: ' + what)
last = {}
def listen(topic, kind, **more):
    t = roslibpy.Topic(ros, topic, kind, **more)
    t.subscribe(lambda m: last.__setitem__(topic, m))
    return t
"#;

pub fn client(python: &PathBuf, served: &ServedScene, program: &str) -> Output {
    let program = format!("{CLIENT_PREAMBLE}{program}\nros.terminate()").replace("PORT", &served.port.to_string());
    Command::new(python).args(["-c", &program]).output().unwrap()
}

/// Connects a client. If no message arrives for a minute, reading fails.
pub fn socket(served: &ServedScene) -> RosbridgeSocket {
    let mut socket = tungstenite::connect(format!("ws://127.0.0.1:{}/", served.port)).unwrap().0;
    let MaybeTlsStream::Plain(stream) = socket.get_mut() else { unreachable!() };
    stream.set_read_timeout(Some(Duration::from_secs(60))).unwrap();
    socket
}

pub fn send_message(socket: &mut RosbridgeSocket, message: &Value) {
    socket.send(Message::text(message.to_string())).unwrap();
}

/// Returns the next text message.
pub fn receive_message(socket: &mut RosbridgeSocket) -> Value {
    loop {
        if let Message::Text(text) = socket.read().unwrap() {
            return serde_json::from_str(&text).unwrap();
        }
    }
}

#[test]
fn a_plugin_builds_the_messages_of_its_sensors() {
    let place = built_for_its_scene("radar");
    let scene = place.path().join("scene.toml").display().to_string();
    let served = ServedScene::with("rosbridge", &scene, &["--allow", "plugins"]);
    let mut socket = socket(&served);
    let subscribe =
        |kind: &str, id: &str| json!({"op": "subscribe", "topic": "/radar", "type": kind, "id": id, "queue_length": 1});
    send_message(&mut socket, &subscribe("sensor_msgs/Range", "one"));
    send_message(&mut socket, &json!({"op": "call_service", "service": "/simulation/start", "id": "start"}));
    let message = loop {
        let got = receive_message(&mut socket);
        if got["op"] == "publish" {
            break got["msg"].clone();
        }
        assert_ne!(got["level"], "error", "{got}");
    };
    let range = message["range"].as_f64().unwrap();
    assert!(range > 1.0 && range < 50.0 && message["max_range"] == 50.0, "{message}");
    // The bridge adds the header, and the fields that the plugin has not set.
    assert!(message["header"]["stamp"]["secs"].is_i64() && message["field_of_view"] == 0.0, "{message}");
}

#[test]
fn a_message_that_its_plugin_builds_wrongly_is_reported() {
    let place = built_for_its_scene("radar");
    let text = place.read("radar.c").replace("\"max_range\"", "\"maximal_range\"");
    place.write("radar.c", &text);
    let include = root().join("plugin-api/include");
    let library = library("tatu_radar");
    succeed(
        Command::new(compiler("cc"))
            .args(["-std=c11", "-shared", "-fPIC", "radar.c", "-o", &library, "-I"])
            .arg(include)
            .current_dir(place.path()),
    );
    let scene = place.path().join("scene.toml").display().to_string();
    let served = ServedScene::with("rosbridge", &scene, &["--allow", "plugins"]);
    let mut socket = socket(&served);
    send_message(&mut socket, &json!({"op": "call_service", "service": "/simulation/start", "id": "start"}));
    wait_for("the report", Duration::from_secs(20), || {
        let logged = served.logged();
        (logged.contains("no messages of /radar") && logged.contains("has no field \"maximal_range\"")).then_some(())
    });
}

#[test]
fn a_token_is_asked_for_where_one_is_wanted() {
    let place = TestFolder::new();
    let mut process = Command::new(env!("CARGO_BIN_EXE_tatu"))
        .current_dir(root())
        .args(["serve", SCENE, "--service", "rosbridge:port=0,token=true"])
        .env("HOME", place.path())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let lines = BufReader::new(process.stderr.take().unwrap()).lines();
    let url = lines.map(Result::unwrap).find(|l| l.starts_with("ws://")).expect("no address was printed");
    let (without, _) = url.split_once('?').unwrap();
    assert!(tungstenite::connect(without).unwrap_err().to_string().contains("401"));
    assert!(tungstenite::connect(format!("{without}?token=0")).is_err());
    let mut socket = tungstenite::connect(&url).unwrap().0;
    send_message(&mut socket, &json!({ "op": "call_service", "service": "/rosapi/topics" }));
    assert_eq!(receive_message(&mut socket)["result"], json!(true));
    process.kill().unwrap();
    process.wait().unwrap();
}

#[test]
#[cfg_attr(no_pypi, ignore = "needs python3 with venv and pip, and PyPI")]
fn the_real_client_drives_a_robot_until_it_is_silent() {
    let python = python();
    let served = served();
    let told = good(&client(
        &python,
        &served,
        r#"
topics = ros.get_topics()
assert {'/cmd_vel', '/odom', '/pose', '/scan', '/image', '/depth', '/points', '/camera_info', '/fix', '/tf', '/clock',
        '/joint_states', '/Pioneer_p3dx/cmd_vel', '/Pioneer_p3dx/laser/scan',
        '/Pioneer_p3dx/Pioneer_p3dx_ultrasonicSensor3/range'} <= set(topics), topics
assert ros.get_topic_type('/scan') == 'sensor_msgs/LaserScan'
assert '/range' not in topics                      # there are sixteen
listen('/odom', 'nav_msgs/Odometry')
listen('/pose', 'geometry_msgs/PoseStamped')
listen('/joint_states', 'sensor_msgs/JointState')
assert call('/simulation/start')['success']
until('the robot tells of itself', lambda: '/odom' in last and '/pose' in last)
begin = last['/pose']['pose']['position']['x']
cmd = roslibpy.Topic(ros, '/cmd_vel', 'geometry_msgs/Twist')
for i in range(15):
    cmd.publish(roslibpy.Message({'linear': {'x': 0.3}}))
    time.sleep(0.1)
until('the wheels turn', lambda: abs(last['/odom']['twist']['twist']['linear']['x'] - 0.3) < 0.02 or
                                 last['/odom']['pose']['pose']['position']['x'] > 0.3)
until('it stops', lambda: last['/odom']['twist']['twist']['linear']['x'] < 0.01)
time.sleep(0.3)
driven = last['/odom']['pose']['pose']['position']['x']
gone = last['/pose']['pose']['position']['x'] - begin
# 1.5 s, and at most 0.5 s until the robot stops without commands; odometry is wrong only by the slip of the wheels.
assert 0.3 < gone < 0.9, gone
assert abs(driven - gone) < 0.02, (driven, gone)
names = last['/joint_states']['name']
assert len(names) == 4 and len(last['/joint_states']['position']) == 4, names
cmd.publish(roslibpy.Message({'angular': {'z': 0.8}}))
until('it turns to the left', lambda: last['/odom']['twist']['twist']['angular']['z'] > 0.5)
print('driven', round(driven, 2))
"#,
    ));
    assert!(told.contains("driven"), "{told}");
}

#[test]
#[cfg_attr(no_pypi, ignore = "needs python3 with venv and pip, and PyPI")]
fn sensors_are_topics_in_the_frames_of_ros() {
    let python = python();
    let served = served();
    good(&client(
        &python,
        &served,
        r#"
for topic, kind in [('/scan', 'sensor_msgs/LaserScan'), ('/image', 'sensor_msgs/Image'), ('/depth', 'sensor_msgs/Image'),
                    ('/camera_info', 'sensor_msgs/CameraInfo'), ('/points', 'sensor_msgs/PointCloud2'),
                    ('/fix', 'sensor_msgs/NavSatFix'), ('/tf', 'tf2_msgs/TFMessage'), ('/pose', 'geometry_msgs/PoseStamped'),
                    ('/Pioneer_p3dx/Pioneer_p3dx_ultrasonicSensor4/range', 'sensor_msgs/Range')]:
    listen(topic, kind, throttle_rate=100)
call('/simulation/start')
until('all sensors tell', lambda: len(last) == 9)
import struct
scan = last['/scan']
n = len(scan['ranges'])
assert n == 682 and abs(scan['angle_min'] + (n - 1) * scan['angle_increment'] - scan['angle_max']) < 1e-6, n
ahead = scan['ranges'][round(-scan['angle_min'] / scan['angle_increment'])]
# Beams without a hit are null in JSON.
assert any(r is None for r in scan['ranges']) and ahead is None or 0.1 < ahead < 4.1, ahead
image = last['/image']
assert (image['width'], image['height'], image['encoding'], image['step']) == (160, 120, 'rgb8', 480)
assert len(base64.b64decode(image['data'])) == 160 * 120 * 3
depth = struct.unpack('<19200f', base64.b64decode(last['/depth']['data']))
points = base64.b64decode(last['/points']['data'])
K = last['/camera_info']['K']
# The same pixel in both messages, in the lower half, which shows the floor: y points down.
row, column = 100, 40
x, y, z = struct.unpack_from('<3f', points, 12 * (160 * row + column))
assert abs(z - depth[160 * row + column]) < 1e-6 and y > 0 and x < 0, (x, y, z)
assert abs(x - (column - K[2]) * z / K[0]) < 1e-5 and abs(y - (row - K[5]) * z / K[4]) < 1e-5, (x, y, z, K)
assert last['/fix']['status']['status'] == 0 and abs(last['/fix']['latitude']) < 1e-3
assert last['/Pioneer_p3dx/Pioneer_p3dx_ultrasonicSensor4/range']['radiation_type'] == 0
frames = {f['child_frame_id']: f for f in last['/tf']['transforms']}
listen('/tf_static', 'tf2_msgs/TFMessage')
until('frames that do not move are told', lambda: '/tf_static' in last)
still = {f['child_frame_id']: f for f in last['/tf_static']['transforms']}
assert still[scan['header']['frame_id']]['header']['frame_id'] == 'base_link', still
# The world and the start of the odometry are on the floor.
start = frames['odom']['transform']
assert start['translation']['z'] == 0 and start['rotation']['x'] == 0 and start['rotation']['y'] == 0, start
assert frames['odom']['header']['frame_id'] == 'map' and frames['base_link']['header']['frame_id'] == 'odom'
laser = frames[scan['header']['frame_id']]
assert laser['header']['frame_id'] == 'base_link'
t, q = laser['transform']['translation'], laser['transform']['rotation']
# The scanner faces ahead, so its ROS frame is not rotated.
# Positions are relative to the driven axle, which is 44.5 mm ahead of the robot's origin.
assert abs(t['x'] - (0.12 - 0.0445)) < 1e-9 and abs(t['z'] - 0.2) < 1e-9 and abs(abs(q['w']) - 1) < 1e-9, laser
camera = frames[image['header']['frame_id']]['transform']['rotation']
assert all(abs(abs(camera[k]) - 0.5) < 1e-9 for k in 'xyzw'), camera
"#,
    ));
}

#[test]
#[cfg_attr(no_pypi, ignore = "needs python3 with venv and pip, and PyPI")]
fn clients_offer_each_other_topics_services_and_actions() {
    let python = python();
    let served = served();
    let server = format!(
        "{CLIENT_PREAMBLE}
def add(request, response):
    response['sum'] = request['a'] + request['b']
    return True
roslibpy.Service(ros, '/add', 'example_interfaces/AddTwoInts').advertise(add)
roslibpy.Service(ros, '/hang', 'std_srvs/Trigger').advertise(lambda request, response: time.sleep(60))
listen('/chatter', 'std_msgs/String')
until('chatter', lambda: '/chatter' in last)
roslibpy.Topic(ros, '/echo', 'std_msgs/String').publish(roslibpy.Message({{'data': last['/chatter']['data'] * 2}}))
time.sleep(60)
"
    );
    let server = server.replace("PORT", &served.port.to_string());
    let mut server = Command::new(&python).args(["-c", &server]).stdout(Stdio::null()).spawn().unwrap();
    let done = client(
        &python,
        &served,
        r#"
until('the service is there', lambda: '/add' in ros.get_services())
assert call('/add', a=2, b=40)['sum'] == 42
listen('/echo', 'std_msgs/String')
chatter = roslibpy.Topic(ros, '/chatter', 'std_msgs/String')
def again():
    chatter.publish(roslibpy.Message({'data': 'ab'}))
    return '/echo' in last
until('an echo', again)
assert last['/echo']['data'] == 'abab', last
try:
    call('/nowhere')
    raise SystemExit('a service that is not there was called')
except roslibpy.core.ServiceException as e:
    assert 'there is no service /nowhere' in str(e), e
assert call('/rosapi/set_param', name='gain', value='3') == {}
assert ros.get_param('gain') == 3
assert ros.get_param('/use_sim_time') is True and ros.get_param('use_sim_time') is True
details = call('/rosapi/message_details', type='geometry_msgs/Twist')['typedefs']
assert details[0]['fieldnames'] == ['linear', 'angular'] and len(details) == 2, details
# If the server of a call exits, the waiting caller receives an error.
import threading
told = []
def ask():
    try:
        call('/hang')
    except Exception as e:
        told.append(str(e))
waiting = threading.Thread(target=ask)
waiting.start()
time.sleep(0.5)
os.kill(SERVER, 9)
waiting.join()
assert 'disconnected' in told[0], told
"#
        .replace("SERVER", &server.id().to_string())
        .as_str(),
    );
    let _ = server.kill();
    let _ = server.wait();
    good(&done);
}

#[test]
fn a_goal_is_sent_to_the_action_server_and_its_result_is_returned() {
    let served = served();
    let (mut server, mut client) = (socket(&served), socket(&served));
    let wait = |socket: &mut RosbridgeSocket| {
        send_message(socket, &json!({ "op": "call_service", "id": "done", "service": "/rosapi/get_time" }));
        assert_eq!(receive_message(socket)["id"], "done");
    };
    send_message(&mut client, &json!({ "op": "send_action_goal", "id": "g", "action": "/fib", "args": {} }));
    assert!(receive_message(&mut client)["msg"].as_str().unwrap().contains("no client offers the action /fib"));
    send_message(
        &mut server,
        &json!({ "op": "advertise_action", "action": "/fib", "type": "example_interfaces/action/Fibonacci" }),
    );
    wait(&mut server);
    send_message(
        &mut client,
        &json!({ "op": "send_action_goal", "id": "g", "action": "/fib", "args": { "order": 3 }, "feedback": true }),
    );
    let goal = receive_message(&mut server);
    assert_eq!((&goal["op"], &goal["args"]["order"]), (&json!("send_action_goal"), &json!(3)));
    send_message(
        &mut server,
        &json!({ "op": "action_feedback", "id": goal["id"], "action": "/fib", "values": { "sequence": [0, 1] } }),
    );
    let feedback = receive_message(&mut client);
    assert_eq!((&feedback["id"], &feedback["values"]["sequence"]), (&json!("g"), &json!([0, 1])));
    send_message(&mut client, &json!({ "op": "cancel_action_goal", "id": "g", "action": "/fib" }));
    assert_eq!(receive_message(&mut server), json!({ "op": "cancel_action_goal", "id": goal["id"], "action": "/fib" }));
    send_message(
        &mut server,
        &json!({ "op": "action_result", "id": goal["id"], "action": "/fib", "values": {}, "status": 5, "result": true }),
    );
    assert_eq!(receive_message(&mut client)["status"], 5);
    // If a client disconnects during a goal, the goal is aborted.
    send_message(&mut client, &json!({ "op": "send_action_goal", "id": "h", "action": "/fib", "args": {} }));
    receive_message(&mut server);
    drop(server);
    assert_eq!(receive_message(&mut client)["status"], 6);
}

#[test]
fn invalid_messages_affect_only_their_sender() {
    let served = served();
    let mut good = socket(&served);
    send_message(&mut good, &json!({ "op": "call_service", "id": "1", "service": "/rosapi/get_time" }));
    assert_eq!(receive_message(&mut good)["result"], true);
    // Each message is answered with an error, and the connection remains open.
    for (message, told) in [
        ("nonsense", "not valid JSON"),
        ("[1]", "`op`"),
        (r#"{"op": "dance", "id": "d"}"#, "`dance`"),
        (r#"{"op": "publish", "topic": "/cmd_vel", "msg": {"linaer": {}}}"#, "has no field `linaer`"),
        (r#"{"op": "publish", "topic": "/cmd_vel", "msg": {"linear": {"x": "fast"}}}"#, "a number"),
        (r#"{"op": "publish", "topic": "/odom", "msg": {}}"#, "clients cannot publish it"),
        (r#"{"op": "advertise", "topic": "/scan", "type": "std_msgs/String"}"#, "has the type sensor_msgs/LaserScan"),
        (r#"{"op": "advertise_service", "service": "/rosapi/topics", "type": "a/B"}"#, "already provided"),
        (r#"{"op": "fragment", "id": "a", "num": 0, "total": 1, "data": "{"}"#, "valid JSON"),
    ] {
        good.send(Message::text(message)).unwrap();
        let answer = receive_message(&mut good);
        assert!(answer["op"] == "status" && answer["msg"].as_str().unwrap().contains(told), "{message}: {answer}");
    }
    // Requests from a page of another server, with another host name, and without a WebSocket upgrade are refused.
    let ask = |head: &str| {
        let mut stream = served.connect();
        stream.write_all(head.replace("PORT", &served.port.to_string()).as_bytes()).unwrap();
        let mut out = String::new();
        let _ = stream.read_to_string(&mut out);
        out
    };
    let upgrade = "Upgrade: websocket\r\nConnection: Upgrade\r\nSec-WebSocket-Version: 13\r\nSec-WebSocket-Key: AAAAAAAAAAAAAAAAAAAAAA==\r\n\r\n";
    let foreign = format!("GET / HTTP/1.1\r\nHost: 127.0.0.1:PORT\r\nOrigin: http://evil.example\r\n{upgrade}");
    assert!(ask(&foreign).starts_with("HTTP/1.1 403"));
    let renamed = format!("GET / HTTP/1.1\r\nHost: evil.example:PORT\r\n{upgrade}");
    assert!(ask(&renamed).starts_with("HTTP/1.1 421"));
    assert!(ask("GET / HTTP/1.1\r\nHost: 127.0.0.1:PORT\r\n\r\n").starts_with("HTTP/1.1 426"));
    // A frame with a claimed size of 4 GiB, connections that send nothing, and one that is closed in the middle of a
    // frame.
    let mut liar = socket(&served);
    let MaybeTlsStream::Plain(stream) = liar.get_mut() else { unreachable!() };
    let mut frame = vec![0x81, 0xFF];
    frame.extend_from_slice(&(4_u64 << 30).to_be_bytes());
    frame.extend_from_slice(&[0; 8]);
    stream.write_all(&frame).unwrap();
    wait_for("the liar is closed", Duration::from_secs(20), || liar.read().is_err().then_some(()));
    let silent: Vec<TcpStream> = (0..200).map(|_| TcpStream::connect(("127.0.0.1", served.port)).unwrap()).collect();
    drop(silent);
    let mut half = socket(&served);
    let MaybeTlsStream::Plain(stream) = half.get_mut() else { unreachable!() };
    stream.write_all(&[0x81, 0xFE, 0x10]).unwrap();
    drop(half);
    send_message(&mut good, &json!({ "op": "call_service", "id": "2", "service": "/rosapi/get_time" }));
    assert_eq!(receive_message(&mut good)["id"], "2");
}

#[test]
fn messages_are_cut_or_cbor_where_a_client_wants_it() {
    let served = served();
    let mut socket = socket(&served);
    send_message(
        &mut socket,
        &json!({ "op": "subscribe", "id": "s", "topic": "/odom", "type": "nav_msgs/msg/Odometry", "fragment_size": 300 }),
    );
    send_message(&mut socket, &json!({ "op": "call_service", "id": "1", "service": "/simulation/start" }));
    let (mut parts, mut whole) = (Vec::new(), String::new());
    while parts.len() < 2 || parts.len() < parts[0] {
        let message = receive_message(&mut socket);
        if message["op"] == "fragment" && (message["num"] == 0 || !parts.is_empty()) {
            whole += message["data"].as_str().unwrap();
            parts.push(message["total"].as_u64().unwrap() as usize);
        }
    }
    let whole: Value = serde_json::from_str(&whole).unwrap();
    // The message has the field names of ROS 2, because the subscription names the type of ROS 2.
    assert!(
        whole["msg"]["header"]["stamp"]["nanosec"].is_u64() && whole["msg"]["header"].get("seq").is_none(),
        "{whole}"
    );
    send_message(&mut socket, &json!({ "op": "unsubscribe", "id": "s", "topic": "/odom" }));
    send_message(
        &mut socket,
        &json!({ "op": "subscribe", "topic": "/scan", "type": "sensor_msgs/LaserScan", "compression": "cbor" }),
    );
    loop {
        if let Message::Binary(bytes) = socket.read().unwrap() {
            // The CBOR tag of an array of 32-bit floats, followed by 682 of them.
            let array = [0xD8, 85, 0x59, ((682_u32 * 4) >> 8) as u8, (682_u32 * 4) as u8];
            assert!(bytes.windows(5).any(|w| w == array), "{} bytes", bytes.len());
            break;
        }
    }
}

#[test]
#[cfg_attr(no_pypi, ignore = "needs python3 with venv and pip, and PyPI")]
fn scripts_and_clients_talk_by_the_interfaces_of_v_rep() {
    let python = python();
    let place = TestFolder::new();
    place.write(
        "scene.toml",
        r#"
format = 1
[[object]]
kind = "dummy"
alias = "modern"
script = { text = """
function sysCall_init()
    simROS2 = require 'simROS2'
    heard = simROS2.createPublisher('/heard', 'std_msgs/msg/String')
    simROS2.createSubscription('/say', 'std_msgs/msg/String', say)
    simROS2.createService('/double', 'example_interfaces/srv/AddTwoInts', 'double')
end
function say(m) simROS2.publish(heard, {data = m.data .. '!'}) end
function double(request) return {sum = 2 * (request.a + request.b)} end
""" }
[[object]]
kind = "dummy"
alias = "old"
script = { kind = "threaded", text = """
function sysCall_threadmain()
    local result = simROS.advertise('/result', 'std_msgs/Int64', 1, true)
    local client = simROS.serviceClient('/add', 'example_interfaces/AddTwoInts')
    -- A call to a script's service returns immediately, one to a client's service when the client answers.
    local inner = simROS.call(simROS.serviceClient('/double', 'example_interfaces/AddTwoInts'), {a = 1, b = 2}).sum
    while true do
        local ok, response = pcall(simROS.call, client, {a = 40, b = inner})
        if ok then
            simROS.publish(result, {data = response.sum})
        end
        sim.switchThread()
    end
end
""" }
"#,
    );
    let scene = place.path().join("scene.toml");
    let served = ServedScene::with("rosbridge", scene.to_str().unwrap(), &["--realtime"]);
    good(&client(
        &python,
        &served,
        r#"
call('/simulation/start')
listen('/heard', 'std_msgs/String')
listen('/result', 'std_msgs/Int64')
until('the script offers its service', lambda: '/double' in ros.get_services())
assert call('/double', a=20, b=1)['sum'] == 42
assert ros.get_topic_type('/say') == 'std_msgs/String'
say = roslibpy.Topic(ros, '/say', 'std_msgs/String')
def spoken():
    say.publish(roslibpy.Message({'data': 'hello'}))
    return '/heard' in last
until('the script answers', spoken)
assert last['/heard']['data'] == 'hello!', last
assert '/result' not in last                     # nobody adds yet
def add(request, response):
    response['sum'] = request['a'] + request['b']
    return True
roslibpy.Service(ros, '/add', 'example_interfaces/AddTwoInts').advertise(add)
until('the thread has its answer', lambda: '/result' in last)
assert last['/result']['data'] == 46, last
call('/simulation/stop')
until('its scripts have ended', lambda: '/double' not in ros.get_services())
"#,
    ));
}

/// A model with two joints that are moved by their positions, and one whose motor controls its velocity.
const ARM: &str = r#"
format = 1

[[object]]
kind = "dummy"
alias = "arm"
model_base = true

[[object]]
kind = "joint"
alias = "shoulder"
parent = "/arm"
type = "revolute"
mode = "kinematic"

[[object]]
kind = "joint"
alias = "elbow"
parent = "/arm/shoulder"
type = "revolute"
mode = "kinematic"

[[object]]
kind = "joint"
alias = "wheel"
parent = "/arm"
type = "revolute"
control = "velocity"
"#;

#[test]
#[cfg_attr(no_pypi, ignore = "needs python3 with venv and pip, and PyPI")]
fn joints_follow_a_trajectory_of_the_real_client() {
    let python = python();
    let place = TestFolder::new();
    place.write("arm.toml", ARM);
    let scene = place.path().join("arm.toml");
    let served = ServedScene::with("rosbridge", scene.to_str().unwrap(), &["--realtime"]);
    let out = good(&client(
        &python,
        &served,
        r#"
seen = []
def store(m):
    last['/joint_states'] = m
    seen.append((m['header']['stamp']['secs'] + m['header']['stamp']['nsecs'] * 1e-9, *m['position']))
roslibpy.Topic(ros, '/joint_states', 'sensor_msgs/JointState').subscribe(store)
assert call('/simulation/start')['success']
until('the joints are known', lambda: '/joint_states' in last)
assert last['/joint_states']['name'] == ['shoulder', 'wheel', 'elbow'], last
topic = roslibpy.Topic(ros, '/joint_trajectory', 'trajectory_msgs/JointTrajectory')
def point(t, *positions):
    return {'positions': positions, 'velocities': [0, 0], 'time_from_start': {'secs': int(t), 'nsecs': int(t % 1 * 1e9)}}
topic.publish(roslibpy.Message({'joint_names': ['elbow', 'shoulder'], 'points': [point(1, 1.0, -0.5), point(2.5, 0.2, 0.3)]}))
until('the end', lambda: abs(last['/joint_states']['position'][2] - 0.2) < 1e-9)
assert abs(last['/joint_states']['position'][0] - 0.3) < 1e-9
elbow = max(seen, key=lambda s: s[3])
assert abs(elbow[3] - 1) < 1e-3, elbow
# Cubic polynomials between rests: half of the way in half of the time.
middle = min(seen, key=lambda s: abs(s[0] - (elbow[0] + 0.75)))
assert abs(middle[3] - 0.6) < 0.05, (elbow, middle)
print('followed')
"#,
    ));
    assert!(out.contains("followed"), "{out}");
    let mut socket = socket(&served);
    for (joints, expected) in [
        (json!(["wheel"]), "the joint `wheel` has the control mode `velocity`"),
        (json!(["nose"]), "arm has no joint `nose`: expected one of shoulder, wheel, elbow"),
        (json!([]), "point 0 of the trajectory has 1 positions for 0 joints"),
    ] {
        let msg =
            json!({ "joint_names": joints, "points": [{ "positions": [1.0], "time_from_start": { "secs": 1 } }] });
        send_message(&mut socket, &json!({ "op": "publish", "topic": "/joint_trajectory", "msg": msg }));
        let answer = receive_message(&mut socket);
        assert!(answer["msg"].as_str().unwrap().contains(expected), "{answer}");
    }
}
