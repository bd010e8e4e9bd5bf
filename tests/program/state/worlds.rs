//! Tests of many worlds in one process, and of services that outlive them.

use std::{collections::BTreeMap, net::TcpListener, sync::Arc, thread};

use serde_json::json;
use tatu_core::{
    Session, World,
    document::{self, Document, LoadOptions, ServiceOverride},
    plugins::{Registry, SearchPath},
    replay_to,
};

use crate::{kit::*, remote::jsonl::TestClient};

/// Loads the plugins that these tests need, whose libraries are next to the built program.
fn registry() -> Arc<Registry> {
    let names = [
        "tatu_commands_vrep",
        "tatu_scripts_lua",
        "tatu_sensors_proximity",
        "tatu_models_folder",
        "tatu_importers_mesh",
        "tatu_services_jsonl",
    ];
    load_registry(SearchPath::standard(Some(program()), None, &names))
}

/// Writes `n` scenes with walls and robots that avoid them. Each scene has its own headings, number of robots and seed.
fn arenas(place: &TestFolder, n: u64) {
    place.write("avoid_walls.lua", &std::fs::read_to_string(root().join("scenes/first/avoid_walls.lua")).unwrap());
    for i in 0..n {
        let mut text = format!("format = 1\n[scene]\nseed = {i}\n{FLOOR}");
        for (k, (x, y, w, h)) in
            [(0.0, 2.0, 4.2, 0.1), (0.0, -2.0, 4.2, 0.1), (2.0, 0.0, 0.1, 4.2), (-2.0, 0.0, 0.1, 4.2)]
                .into_iter()
                .enumerate()
        {
            text += &cuboid(&format!("wall{k}"), [w, h, 0.5], [x, y, 0.25], "respondable = true");
        }
        for robot in 0..2 + i % 3 {
            let (x, y) = ([-1.0, 1.0, -1.0, 1.0][robot as usize], [-1.0, -1.0, 1.0, 1.0][robot as usize]);
            let heading = (37 * i + 91 * robot) % 360;
            text += &format!(
                "[[model]]\nmodel = \"pioneer_p3dx\"\nposition_m = [{x:?}, {y:?}, 0.0]\n\
                 orientation_deg = [0.0, 0.0, {heading}.0]\nscript = \"avoid_walls.lua\"\n"
            );
        }
        place.write(&format!("arena{i}.toml"), &text);
    }
}

fn document(place: &TestFolder, name: &str, registry: &Registry) -> Arc<Document> {
    Arc::new(document::load(&place.path().join(name), registry, &LoadOptions::default()).unwrap())
}

#[test]
fn worlds_on_two_threads_do_as_each_does_alone() {
    const WORLDS: u64 = 64;
    const STEPS: u64 = 100;
    let place = TestFolder::new();
    arenas(&place, WORLDS);
    let registry = registry();
    // Each of the two threads steps its worlds alternately, so their steps are interleaved.
    let thread_of = |which: u64| {
        let worlds: Vec<(u64, World)> = (0..WORLDS)
            .filter(|i| i % 2 == which)
            .map(|i| (i, World::new(document(&place, &format!("arena{i}.toml"), &registry), registry.clone()).unwrap()))
            .collect();
        worlds.iter().for_each(|(_, w)| w.start());
        for _ in 0..STEPS {
            worlds.iter().for_each(|(_, w)| assert!(w.step()));
        }
        assert!(worlds.iter().all(|(_, w)| w.faults().is_empty()));
        worlds.iter().map(|(i, w)| (*i, w.hash())).collect::<Vec<_>>()
    };
    let together: BTreeMap<_, _> = thread::scope(|scope| {
        let other = scope.spawn(|| thread_of(1));
        thread_of(0).into_iter().chain(other.join().unwrap()).collect()
    });
    let distinct: std::collections::BTreeSet<u64> = together.values().map(|h| h.total).collect();
    assert_eq!(distinct.len() as u64, WORLDS, "two arenas have the same result");
    for (i, hash) in &together {
        let alone = World::new(document(&place, &format!("arena{i}.toml"), &registry), registry.clone()).unwrap();
        alone.start();
        for _ in 0..STEPS {
            alone.step();
        }
        assert_eq!(alone.hash(), *hash, "arena {i}");
    }
}

