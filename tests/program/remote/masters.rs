//! Tests of several clients at one barrier: clients of all protocols and a script drive robots in one world.

use std::{
    io::{BufRead, BufReader, Read},
    process::{Command, Stdio},
};

use crate::{kit::*, remote::legacy_remote, remote::rosbridge, remote::zmq_remote};

/// Returns the text of a scene with six robots, the first of which has a script.
fn scene() -> String {
    let mut text = String::from(
        "format = 1\n[scene]\nplugins = [\"plugins\"]\n[[object]]\nkind = \"shape\"\nalias = \"floor\"\nprimitive = \"plane\"\nrespondable = true\n",
    );
    for i in 0..6 {
        text += &format!("[[model]]\nmodel = \"pioneer_p3dx\"\nalias = \"robot{i}\"\nposition_m = [0, {i}, 0]\n");
        if i == 0 {
            text += "script = { text = \"\"\"\nfunction sysCall_actuation()\n  \
                     sim.setJointTargetVelocity(sim.getObject('./Pioneer_p3dx_leftMotor'), 1 + 0.1 * math.sin(sim.getSimulationTime()))\n\
                     end\n\"\"\" }\n";
        }
    }
    text
}

/// A plugin in C with a service that drives the last robot.
const SERVICE_IN_C: &str = r#"
#include <string.h>
#include "tatu.h"
typedef struct { const tatu_host *host; tatu_object wheel; } driver;
static tatu_status TATU_CALL init(const tatu_host *host, void **self, tatu_error *e) {
  static driver one;
  (void)e;
  one.host = host;
  *self = &one;
  return TATU_OK;
}
static tatu_status TATU_CALL create(void *self, const tatu_instance *i, void **data, tatu_error *e) {
  (void)i; (void)e;
  *data = self;
  return TATU_OK;
}
static void TATU_CALL destroy(void *data) { (void)data; }
static tatu_status TATU_CALL barrier(void *data, tatu_world *w, uint64_t step, tatu_error *e) {
  driver *d = data;
  const tatu_host_scene *scene = d->host->service(d->host, TATU_HOST_SCENE);
  const tatu_host_commands *commands = d->host->service(d->host, TATU_HOST_COMMANDS);
  tatu_value args[2], results[16];
  tatu_call frame = tatu_frame(args, 2, results, 16);
  (void)e;
  if (!d->wheel && scene->find(w, 0, tatu_text("/robot5/Pioneer_p3dx_leftMotor"), &d->wheel) < 0) return TATU_ERR;
  frame.command = commands->find(w, tatu_text("sim.setJointTargetVelocity"), &frame.alias);
  args[0] = tatu_int(TATU_SLOT(d->wheel));
  args[1] = tatu_float(0.05 * (double)(step % 20));
  return commands->call(w, &frame) < 0 ? TATU_ERR : TATU_GO;
}
static const tatu_life life = {.size = sizeof life, .create = create, .destroy = destroy};
static const tatu_service service = {sizeof service, 0, "steers", "Steers a robot.", 0, &life, barrier, 0, 0, 0, 0, 0};
static const tatu_service *const services[] = {&service, 0};
static const tatu_ext_service ext = {sizeof ext, 0, services};
static const void *TATU_CALL extension(void *self, const char *id) {
  (void)self;
  return strcmp(id, TATU_SERVICE) ? 0 : &ext;
}
TATU_EXPORT const tatu_plugin_t tatu_plugin = {sizeof tatu_plugin, TATU_ABI_MAJOR, TATU_ABI_MINOR, "org.example.steers",
  "Steers", "1.0.0", "MIT", 0, init, 0, extension};
"#;

/// A program with three clients, each of which drives a separate robot and releases the steps. At the end two of them
/// disconnect, and the third continues.
const THREE_CLIENTS: &str = r#"
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

