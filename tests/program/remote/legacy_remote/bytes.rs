//! Tests with messages as raw bytes: those sent by the current library but not by the one in the PyPI package; and
//! those of images, windows, collisions and distances, which both send.

use super::wire::{PacketConnection, floats, floats_of, int_at, ints, near, zero};
use crate::{kit::served_scene::ServedScene, kit::*};

/// A handle that does not refer to any object.
const UNKNOWN_HANDLE: i32 = 999_999;

const SCENE: &str = r#"
[[object]]
kind = "shape"
alias = "ball"
primitive = "sphere"
size_m = [0.2, 0.2, 0.2]
position_m = [0, 0, 1]
data = { "\u0001handle" = "7" }
script.text = """
function sysCall_sensing()
    local found, panel = pcall(simGetUIHandle, 'Panel')
    if found and simGetUIButtonLabel(panel, 3) == 'use it' then
        tatu.actOnButtons(panel, 1, 'change', 125)
        simSetUIButtonLabel(panel, 3, 'used')
    end
end
"""
[[object]]
kind = "shape"
alias = "box"
size_m = [0.2, 0.2, 0.2]
position_m = [1, 0, 1]
data = { "\u0001handle" = "8" }
[[object]]
kind = "joint"
alias = "hinge"
[[object]]
kind = "joint"
alias = "socket"
type = "spherical"
mode = "kinematic"
[[object]]
kind = "shape"
alias = "base"
size_m = [0.1, 0.1, 0.1]
position_m = [5, 0, 2]
[[object]]
kind = "force_sensor"
alias = "force"
parent = "/base"
position_m = [0, 0, -0.1]
[[object]]
kind = "shape"
alias = "tool"
parent = "/base/force"
size_m = [0.1, 0.1, 0.1]
mass_kg = 2
dynamic = true
[[object]]
kind = "sensor"
sensor = "depth_camera"
alias = "eye"
columns = 3
rows = 2
near_m = 0.5
far_m = 2.5
position_m = [0, 9, 1]
"#;

/// The collision objects, distance objects and windows of a V-REP scene, in the form in which the importer stores them.
const REGISTERED: &str = r#"{"collections":[],"collisions":[{"name":"Touch","handle":2010000,"of":[7,8],"threshold":0.0,"explicit":false}],"distances":[{"name":"Gap","handle":2020000,"of":[7,8],"threshold":0.0,"explicit":false},{"name":"Asked","handle":2020001,"of":[7,8],"threshold":0.0,"explicit":true}],"ik_groups":[],"windows":[{"name":"Panel","handle":2060000,"object":7,"attributes":1,"cells":[4,2],"buttons":[{"handle":3,"attributes":2,"cells":[1,1,0,0],"labels":["on",""],"slider":-0.5}]}]}"#;

/// Serves the scene.
fn served() -> (TestFolder, ServedScene) {
    let place =
        TestFolder::scene(&format!("dialect = \"3.6\"\ndata = {{ \"\\u0001registered\" = '{REGISTERED}' }}\n{SCENE}"));
    let served = ServedScene::new("legacy_remote", place.path().join("scene.toml").to_str().unwrap());
    (place, served)
}

/// Starts a run in synchronous mode.
fn start(wire: &mut PacketConnection) {
    wire.done(0x0001, b"", b"");
    wire.done(0x1007, &ints(&[0]), b"");
}

/// Triggers one step and waits for its end.
fn step(wire: &mut PacketConnection) {
    wire.done(0x0003, b"", b"");
    wire.good(0x1021, &ints(&[1]), b"");
}

#[test]
fn forces_and_turns_of_joints() {
    let (_place, served) = served();
    let mut wire = PacketConnection::new(&served);
    let (hinge, socket) = (wire.handle("hinge"), wire.handle("socket"));
    for force in [2.5_f32, 0.0, 40.0] {
        wire.done(0x100E, &ints(&[hinge]), &floats(&[force]));
        assert_eq!(wire.good(0x1038, &ints(&[hinge]), b""), floats(&[force]));
    }
    // The matrix of a rotation by 90 degrees about z, row by row. A joint ignores the translation in the last column.
    let turn = [0.0, -1.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0];
    wire.done(0x100B, &ints(&[socket]), &floats(&turn));
    near(&wire.good(0x100A, &ints(&[socket]), b""), &turn);
    for (raw, data) in [(0x100E, floats(&[1.0])), (0x1038, vec![]), (0x100B, floats(&turn))] {
        wire.bad(raw, &ints(&[UNKNOWN_HANDLE]), &data);
    }
    // Too few bytes, and no handle at all.
    wire.bad(0x100E, &ints(&[hinge]), &[0, 0]);
    wire.bad(0x100B, &ints(&[socket]), &floats(&turn[..11]));
    wire.bad(0x1038, &[1], b"");
}

