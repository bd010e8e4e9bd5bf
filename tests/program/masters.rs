//! One barrier, many masters: clients of all protocols and a script steer robots of one world.

use std::{
    io::{BufRead, BufReader, Read},
    process::{Command, Stdio},
};

use crate::{kit::*, legacy, rosbridge, zmq};

/// Five robots; the first one has a script.
fn scene() -> String {
    let mut text = String::from(
        "format = 1\n[[object]]\nkind = \"shape\"\nalias = \"floor\"\nprimitive = \"plane\"\nrespondable = true\n",
    );
    for i in 0..5 {
        text += &format!("[[model]]\nmodel = \"pioneer_p3dx\"\nalias = \"robot{i}\"\nposition_m = [0, {i}, 0]\n");
        if i == 0 {
            text += "script = { text = \"\"\"\nfunction sysCall_actuation()\n  \
                     sim.setJointTargetVelocity(sim.getObject('./Pioneer_p3dx_leftMotor'), 1 + 0.1 * math.sin(sim.getSimulationTime()))\n\
                     end\n\"\"\" }\n";
        }
    }
    text
}

/// Each client steers a robot of its own and lets the steps pass; in the end two of them are gone, and the third goes on.
const PROGRAM: &str = r#"
import json, socket
from coppeliasim_zmqremoteapi_client import RemoteAPIClient

modern = RemoteAPIClient('localhost', MODERN)
sim = modern.require('sim')
lines = socket.create_connection(('127.0.0.1', LINES)).makefile('rw')
def ask(**message):
    lines.write(json.dumps(message) + '\n')
    lines.flush()
def answer():
    while True:
        message = json.loads(lines.readline())
        if 'id' in message:
            return message
ask(id=0, stepping=True); answer()
modern.setStepping(True)
good(vrep.simxSynchronous(client, True))
wheels = ['/robot%d/Pioneer_p3dx_leftMotor' % i for i in range(4)]
one, two = sim.getObject(wheels[1]), handle(wheels[2])
ask(id=1, call='sim.getObject', args=[wheels[3]])
three = answer()['result'][0]
for i in range(30):
    ask(id=2, call='sim.setJointTargetVelocity', args=[three, 0.3 * i]); answer()
    good(vrep.simxSetJointTargetVelocity(client, two, 0.2 * i, WAIT))
    sim.setJointTargetVelocity(one, 0.1 * i)
    good(vrep.simxSynchronousTrigger(client))
    ask(id=3, step=1)
    modern.step()
    answer()
assert abs(sim.getSimulationTime() - 1.5) < 1e-9, sim.getSimulationTime()
lines.close()
vrep.simxFinish(client)
for i in range(10):
    modern.step()
print('time', sim.getSimulationTime())
modern.setStepping(False)
sim.stopSimulation()
"#;

/// Drives a robot of its own, without waiting for steps, until it is killed.
const DRIVER: &str = r#"
cmd = roslibpy.Topic(ros, '/robot4/cmd_vel', 'geometry_msgs/Twist')
i = 0
while True:
    cmd.publish(roslibpy.Message({'linear': {'x': 0.1 + 0.01 * (i % 10)}, 'angular': {'z': 0.3}}))
    if i == 0:
        print('drives', flush=True)
    i += 1
    time.sleep(0.003)
"#;

#[test]
fn masters_of_all_protocols_steer_one_world_and_are_repeated() {
    let (Some(python), Some(bindings), Some(ros)) = (zmq::python("2.0.4"), legacy::bindings(), rosbridge::python())
    else {
        return;
    };
    let place = Place::new();
    place.write("scene.toml", &scene());
    let mut process = Command::new(env!("CARGO_BIN_EXE_tatu"))
        .current_dir(place.path())
        .env_remove("TATU_PLUGIN_PATH")
        .args(["run", "scene.toml", "--log", "log.jsonl", "--realtime"])
        .args([
            "--service",
            "jsonl:port=0,wait_for=1",
            "--service",
            "zmq_remote:port=0",
            "--service",
            "legacy_remote:port=0",
            "--service",
            "rosbridge:port=0",
        ])
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let mut err = BufReader::new(process.stderr.take().unwrap());
    let mut ports = std::collections::BTreeMap::new();
    while ports.len() < 4 {
        let mut line = String::new();
        assert!(err.read_line(&mut line).unwrap() > 0, "the program ended before it listened");
        if let Some((service, address)) = line.trim().split_once(": listening on ") {
            ports.insert(service.to_owned(), address.rsplit(':').next().unwrap().to_owned());
        }
    }
    let program = format!("{}{PROGRAM}", legacy::begin(bindings, ports["legacy_remote"].parse().unwrap()))
        .replace("MODERN", &ports["zmq_remote"])
        .replace("LINES", &ports["jsonl"]);
    let driver = format!("{}{DRIVER}", rosbridge::BEGIN).replace("PORT", &ports["rosbridge"]);
    let mut driver =
        Command::new(ros).args(["-c", &driver]).stdout(Stdio::piped()).stderr(Stdio::null()).spawn().unwrap();
    BufReader::new(driver.stdout.as_mut().unwrap()).read_line(&mut String::new()).unwrap();
    let done = Command::new(&python).args(["-c", &program]).output().unwrap();
    driver.kill().unwrap();
    driver.wait().unwrap();
    let told = String::from_utf8_lossy(&done.stdout).into_owned();
    assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
    assert!(told.contains("time 2.0"), "{told}");
    let mut live = String::new();
    err.read_to_string(&mut live).unwrap();
    process.wait().unwrap();
    let hash = |text: &str| text.split("hash ").nth(1).unwrap_or_else(|| panic!("{text}"))[..16].to_owned();
    let again = place.tatu(&["run", "--replay", "log.jsonl"]);
    assert_eq!(hash(&live), hash(&again.err));
    let log = std::fs::read_to_string(place.path().join("log.jsonl")).unwrap();
    assert!(log.contains("tatu.drive"), "no velocity came in before the others ended");
}