/// A program that drives another robot without waiting for steps. It runs until it is killed.
const ROS_DRIVER: &str = r#"
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
#[cfg_attr(no_pypi, ignore = "needs python3 with venv and pip, and PyPI")]
fn masters_of_all_protocols_steer_one_world_and_are_repeated() {
    let (python, bindings, ros) = (zmq_remote::python("2.0.4"), legacy_remote::bindings(), rosbridge::python());
    let place = TestFolder::new();
    place.write("scene.toml", &scene()).write("plugins/steers.c", SERVICE_IN_C);
    succeed(
        Command::new(compiler("cc"))
            .args(["-std=c11", "-Wall", "-Wextra", "-Werror", "-shared", "-fPIC", "-I"])
            .arg(root().join("plugin-api/include"))
            .args(["steers.c", "-o", &library("tatu_steers")])
            .current_dir(place.path().join("plugins")),
    );
    let mut process = Command::new(env!("CARGO_BIN_EXE_tatu"))
        .current_dir(place.path())
        .env_remove("TATU_PLUGIN_PATH")
        .args(["run", "scene.toml", "--capsule", "run.tatu", "--realtime"])
        .args([
            "--service",
            "jsonl:port=0,wait_for=1",
            "--service",
            "zmq_remote:port=0",
            "--service",
            "legacy_remote:port=0",
            "--service",
            "rosbridge:port=0",
            "--service",
            "steers",
            "--allow",
            "plugins",
        ])
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let mut err = BufReader::new(process.stderr.take().unwrap());
    let mut ports = std::collections::BTreeMap::new();
    while ports.len() < 4 {
        let mut line = String::new();
        assert!(err.read_line(&mut line).unwrap() > 0, "the program exited before it listened");
        eprint!("{line}");
        if let Some((service, address)) = line.trim().split_once(": listening on ") {
            ports.insert(service.to_owned(), address.rsplit(':').next().unwrap().to_owned());
        }
    }
    let program = format!("{}{THREE_CLIENTS}", legacy_remote::begin(bindings, ports["legacy_remote"].parse().unwrap()))
        .replace("MODERN", &ports["zmq_remote"])
        .replace("LINES", &ports["jsonl"]);
    let driver = format!("{}{ROS_DRIVER}", rosbridge::CLIENT_PREAMBLE).replace("PORT", &ports["rosbridge"]);
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
    let again = place.tatu(&["verify", "run.tatu"]).good();
    assert!(again.out.starts_with("same: ") && again.out.contains(&hash(&live)), "{}{}", again.out, again.err);
    place.tatu(&["unpack", "run.tatu"]).good();
    let log = place.read("run/run/inputs.jsonl");
    assert!(log.contains("steers"), "the service in C did nothing");
    assert!(log.contains("tatu.drive"), "no velocity arrived before the others exited");
}

/// A robot, and a script that drives it if a file requests this, so that the two runs to be compared have the same
/// objects.
const STEERED: &str = r#"
format = 1
[[object]]
kind = "shape"
alias = "floor"
primitive = "plane"
respondable = true
[[model]]
model = "pioneer_p3dx"
alias = "robot"
script = { text = """
function sysCall_init()
    left = sim.getObject('./Pioneer_p3dx_leftMotor')
    right = sim.getObject('./Pioneer_p3dx_rightMotor')
    local file = io.open('steer.txt')
    steer = file ~= nil
    if file then file:close() end
    k = 0
end
function sysCall_actuation()
    if steer then
        sim.setJointTargetVelocity(left, 0.125 * k)
        sim.setJointTargetVelocity(right, 0.25 * k)
    end
    k = k + 1
end
""" }
"#;

/// A program that sends the commands of the script in [`STEERED`] at the same steps, and then a stop. The line `READY`
/// is replaced by the code that starts the simulation.
const BY_ZMQ: &str = r#"
from coppeliasim_zmqremoteapi_client import RemoteAPIClient
client = RemoteAPIClient('localhost', PORT)
sim = client.require('sim')
left = sim.getObject('/robot/Pioneer_p3dx_leftMotor')
right = sim.getObject('/robot/Pioneer_p3dx_rightMotor')
client.setStepping(True)
READY
for k in range(20):
    sim.setJointTargetVelocity(left, 0.125 * k)
    sim.setJointTargetVelocity(right, 0.25 * k)
    client.step()
sim.stopSimulation()
"#;
const BY_LEGACY: &str = r#"
left = handle('Pioneer_p3dx_leftMotor')
right = handle('Pioneer_p3dx_rightMotor')
good(vrep.simxSynchronous(client, True))
READY
for k in range(20):
    good(vrep.simxSetJointTargetVelocity(client, left, 0.125 * k, WAIT))
    good(vrep.simxSetJointTargetVelocity(client, right, 0.25 * k, WAIT))
    good(vrep.simxSynchronousTrigger(client))
    good(vrep.simxGetPingTime(client))