#[test]
fn places_and_turns_of_objects() {
    let (_place, served) = served();
    let mut wire = PacketConnection::new(&served);
    let (ball, block) = (wire.handle("ball"), wire.handle("box"));
    // The quaternion of a rotation by 90 degrees about z. In the frame of the ball, which is rotated in the same way,
    // the orientation is the identity.
    let quarter = [0.0, 0.0, 0.5_f32.sqrt(), 0.5_f32.sqrt()];
    for object in [ball, block] {
        wire.done(0x1801, &ints(&[object]), &[ints(&[-1]), floats(&quarter)].concat());
        near(&wire.good(0x2801, &ints(&[object, -1]), b""), &quarter);
    }
    near(&wire.good(0x2801, &ints(&[block, ball]), b""), &[0.0, 0.0, 0.0, 1.0]);
    wire.done(0x1801, &ints(&[block]), &[ints(&[ball]), floats(&quarter)].concat());
    near(&wire.good(0x2801, &ints(&[block, -1]), b""), &[0.0, 0.0, 1.0, 0.0]);
    // Position and orientation as clients from before 2014 request them: the data of the command names the reference
    // frame.
    near(&wire.good(0x1019, &ints(&[block]), &ints(&[-1])), &[1.0, 0.0, 1.0]);
    near(&wire.good(0x1019, &ints(&[block]), &ints(&[ball])), &[0.0, -1.0, 0.0]);
    near(&wire.good(0x1018, &ints(&[ball]), &ints(&[-1])), &[0.0, 0.0, std::f32::consts::FRAC_PI_2]);
    for to in [-1, ball] {
        wire.bad(0x1801, &ints(&[UNKNOWN_HANDLE]), &[ints(&[to]), floats(&quarter)].concat());
        wire.bad(0x2801, &ints(&[UNKNOWN_HANDLE, to]), b"");
        wire.bad(0x1019, &ints(&[UNKNOWN_HANDLE]), &ints(&[to]));
        wire.bad(0x1018, &ints(&[UNKNOWN_HANDLE]), &ints(&[to]));
    }
    wire.bad(0x2801, &ints(&[ball, UNKNOWN_HANDLE]), b"");
    wire.bad(0x2801, &ints(&[ball]), b"");
    wire.bad(0x1801, &ints(&[ball]), &[ints(&[-1]), floats(&quarter[..3])].concat());
}

#[test]
fn collisions_and_distances() {
    let (_place, served) = served();
    let mut wire = PacketConnection::new(&served);
    let (ball, block) = (wire.handle("ball"), wire.handle("box"));
    let (touch, gap) = (int_at(&wire.good(0x300A, b"Touch\0", b""), 0), int_at(&wire.good(0x300B, b"Gap\0", b""), 0));
    let asked = int_at(&wire.good(0x300B, b"Asked\0", b""), 0);
    // A ball with a radius of 0.1 m is at 0, and the near face of the box is 0.1 m in front of its centre.
    for (x, distance) in [(1.0_f32, 0.8), (0.5, 0.3), (0.15, 0.0)] {
        wire.done(0x101B, &ints(&[block]), &[ints(&[-1]), floats(&[x, 0.0, 1.0])].concat());
        let touching = ints(&[i32::from(distance == 0.0)]);
        assert_eq!(wire.good(0x200F, &ints(&[ball, block]), b""), touching);
        assert_eq!(wire.good(0x1026, &ints(&[touch]), b""), touching);
        near(&wire.good(0x2010, &ints(&[ball, block]), b""), &[distance]);
        near(&wire.good(0x1027, &ints(&[gap]), b""), &[distance]);
    }
    assert!(wire.bad(0x1027, &ints(&[asked]), b"").contains("never handled"));
    for raw in [0x200F, 0x2010] {
        wire.bad(raw, &ints(&[UNKNOWN_HANDLE, block]), b"");
        wire.bad(raw, &ints(&[ball, UNKNOWN_HANDLE]), b"");
        wire.bad(raw, &ints(&[ball]), b"");
    }
    for raw in [0x1026, 0x1027] {
        wire.bad(raw, &ints(&[UNKNOWN_HANDLE]), b"");
    }
    for raw in [0x300A, 0x300B] {
        assert!(wire.bad(raw, b"nothing\0", b"").contains("nothing"));
    }
}

