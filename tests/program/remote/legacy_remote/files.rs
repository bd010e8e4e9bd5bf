//! Tests of files that clients transfer to the program, load and erase, and of files that are refused.

use std::fs;

use super::{bindings, client, wire::PacketConnection};
use crate::{
    kit::served_scene::{ServedScene, good},
    kit::*,
};

const CRATE: &str = "format = 1\n[[object]]\nkind = \"shape\"\nalias = \"crate\"\nsize_m = [0.1, 0.1, 0.1]\n\
                     position_m = [2, 0, 3]\nrespondable = true\ndynamic = true\nmass_kg = 1.0\n";
const ROBOT: &str = "<?xml version=\"1.0\"?>\n<robot name=\"arm\"><link name=\"base\"><inertial><mass value=\"1\"/>\
                     <inertia ixx=\"1\" ixy=\"0\" ixz=\"0\" iyy=\"1\" iyz=\"0\" izz=\"1\"/></inertial><collision><geometry>\
                     <box size=\"0.1 0.1 0.1\"/></geometry></collision></link></robot>\n";

/// A served scene with a folder for files of scripts, and a folder for transferred files.
struct TransferServer {
    place: TestFolder,
    served: ServedScene,
}

impl TransferServer {
    fn new() -> TransferServer {
        let place = TestFolder::scene("");
        place.write("side/crate.toml", CRATE).write("side/arm.urdf", ROBOT).write("side/note.txt", "a note");
        place.write("files/empty.txt", "");
        place.write("side/next.toml", &CRATE.replace("\"crate\"", "\"of_next_scene\""));
        let scene = place.path().join("scene.toml");
        let files = place.path().join("files");
        let served = ServedScene::with("legacy_remote", scene.to_str().unwrap(), &["--files", files.to_str().unwrap()]);
        TransferServer { place, served }
    }
    /// Returns the names in the folder for transferred files, sorted.
    fn transferred(&self) -> Vec<String> {
        let Ok(folder) = fs::read_dir(self.place.path().join("files/transferred")) else { return Vec::new() };
        let mut all: Vec<String> = folder.map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
        all.sort();
        all
    }
    fn put(&self, name: &str, text: &str) {
        self.place.write(&format!("files/transferred/{name}"), text);
    }
    fn get(&self, name: &str) -> String {
        self.place.read(&format!("files/transferred/{name}"))
    }
}

#[test]
#[cfg_attr(no_pypi, ignore = "needs python3 with venv and pip, and PyPI")]
fn models_and_scenes_of_the_clients_side_are_loaded() {
    let bindings = bindings();
    let side = TransferServer::new();
    let program = r#"
SIDE = 'FOLDER/side/'
first = good(vrep.simxLoadModel(client, SIDE + 'crate.toml', 1, WAIT))
assert first == handle('crate'), first
# The library erases the file after each load; loading it again must succeed.
for i in range(5):
    assert good(vrep.simxLoadModel(client, SIDE + 'crate.toml', 1, WAIT)) != first
assert good(vrep.simxLoadModel(client, SIDE + 'arm.urdf', 1, WAIT)) == handle('arm')

# Manually: transferred, loaded by name, erased, and then unknown.
good(vrep.simxTransferFile(client, (SIDE + 'crate.toml').encode(), b'mine.toml', 5000, WAIT))
good(vrep.simxLoadModel(client, 'mine.toml', 0, WAIT))
good(vrep.simxEraseFile(client, b'mine.toml', WAIT))
assert vrep.simxLoadModel(client, 'mine.toml', 0, WAIT)[0] == vrep.simx_return_remote_error_flag
assert 'mine.toml' in good(vrep.simxGetLastErrors(client, WAIT))[0]

# In parts, one per message.
vrep.simxTransferFile(client, (SIDE + 'crate.toml').encode(), b'parts.toml', 5000, vrep.simx_opmode_oneshot_split + 100)
for _ in range(500):
    if vrep.simxLoadModel(client, 'parts.toml', 0, WAIT)[0] == 0:
        break
    time.sleep(0.01)
good(vrep.simxEraseFile(client, b'parts.toml', WAIT))
good(vrep.simxGetLastErrors(client, WAIT))

# Windows of buttons cannot be loaded from files, and the error states that.
assert vrep.simxLoadUI(client, SIDE + 'note.txt', 1, WAIT)[0] == vrep.simx_return_remote_error_flag
assert 'windows of buttons' in good(vrep.simxGetLastErrors(client, WAIT))[0]

good(vrep.simxLoadScene(client, SIDE + 'next.toml', 1, WAIT))
for _ in range(500):
    if vrep.simxGetObjectHandle(client, 'of_next_scene', WAIT)[0] == 0:
        break
    time.sleep(0.02)
handle('of_next_scene')
print('loaded')
vrep.simxFinish(client)
"#
    .replace("FOLDER", side.place.path().to_str().unwrap());
    assert!(good(&client(&side.served, bindings, &program).output().unwrap()).contains("loaded"));
    // Each loaded file is kept once, because input logs refer to it. The file of the window has been removed.
    let kept = side.transferred();
    let of = |ending: &str| kept.iter().filter(|n| n.ends_with(ending)).count();
    assert_eq!((of(".toml"), of(".urdf"), kept.len()), (4, 1, 5), "{kept:?}");
    assert!(["mine.toml", "parts.toml"].iter().all(|n| kept.contains(&n.to_string())), "{kept:?}");
    assert_eq!(side.get("parts.toml"), CRATE);
}

