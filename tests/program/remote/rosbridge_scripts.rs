//! Tests of actions and images between scripts and rosbridge clients, as messages on the wire
//! (tests/facts/script-api.md, 8).

use std::{path::Path, time::Duration};

use serde_json::{Value, json};

use crate::{
    kit::{
        served_scene::{ServedScene, good},
        *,
    },
    remote::rosbridge::{RosbridgeSocket, client, python, receive_message, send_message, socket},
};

const FIBONACCI: &str = "example_interfaces/action/Fibonacci";

/// Starts the program with a script, and connects a client when the simulation runs.
fn started(place: &TestFolder, kind: &str, script: &str) -> (ServedScene, RosbridgeSocket) {
    place.write(
        "scene.toml",
        &format!(
            "format = 1\n[[object]]\nkind = \"dummy\"\nalias = \"scripted\"\nscript = {{ kind = \"{kind}\", text = '''{script}''' }}\n"
        ),
    );
    let served = ServedScene::with("rosbridge", scene(place.path()).as_str(), &["--realtime"]);
    let socket = socket(&served);
    (served, socket)
}

fn scene(folder: &Path) -> String {
    folder.join("scene.toml").to_str().unwrap().to_owned()
}

fn start(socket: &mut RosbridgeSocket) {
    send_message(socket, &json!({ "op": "call_service", "id": "start", "service": "/simulation/start" }));
    assert_eq!(receive_message(socket)["id"], "start");
}

/// Repeats a message until it succeeds, because scripts start shortly after the simulation.
fn again(socket: &mut RosbridgeSocket, message: &Value, is_failure: impl Fn(&Value) -> bool) -> Value {
    for _ in 0..400 {
        send_message(socket, message);
        let answer = receive_message(socket);
        if !is_failure(&answer) {
            return answer;
        }
        std::thread::sleep(Duration::from_millis(50));
    }
    panic!("no successful answer within 20 s: {message}");
}

#[test]
fn a_client_sends_goals_to_a_script() {
    let place = TestFolder::new();
    let (_served, mut peer) = started(&place, "child", crate::scripts::ros_actions::SERVER);
    start(&mut peer);
    let goal = |id: &str, order: i64, feedback: bool| {
        json!({ "op": "send_action_goal", "id": id, "action": "/fib", "action_type": FIBONACCI,
            "args": { "order": order }, "feedback": feedback })
    };
    let first = again(&mut peer, &goal("a", 4, true), |m| m["op"] == "status");
    assert_eq!(
        (&first["op"], &first["id"], &first["action"]),
        (&json!("action_feedback"), &json!("a"), &json!("/fib"))
    );
    assert_eq!(first["values"]["sequence"], json!([0, 1, 1]));
    assert_eq!(receive_message(&mut peer)["values"]["sequence"], json!([0, 1, 1, 2]));
    assert_eq!(receive_message(&mut peer)["values"]["sequence"], json!([0, 1, 1, 2, 3]));
    let result = receive_message(&mut peer);
    assert_eq!(
        result,
        json!({ "op": "action_result", "id": "a", "action": "/fib", "values": { "sequence": [0, 1, 1, 2, 3] },
            "status": 4, "result": true })
    );
    // No feedback is sent if the goal did not request it.
    send_message(&mut peer, &goal("b", 4, false));
    assert_eq!(receive_message(&mut peer)["op"], "action_result");
    send_message(&mut peer, &goal("c", -1, true));
    let rejected = receive_message(&mut peer);
    assert_eq!((&rejected["op"], &rejected["result"]), (&json!("action_result"), &json!(false)), "{rejected}");
    assert!(rejected["values"].as_str().unwrap().contains("rejected"), "{rejected}");
    send_message(&mut peer, &json!({ "op": "send_action_goal", "id": "d", "action": "/fib", "args": { "ordre": 1 } }));
    assert!(receive_message(&mut peer)["values"].as_str().unwrap().contains("`ordre`"));
    // A goal that would take long is cancelled.
    send_message(&mut peer, &goal("e", 100_000, true));
    assert_eq!(receive_message(&mut peer)["op"], "action_feedback");
    send_message(&mut peer, &json!({ "op": "cancel_action_goal", "id": "e", "action": "/fib" }));
    let canceled = loop {
        let message = receive_message(&mut peer);
        if message["op"] == "action_result" {
            break message;
        }
    };
    assert_eq!((&canceled["id"], &canceled["status"]), (&json!("e"), &json!(5)));
    // A client cannot offer an action that the script offers, and a stop ends the current goal.
    send_message(&mut peer, &json!({ "op": "advertise_action", "action": "/fib", "type": FIBONACCI }));
    assert!(receive_message(&mut peer)["msg"].as_str().unwrap().contains("a script already offers the action /fib"));
    send_message(&mut peer, &goal("f", 100_000, false));
    send_message(&mut peer, &json!({ "op": "call_service", "id": "stop", "service": "/simulation/stop" }));
    assert_eq!(receive_message(&mut peer)["id"], "stop");
    let aborted = receive_message(&mut peer);
    assert_eq!((&aborted["id"], &aborted["status"], &aborted["result"]), (&json!("f"), &json!(6), &json!(false)));
}

