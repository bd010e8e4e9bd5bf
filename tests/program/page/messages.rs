//! Tests of the page's protocol by a client without a browser.

use std::time::Duration;

use serde_json::{Value, json};
use tungstenite::Message;

use super::program::{PageServer, PageSocket, ROBOT, call, next, send_message};
use crate::{kit::browser::wait_for, kit::*};

#[test]
fn short_readings_of_any_sensor_are_listed_with_its_properties() {
    let sensor = |kind: &str, keys: &str| {
        format!("[[object]]\nkind = \"sensor\"\nalias = \"{kind}\"\nsensor = \"{kind}\"\n{keys}\n")
    };
    let battery = sensor("battery", "idle_current_a = 1.5");
    let spots = sensor("floor", "count = 17");
    let place =
        TestFolder::scene(&format!("{battery}{}{spots}", sensor("compass", "strength_t = 0.5\ninclination_deg = 0.0")));
    let served = PageServer::new(place.path(), &["open", "scene.toml", "--no-browser"]);
    let mut socket = served.socket();
    let objects = next(&mut socket, "scene")["objects"].clone();
    let handle = |alias: &str| objects.as_array().unwrap().iter().find(|o| o["alias"] == alias).unwrap()["id"].clone();
    let (battery, compass, spots) = (handle("battery"), handle("compass"), handle("floor"));
    for what in ["start", "pause"] {
        socket.send(Message::text(json!({ "type": "run", "action": what }).to_string())).unwrap();
    }
    let mut listed = |id: &Value, key: &str| {
        socket.send(Message::text(json!({ "type": "details", "object": id }).to_string())).unwrap();
        let rows = next(&mut socket, "details")["rows"].clone();
        rows.as_array().unwrap().iter().find(|r| r["key"] == key).map(|r| r["value"].clone())
    };
    wait_for("a reading", Duration::from_secs(20), || {
        (listed(&battery, "battery.current") == Some(json!([1.5]))).then_some(())
    });
    let field = listed(&compass, "magnetic_field.field").unwrap();
    assert!((field[1].as_f64().unwrap() - 0.5).abs() < 1e-9, "{field}");
    assert_eq!(listed(&spots, "reflectance.value"), None, "a field with 17 values must not be listed");
}

#[test]
fn a_scene_is_opened_started_changed_and_reset() {
    let served = PageServer::new(root(), &["open", "--no-browser"]);
    let mut socket = served.socket();
    assert_eq!(next(&mut socket, "scene")["objects"], json!([]));
    let gone = call(&mut socket, "tatu.open", json!(["scenes/nothing.toml"]));
    assert!(gone["error"].is_string(), "{gone}");
    socket
        .send(Message::text(json!({ "type": "call", "name": "tatu.open", "args": [ROBOT], "id": 0 }).to_string()))
        .unwrap();
    let scene = next(&mut socket, "scene");
    let objects = scene["objects"].as_array().unwrap();
    let robot = objects.iter().find(|o| o["alias"] == "Pioneer_p3dx").unwrap_or_else(|| panic!("{scene}"));
    let (id, script) = (robot["id"].clone(), robot["scripts"][0]["id"].clone());
    let begin = robot["pose"][0].as_f64().unwrap();
    let text = call(&mut socket, "tatu.getScript", json!([script]))["results"][0].clone();
    let broken = call(&mut socket, "tatu.setScript", json!([script, "x = = 1"]));
    assert!(broken["error"].as_str().unwrap().contains("cannot be loaded"), "{broken}");
    assert_eq!(call(&mut socket, "tatu.getScript", json!([script]))["results"][0], text);
    let place = |socket: &mut PageSocket| {
        call(socket, "tatu.get", json!([id, "object.position"]))["results"][0][0].as_f64().unwrap()
    };
    socket.send(Message::text(json!({ "type": "speed", "speed": 10 }).to_string())).unwrap();
    socket.send(Message::text(json!({ "type": "run", "action": "start" }).to_string())).unwrap();
    wait_for("the robot drives", Duration::from_secs(30), || ((place(&mut socket) - begin).abs() > 0.1).then_some(()));
    socket.send(Message::text(json!({ "type": "run", "action": "stop" }).to_string())).unwrap();
    wait_for("it is reset", Duration::from_secs(30), || ((place(&mut socket) - begin).abs() < 1e-9).then_some(()));
}

