//! Tests of the legacy remote API with the real client library, taken from a PyPI package and driven by its own Python
//! binding. `wire` is a client of raw bytes, `bytes` the tests that use it; `files` transfers files.

mod bytes;
mod files;
pub mod wire;

use std::{
    io::{BufRead, BufReader, Read, Write},
    net::TcpStream,
    path::PathBuf,
    process::{Child, ChildStderr, Command, Stdio},
    sync::OnceLock,
    time::Duration,
};

use crate::{
    kit::served_scene::{self, ServedScene, good},
    kit::*,
};

const SCENE: &str = "scenes/first/pioneer_avoids_walls.toml";

/// Serves one of the scenes in `scenes/first`.
fn served() -> ServedScene {
    ServedScene::new("legacy_remote", SCENE)
}

/// Returns the folder of the library and its Python binding.
pub fn bindings() -> &'static PathBuf {
    static BINDINGS: OnceLock<PathBuf> = OnceLock::new();
    BINDINGS.get_or_init(|| {
        let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("legacy-client");
        let bindings = folder.join("pypot/vrep/remoteApiBindings");
        if !bindings.join("vrep.py").is_file() {
            let fetched = Command::new("python3")
                .args(["-m", "pip", "download", "-q", "--no-deps", "pypot==5.0.2", "-d"])
                .arg(&folder)
                .output();
            let unpack = "import glob, sys, zipfile\nzipfile.ZipFile(glob.glob(sys.argv[1] + '/*.whl')[0]).extractall(sys.argv[1])";
            if fetched.is_ok_and(|o| o.status.success()) {
                let _ = Command::new("python3").args(["-c", unpack]).arg(&folder).output();
            }
        }
        assert!(bindings.join("vrep.py").is_file(), "pypot==5.0.2 cannot be fetched from PyPI{}", served_scene::OFFLINE_HINT);
        bindings
    })
}

/// The beginning of each client program, which loads the binding without the package that contains it, and connects.
const CLIENT_PREAMBLE: &str = r#"
import importlib.util, sys, time, types
FOLDER = 'BINDINGS/'
for name in ('pypot', 'pypot.vrep', 'pypot.vrep.remoteApiBindings'):
    sys.modules[name] = types.ModuleType(name)
    sys.modules[name].__path__ = [FOLDER] if name.endswith('Bindings') else []
def load(name):
    spec = importlib.util.spec_from_file_location('pypot.vrep.remoteApiBindings.' + name, FOLDER + name + '.py')
    module = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module
    spec.loader.exec_module(module)
    return module
load('vrepConst')
vrep = load('vrep')
WAIT = vrep.simx_opmode_oneshot_wait
client = vrep.simxStart('127.0.0.1', PORT, True, True, 5000, 5)
assert client >= 0, client
def good(result):
    error, *values = result if isinstance(result, tuple) else (result,)
    assert error == 0, error
    return values[0] if len(values) == 1 else values
def handle(name):
    return good(vrep.simxGetObjectHandle(client, name, WAIT))
"#;

/// Returns the beginning of a program that connects to a port.
pub fn begin(bindings: &std::path::Path, port: u16) -> String {
    CLIENT_PREAMBLE.replace("PORT", &port.to_string()).replace("BINDINGS", &bindings.display().to_string())
}

fn client(served: &ServedScene, bindings: &std::path::Path, program: &str) -> Command {
    let all = format!("{}{program}", begin(bindings, served.port));
    let mut command = Command::new("python3");
    command.args(["-c", &all]);
    command
}

/// Starts `tatu run scene.toml --log run.log` in `place`. Returns the process, the port of its service, and the rest of
/// its standard error.
fn logged(place: &TestFolder) -> (Child, u16, BufReader<ChildStderr>) {
    let mut process = Command::new(program())
        .current_dir(place.path())
        .args(["run", "scene.toml", "--service", "legacy_remote:port=0", "--log", "run.log", "--realtime"])
        .env_remove("TATU_PLUGIN_PATH")
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let (mut err, mut line) = (BufReader::new(process.stderr.take().unwrap()), String::new());
    err.read_line(&mut line).unwrap();
    let port = line.trim().rsplit(':').next().unwrap().parse().unwrap_or_else(|_| panic!("{line}"));
    (process, port, err)
}