#[test]
fn a_force_sensor_breaks() {
    let (_place, served) = served();
    let mut wire = PacketConnection::new(&served);
    let force = wire.handle("force");
    start(&mut wire);
    (0..10).for_each(|_| step(&mut wire));
    // A load of 2 kg hangs from the sensor; its weight is 2 kg * 9.81 m/s2, downwards.
    let held = wire.good(0x100F, &ints(&[force]), b"");
    assert_eq!((held[0], held.len()), (1, 25));
    assert!((floats_of(&held[9..13])[0] + 19.62).abs() < 0.02, "{:?}", floats_of(&held[1..]));
    wire.done(0x1010, &ints(&[force]), b"");
    step(&mut wire);
    assert_eq!(wire.good(0x100F, &ints(&[force]), b"")[0], 3, "expected the bits for measured and broken");
    let ball = wire.handle("ball");
    for wrong in [UNKNOWN_HANDLE, ball] {
        wire.bad(0x1010, &ints(&[wrong]), b"");
        wire.bad(0x100F, &ints(&[wrong]), b"");
    }
}

#[test]
fn windows_of_buttons() {
    let (_place, served) = served();
    let mut wire = PacketConnection::new(&served);
    let panel = int_at(&wire.good(0x3007, b"Panel\0", b""), 0);
    let slider = ints(&[panel, 3]);
    assert_eq!(wire.good(0x2001, &slider, b""), ints(&[250]));
    wire.done(0x2002, &slider, &ints(&[500]));
    assert_eq!(wire.good(0x2001, &slider, b""), ints(&[500]));
    // The answer refers only to the window, and the library expects it at an offset of four bytes. No button was
    // pressed.
    assert_eq!(wire.good(0x2003, &ints(&[panel]), b""), ints(&[0, -1, 0, 0]));
    assert_eq!(wire.good(0x2004, &slider, b""), ints(&[2]));
    wire.done(0x2005, &slider, &ints(&[18]));
    assert_eq!(wire.good(0x2004, &slider, b""), ints(&[18]));
    wire.done(0x2006, &slider, b"up\0down\0");
    // The script of the scene uses the slider if it has this label. The event can be read once.
    wire.done(0x2006, &slider, b"use it\0down\0");
    start(&mut wire);
    step(&mut wire);
    assert_eq!(wire.good(0x2003, &ints(&[panel]), b""), ints(&[0, 3, 125, 0]));
    assert_eq!(wire.good(0x2003, &ints(&[panel]), b""), ints(&[0, -1, 0, 0]));
    for raw in [0x2001, 0x2002, 0x2004, 0x2005] {
        wire.bad(raw, &ints(&[UNKNOWN_HANDLE, 3]), &ints(&[1]));
        wire.bad(raw, &ints(&[panel, 99]), &ints(&[1]));
    }
    wire.bad(0x2003, &ints(&[UNKNOWN_HANDLE]), b"");
    wire.bad(0x2006, &ints(&[UNKNOWN_HANDLE, 3]), b"up\0down\0");
    assert!(wire.bad(0x2006, &slider, b"up\0down").contains("not terminated"));
    assert!(wire.bad(0x3005, b"panel.ttb\0", b"").contains("windows of buttons"));
    wire.done(0x1029, &ints(&[panel]), b"");
    wire.bad(0x1029, &ints(&[panel]), b"");
    assert!(wire.bad(0x3007, b"Panel\0", b"").contains("Panel"));
}

#[test]
fn images_are_written_to_a_sensor() {
    let (_place, served) = served();
    let mut wire = PacketConnection::new(&served);
    let eye = ints(&[wire.handle("eye")]);
    let size = ints(&[3, 2]);
    let colours: Vec<u8> = (0..18).map(|i| 14 * i).collect();
    wire.done(0x1006, &eye, &colours);
    assert_eq!(wire.good(0x1004, &eye, b""), [&size[..], &colours].concat());
    let grey = [0, 1, 100, 127, 128, 255];
    wire.done(0x1005, &eye, &grey);
    assert_eq!(wire.good(0x1003, &eye, b""), [&size[..], &grey].concat());
    for (raw, n) in [(0x1005, 5), (0x1005, 18), (0x1005, 0), (0x1006, 6), (0x1006, 17), (0x1006, 19)] {
        let why = wire.bad(raw, &eye, &vec![9; n]);
        assert!(why.contains("6 pixels") && why.contains(&format!("found {n}")), "{why}");
    }
    assert_eq!(wire.good(0x1003, &eye, b""), [&size[..], &grey].concat(), "the image must not change");
    for raw in [0x1005, 0x1006] {
        wire.bad(raw, &ints(&[UNKNOWN_HANDLE]), &[9; 6]);
    }
}

