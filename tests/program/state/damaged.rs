//! Tests of damaged logs, snapshots and other files that the program reads back: it refuses or runs them, but never
//! panics or ignores damage silently. To run the same tests with thousands of files, use `TATU_DAMAGED=10000 cargo test
//! --release --test program damaged`.

use std::fs;

use crate::kit::*;

/// A pseudo-random generator with a fixed sequence.
struct TestRng(u64);

impl TestRng {
    fn below(&mut self, n: usize) -> usize {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 % n.max(1) as u64) as usize
    }
    /// Returns a copy of a file that may be truncated, and in which some bytes are removed, duplicated, flipped or
    /// overwritten.
    fn damage(&mut self, whole: &[u8]) -> Vec<u8> {
        let mut bytes = whole.to_vec();
        for _ in 0..=self.below(3) {
            let at = self.below(bytes.len());
            let long = self.below(64).min(bytes.len() - at);
            match self.below(5) {
                0 => bytes.truncate(at),
                1 => drop(bytes.drain(at..at + long)),
                2 => bytes.extend_from_within(at..at + long),
                3 if at < bytes.len() => bytes[at] ^= 1 << self.below(8),
                _ => bytes[at..at + long].fill(b"0-9e\"{\0\xff"[self.below(8)]),
            }
            if bytes.is_empty() {
                break;
            }
        }
        bytes
    }
}

/// Returns the number of repetitions: the value of `TATU_DAMAGED` if it is set, otherwise `few`.
fn times(few: usize) -> usize {
    std::env::var("TATU_DAMAGED").ok().and_then(|n| n.parse().ok()).unwrap_or(few)
}

const URDF: &str = r#"<robot name="r"><link name="a"><visual><geometry><box size="0.1 0.2 0.3"/></geometry></visual>
<collision><geometry><mesh filename="m.obj"/></geometry></collision></link>
<link name="b"><inertial><mass value="1"/><inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial></link>
<joint name="j" type="revolute"><parent link="a"/><child link="b"/><axis xyz="0 0 1"/>
<limit lower="-1" upper="1" effort="1" velocity="1"/></joint></robot>"#;
const MESH: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 2 3\nf 1 2 4\nf 1 3 4\nf 2 3 4\n";

#[test]
fn damaged_files_are_refused_or_run() {
    let place = TestFolder::scene(&format!(
        "dt_s = 0.05\n{FLOOR}{}{}\n[[import]]\nfile = \"r.urdf\"\n",
        cuboid("box", [0.1; 3], [0.0, 0.0, 0.3], "dynamic = true\nrespondable = true"),
        watcher("d", "function sysCall_init() n = 1 end function sysCall_actuation() n = n + 1 end"),
    ));
    place.write("r.urdf", URDF).write("m.obj", MESH).write("keys", "0.1 a\n0.2 up\n0.3 27\n");
    let all = ["--steps", "6", "--keys", "keys", "--log", "log", "--trace", "trace", "--snapshot-at", "0.15", "snap"];
    place.run(&all).good();
    let run = ["run", "scene.toml", "--steps", "6", "--watchdog", "10"];
    let mut dice = TestRng(0x7A7_0001);
    for (file, args) in [
        ("log", &["run", "--replay", "log", "--watchdog", "10"][..]),
        ("snap", &[&run[..], &["--from", "snap"]].concat()),
        ("trace", &["diff", "trace", "trace.whole"]),
        ("keys", &[&run[..], &["--keys", "keys"]].concat()),
        ("scene.toml", &run),
        ("r.urdf", &run),
        ("m.obj", &run),
    ] {
        let path = place.path().join(file);
        let whole = fs::read(&path).unwrap();
        fs::write(place.path().join(format!("{file}.whole")), &whole).unwrap();
        for _ in 0..times(12) {
            let bad = dice.damage(&whole);
            fs::write(&path, &bad).unwrap();
            let done = place.tatu(args);
            assert!((0..=2).contains(&done.code), "{file}: exit {}\n{}", done.code, done.err);
            assert!(!done.err.contains("panicked"), "{file}: {}", done.err);
            assert!(done.code == 0 || !(done.err.clone() + &done.out).trim().is_empty(), "{file}: no message");
            // Files that the change has left equal are skipped.
            if bad == whole {
                continue;
            }
            match file {
                "snap" => assert_eq!(done.code, 2, "{}", done.err),
                // Missing lines at the end are reported.
                "log" if done.code == 0 => {
                    let told = done.err.contains("did not end normally") || done.err.contains("last line");
                    assert!(told, "the damage is not reported: {}", done.err);
                }
                "trace" if done.code == 0 => {
                    let lines = |b: &[u8]| -> Vec<serde_json::Value> {
                        let text = String::from_utf8(b.to_vec()).unwrap();
                        text.lines().map(|l| serde_json::from_str(l).unwrap()).collect()
                    };
                    assert_eq!(lines(&bad), lines(&whole), "the damage is not reported");
                }
                _ => {}
            }
        }
        fs::write(&path, &whole).unwrap();
    }
}