#[test]
#[cfg_attr(no_pypi, ignore = "needs python3 with venv and pip, and PyPI")]
fn the_real_client_sends_goals_to_a_script() {
    let python = python();
    let place = TestFolder::new();
    let (served, _) = started(&place, "child", crate::scripts::ros_actions::SERVER);
    good(&client(
        &python,
        &served,
        r#"
call('/simulation/start')
fib = roslibpy.ActionClient(ros, '/fib', 'example_interfaces/action/Fibonacci')
ended, heard, failed = [], [], []
def give(order):
    return fib.send_goal(roslibpy.Goal({'order': order}), ended.append, heard.append, failed.append)
def given():
    # Before the script has begun, no server offers the action.
    if not heard:
        give(4)
        time.sleep(0.2)
    return heard
until('feedback', given)
until('a result', lambda: ended)
assert ended[0]['values']['sequence'] == [0, 1, 1, 2, 3] and ended[0]['status'] == roslibpy.GoalStatus.SUCCEEDED, ended
assert heard[0]['sequence'] == [0, 1, 1], heard
del ended[:]
goal = give(100000)
count = len(heard)
until('feedback', lambda: len(heard) > count)
fib.cancel_goal(goal)
until('it is taken back', lambda: any(r['status'] == roslibpy.GoalStatus.CANCELED for r in ended))
give(-1)
until('a no', lambda: failed)
assert 'rejected' in str(failed[0]), failed
"#,
    ));
}

#[test]
fn a_script_sends_goals_to_a_client() {
    let place = TestFolder::new();
    let script = r#"
simROS2 = require 'simROS2'
function sysCall_thread()
    local said = simROS2.createPublisher('/said', 'std_msgs/msg/String')
    local function say(...) simROS2.publish(said, {data = table.concat({...}, ' ')}) end
    local client = simROS2.createActionClient('/fib', 'example_interfaces/action/Fibonacci',
        function(id, accepted) goal = id say('answer', tostring(accepted)) end,
        function(id, feedback) assert(id == goal) say('feedback', table.concat(feedback.sequence, ',')) cancel = true end,
        function(id, code, result)
            say('result', code - simROS2.action_result_code.succeeded, table.concat(result.sequence, ','))
            done = true
        end)
    -- In a thread, this waits for the client that offers the action.
    assert(simROS2.sendGoal(client, {order = 3}))
    while not done do sim.wait(0.05) end
    done, cancel = false, false
    simROS2.sendGoal(client, {order = 99})
    while not cancel do sim.wait(0.05) end
    assert(simROS2.cancelLastGoal(client))
    while not done do sim.wait(0.05) end
    done = false
    simROS2.sendGoal(client, {order = 5})
    while not done do sim.wait(0.05) end
    local ok, why = pcall(simROS2.sendGoal, client, {order = 6})
    say(tostring(why))
end
"#;
    let (served, mut peer) = started(&place, "child", script);
    let mut server = socket(&served);
    send_message(&mut peer, &json!({ "op": "subscribe", "topic": "/said", "type": "std_msgs/msg/String" }));
    start(&mut peer);
    send_message(&mut server, &json!({ "op": "advertise_action", "action": "/fib", "type": FIBONACCI }));
    let mut heard = || receive_message(&mut peer)["msg"]["data"].as_str().unwrap().to_owned();
    let goal = receive_message(&mut server);
    assert_eq!(
        (&goal["op"], &goal["action"], &goal["action_type"], &goal["args"], &goal["feedback"]),
        (&json!("send_action_goal"), &json!("/fib"), &json!(FIBONACCI), &json!({ "order": 3 }), &json!(true))
    );
    assert_eq!(heard(), "answer true");
    let feedback =
        |goal: &Value, of: Value| json!({ "op": "action_feedback", "id": goal["id"], "action": "/fib", "values": of });
    let result = |goal: &Value, status: i64, of: Value| json!({ "op": "action_result", "id": goal["id"], "action": "/fib", "values": of, "status": status, "result": true });
    send_message(&mut server, &feedback(&goal, json!({ "sequence": [0, 1] })));
    assert_eq!(heard(), "feedback 0,1");
    send_message(&mut server, &result(&goal, 4, json!({ "sequence": [0, 1, 1] })));
    assert_eq!(heard(), "result 0 0,1,1");
    // The next goal is cancelled.
    let goal = receive_message(&mut server);
    assert_eq!(heard(), "answer true");
    send_message(&mut server, &feedback(&goal, json!({ "sequence": [0] })));
    assert_eq!(heard(), "feedback 0");
    assert_eq!(receive_message(&mut server), json!({ "op": "cancel_action_goal", "id": goal["id"], "action": "/fib" }));
    send_message(&mut server, &result(&goal, 5, json!({})));
    assert_eq!(heard(), "result 2 ");
    // The client disconnects during the last goal, which is aborted. After that, no client offers the action.
    receive_message(&mut server);
    assert_eq!(heard(), "answer true");
    drop(server);
    assert_eq!(heard(), "result 1 ");
    let told = heard();
    assert!(told.contains("offers the action /fib: waited 5 s"), "{told}");
}