#[test]
fn a_transferred_file_replaces_no_other_and_only_it_is_erased() {
    let side = TransferServer::new();
    side.put("old.txt", "of another run");
    let mut wire = PacketConnection::new(&side.served);
    wire.good(0x3004, b"a.txt\0", b"first");
    assert_eq!(side.get("a.txt"), "first");
    wire.good(0x3004, b"a.txt\0", b"second");
    assert_eq!((side.get("a.txt"), side.transferred().len()), ("second".to_owned(), 2));
    wire.good(0x3004, b"old.txt\0", b"new");
    assert_eq!((side.get("old.txt"), side.get("old-2.txt")), ("of another run".to_owned(), "new".to_owned()));
    for name in ["a.txt", "old.txt"] {
        wire.good(0x3006, format!("{name}\0").as_bytes(), b"");
        let why = wire.bad(0x3006, format!("{name}\0").as_bytes(), b"");
        assert!(why.contains(name) && why.contains("transferred"), "{why}");
    }
    assert_eq!(side.transferred(), ["old.txt"]);
    // A client cannot erase files that were transferred in an earlier run, or files in other folders.
    for name in ["old.txt\0", "empty.txt\0", "scene.toml\0"] {
        wire.bad(0x3006, name.as_bytes(), b"");
    }
    assert!(side.place.path().join("files/empty.txt").is_file() && side.get("old.txt") == "of another run");
    // A file that could not be loaded is also logged, because a replay must fail in the same way.
    wire.good(0x3004, b"bad.toml\0", b"no scene");
    let why = wire.bad(0x3003, b"bad.toml\0", b"");
    assert!(why.contains("bad.toml"), "{why}");
    wire.good(0x3006, b"bad.toml\0", b"");
    assert_eq!(side.get("bad.toml"), "no scene");
    // The same content again uses the existing file, but different content creates a new one.
    for (text, files) in [("no scene", 2), ("no scene either", 3), ("no scene", 2)] {
        wire.good(0x3004, b"bad.toml\0", text.as_bytes());
        assert_eq!(side.transferred().len(), files, "{text}");
    }
}

#[test]
fn names_that_lead_elsewhere_are_refused() {
    let side = TransferServer::new();
    let mut wire = PacketConnection::new(&side.served);
    let long = format!("{}\0", "y".repeat(101));
    for name in
        ["\0", ".\0", "..\0", "../x.txt\0", "/x.txt\0", "a/b\0", "a\\b\0", "c:b\0", ".hidden\0", "a\nb\0", &long]
    {
        for raw in [0x3004, 0x3006] {
            let why = wire.bad(raw, name.as_bytes(), b"text");
            assert!(why.contains("is not a valid name for a transferred file"), "{name:?}: {why}");
        }
    }
    wire.bad(0x3004, b"\xff\0", b"text");
    for name in [&b"libtatu_x.so\0"[..], b"tatu_x.DLL\0"] {
        assert!(wire.bad(0x3004, name, b"text").contains("native library"));
    }
    // Streaming mode is refused, and so is a name without a terminating zero.
    assert!(wire.bad_in(2, 0x3004, b"a.txt\0", b"text").contains("once"));
    wire.bad(0x3004, b"a.txt", b"text");
    assert!(side.transferred().is_empty(), "{:?}", side.transferred());
}

