//! Tests of `--reload`, with files that change during a run. A client holds the run at known steps, so every change
//! takes effect at a known barrier.

use std::{fs, process::Command, thread, time::Duration};

use serde_json::{Value, json};

use crate::{
    kit::*,
    remote::jsonl::{ProgramOutput, RunningProgram, TestClient},
};

/// A script that drives a robot along a curve that depends on a counter, a table and an upvalue.
const ROBOT: &str = "
n = 0
local turns = 0
past = {}
function sysCall_init()
    left, right = sim.getObject('./Pioneer_p3dx_leftMotor'), sim.getObject('./Pioneer_p3dx_rightMotor')
end
function sysCall_actuation()
    n = n + 1
    past[#past + 1] = n % 7
    if past[#past] == 3 then turns = turns + 1 end
    sim.setJointTargetVelocity(left, 2 + 0.2 * past[#past])
    sim.setJointTargetVelocity(right, 2 + 0.1 * turns)
end
";

/// Creates a scene with two robots far from each other, each with a script file. `head` is put before them, and `more`
/// after them.
fn two_robots(head: &str, more: &str) -> TestFolder {
    let robot = |alias: &str, y: f64| {
        format!(
            "[[model]]\nmodel = \"pioneer_p3dx\"\nalias = \"{alias}\"\nposition_m = [0.0, {y}, 0.1388]\nscript = \"{alias}.lua\"\n"
        )
    };
    let place = TestFolder::scene(&format!("seed = 3\n{head}{FLOOR}{}{}{more}", robot("A", -3.0), robot("B", 3.0)));
    place.write("A.lua", ROBOT).write("B.lua", ROBOT);
    place
}

/// A run whose steps a client releases. The program checks files at most ten times a second, and ignores files that
/// have just been written.
struct SteppedRun {
    run: RunningProgram,
    client: TestClient,
}

impl SteppedRun {
    fn start(place: &TestFolder, args: &[&str]) -> SteppedRun {
        let args = [&["--json", "--hashes", "--trace", "t.jsonl"], args].concat();
        let run = RunningProgram::start(place, ",wait_for=1", &args);
        let mut client = run.client();
        client.stepping();
        SteppedRun { run, client }
    }
    fn steps(&mut self, n: u64) -> &mut Self {
        self.client.step(n);
        self
    }
    /// Writes a file, and waits long enough for the program to read it.
    fn write(&mut self, place: &TestFolder, name: &str, text: &str) -> &mut Self {
        place.write(name, text);
        thread::sleep(Duration::from_millis(250));
        self
    }
    fn end(mut self) -> (Value, ProgramOutput) {
        self.client.ask(json!({ "request": "quit" }));
        let ended = self.run.end();
        let summary = serde_json::from_str(&ended.out).unwrap_or_else(|e| panic!("{e}: {}\n{}", ended.out, ended.err));
        (summary, ended)
    }
}

fn hash_of(summary: &Value, object: &str) -> String {
    summary["objects"][object]["hash"].as_str().unwrap_or_else(|| panic!("no {object} in {summary}")).to_owned()
}

#[track_caller]
fn assert_reports(ended: &ProgramOutput, words: &[&str]) {
    for w in words {
        assert!(ended.err.contains(w), "standard error does not contain `{w}`:\n{}", ended.err);
    }
}

/// Returns the summary of a run with this number of steps in which no file changes.
fn undisturbed(place: &TestFolder, steps: u64) -> Value {
    place.run(&["--hashes", "--trace", "plain.jsonl", "--steps", &steps.to_string()]).good().json()
}

#[test]
fn an_equivalent_script_continues_after_a_reload() {
    let place = two_robots("", "");
    let plain = undisturbed(&place, 60);
    let mut held = SteppedRun::start(&place, &["--reload"]);
    held.steps(20);
    held.write(&place, "A.lua", &format!("-- a remark,\n-- and another\n{ROBOT}")).steps(20);
    // The file is written again with the same content.
    held.write(&place, "B.lua", ROBOT).steps(20);
    let (summary, ended) = held.end();
    let ended = ended.good();
    assert_reports(&ended, &["note: reloaded the script", "A.lua of /A (state kept)"]);
    assert!(!ended.err.contains("B.lua of /B"), "{}", ended.err);
    assert_eq!((&summary["hash"], &summary["reloads"]), (&plain["hash"], &json!(1)), "{}", ended.err);
    assert!(place.read("t.jsonl") == place.read("plain.jsonl"), "the traces differ");
}

#[test]
fn a_reloaded_script_inherits_the_global_variables() {
    let place = two_robots("", "");
    let plain = undisturbed(&place, 40);
    let mut held = SteppedRun::start(&place, &["--reload"]);
    held.steps(20);
    let changed = ROBOT.replace("n = n + 1", "n = n + 1\nsim.addStatusbarMessage(n .. ' ' .. #past .. ' ' .. turns)");
    held.write(&place, "A.lua", &changed).steps(1);
    // A script that cannot be compiled is refused and reported once.
    held.write(&place, "A.lua", "function sysCall_actuation()\n  local x = = 1\nend").steps(18);
    held.steps(1);
    let (summary, ended) = held.end();
    let ended = ended.good();
    assert_reports(&ended, &["A.lua of /A (state kept)", "E306", "A.lua:2", "the old version remains in use"]);
    assert_eq!(ended.err.matches("E306").count(), 1, "{}", ended.err);
    let lines = place.lines("t.jsonl");
    // The counter and the table continue at 20, but the local variable of the chunk is initialised again.
    assert_eq!(lines[20].status(), ["21 20 0"]);
    assert_eq!(lines[21].status(), ["22 21 0"], "the old script must continue");
    assert_eq!(hash_of(&summary, "/B"), hash_of(&plain, "/B"), "the other robot must not change");
    assert_ne!(hash_of(&summary, "/A"), hash_of(&plain, "/A"));
}

#[test]
fn a_reloaded_script_without_savable_state_restarts_and_is_reported() {
    let place = two_robots("", &watcher("w", "").replace("script = { text = '''\n\n''' }", "script = \"w.lua\""));
    let waiting = "function sysCall_thread() while true do sim.addStatusbarMessage('one') sim.wait(0.05) end end";
    place.write("w.lua", waiting);
    let mut held = SteppedRun::start(&place, &["--reload"]);
    held.steps(5);
    held.write(&place, "w.lua", &waiting.replace("one", "two")).steps(5);
    let (_, ended) = held.end();
    assert_reports(&ended.good(), &["w.lua of /w (state reset: "]);
    let lines = place.lines("t.jsonl");
    assert_eq!((lines[4].status(), lines[6].status()), (vec!["one"], vec!["two"]));
}

/// A plugin with a command and a sensor. Both count, and report the count and the plugin's version.
const PROBE: &str = r#"
#include "tatu.h"
#include <stdlib.h>
#include <string.h>
#ifndef CREATE
#define CREATE TATU_OK
#endif
#ifndef ANOTHER
#define ANOTHER "probe.another"
#endif
typedef struct { uint64_t calls; } state;
static tatu_status count(tatu_call *call) {
  state *s = call->state;
  return tatu_return(call, tatu_float(VERSION * 1000 + (double)++s->calls));
}
#if VERSION == 1
static const tatu_name old_name = {.size = sizeof old_name, .name = "probe.old"};
static const tatu_name *const old_names[] = {&old_name, 0};
static const tatu_command old = {.size = sizeof old, .flags = TATU_COMMAND_RAW, .names = old_names, .call = count};
#else
static const tatu_name new_name = {.size = sizeof new_name, .name = ANOTHER};
static const tatu_name *const new_names[] = {&new_name, 0};
static const tatu_command new = {.size = sizeof new, .flags = TATU_COMMAND_RAW, .names = new_names, .call = count};
#endif
static const tatu_name count_name = {.size = sizeof count_name, .name = "probe.count"};
static const tatu_name *const count_names[] = {&count_name, 0};
static const tatu_command count_command = {.size = sizeof count_command, .flags = TATU_COMMAND_RAW,
  .names = count_names, .call = count};
#if VERSION == 1
static const tatu_command *const commands[] = {&old, &count_command, 0};
#else
static const tatu_command *const commands[] = {&new, &count_command, 0};
#endif
static tatu_status begin(void *self, const tatu_instance *given, void **data, tatu_error *error) {
  (void)self; (void)given; (void)data; (void)error;
  return TATU_OK;
}
static void end(void *data) { (void)data; }
static const tatu_life world_life = {.size = sizeof world_life, .state_bytes = sizeof(state), .create = begin,
  .destroy = end, .version = 1};
static const tatu_ext_command command = {.size = sizeof command, .commands = commands, .per_world = &world_life};

/* The sensor stores its sum in its own memory, and the number of its readings in the state block. */
static tatu_status create(void *self, const tatu_instance *given, void **data, tatu_error *error) {
  (void)self; (void)given;
  if (CREATE < 0) return tatu_fail(error, TATU_ERR, "this version makes none");
  *data = calloc(1, sizeof(double));
  return TATU_OK;
}
static void destroy(void *data) { free(data); }
static tatu_status save(void *data, const tatu_writer *w, tatu_error *error) {
  (void)error;
  w->write(w, data, sizeof(double));
  return TATU_OK;
}
static tatu_status load(void *data, tatu_str bytes, uint32_t version, tatu_error *error) {
  if (version != 1 || bytes.len != sizeof(double)) return tatu_fail(error, TATU_ERR, "not mine");
  memcpy(data, bytes.ptr, sizeof(double));
  return TATU_OK;
}
static const tatu_life life = {.size = sizeof life, .state_bytes = sizeof(uint64_t), .create = create,
  .destroy = destroy, .save = save, .load = load, .version = 1};
static const tatu_field sum = {.size = sizeof sum, .elem = TATU_ELEM_F64, .dims = {1, 1, 1}, .name = "probe.sum"};
static const tatu_field readings = {.size = sizeof readings, .elem = TATU_ELEM_F64, .dims = {1, 1, 1},
  .name = "probe.readings"};
static const tatu_field *const fields[] = {&sum, &readings, 0};
static tatu_status measure(void *self, const tatu_sensor_batch *b, tatu_error *error) {
  (void)self; (void)error;
  for (uint32_t i = 0; i < b->n; i++) {
    double *own = b->data[i];
    uint64_t *n = b->state[i];
    *own += VERSION;
    *n += 1;
    *(double *)b->fields[2 * i] = *own;
    *(double *)b->fields[2 * i + 1] = (double)*n;
  }
  return TATU_OK;
}
static const tatu_sensor probe = {.size = sizeof probe, .id = "probe", .text = "Counts.", .fields = fields,
  .life = &life, .measure = measure};
#ifndef LACKS_SENSOR
static const tatu_sensor *const kinds[] = {&probe, 0};
#else
static const tatu_sensor *const kinds[] = {0};
#endif
static const tatu_ext_sensor sensor = {.size = sizeof sensor, .kinds = kinds};
static const void *extension(void *self, const char *id) {
  (void)self; (void)probe;
  if (!strcmp(id, TATU_COMMAND)) return &command;
  return strcmp(id, TATU_SENSOR) ? 0 : &sensor;
}
TATU_EXPORT const tatu_plugin_t tatu_plugin = {.size = sizeof tatu_plugin, .abi_major = TATU_ABI_MAJOR,
  .abi_minor = TATU_ABI_MINOR, .id = "org.example.probe", .name = "Probe", .version = "1", .licence = "MIT",
  .extension = extension};
"#;

/// Compiles the plugin into the folder `built` with these definitions, and returns the bytes of the library.
fn probe(place: &TestFolder, defines: &[&str]) -> Vec<u8> {
    place.write("built/probe.c", PROBE);
    let mut cc = Command::new(compiler("cc"));
    cc.args(["-std=c11", "-Wall", "-Wno-missing-field-initializers", "-shared", "-fPIC", "-I"]);
    cc.arg(root().join("plugin-api/include")).args(defines).args(["-o", "built/probe.out", "built/probe.c"]);
    succeed(cc.current_dir(place.path()));
    fs::read(place.path().join("built/probe.out")).unwrap()
}

#[test]
fn a_changed_plugin_replaces_the_old_one() {
    let script = "
        local count, old = nil, nil
        function sysCall_init() old = probe.old end
        function sysCall_actuation()
            sim.addStatusbarMessage(string.format('%d', probe.count()))
            local ok, why = pcall(old)
            if not ok then sim.addStatusbarMessage(tostring(why)) end
        end";
    let more = format!("{}[[object]]\nkind = \"sensor\"\nsensor = \"probe\"\nalias = \"p\"\n", watcher("w", script));
    let place = two_robots("plugins = [\"plugins\"]\n", &more);
    let file = place.path().join("plugins").join(library("tatu_probe"));
    fs::create_dir_all(place.path().join("plugins")).unwrap();
    let (first, second) = (probe(&place, &["-DVERSION=1"]), probe(&place, &["-DVERSION=2"]));
    let bad = [probe(&place, &["-DVERSION=2", "-DLACKS_SENSOR"]), probe(&place, &["-DVERSION=2", "-DCREATE=-1"])];
    fs::write(&file, &first).unwrap();
    let plain = undisturbed(&place, 16);

    let mut held = SteppedRun::start(&place, &["--reload", "--watch", "/p"]);
    // Overwrites the same file, as linkers do; this would crash a process that has it mapped.
    let put = |bytes: &[u8]| {
        fs::write(&file, bytes).unwrap();
        thread::sleep(Duration::from_millis(250));
    };
    held.steps(4);
    put(&second[..second.len() / 2]);
    held.steps(2);
    put(b"no library at all");
    held.steps(2);
    put(&bad[0]);
    held.steps(2);
    put(&bad[1]);
    held.steps(2);
    put(&second);
    held.steps(4);
    let (summary, ended) = held.end();
    let ended = ended.good();
    assert_eq!(ended.err.matches("E301").count(), 2, "{}", ended.err);
    assert_reports(&ended, &["E305", "no longer offers the sensor `probe`", "E402", "this version makes none"]);
    assert_reports(&ended, &["note: reloaded the plugin org.example.probe 1 from"]);
    assert!(!ended.err.contains("starts over"), "{}", ended.err);
    assert_eq!(summary["reloads"], 1);
    for robot in ["/A", "/B"] {
        assert_eq!(hash_of(&summary, robot), hash_of(&plain, robot), "{robot} has changed");
    }

    let lines = place.lines("t.jsonl");
    for (i, line) in lines.iter().enumerate() {
        let (n, version) = (i as f64 + 1.0, if i < 12 { 1.0 } else { 2.0 });
        assert_eq!(line.sensor("/p", "probe.readings"), n, "step {i}");
        assert_eq!(line.sensor("/p", "probe.sum"), 12.0_f64.min(n) + 2.0 * (n - 12.0).max(0.0), "step {i}");
        // The script calls the command twice per step while the old command exists.
        let calls = if i < 12 { 2 * i + 1 } else { 24 + i - 12 + 1 };
        assert_eq!(line.status()[0], (version as usize * 1000 + calls).to_string(), "step {i}");
    }
    let gone = lines[13].status()[1].to_owned();
    assert!(gone.contains("probe.old") && gone.contains("its new version has no such command"), "{gone}");
}

#[test]
fn a_warning_from_the_start_does_not_block_new_versions() {
    let place = two_robots("plugins = [\"plugins\"]\n", "");
    let file = place.path().join("plugins").join(library("tatu_probe"));
    fs::create_dir_all(place.path().join("plugins")).unwrap();
    // The invalid name is reported at the start of the run, and not again for new versions, which also contain it.
    let [second, third] = ["-DVERSION=2", "-DVERSION=3"].map(|v| probe(&place, &[v, "-DANOTHER=\"pro be\""]));
    fs::write(&file, &second).unwrap();
    let mut held = SteppedRun::start(&place, &["--reload"]);
    for bytes in [&third, &second] {
        held.steps(2);
        fs::write(&file, bytes).unwrap();
        thread::sleep(Duration::from_millis(250));
    }
    held.steps(2);
    let (summary, ended) = held.end();
    let ended = ended.good();
    assert_eq!(summary["reloads"], 2, "{}", ended.err);
    assert!(!ended.err.contains("pro be"), "the warning from the start is repeated: {}", ended.err);
    place.run(&["--steps", "1"]).good().reports(&["E303", "`pro be` has an invalid name"]);
}

/// Changes in the text of a model folder are applied as in any file of the document. If the text has an error, the old
/// version remains in effect.
#[test]
fn a_changed_model_of_a_folder_is_reloaded() {
    let part = |mass: &str| {
        format!(
            "format = 1\n[model]\ntext = \"A box.\"\n[model.params.density]\ntype = \"float\"\ndefault = 2.0\n\
             text = \"kg for each box.\"\n{}",
            cuboid("box", [0.2; 3], [0.0, 0.0, 1.0], &format!("dynamic = true\nmass_kg = \"{mass}\""))
        )
    };
    let script = "function sysCall_actuation()
            sim.addStatusbarMessage(string.format('%.1f', sim.getFloatProperty(sim.getObject('/P'), 'shape.mass')))
        end";
    let scene = format!("[[model]]\nmodel = \"part\"\nalias = \"P\"\ndensity = 1.5\n{}", watcher("w", script));
    let place = two_robots("", &scene);
    place.write("models/part/model.toml", &part("=density"));
    let mut held = SteppedRun::start(&place, &["--reload"]);
    held.steps(5);
    held.write(&place, "models/part/model.toml", &part("=2 * density")).steps(5);
    held.write(&place, "models/part/model.toml", &part("=2 * densty")).steps(5);
    held.write(&place, "models/part/model.toml", &part("=4 * density")).steps(5);
    let (_, ended) = held.end();
    let ended = ended.good();
    assert_reports(
        &ended,
        &["note: reloaded /P: shape.mass", "no parameter or number `densty`", "models/part/model.toml:"],
    );
    let lines = place.lines("t.jsonl");
    let masses: Vec<&str> = lines.iter().map(|l| l.status()[0]).collect();
    assert_eq!(masses, [["1.5"; 5], ["3.0"; 5], ["3.0"; 5], ["6.0"; 5]].concat());
}

#[test]
fn a_changed_model_is_merged_into_the_existing_scene() {
    let part = |mass: f64, more: &str| {
        format!(
            "format = 1\n{}{more}",
            cuboid("box", [0.2; 3], [0.0, 0.0, 1.0], &format!("dynamic = true\nmass_kg = {mass}"))
        )
    };
    let more = format!(
        "[[model]]\nmodel = \"part.toml\"\nalias = \"P\"\n{}",
        watcher(
            "w",
            "
        function sysCall_actuation()
            sim.addStatusbarMessage(string.format('%.1f', sim.getFloatProperty(sim.getObject('/P/box'), 'shape.mass')))
        end"
        )
    );
    let place = two_robots("", &more);
    place.write("part.toml", &part(2.0, ""));
    let plain = undisturbed(&place, 20);
    let mut held = SteppedRun::start(&place, &["--reload", "--watch", "/P/box"]);
    held.steps(5);
    held.write(&place, "part.toml", &part(3.0, "")).steps(5);
    held.write(&place, "part.toml", "format = 1\n[[object]]\nkind = \"shap\"\n").steps(5);
    held.write(&place, "part.toml", &part(3.0, "[[object]]\nkind = \"dummy\"\nalias = \"more\"\n")).steps(5);
    let (summary, ended) = held.end();
    let ended = ended.good();
    assert_reports(&ended, &["note: reloaded /P/box: shape.mass", "part.toml:3", "E307", "/P/more was added"]);
    let lines = place.lines("t.jsonl");
    let masses: Vec<&str> = lines.iter().map(|l| l.status()[0]).collect();
    assert_eq!(masses, [["2.0"; 5], ["3.0"; 5], ["3.0"; 5], ["3.0"; 5]].concat());
    // The object continues to fall as before, because the speed does not depend on its mass.
    let plain_lines = place.lines("plain.jsonl");
    assert_eq!(plain_lines.len(), 20);
    let z = |i: usize| lines[i].object::<3>("/P/box", "position")[2];
    assert!(z(4) > z(5) && z(5) > z(6), "{} {} {}", z(4), z(5), z(6));
    for robot in ["/A", "/B"] {
        assert_eq!(hash_of(&summary, robot), hash_of(&plain, robot), "{robot} has changed");
    }
}

#[test]
fn a_run_with_reload_cannot_be_logged() {
    let place = two_robots("", "");
    for other in [["--log", "run.log"], ["--snapshot-at", "1"], ["--from", "x"]] {
        let done = place.tatu(&[&["run", "scene.toml", "--reload"], &other[..]].concat());
        assert_eq!(done.code, 2, "{}", done.err);
    }
    let plain = undisturbed(&place, 20);
    let same = place.run(&["--reload", "--steps", "20"]).good().json();
    assert_eq!((&same["hash"], &same["reloads"]), (&plain["hash"], &json!(0)));
}

#[test]
fn a_graph_whose_streams_change_records_the_new_ones() {
    let stream = |name: &str| format!("{{ name = \"{name}\", of = \"/ball\", data = \"{name}\" }}");
    let scene = |streams: &str| {
        format!(
            "format = 1\n[[object]]\nkind = \"dummy\"\nalias = \"ball\"\n\
             [[object]]\nkind = \"graph\"\nalias = \"g\"\nstreams = [{streams}]\n"
        )
    };
    let place = TestFolder::new();
    place.write("scene.toml", &scene(&stream("z")));
    let mut held = SteppedRun::start(&place, &["--reload", "--graphs", "out"]);
    held.steps(5);
    held.write(&place, "scene.toml", &scene(&format!("{}, {}", stream("z"), stream("x")))).steps(5);
    let (_, ended) = held.end();
    assert_reports(&ended.good(), &["reloaded /g: graph.streams"]);
    let table = place.read("out/g.csv");
    let head = table.lines().next().unwrap();
    assert!(head.contains('z') && head.contains('x'), "{table}");
    assert!(table.lines().count() > 4, "{table}");
}
