//! Tests of the ZeroMQ remote API with the real client from PyPI, in a virtual environment, and with invalid bytes.

use std::{
    io::{BufRead, BufReader, Read, Write},
    net::TcpStream,
    path::PathBuf,
    process::{Command, Output, Stdio},
    time::Duration,
};

use crate::{
    kit::browser::wait_for,
    kit::served_scene::{self, ServedScene, good},
    kit::*,
};

const SCENE: &str = "scenes/first/pioneer_avoids_walls.toml";

/// Serves one of the scenes in `scenes/first`.
fn served() -> ServedScene {
    ServedScene::new("zmq_remote", SCENE)
}

/// Returns a Python interpreter that has the given version of the real client.
pub fn python(version: &str) -> PathBuf {
    served_scene::python(&format!("coppeliasim-zmqremoteapi-client=={version}"), "coppeliasim_zmqremoteapi_client")
}

/// Runs a client program in which `PORT` is replaced by the port.
fn client(python: &PathBuf, served: &ServedScene, program: &str) -> Output {
    let program = program.replace("PORT", &served.port.to_string());
    Command::new(python).args(["-c", &program]).output().unwrap()
}

#[test]
#[cfg_attr(no_pypi, ignore = "needs python3 with venv and pip, and PyPI")]
fn the_real_client_steers_a_robot_in_step() {
    let python = python("2.0.4");
    let served = served();
    let told = good(&client(
        &python,
        &served,
        r#"
from coppeliasim_zmqremoteapi_client import RemoteAPIClient
client = RemoteAPIClient('localhost', PORT)
sim = client.require('sim')
robot = sim.getObject('/Pioneer_p3dx')
begin = sim.getObjectPosition(robot)
assert sim.getSimulationState() == sim.simulation_stopped and sim.handle_all == -2
sim.setObjectPosition(robot, sim.handle_world, begin)
assert sim.getObjectPosition(robot) == begin
try:
    sim.getObject('/nope')
    raise SystemExit('no error')
except Exception as e:
    assert '/nope' in str(e) and "(in function 'sim.getObject')" in str(e), e
try:
    client.require('simNothing')
    raise SystemExit('no error')
except Exception as e:
    assert 'simNothing' in str(e), e
sim.setStringSignal('data', b'\x00\xff\x80')
assert sim.getStringSignal('data') == b'\x00\xff\x80', sim.getStringSignal('data')
client.setStepping(True)
sim.startSimulation()
for i in range(40):
    assert abs(sim.getSimulationTime() - 0.05 * i) < 1e-9, (i, sim.getSimulationTime())
    client.step()
there = sim.getObjectPosition(robot)
assert abs(there[0] - begin[0]) > 0.1, there
sim.stopSimulation()
import time
while sim.getSimulationState() != sim.simulation_stopped:
    time.sleep(0.01)
assert sim.getObjectPosition(robot) == begin
# Without stepping, a run proceeds by itself.
sim.setStepping(False)
sim.startSimulation()
while sim.getSimulationTime() < 1:
    sim.step()
print('done', sim.getSimulationTime() >= 1)
"#,
    ));
    assert!(told.contains("done True"), "{told}");
}

#[test]
#[cfg_attr(no_pypi, ignore = "needs python3 with venv and pip, and PyPI")]
fn clients_of_the_first_protocol_step_too() {
    let python = python("0.0.4");
    let served = served();
    let told = good(&client(
        &python,
        &served,
        r#"
from coppeliasim_zmqremoteapi_client import RemoteAPIClient
client = RemoteAPIClient('localhost', PORT)
sim = client.getObject('sim')
robot = sim.getObject('/Pioneer_p3dx')
client.setStepping(True)
sim.startSimulation()
for i in range(20):
    client.step()
print('time', round(sim.getSimulationTime(), 6))
try:
    sim.getObject('/nope')
    print('no error')
except Exception as e:
    print('told', '/nope' in str(e))
sim.stopSimulation()
"#,
    ));
    assert!(told.contains("told True") && told.contains("time "), "{told}");
}