/// Creates a session with the `jsonl` service. Returns it with the port on which the service listens.
fn session(registry: &Arc<Registry>, more: &str) -> (Session, u16) {
    let place = TestFolder::scene(&watcher("nobody", ""));
    // Another program may have taken the port since it was found to be free, so this tries several times.
    for _ in 0..20 {
        let port = TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap().port();
        let service = ServiceOverride::parse(&format!("jsonl:port={port}{more}")).unwrap();
        let options = LoadOptions { services: vec![service], ..Default::default() };
        let services = document::load(&place.path().join("scene.toml"), registry, &options).unwrap().requests.services;
        if let Ok(session) = Session::new(registry.clone(), &services) {
            return (session, port);
        }
    }
    panic!("no free port");
}

/// Runs steps until a stop is requested.
fn run_until_stop_request(world: &World) {
    while !world.stop_requested() && world.step() {}
}

#[test]
fn a_service_outlives_a_world() {
    let registry = registry();
    let place = TestFolder::scene(&format!("{FLOOR}{}", cuboid("first", [0.1; 3], [0.0, 0.0, 3.0], "dynamic = true")));
    place.write("second.toml", &format!("format = 1\n{}", watcher("second", "")));
    let (session, port) = session(&registry, ",wait_for=1");
    // The client keeps its connection while one world replaces another.
    let client = thread::spawn(move || {
        let mut client = TestClient::connect(port);
        client.stepping();
        client.call("sim.getObject", json!(["/first"]));
        assert_eq!(client.step(5), 5);
        assert!(client.ask(json!({ "call": "sim.getObject", "args": ["/second"] }))["error"].is_object());
        client.ask(json!({ "request": "stop" }));
        // When the first world has stopped, the client requests a start. Until then it polls the state.
        while client.ask(json!({ "state": true }))["state"] != "stopped" {}
        client.ask(json!({ "request": "start" }));
        assert_eq!(client.step(2), 2);
        client.ask(json!({ "request": "stop" }));
        // Waits until the second world answers.
        while client.ask(json!({ "call": "sim.getObject", "args": ["/second"] }))["result"].is_null() {}
        let reached = client.step(3);
        client.ask(json!({ "request": "quit" }));
        reached
    });
    let first = World::new(document(&place, "scene.toml", &registry), registry.clone()).unwrap();
    session.join(&first);
    first.start();
    run_until_stop_request(&first);
    assert_eq!(first.steps(), 5);
    first.stop();
    assert!(session.wait_for_start(&first), "no service requested a start");
    first.start();
    run_until_stop_request(&first);
    assert_eq!(first.steps(), 2);
    drop(first);
    let second = World::new(document(&place, "second.toml", &registry), registry.clone()).unwrap();
    session.join(&second);
    second.start();
    run_until_stop_request(&second);
    assert_eq!(client.join().unwrap(), 3);
    assert_eq!(second.steps(), 3);
}

#[test]
fn a_session_has_two_worlds_and_each_its_log() {
    let registry = registry();
    let place = TestFolder::new();
    arenas(&place, 2);
    let documents: Vec<_> = (0..2).map(|i| document(&place, &format!("arena{i}.toml"), &registry)).collect();
    let (session, port) = session(&registry, ",wait_for=2");
    let clients = (0..2_u64).map(|i| {
        thread::spawn(move || {
            let mut client = TestClient::connect(port);
            client.ask(json!({ "world": i }));
            client.stepping();
            let wall = client.handle("/wall2");
            for n in 0..20 {
                client.call("sim.setObjectPosition", json!([wall, -1, [2.0 - 0.02 * f64::from(n), 0.0, 0.25]]));
                assert_eq!(client.step(1 + i), (1 + i) * (n as u64 + 1));
            }
            client.ask(json!({ "stepping": false }));
        })
    });
    let clients: Vec<_> = clients.collect();
    let worlds: Vec<World> = documents.iter().map(|d| World::new(d.clone(), registry.clone()).unwrap()).collect();
    worlds.iter().for_each(|w| session.join(w));
    worlds.iter().for_each(World::start);
    while clients.iter().any(|c| !c.is_finished()) {
        worlds.iter().for_each(|w| assert!(w.step()));
    }
    clients.into_iter().for_each(|c| c.join().unwrap());
    assert!(worlds[0].steps() >= 40);
    for (world, document) in worlds.iter().zip(documents) {
        let log = world.input_log().records().to_vec();
        assert_eq!(log.iter().filter(|r| r.service == "jsonl").count(), 21, "{log:?}");
        // A world is a function of its document and its log. The first half is replayed at once, the rest step by step.
        let again = replay_to(document, registry.clone(), &log, world.steps() / 2).unwrap();
        assert_eq!(again.steps(), world.steps() / 2);
        while again.steps() < world.steps() {
            again.step();
        }
        assert_eq!(again.hash(), world.hash());
        assert_eq!(*again.input_log().records(), log);
    }
}