/// Calls random commands with arguments of any type while boxes touch each other. `TATU_DAMAGED` sets the number of
/// steps, in each of which at least 60 calls are tried.
#[test]
fn random_calls_do_not_crash() {
    let place = TestFolder::new();
    let names: Vec<String> = place
        .tatu(&["list", "commands", "--json"])
        .good()
        .json()
        .as_array()
        .unwrap()
        .iter()
        .filter_map(|c| c["names"][0].as_str().or(c["name"].as_str()).map(str::to_owned))
        .filter(|n| {
            !["sim.quitSimulator", "sim.stopSimulation", "sim.pauseSimulation", "sim.wait"].contains(&n.as_str())
        })
        .collect();
    assert!(names.len() > 300, "{}", names.len());
    let list = names.iter().map(|n| format!("'{n}'")).collect::<Vec<_>>().join(",");
    let boxes: String = (0..4)
        .map(|i| {
            cuboid(
                &format!("b{i}"),
                [0.1; 3],
                [0.0, 0.0, 0.06 + 0.11 * f64::from(i)],
                "dynamic = true\nrespondable = true",
            )
        })
        .collect();
    for contact in ["", "function sysCall_contact(d) calls(2) end"] {
        let script = format!(
            "function sysCall_init() names = {{{list}}} seed = 7 end
             local function dice(n) seed = (seed * 1103515245 + 12345) % 2147483648 return (seed // 65536) % n + 1 end
             local function value(depth)
               local k = dice(12)
               if k == 1 then return nil elseif k == 2 then return dice(20) elseif k == 3 then return -dice(3)
               elseif k == 4 then return dice(100) / 7 elseif k == 5 then return '/b' .. dice(4) elseif k == 6 then return 'x'
               elseif k == 7 then return true elseif k == 8 then return 1e308 elseif k == 9 then return function() end
               elseif k == 10 then return 0/0
               else local t = {{}} if depth < 2 then for i = 1, dice(6) do t[i] = value(depth + 1) end end return t end
             end
             function calls(n)
               for i = 1, n do
                 local f = _G for part in names[dice(#names)]:gmatch('[^.]+') do f = f and f[part] end
                 if f then pcall(f, value(0), value(0), value(0), value(0)) end
               end
             end
             function sysCall_actuation() calls(60) end
             function sysCall_dyn(d) calls(1) end
             {contact}"
        );
        let place = TestFolder::scene(&format!("{FLOOR}{boxes}{}", watcher("d", &script)));
        let done = place.tatu(&["run", "scene.toml", "--steps", &times(20).to_string(), "--files", "."]);
        assert!((0..=1).contains(&done.code) && !done.err.contains("panicked"), "exit {}: {}", done.code, done.err);
    }
}