#[test]
#[cfg_attr(no_pypi, ignore = "needs python3 with venv and pip, and PyPI")]
fn a_client_that_dies_does_not_block_the_run() {
    let python = python("2.0.4");
    let served = served();
    let hold = "
from coppeliasim_zmqremoteapi_client import RemoteAPIClient
client = RemoteAPIClient('localhost', PORT)
sim = client.require('sim')
client.setStepping(True)
sim.startSimulation()
print('held', flush=True)
";
    // The client is killed between its steps, with a lock, during a step, during a command that waits, and in a
    // callback.
    for state in [
        "import time; time.sleep(100)",
        "sim.acquireLock(); import time; time.sleep(100)",
        "while True: client.step()",
        "sim.wait(1e6)",
        "import time; sim.testCB(1, lambda a, b: time.sleep(100), 2)",
    ] {
        let mut victim = Command::new(&python)
            .args(["-c", &format!("{}{state}", hold.replace("PORT", &served.port.to_string()))])
            .stdout(Stdio::piped())
            .spawn()
            .unwrap();
        BufReader::new(victim.stdout.as_mut().unwrap()).read_line(&mut String::new()).unwrap();
        std::thread::sleep(Duration::from_millis(100));
        victim.kill().unwrap();
        victim.wait().unwrap();
        let told = good(&client(
            &python,
            &served,
            "
import time
from coppeliasim_zmqremoteapi_client import RemoteAPIClient
sim = RemoteAPIClient('localhost', PORT).require('sim')
begin = sim.getSimulationTime()
while sim.getSimulationTime() < begin + 0.5:
    time.sleep(0.01)
sim.stopSimulation()
while sim.getSimulationState() != sim.simulation_stopped:
    time.sleep(0.01)
print('went on')
",
        ));
        assert!(told.contains("went on"), "{state}: {told}");
    }
}

#[test]
#[cfg_attr(no_pypi, ignore = "needs python3 with venv and pip, and PyPI")]
fn malformed_frames_close_only_their_connection() {
    let served = served();
    let mut greeting = [0_u8; 64];
    (greeting[0], greeting[8], greeting[9], greeting[10]) = (0xFF, 1, 0x7F, 3);
    greeting[12..16].copy_from_slice(b"NULL");
    let ready = b"\x04\x1a\x05READY\x0bSocket-Type\x00\x00\x00\x03REQ";
    let ready = [&[4, (ready.len() - 2) as u8][..], &ready[2..]].concat();
    let refused = |bytes: &[u8]| {
        let mut stream = served.connect();
        let _ = stream.write_all(bytes);
        // The connection is closed, and the only answer is a greeting.
        let mut answer = Vec::new();
        let _ = stream.read_to_end(&mut answer);
        assert!(answer.len() < 200, "{} bytes", answer.len());
    };
    refused(&[0x47; 64]);
    refused(b"GET / HTTP/1.1\r\nHost: 127.0.0.1\r\n\r\n and so on, for more than a greeting has ....");
    let shaken = |more: &[u8]| [&greeting[..], &ready, more].concat();
    // A frame with a claimed size of 64 GiB, a frame with unknown flags, and a body without a delimiter.
    refused(&shaken(&[1, 0, 2, 0, 0, 0, 16, 0, 0, 0, 0]));
    refused(&shaken(&[0xF0, 1, 0]));
    refused(&shaken(&[0, 1, 0]));
    // A message that is not a request is answered with an error, and the connection remains open.
    let mut stream = served.connect();
    stream.write_all(&shaken(&[1, 0, 0, 1, 0xFF])).unwrap();
    let mut all = vec![0; 64 + 30];
    stream.read_exact(&mut all).unwrap();
    let mut head = [0; 4];
    stream.read_exact(&mut head).unwrap();
    assert_eq!(head[..2], [1, 0], "{head:?}");
    // A thousand connections send nothing or half a greeting.
    let quiet: Vec<TcpStream> = (0..1000).filter_map(|_| TcpStream::connect(("127.0.0.1", served.port)).ok()).collect();
    for mut stream in &quiet {
        let _ = stream.write_all(&greeting[..20]);
    }
    drop(quiet);
    let python = python("2.0.4");
    let done = || {
        let program = "from coppeliasim_zmqremoteapi_client import RemoteAPIClient\n\
                       print(RemoteAPIClient('localhost', PORT).require('sim').getSimulationTime())";
        client(&python, &served, program).status.success().then_some(())
    };
    wait_for("a client after all these", Duration::from_secs(30), done);
}