vrep.simxStopSimulation(client, WAIT)
"#;
const BY_LINES: &str = r#"
import json, socket
lines = socket.create_connection(('127.0.0.1', PORT)).makefile('rw')
def ask(**message):
    lines.write(json.dumps(dict(message, id=1)) + '\n')
    lines.flush()
    while True:
        answer = json.loads(lines.readline())
        if 'id' in answer:
            return answer
left = ask(call='sim.getObject', args=['/robot/Pioneer_p3dx_leftMotor'])['result'][0]
right = ask(call='sim.getObject', args=['/robot/Pioneer_p3dx_rightMotor'])['result'][0]
ask(stepping=True)
for k in range(20):
    ask(call='sim.setJointTargetVelocity', args=[left, 0.125 * k])
    ask(call='sim.setJointTargetVelocity', args=[right, 0.25 * k])
    ask(step=1)
ask(request='stop')
"#;
/// Code that waits until the other client holds the barrier, and then releases it.
const RELEASE_BARRIER: &str = r#"
import json, socket
gate = socket.create_connection(('127.0.0.1', GATE)).makefile('rw')
for on in (True, False):
    gate.write(json.dumps({'id': 1, 'stepping': on}) + '\n')
    gate.flush()
    gate.readline()
"#;

#[test]
#[cfg_attr(no_pypi, ignore = "needs python3 with venv and pip, and PyPI")]
fn equal_commands_by_any_protocol_lead_to_equal_hashes() {
    let (python, bindings) = (zmq_remote::python("2.0.4"), legacy_remote::bindings());
    let place = TestFolder::new();
    place.write("scene.toml", STEERED);
    let hash = |text: &str| text.split("hash ").nth(1).unwrap_or_else(|| panic!("{text}"))[..16].to_owned();
    let by = |service: &str, program: &str| {
        let mut process = Command::new(env!("CARGO_BIN_EXE_tatu"))
            .current_dir(place.path())
            .env_remove("TATU_PLUGIN_PATH")
            .args(["run", "scene.toml", "--service", "jsonl:port=0,wait_for=1"])
            .args(if service == "jsonl" { vec![] } else { vec!["--service".to_owned(), format!("{service}:port=0")] })
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        let mut err = BufReader::new(process.stderr.take().unwrap());
        let mut ports = std::collections::BTreeMap::new();
        while !(ports.contains_key("jsonl") && ports.contains_key(service)) {
            let mut line = String::new();
            assert!(err.read_line(&mut line).unwrap() > 0, "the program exited before it listened");
            eprint!("{line}");
            if let Some((service, address)) = line.trim().split_once(": listening on ") {
                ports.insert(service.to_owned(), address.rsplit(':').next().unwrap().to_owned());
            }
        }
        let begin = match service {
            "legacy_remote" => legacy_remote::begin(bindings, ports[service].parse().unwrap()),
            _ => String::new(),
        };
        let program =
            program.replace("READY", RELEASE_BARRIER).replace("PORT", &ports[service]).replace("GATE", &ports["jsonl"]);
        let done = Command::new(&python).args(["-c", &format!("{begin}{program}")]).output().unwrap();
        assert!(done.status.success(), "{service}: {}", String::from_utf8_lossy(&done.stderr));
        let mut told = String::new();
        err.read_to_string(&mut told).unwrap();
        process.wait().unwrap();
        assert!(told.contains("20 steps"), "{service}: {told}");
        hash(&told)
    };
    let hashes = [by("jsonl", BY_LINES), by("zmq_remote", BY_ZMQ), by("legacy_remote", BY_LEGACY)];
    let unsteered = place.tatu(&["run", "scene.toml", "--steps", "20"]);
    place.write("steer.txt", "");
    let script = hash(&place.tatu(&["run", "scene.toml", "--steps", "20"]).err);
    assert_ne!(script, hash(&unsteered.err));
    assert_eq!(hashes, [script.clone(), script.clone(), script]);
}