/// A link in place of the folder is refused, and a link in place of a file is not followed.
#[cfg(unix)]
#[test]
fn links_are_not_followed() {
    use std::os::unix::fs::symlink;
    let (side, away) = (TransferServer::new(), TestFolder::new());
    away.write("outside.txt", "outside");
    let (folder, outside) = (side.place.path().join("files/transferred"), away.path().join("outside.txt"));
    symlink(away.path(), &folder).unwrap();
    let mut wire = PacketConnection::new(&side.served);
    wire.bad(0x3004, b"in.txt\0", b"text");
    assert!(!away.path().join("in.txt").exists());
    fs::remove_file(&folder).unwrap();
    fs::create_dir(&folder).unwrap();
    symlink(&outside, folder.join("link.txt")).unwrap();
    wire.good(0x3004, b"link.txt\0", b"outside");
    assert_eq!(side.transferred(), ["link-2.txt", "link.txt"]);
    wire.good(0x3006, b"link.txt\0", b"");
    assert_eq!((side.transferred(), away.read("outside.txt")), (vec!["link.txt".to_owned()], "outside".to_owned()));
}

#[test]
fn the_size_of_the_transfer_folder_is_limited() {
    let side = TransferServer::new();
    let mut wire = PacketConnection::new(&side.served);
    let most = 64 << 20;
    let mut bytes = vec![7; most];
    wire.good(0x3004, b"large.bin\0", &bytes);
    assert_eq!(fs::metadata(side.place.path().join("files/transferred/large.bin")).unwrap().len(), most as u64);
    bytes.push(7);
    let why = wire.bad(0x3004, b"larger.bin\0", &bytes);
    assert!(why.contains(&most.to_string()) && why.contains(&(most + 1).to_string()), "{why}");
    // The limit is on the size of the whole folder, in which a sparse file counts with its full size.
    side.put("full.bin", "");
    let full = fs::File::options().write(true).open(side.place.path().join("files/transferred/full.bin")).unwrap();
    full.set_len(192 << 20).unwrap();
    let why = wire.bad(0x3004, b"more.bin\0", b"more");
    assert!(why.contains("268435456") && why.contains("erase"), "{why}");
    wire.good(0x3006, b"large.bin\0", b"");
    wire.good(0x3004, b"more.bin\0", b"more");
    assert_eq!(side.transferred(), ["full.bin", "more.bin"]);
}

#[test]
#[cfg_attr(no_pypi, ignore = "needs python3 with venv and pip, and PyPI")]
fn a_transferred_model_is_repeated_from_the_log() {
    let bindings = bindings();
    let place = TestFolder::scene("");
    place.write("side/crate.toml", CRATE);
    let program = r#"
good(vrep.simxSynchronous(client, True))
for x in range(3):
    crate = good(vrep.simxLoadModel(client, 'FOLDER/side/crate.toml', 1, WAIT))
    good(vrep.simxSetObjectPosition(client, crate, -1, [x, 0, 3], WAIT))
    good(vrep.simxSynchronousTrigger(client))
    vrep.simxGetPingTime(client)
good(vrep.simxStopSimulation(client, WAIT))
vrep.simxFinish(client)
"#
    .replace("FOLDER", place.path().to_str().unwrap());
    let (mut process, port, mut err) = super::logged(&place);
    let mut with = std::process::Command::new("python3");
    with.args(["-c", &format!("{}{program}", super::begin(bindings, port))]);
    good(&with.output().unwrap());
    let mut live = String::new();
    std::io::Read::read_to_string(&mut err, &mut live).unwrap();
    assert!(process.wait().unwrap().success(), "{live}");
    let hash = |text: &str| text.split("hash ").nth(1).unwrap_or_else(|| panic!("{text}"))[..16].to_owned();
    let again = place.tatu(&["run", "--replay", "run.log"]).good();
    assert_eq!(hash(&live), hash(&again.err));
    // The log contains only the names of files. If a file is missing, the replay differs, which is reported.
    fs::remove_dir_all(place.path().join("transferred")).unwrap();
    let without = place.tatu(&["run", "--replay", "run.log"]);
    assert!(without.code == 1 && without.err.contains("E504"), "{}", without.err);
}