/// While a script loops endlessly, with or without calls to commands, the page receives no answers until it requests a
/// stop.
#[test]
fn a_stop_in_the_page_ends_a_script_that_does_not_return() {
    for body in ["while true do end", "while true do sim.getSimulationTime() end"] {
        let script = format!("function sysCall_actuation() io.open('spins', 'w'):close() {body} end");
        let scene = format!("budget = {{ instructions = 1000000000000 }}\n{}", watcher("d", &script));
        let place = TestFolder::scene(&scene);
        let served = PageServer::new(place.path(), &["open", "scene.toml", "--no-browser", "--watchdog", "250"]);
        let mut socket = served.socket();
        next(&mut socket, "scene");
        let mut run = |what: &str| {
            socket.send(Message::text(json!({ "type": "run", "action": what }).to_string())).unwrap();
        };
        run("start");
        wait_for("the script spins", Duration::from_secs(30), || place.path().join("spins").exists().then_some(()));
        run("stop");
        // After the stop, the page receives answers again.
        let answer = call(&mut socket, "tatu.get", json!([0, "scene.phase"]));
        assert_eq!(answer["error"], Value::Null, "{answer}");
    }
}

#[test]
fn wrong_requests_are_refused_with_the_field_and_the_expected_value() {
    let served = PageServer::new(root(), &["open", ROBOT, "--no-browser"]);
    let mut socket = served.socket();
    for (request, parts) in [
        (json!({ "type": "fly" }), &["unknown variant `fly`", "`run`"][..]),
        (json!({ "type": "run", "action": "fly" }), &["`action`", "`fly`", "`start`"]),
        (json!({ "type": "speed", "speed": "fast" }), &["`speed`", "expected f64"]),
        (json!({ "type": "details", "object": "robot" }), &["`object`", "expected u32"]),
        (json!({ "type": "call", "id": 3, "name": "tatu.get" }), &["missing field `args`"]),
        (json!({ "do": "start" }), &["lacks the key `type`"]),
    ] {
        send_message(&mut socket, request.clone());
        let error = next(&mut socket, "error");
        let text = error["error"].as_str().unwrap();
        assert!(parts.iter().all(|p| text.contains(p)), "{request}: {text}");
        assert_eq!(error.get("of"), request.get("id"), "{request}");
    }
}

/// Objects that commands have changed are sent to all clients. New clients get the current scene.
#[test]
fn objects_that_change_are_sent_alone() {
    let place = TestFolder::scene(
        "[[object]]\nkind = \"dummy\"\nalias = \"base\"\n[[object]]\nkind = \"shape\"\nalias = \"block\"\n\
         script = { text = \"x = 1\" }\n",
    );
    let served = PageServer::new(place.path(), &["open", "scene.toml", "--no-browser"]);
    let (mut acting, mut other) = (served.socket(), served.socket());
    let objects = next(&mut acting, "scene")["objects"].clone();
    next(&mut other, "scene");
    let of = |objects: &Value, alias: &str| {
        objects.as_array().unwrap().iter().find(|o| o["alias"] == alias).cloned().unwrap_or_default()
    };
    let (block, base) = (of(&objects, "block"), of(&objects, "base")["id"].clone());
    let id = block["id"].clone();
    let script = block["scripts"][0].clone();
    for (command, args, pointer, value) in [
        ("tatu.set", json!([id, "shape.color", [1, 0, 0.5]]), "/parts/0/color", json!([1.0, 0.0, 0.5])),
        ("tatu.set", json!([id, "shape.size", [1, 2, 3]]), "/parts/0/size", json!([1.0, 2.0, 3.0])),
        ("tatu.set", json!([id, "object.visible", false]), "/visible", json!(false)),
        ("tatu.set", json!([id, "object.layer", 4]), "/layer", json!(4)),
        ("tatu.set", json!([id, "object.parent", { "object": base }]), "/parent", base.clone()),
        ("tatu.set", json!([id, "object.alias", "brick"]), "/alias", json!("brick")),
    ] {
        let answer = call(&mut acting, command, args.clone());
        assert_eq!(answer["type"], "result", "{args}: {answer}");
        let changed = next(&mut other, "objects")["objects"].clone();
        assert_eq!(changed.as_array().unwrap().len(), 1, "{changed}");
        assert_eq!((&changed[0]["id"], changed[0].pointer(pointer)), (&id, Some(&value)), "{args}: {changed}");
    }
    call(&mut acting, "tatu.setScript", json!([script["id"], "x = 2"]));
    let changed = next(&mut other, "objects")["objects"][0]["scripts"][0].clone();
    assert!(changed["version"] != script["version"] && changed["name"] == script["name"], "{changed}");
    let late = next(&mut served.socket(), "scene")["objects"].clone();
    assert_eq!(of(&late, "brick")["parts"][0]["color"], json!([1.0, 0.0, 0.5]));
}