#[test]
#[cfg_attr(no_pypi, ignore = "needs python3 with venv and pip, and PyPI")]
fn the_real_library_writes_images_and_reads_windows() {
    let bindings = super::bindings();
    let (_place, served) = served();
    let program = "
eye, panel = handle('eye'), good(vrep.simxGetUIHandle(client, 'Panel', WAIT))
for options, each in ((0, 3), (1, 1)):
    image = [(37 * i + 5) % 128 for i in range(6 * each)]
    good(vrep.simxSetVisionSensorImage(client, eye, image, options, WAIT))
    size, back = good(vrep.simxGetVisionSensorImage(client, eye, options, WAIT))
    assert (list(size), list(back)) == ([3, 2], image), (size, back)
    wrong = vrep.simxSetVisionSensorImage(client, eye, image[1:], options, WAIT)
    assert wrong == vrep.simx_return_remote_error_flag, wrong
    assert '6 pixels' in good(vrep.simxGetLastErrors(client, WAIT))[0]
good(vrep.simxSetUISlider(client, panel, 3, 700, WAIT))
assert good(vrep.simxGetUISlider(client, panel, 3, WAIT)) == 700
assert good(vrep.simxGetUIEventButton(client, panel, WAIT)) == [-1, [0, 0]]
assert good(vrep.simxGetUIButtonProperty(client, panel, 3, WAIT)) == 2
good(vrep.simxSetUIButtonProperty(client, panel, 3, 18, WAIT))
good(vrep.simxSetUIButtonLabel(client, panel, 3, 'up', 'down', WAIT))
good(vrep.simxRemoveUI(client, panel, WAIT))
touch, gap = good(vrep.simxGetCollisionHandle(client, 'Touch', WAIT)), good(vrep.simxGetDistanceHandle(client, 'Gap', WAIT))
assert good(vrep.simxReadCollision(client, touch, WAIT)) is False
assert abs(good(vrep.simxReadDistance(client, gap, WAIT)) - 0.8) < 1e-6
print('given')
vrep.simxFinish(client)
";
    let told = super::client(&served, bindings, program).output().unwrap();
    assert!(crate::kit::served_scene::good(&told).contains("given"));
}

/// A scene whose script counts its steps in a signal.
const COUNTING: &str = r#"
[[object]]
kind = "dummy"
alias = "counter"
script = { dialect = "3.6", text = """
function sysCall_actuation() steps = (steps or 0) + 1 sim.setIntegerSignal('steps', steps) end
function fails() local nothing = nil return nothing.here end
""" }
"#;

#[test]
fn triggers_in_the_same_breath_as_the_start_permit_the_first_steps() {
    let place = TestFolder::scene(COUNTING);
    let served = ServedScene::new("legacy_remote", place.path().join("scene.toml").to_str().unwrap());
    let mut wire = PacketConnection::new(&served);
    wire.done(0x0001, b"", b"");
    // Before a start, a trigger is refused, and does not count.
    wire.bad(0x0003, b"", b"");
    assert_eq!(wire.together(&[(0x1007, ints(&[0])), (0x0003, vec![])]), [0, 0]);
    let begin = std::time::Instant::now();
    let steps = |wire: &mut PacketConnection| {
        let states = wire.together(&[(0x3011, zero("steps"))]);
        if states == [0] { int_at(&wire.good(0x3011, &zero("steps"), b""), 0) } else { 0 }
    };
    while steps(&mut wire) < 1 && begin.elapsed().as_secs() < 20 {}
    std::thread::sleep(std::time::Duration::from_millis(200));
    assert_eq!(steps(&mut wire), 1, "a trigger permits one step");
    wire.done(0x0003, b"", b"");
    while steps(&mut wire) < 2 && begin.elapsed().as_secs() < 20 {}
    assert_eq!(steps(&mut wire), 2);
}

#[test]
fn errors_of_commands_without_an_answer_are_logged_once() {
    let place = TestFolder::scene(COUNTING);
    let served = ServedScene::new("legacy_remote", place.path().join("scene.toml").to_str().unwrap());
    let mut wire = PacketConnection::new(&served);
    wire.done(0x1007, &ints(&[0]), b"");
    // The script has run, so that its functions exist.
    let begin = std::time::Instant::now();
    while wire.together(&[(0x3011, zero("steps"))]) != [0] && begin.elapsed().as_secs() < 20 {}
    let of = [ints(&[1]), zero("counter"), zero("fails")].concat();
    for _ in 0..3 {
        wire.send(0x3401, &of, &ints(&[0, 0, 0, 0]));
    }
    while !served.logged().contains("0x3401") && begin.elapsed().as_secs() < 20 {
        std::thread::sleep(std::time::Duration::from_millis(20));
    }
    std::thread::sleep(std::time::Duration::from_millis(200));
    let log = served.logged();
    assert_eq!(log.matches("a command of a client failed: 0x3401").count(), 1, "{log}");
}