#[test]
#[cfg_attr(no_pypi, ignore = "needs python3 with venv and pip, and PyPI")]
fn the_real_library_steers_a_robot() {
    let bindings = bindings();
    let served = served();
    let told = client(
        &served,
        bindings,
        r#"
robot, left = handle('Pioneer_p3dx'), handle('/Pioneer_p3dx/Pioneer_p3dx_leftMotor')
assert vrep.simxGetObjectHandle(client, 'nope', WAIT)[0] == vrep.simx_return_remote_error_flag
assert 'nope' in good(vrep.simxGetLastErrors(client, WAIT))[0]
begin = good(vrep.simxGetObjectPosition(client, robot, -1, WAIT))
assert abs(begin[0] + 1.5) < 1e-6 and abs(begin[1] - 1.2) < 1e-6, begin
assert len(good(vrep.simxGetObjects(client, vrep.sim_object_joint_type, WAIT))) == 4
handles, ints, numbers, texts = good(vrep.simxGetObjectGroupData(client, vrep.sim_object_joint_type, 0, WAIT))
assert 'Pioneer_p3dx_leftMotor' in texts, texts

# Signals, in one piece and in parts.
good(vrep.simxSetFloatSignal(client, 'f', 1.5, WAIT))
assert good(vrep.simxGetFloatSignal(client, 'f', WAIT)) == 1.5
vrep.simxSetStringSignal(client, 's', b'a\x00b' * 100, vrep.simx_opmode_oneshot_split + 200)
for _ in range(200):
    error, text = vrep.simxGetStringSignal(client, 's', WAIT)
    if error == 0:
        break
    time.sleep(0.01)
assert bytes(text) == b'a\x00b' * 100
assert vrep.simxGetIntegerSignal(client, 'none', WAIT)[0] == vrep.simx_return_remote_error_flag

# Step by step: each trigger is one step.
good(vrep.simxSynchronous(client, True))
good(vrep.simxStartSimulation(client, WAIT))
sonar = handle('Pioneer_p3dx_ultrasonicSensor5')
vrep.simxReadProximitySensor(client, sonar, vrep.simx_opmode_streaming)
for i in range(40):
    good(vrep.simxSynchronousTrigger(client))
    vrep.simxGetPingTime(client)
assert vrep.simxGetLastCmdTime(client) == 2000, vrep.simxGetLastCmdTime(client)
assert vrep.simxReadProximitySensor(client, sonar, vrep.simx_opmode_buffer)[0] == 0
vrep.simxReadProximitySensor(client, sonar, vrep.simx_opmode_discontinue)
there = good(vrep.simxGetObjectPosition(client, robot, -1, WAIT))
assert abs(there[0] - begin[0]) > 0.1, there
good(vrep.simxStopSimulation(client, WAIT))
for _ in range(200):
    back = good(vrep.simxGetObjectPosition(client, robot, -1, WAIT))
    if back == begin:
        break
    time.sleep(0.02)
assert back == begin, back
print('done')
vrep.simxFinish(client)
"#,
    )
    .output()
    .unwrap();
    assert!(good(&told).contains("done"));
}

