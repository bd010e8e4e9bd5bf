//! Tests of changing the scene of `tatu serve`: a client that opens an invalid scene gets the error, and no start
//! request is lost.

use std::{
    io::{BufRead, BufReader, Write},
    net::TcpStream,
    time::Duration,
};

use serde_json::{Value, json};

use crate::{kit::served_scene::ServedScene, kit::*};

struct ServiceClient {
    to: TcpStream,
    from: BufReader<TcpStream>,
}

impl ServiceClient {
    fn new(served: &ServedScene) -> ServiceClient {
        let to = served.connect();
        ServiceClient { from: BufReader::new(to.try_clone().unwrap()), to }
    }
    /// Sends a line without waiting for its answer.
    fn send(&mut self, message: &Value) {
        writeln!(self.to, "{message}").unwrap();
    }
    fn answer(&mut self) -> Value {
        let mut line = String::new();
        assert!(self.from.read_line(&mut line).unwrap() > 0, "the program has exited");
        serde_json::from_str(&line).unwrap()
    }
    fn ask(&mut self, message: &Value) -> Value {
        self.send(message);
        self.answer()
    }
    fn open(&mut self, file: &str) -> Value {
        self.ask(&json!({ "id": 1, "call": "tatu.open", "args": [file] }))
    }
    /// Polls the world, and returns whether it reaches a state.
    fn reaches_state(&mut self, state: &str) -> bool {
        (0..400).any(|_| {
            let there = self.ask(&json!({ "state": true }))["state"] == state;
            if !there {
                std::thread::sleep(Duration::from_millis(10));
            }
            there
        })
    }
    fn has(&mut self, path: &str) -> bool {
        self.ask(&json!({ "id": 2, "call": "sim.getObject", "args": [path] }))["error"].is_null()
    }
}

fn served() -> (TestFolder, ServedScene) {
    let place = TestFolder::new();
    let dummy = |alias: &str| format!("format = 1\n[[object]]\nkind = \"dummy\"\nalias = \"{alias}\"\n");
    place.write("good.toml", &dummy("first")).write("other.toml", &dummy("second"));
    place.write("bad.toml", "format = 1\n[[object]]\nkind = \"nonsense\"\n").write("cut.ttt", "VREP");
    let scene = place.path().join("good.toml").display().to_string();
    let served = ServedScene::with("jsonl", &scene, &["--files", place.path().to_str().unwrap(), "--no-addons"]);
    (place, served)
}

#[test]
fn a_scene_that_cannot_be_opened_is_refused_and_the_present_one_goes_on() {
    let (_place, mut served) = served();
    let mut client = ServiceClient::new(&served);
    for running in [false, true] {
        if running {
            client.ask(&json!({ "request": "start" }));
            assert!(client.reaches_state("running"));
        }
        for (file, words) in [
            ("bad.toml", "bad.toml:3: unknown object kind `nonsense`"),
            ("cut.ttt", "cut.ttt"),
            ("none.toml", "none.toml"),
        ] {
            let answer = client.open(file);
            let text = answer["error"]["text"].as_str().unwrap_or_else(|| panic!("{answer}"));
            assert!(text.contains(words), "{text}");
            assert!(client.has("/first") && served.is_there());
        }
        assert!(!running || client.reaches_state("running"));
    }
}

#[test]
fn a_start_right_after_another_scene_is_that_of_the_new_one() {
    let (_place, served) = served();
    let mut client = ServiceClient::new(&served);
    for (file, object) in [("other.toml", "/second"), ("good.toml", "/first"), ("other.toml", "/second")] {
        // Both requests are sent together so that they arrive at the same barrier.
        client.send(&json!({ "id": 1, "call": "tatu.open", "args": [file] }));
        client.send(&json!({ "request": "start" }));
        let answers = [client.answer(), client.answer()];
        assert!(answers.iter().all(|a| a["error"].is_null()), "{answers:?}");
        assert!(client.reaches_state("running"), "the start of {file} is lost");
        assert!(client.has(object));
    }
    client.ask(&json!({ "request": "stop" }));
    assert!(client.reaches_state("stopped"));
}

#[test]
fn a_program_without_a_scene_has_a_floor_for_models_of_the_original_s_names() {
    let place = TestFolder::new();
    let served = ServedScene::with("jsonl", "", &["--files", &place.path().display().to_string()]);
    let mut client = ServiceClient::new(&served);
    for path in ["/floor", "/light", "/camera"] {
        assert!(client.has(path), "{path}");
    }
    let call = |client: &mut ServiceClient, name: &str, args: Value| {
        client.ask(&json!({ "id": 3, "call": name, "args": args }))
    };
    // The folder of models, and a path in it, as clients of the original write them.
    let folder = call(&mut client, "sim.getStringParam", json!([133]));
    let folder = folder["result"][0].as_str().unwrap_or_else(|| panic!("{folder}")).to_owned();
    let robot = call(&mut client, "sim.loadModel", json!([format!("{folder}/robots/mobile/pioneer p3dx.ttm")]));
    let robot = robot["result"][0].as_i64().unwrap_or_else(|| panic!("{robot}"));
    let wrong = call(&mut client, "sim.loadModel", json!(["models/robots/mobile/KUKA YouBot.ttm"]));
    assert!(wrong["error"].to_string().contains("`omni_platform`"), "{wrong}");
    call(&mut client, "sim.startSimulation", json!([]));
    let time =
        |client: &mut ServiceClient| call(client, "sim.getSimulationTime", json!([]))["result"][0].as_f64().unwrap();
    while time(&mut client) < 1.0 {}
    let running = call(&mut client, "sim.closeScene", json!([]));
    assert_eq!(running["result"][0], -1, "{running}");
    let at = call(&mut client, "sim.getObjectPosition", json!([robot, -1]));
    let height = at["result"][0][2].as_f64().unwrap_or_else(|| panic!("{at}"));
    assert!(height > 0.1 && height < 0.2, "it stands on the floor: {at}");
    call(&mut client, "sim.stopSimulation", json!([]));
    assert!(client.reaches_state("stopped"));
    let closed = call(&mut client, "sim.closeScene", json!([]));
    assert_eq!(closed["result"][0], 1, "{closed}");
    let gone = (0..400).any(|_| {
        std::thread::sleep(Duration::from_millis(10));
        !client.has("/Pioneer_p3dx")
    });
    assert!(gone && client.has("/floor"), "{}", served.logged());
}