#[test]
fn images_of_scripts_and_clients_have_their_rows_turned_over() {
    let place = TestFolder::new();
    let script = r#"
function sysCall_init()
    eye = simROS2.imageTransportCreatePublisher('/eye')
    old = simROS.imageTransportAdvertise('/old')
    simROS2.imageTransportCreateSubscription('/shown', function(data, width, height)
        -- Sends it back unchanged, through the older interface.
        simROS.imageTransportPublish(old, data, width, height, 'lens')
    end)
end
function sysCall_sensing()
    -- Two rows: the lower one red, the upper one blue.
    simROS2.imageTransportPublish(eye, '\xff\0\0\0\0\xff', 1, 2, 'lens')
end
"#;
    let (_served, mut peer) = started(&place, "child", script);
    send_message(
        &mut peer,
        &json!({ "op": "subscribe", "id": "eye", "topic": "/eye", "type": "sensor_msgs/msg/Image" }),
    );
    start(&mut peer);
    let message = receive_message(&mut peer);
    let image = &message["msg"];
    assert_eq!(
        (&image["encoding"], &image["width"], &image["height"], &image["step"], &image["is_bigendian"]),
        (&json!("rgb8"), &json!(1), &json!(2), &json!(3), &json!(0))
    );
    assert_eq!(image["header"]["frame_id"], "lens");
    // The base64 text of an image with blue on top and red below.
    assert_eq!(image["data"], "AAD//wAA");
    send_message(&mut peer, &json!({ "op": "unsubscribe", "id": "eye", "topic": "/eye" }));
    send_message(&mut peer, &json!({ "op": "subscribe", "topic": "/old", "type": "sensor_msgs/Image" }));
    // An image from a client is received by the script and sent back, with either channel order.
    for (encoding, data) in [("rgb8", "AAD//wAA"), ("bgr8", "/wAAAAD/")] {
        send_message(
            &mut peer,
            &json!({ "op": "publish", "topic": "/shown", "msg": {
                "width": 1, "height": 2, "encoding": encoding, "step": 3, "data": data } }),
        );
        let back = loop {
            let message = receive_message(&mut peer);
            if message["topic"] == "/old" {
                break message;
            }
        };
        assert_eq!(back["msg"]["data"], "AAD//wAA", "{encoding}: {back}");
        assert!(back["msg"]["header"]["stamp"]["secs"].is_i64(), "{back}");
    }
    send_message(&mut peer, &json!({ "op": "publish", "topic": "/shown", "msg": { "encoding": "yuv422" } }));
    assert!(receive_message(&mut peer)["msg"].as_str().unwrap().contains("yuv422"));
}