/// As in V-REP, the script of the scene opens the port, and a stop closes it.
#[test]
#[cfg_attr(no_pypi, ignore = "needs python3 with venv and pip, and PyPI")]
fn a_script_opens_a_port() {
    let bindings = bindings();
    let port = std::net::TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap().port();
    let place = TestFolder::new();
    let script = format!(
        "if (sim_call_type==sim_childscriptcall_initialization) then simExtRemoteApiStart({port}) end
        double = function(ints, floats, strings, bytes)
            return {{ints[1] * 2}}, {{floats[1] * 2}}, {{strings[1] .. '!'}}, bytes .. bytes
        end"
    );
    place.write("opens.lua", &script);
    place.write(
        "scene.toml",
        "format = 1\n[scene]\ndialect = \"3.2\"\n[[object]]\nkind = \"dummy\"\nalias = \"host\"\nscript = \"opens.lua\"\n",
    );
    let mut served = ServedScene::new("legacy_remote", place.path().join("scene.toml").to_str().unwrap());
    let first = served.port;
    good(&client(&served, bindings, "good(vrep.simxStartSimulation(client, WAIT))").output().unwrap());
    served.port = port;
    let program = "
ints, numbers, texts, buffer = good(vrep.simxCallScriptFunction(
    client, 'host', vrep.sim_scripttype_childscript, 'double', [21], [0.5], ['a'], bytearray(b'x\\x00'), WAIT))
assert (ints, numbers, texts, bytes(buffer)) == ([42], [1.0], ['a!'], b'x\\x00x\\x00'), (ints, numbers, texts, buffer)
print('called')
";
    assert!(good(&client(&served, bindings, program).output().unwrap()).contains("called"));
    served.port = first;
    good(&client(&served, bindings, "good(vrep.simxStopSimulation(client, WAIT))").output().unwrap());
    crate::kit::browser::wait_for("the port is closed", Duration::from_secs(20), || {
        TcpStream::connect(("127.0.0.1", port)).is_err().then_some(())
    });
}

#[test]
#[cfg_attr(no_pypi, ignore = "needs python3 with venv and pip, and PyPI")]
fn a_client_that_dies_does_not_block_the_run() {
    let bindings = bindings();
    let served = served();
    let hold = "
good(vrep.simxSynchronous(client, True))
good(vrep.simxStartSimulation(client, WAIT))
print('held', flush=True)
";
    // The client is killed between two triggers, between a trigger and its end, and while it has a stream.
    for state in [
        "time.sleep(100)",
        "while True: vrep.simxSynchronousTrigger(client)",
        "vrep.simxGetObjectPosition(client, handle('Pioneer_p3dx'), -1, vrep.simx_opmode_streaming); time.sleep(100)",
    ] {
        let mut victim = client(&served, bindings, &format!("{hold}{state}")).stdout(Stdio::piped()).spawn().unwrap();
        BufReader::new(victim.stdout.as_mut().unwrap()).read_line(&mut String::new()).unwrap();
        std::thread::sleep(Duration::from_millis(100));
        victim.kill().unwrap();
        victim.wait().unwrap();
        let told = client(
            &served,
            bindings,
            "
def now():
    vrep.simxGetPingTime(client)
    return vrep.simxGetLastCmdTime(client)
begin = now()
while now() < begin + 500:
    time.sleep(0.01)
good(vrep.simxStopSimulation(client, WAIT))
print('went on')
vrep.simxFinish(client)
",
        )
        .output()
        .unwrap();
        assert!(good(&told).contains("went on"), "{state}");
    }
}

#[test]
#[cfg_attr(no_pypi, ignore = "needs python3 with venv and pip, and PyPI")]
fn malformed_packets_close_only_their_connection() {
    let served = served();
    let ask = |bytes: &[u8]| {
        let mut stream = served.connect();
        let _ = stream.write_all(bytes);
        let _ = stream.shutdown(std::net::Shutdown::Write);
        let mut answer = Vec::new();
        let _ = stream.read_to_end(&mut answer);
        answer
    };
    // Bytes that are not a packet, an empty packet, one with the wrong byte order, a command with an impossible size,
    // and half a packet.
    for bytes in [
        &b"GET / HTTP/1.1\r\n\r\n"[..],
        &[1, 0, 0, 0, 0, 0],
        &[0, 1, 0, 18, 0, 0],
        &[&[1, 0, 44, 0, 0, 0][..], &[0; 18], &[0xFF; 26]].concat(),
        &[1, 0, 0xFF, 0xFF, 0xFF, 0xFF, 1],
    ] {
        assert!(ask(bytes).is_empty(), "{bytes:?}");
    }
    // A message with only a header is answered by a header, because it has no command.
    let answer = ask(&[&[1, 0, 18, 0, 0, 0, 0, 0, 11][..], &[7, 0, 0, 0], &[0; 11]].concat());
    assert_eq!((answer.len(), &answer[9..13]), (24, &[0xFF; 4][..]), "{answer:?}");
    let many: Vec<TcpStream> = (0..300).filter_map(|_| TcpStream::connect(("127.0.0.1", served.port)).ok()).collect();
    drop(many);
    let bindings = bindings();
    let told =
        client(&served, bindings, "print(handle('Pioneer_p3dx') > 0)\nvrep.simxFinish(client)").output().unwrap();
    assert!(good(&told).contains("True"));
}