#[test]
#[cfg_attr(no_pypi, ignore = "needs python3 with venv and pip, and PyPI")]
fn functions_of_a_client_are_called_back() {
    let python = python("2.0.4");
    let served = served();
    let told = good(&client(
        &python,
        &served,
        r#"
from coppeliasim_zmqremoteapi_client import RemoteAPIClient
client = RemoteAPIClient('localhost', PORT)
sim = client.require('sim')
calls = 0
def add(a, b):
    global calls
    calls += 1
    return a + b
assert sim.testCB(21, add, 21, 9) == 42 and calls == 10, calls
# A callback can call commands, and commands that call callbacks.
def deep(a, b):
    assert sim.testCB(a, add, b, 0) == a + b
    return sim.getObject('/Pioneer_p3dx')
robot = sim.getObject('/Pioneer_p3dx')
assert sim.testCB(1, deep, 2, 3) == robot
# An error of a command in a callback is passed on, and the client can continue.
def wrong(a, b):
    sim.getObject('/nope')
try:
    sim.testCB(1, wrong, 2, 0)
    raise SystemExit('no error')
except Exception as e:
    assert '/nope' in str(e), e
"#,
    ));
    assert!(told.is_empty(), "{told}");
    // Functions of clients can also be passed inside tables, and to commands that wait for steps.
    let told = good(&client(
        &python,
        &served,
        r#"
from coppeliasim_zmqremoteapi_client import RemoteAPIClient
client = RemoteAPIClient('localhost', PORT)
sim = client.require('sim')
dummy = sim.createDummy(0.1)
seen = []
def on_move(data):
    seen.append(data['pose'][0])
    sim.setFloatSignal('x', data['pose'][0])
# During a callback, the simulation time stands still, even in a command that waits.
sim.startSimulation()
while sim.getSimulationTime() == 0:
    pass
def waits(a, b):
    begin = sim.getSimulationTime()
    sim.wait(1)
    assert sim.getSimulationTime() == begin
    try:
        client.step()
        raise SystemExit('no error')
    except Exception as e:
        assert 'cannot request a step' in str(e), e
sim.testCB(1, waits, 2, 0)
goal = [1, 0, 0, 0, 0, 0, 1]
sim.moveToPose({'object': dummy, 'targetPose': goal, 'maxVel': [2.0], 'maxAccel': [4.0], 'maxJerk': [80.0],
                'metric': [1, 1, 1, 0.1], 'callback': on_move})
assert len(seen) > 5 and seen == sorted(seen), seen
assert abs(seen[-1] - 1) < 1e-3 and sim.getFloatSignal('x') == seen[-1], seen
print('moved')
"#,
    ));
    assert!(told.contains("moved"), "{told}");
}

#[test]
#[cfg_attr(no_pypi, ignore = "needs python3 with venv and pip, and PyPI")]
fn actions_of_clients_are_replayed_from_the_log() {
    let python = python("2.0.4");
    let folder = tempfile::tempdir().unwrap();
    let log = folder.path().join("log.jsonl").display().to_string();
    let mut process = Command::new(env!("CARGO_BIN_EXE_tatu"))
        .current_dir(root())
        .args(["run", SCENE, "--service", "zmq_remote:port=0", "--log", &log, "--realtime"])
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let mut err = BufReader::new(process.stderr.take().unwrap());
    let mut line = String::new();
    // If the next port is in use, a warning is printed first.
    while !line.contains(": listening on ") {
        line.clear();
        assert!(err.read_line(&mut line).unwrap() > 0, "the program exited before it listened");
    }
    let port = line.trim().rsplit(':').next().unwrap().to_owned();
    let program = "
from coppeliasim_zmqremoteapi_client import RemoteAPIClient
client = RemoteAPIClient('localhost', PORT)
sim = client.require('sim')
client.setStepping(True)
left = sim.getObject('/Pioneer_p3dx/Pioneer_p3dx_leftMotor')
for i in range(20):
    sim.setJointTargetVelocity(left, 0.1 * i)
    sim.setInt32Signal('n', i)
    client.step()
def speed(a, b):
    sim.setInt32Signal('n', 100)
    return sim.testCB(a, lambda a, b: a * b, b, 1)
for i in range(10):
    sim.setJointTargetVelocity(left, sim.testCB(0.2, speed, i, 1))
    client.step()
sim.setStepping(False)
sim.stopSimulation()
"
    .replace("PORT", &port);
    good(&Command::new(&python).args(["-c", &program]).output().unwrap());
    let mut live = String::new();
    err.read_to_string(&mut live).unwrap();
    process.wait().unwrap();
    let hash = |text: &str| text.split("hash ").nth(1).unwrap_or_else(|| panic!("{text}"))[..16].to_owned();
    let again =
        Command::new(env!("CARGO_BIN_EXE_tatu")).current_dir(root()).args(["run", "--replay", &log]).output().unwrap();
    assert_eq!(hash(&live), hash(&String::from_utf8_lossy(&again.stderr)));
}