/// A client in C, as V-REP users write it. It declares the functions that it calls itself, because the header of the
/// library is V-REP's and is not included here.
const C_CLIENT: &str = r#"
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

enum { WAIT = 0x010000 };
int simxStart(const char *address, int port, unsigned char wait, unsigned char once, int timeout_ms, int cycle_ms);
void simxFinish(int client);
int simxGetObjectHandle(int client, const char *name, int *handle, int mode);
int simxGetObjectPosition(int client, int object, int relative_to, float *position, int mode);
int simxGetObjectVelocity(int client, int object, float *linear, float *angular, int mode);
int simxSetJointTargetVelocity(int client, int joint, float velocity, int mode);
int simxSynchronous(int client, unsigned char on);
int simxSynchronousTrigger(int client);
int simxGetPingTime(int client, int *ms);
int simxStartSimulation(int client, int mode);

static void good(int code, const char *what) {
  if (code != 0) {
    printf("%s: %d\n", what, code);
    exit(1);
  }
}
#define GOOD(call) good(call, #call)

int main(int argc, char **argv) {
  int robot, left, right, ms, i, client = simxStart("127.0.0.1", atoi(argv[argc - 1]), 1, 1, 5000, 5);
  float before[3], after[3], linear[3], angular[3];
  good(client < 0, "simxStart");
  GOOD(simxGetObjectHandle(client, "Pioneer_p3dx", &robot, WAIT));
  GOOD(simxGetObjectHandle(client, "Pioneer_p3dx_leftMotor", &left, WAIT));
  GOOD(simxGetObjectHandle(client, "Pioneer_p3dx_rightMotor", &right, WAIT));
  GOOD(simxSynchronous(client, 1));
  GOOD(simxStartSimulation(client, WAIT));
  GOOD(simxGetObjectPosition(client, robot, -1, before, WAIT));
  for (i = 0; i < 20; i++) {
    GOOD(simxSetJointTargetVelocity(client, left, 2, WAIT));
    GOOD(simxSetJointTargetVelocity(client, right, 2, WAIT));
    GOOD(simxSynchronousTrigger(client));
    GOOD(simxGetPingTime(client, &ms));
  }
  GOOD(simxGetObjectPosition(client, robot, -1, after, WAIT));
  GOOD(simxGetObjectVelocity(client, robot, linear, angular, WAIT));
  printf("drove %.2f m, %.2f m/s\n", hypotf(after[0] - before[0], after[1] - before[1]), hypotf(linear[0], linear[1]));
  simxFinish(client);
  return 0;
}
"#;

#[test]
#[cfg_attr(not(all(target_os = "linux", target_arch = "x86_64")), ignore = "the library is for Linux on x86-64")]
#[cfg_attr(no_pypi, ignore = "needs python3 with venv and pip, and PyPI")]
fn a_program_in_c_is_linked_to_the_library() {
    let library = bindings().join("lib/linux/64Bit/remoteApi.so");
    let place = TestFolder::new();
    place.write("client.c", C_CLIENT);
    let mut build = Command::new(compiler("cc"));
    build.current_dir(place.path()).args(["-o", "client", "client.c"]).arg(&library).args(["-lm", "-lpthread"]);
    succeed(&mut build);
    let floor =
        "format = 1\n[[object]]\nkind = \"shape\"\nalias = \"floor\"\nprimitive = \"plane\"\nrespondable = true\n";
    place.write("scene.toml", &format!("{floor}[[model]]\nmodel = \"pioneer_p3dx\"\n"));
    let served = ServedScene::new("legacy_remote", place.path().join("scene.toml").to_str().unwrap());
    let told = succeed(Command::new(place.path().join("client")).arg(served.port.to_string()));
    assert!(told.starts_with("drove 0.1"), "{told}");
}
