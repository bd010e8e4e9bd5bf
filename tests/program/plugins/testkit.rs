//! Tests of `tatu plugin test` on projects in C and Rust, and of all examples in its page.

use std::{fs, path::PathBuf, process::Command};

use serde_json::Value;

use crate::kit::*;

/// Returns the text of docs/plugin-authors/testing.md.
fn page() -> String {
    fs::read_to_string(root().join("docs/plugin-authors/testing.md")).unwrap()
}

/// Returns the `n`-th code block of the page in a language.
#[track_caller]
fn code(language: &str, n: usize) -> String {
    let page = page();
    let fence = format!("```{language}\n");
    let piece = page.split(fence.as_str()).nth(n + 1).unwrap_or_else(|| panic!("no block {n} in {language}"));
    piece.split("```").next().unwrap().to_owned()
}

/// Returns the source of the plugin in plugin-api/README.md, "The first command".
fn hello() -> String {
    let readme = fs::read_to_string(root().join("plugin-api/README.md")).unwrap();
    readme.split("```c\n").nth(1).unwrap().split("```").next().unwrap().to_owned()
}

/// The output of `tatu plugin test --json`, by the name of the test.
struct TestReport {
    code: i32,
    json: Value,
    err: String,
}

impl TestReport {
    #[track_caller]
    fn test(&self, name: &str) -> &Value {
        let found = self.json["tests"].as_array().into_iter().flatten().find(|t| t["name"] == name);
        found.unwrap_or_else(|| panic!("there is no test `{name}` in {}\n{}", self.json, self.err))
    }
    #[track_caller]
    fn passed(&self, name: &str) {
        assert_eq!(self.test(name)["passed"], true, "{}", self.test(name));
    }
    /// Checks that a test failed, and that one of its failures contains all of these words.
    #[track_caller]
    fn failed(&self, name: &str, words: &[&str]) {
        let test = self.test(name);
        assert_eq!(test["passed"], false, "{test}");
        let told = test["failures"].to_string();
        words.iter().for_each(|w| assert!(told.contains(w), "`{name}` lacks `{w}`: {told}"));
    }
}

/// Runs `tatu plugin test --json`. Cargo builds offline and reuses the target folder of earlier runs.
fn test(place: &TestFolder, folder: &str, args: &[&str]) -> TestReport {
    let target = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("testkit");
    let done = Command::new(program())
        .current_dir(place.path())
        .args(["plugin", "test", folder, "--json"])
        .args(args)
        .env_remove("TATU_PLUGIN_PATH")
        .env_remove("TATU_TESTHOST")
        .env("CARGO_TARGET_DIR", target)
        .env("CARGO_NET_OFFLINE", "true")
        .envs(SINGLE_BUILD)
        .output()
        .unwrap();
    let text = |b: &[u8]| String::from_utf8_lossy(b).into_owned();
    let json = serde_json::from_slice(&done.stdout).unwrap_or(Value::Null);
    TestReport { code: done.status.code().unwrap_or(-1), json, err: text(&done.stderr) }
}

/// Creates a crate with a plugin whose dependencies have the versions in this workspace.
fn krate(place: &TestFolder, name: &str, more: &str, source: &str) {
    let api = root().join("plugin-api");
    let (api, kit) = (api.display(), api.join("testkit").display().to_string());
    let manifest = format!(
        "[package]\nname = \"{name}\"\nversion = \"0.1.0\"\nedition = \"2024\"\n\n\
         [lib]\ncrate-type = [\"cdylib\", \"rlib\"]\ndoctest = false\n\n\
         [dependencies]\ntatu-plugin-api = {{ path = {api:?} }}\n{more}\n\
         [dev-dependencies]\ntatu-plugin-testkit = {{ path = {kit:?} }}\n\n\
         [profile.dev]\ndebug = false\n\n[workspace]\n",
        api = api.to_string()
    );
    place.write(&format!("{name}/Cargo.toml"), &manifest).write(&format!("{name}/src/lib.rs"), source);
    fs::copy(root().join("Cargo.lock"), place.path().join(name).join("Cargo.lock")).unwrap();
}

#[test]
fn the_page_s_tests_in_c_and_its_scene_pass() {
    let place = TestFolder::new();
    place.write("hello/hello.c", &hello());
    place.write("hello/tests/hello.c", &code("c", 0)).write("hello/tests/hello.toml", &code("toml", 0));
    let tested = test(&place, "hello", &[]);
    ["doubles_numbers", "wants_a_number", "hello"].iter().for_each(|name| tested.passed(name));
    assert_eq!((tested.code, tested.json["passed"].as_u64(), tested.json["failed"].as_u64()), (0, Some(3), Some(0)));

    let tested = test(&place, "hello", &["--only", "doubles"]);
    assert_eq!((tested.code, tested.json["passed"].as_u64()), (0, Some(1)));
    let tested = test(&place, "hello", &["--only", "trebles"]);
    assert!(tested.code == 2 && tested.err.contains("no tests with `trebles`"), "{}", tested.err);
    // The human-readable output has one line per test.
    let lines = place.tatu(&["plugin", "test", "hello"]).good().out;
    assert!(
        lines.contains("ok    tests/hello.c  doubles_numbers\n") && lines.ends_with("3 passed, 0 failed\n"),
        "{lines}"
    );
}

/// Tests in C, each of which fails in a different way.
const FAILING_TESTS: &str = r#"#include "tatu/test.h"
#include "tatu/command.h"
static const char *const sonar = "format = 1\n[[object]]\nkind = \"sensor\"\nsensor = \"proximity\"\nalias = \"eye\"\n";
static const char *const empty = "format = 1\n[scene]\n";
static void deep(tatu_test *t) { TATU_REQUIRE(2 > 3); }
TATU_TEST(checks) {
  TATU_CHECK(1 > 2);
  TATU_CHECK_NEAR(0.25 + 0.25, 1, 0.1);
  deep(t);
  TATU_CHECK(!"reached");
}
TATU_TEST(crashes) {
  volatile int *nowhere = NULL;
  TATU_CHECK(4 > 5);
  *nowhere = 1;
}
TATU_TEST(hangs) { for (;;) (void)t; }
TATU_TEST(leaves) { (void)t; exit(0); }
TATU_TEST(field) {
  tatu_test_scene(t, sonar);
  tatu_test_step(t, 1);
  tatu_test_number(t, "/eye", "proximity.distanse", 0);
}
TATU_TEST(index) {
  tatu_test_scene(t, sonar);
  tatu_test_step(t, 1);
  TATU_CHECK_NEAR(tatu_test_number(t, "/eye", "proximity.detected", 0), 0, 0);
  tatu_test_number(t, "/eye", "proximity.point", 3);
}
TATU_TEST(early) { tatu_test_scene(t, sonar); tatu_test_number(t, "/eye", "proximity.distance", 0); }
TATU_TEST(path) { tatu_test_scene(t, sonar); tatu_test_step(t, 1); tatu_test_number(t, "/eyes", "proximity.distance", 0); }
TATU_TEST(command) { tatu_test_scene(t, empty); tatu_test_call(t, "hello.twise", NULL, 0); }
TATU_TEST(property) { tatu_test_scene(t, sonar); tatu_test_set(t, "/eye", "proximity.rang", tatu_float(1)); }
TATU_TEST(scene) { tatu_test_scene(t, "format = 1\n[scene]\ntexxt = \"\"\n"); }
TATU_TEST(no_scene) { tatu_test_step(t, 1); }
TATU_TEST(fault) {
  tatu_test_scene(t, "format = 1\n[[object]]\nkind = \"dummy\"\nalias = \"d\"\nscript = { text = "
                     "'''function sysCall_actuation() error('on purpose') end''' }\n");
  tatu_test_step(t, 2);
}
TATU_TEST(fault_taken) {
  tatu_test_scene(t, "format = 1\n[[object]]\nkind = \"dummy\"\nalias = \"d\"\nscript = { text = "
                     "'''function sysCall_init() error('on purpose') end''' }\n");
  tatu_test_step(t, 2);
  TATU_CHECK(tatu_test_faults(t).len > 0);
  TATU_CHECK(tatu_test_faults(t).len == 0);
}
TATU_TEST(properties) {
  tatu_test_scene(t, sonar);
  tatu_test_set(t, "/eye", "proximity.range", tatu_float(3));
  TATU_CHECK_NEAR(tatu_to_float(tatu_test_get(t, "/eye", "proximity.range")), 3, 0);
  TATU_CHECK_NEAR(tatu_to_float(tatu_test_get(t, "", "scene.time")), 0, 0);
  TATU_CHECK(t->host->step(NULL, 1) == TATU_ERR_GONE && t->host->last_error().len > 0);
  TATU_CHECK(t->host->field(t->world, NULL, "x", NULL) == TATU_ERR_ARGUMENT);
  TATU_CHECK(t->host->open(NULL) == NULL);
}
TATU_TESTS(checks, crashes, hangs, leaves, field, index, early, path, command, property, scene, no_scene, fault,
           fault_taken, properties);
"#;

#[test]
fn failures_are_reported_with_place_and_reason_and_the_other_tests_run() {
    let place = TestFolder::new();
    place
        .write("mine/hello.c", &hello())
        .write("mine/tests/wrong.c", FAILING_TESTS)
        .write("mine/tests/broken.c", "int main(");
    let long = "format = 1\n# steps: 2\n[[object]]\nkind = \"dummy\"\nalias = \"d\"\nscript = { text = '''
function sysCall_sensing() assert(sim.getSimulationTime() < 0.04, 'too late') end\n''' }\n";
    place.write("mine/tests/late.toml", long);
    let tested = test(&place, "mine", &["--timeout", "10"]);
    assert_eq!(tested.code, 1);
    let all = tested.test("checks")["failures"].as_array().unwrap();
    assert_eq!(all.iter().map(|f| f["line"].as_u64().unwrap()).collect::<Vec<_>>(), [7, 8, 5], "{all:?}");
    assert!(all.iter().all(|f| f["file"] == "tests/wrong.c"), "{all:?}");
    tested.failed("checks", &["1 > 2 does not hold", "0.25 + 0.25 is 0.5, and 1 is 1: 0.5 apart, at most 0.1"]);
    // Failures that were reported before the crash are not lost.
    tested.failed("crashes", &["4 > 5 does not hold", "the test crashed: signal 11"]);
    tested.failed("hangs", &["did not end within 10 s"]);
    tested.failed("leaves", &["ended the process before the test was complete"]);
    tested.failed("field", &["/eye", "no field `proximity.distanse`", "did you mean `proximity.distance`?"]);
    tested.failed("index", &["`proximity.point` has 3 numbers, but index 3 was requested"]);
    tested.failed("early", &["has not measured yet", "run a step first"]);
    tested.failed("path", &["there is no object `/eyes`", "did you mean `eye`?"]);
    tested.failed("command", &["no plugin offers the command `hello.twise`", "did you mean `hello.twice`?"]);
    tested.failed("property", &["proximity.rang", "did you mean `proximity.range`?"]);
    tested.failed("scene", &["unknown key `texxt`", "did you mean `text`?"]);
    tested.failed("no_scene", &["call tatu_test_scene first"]);
    tested.failed("fault", &["F205", "on purpose"]);
    tested.passed("fault_taken");
    tested.passed("properties");
    tested.failed("broken", &["cannot be compiled"]);
    tested.failed("late", &["the run reported errors"]);
}

#[test]
fn the_test_host_exchanges_values_and_does_not_wait() {
    let place = TestFolder::new();
    let template = fs::read_to_string(root().join("plugin-api/template/c_command/c_command.c")).unwrap();
    let tests = r#"#include "tatu/test.h"
TATU_TEST(waits) { tatu_test_scene(t, "format = 1"); tatu_test_call(t, "example.nextStep", NULL, 0); }
TATU_TEST(refuses) { tatu_test_scene(t, "format = 1"); tatu_test_call(t, "example.refuse", TATU_VALUES(tatu_string("not today"))); }
TATU_TEST(counts) {
  tatu_value count, all[2];
  uint32_t n = 0;
  tatu_test_scene(t, "format = 1");
  count = tatu_test_call(t, "example.count", NULL, 0);
  TATU_CHECK(count.tag == TATU_I64 && count.u.i == 1);
  TATU_CHECK(t->host->call(t->world, "example.count", NULL, 0, all, 2, &n) == TATU_OK && n == 1 && all[0].u.i == 2);
  /* In a new world, the count restarts. */
  tatu_test_scene(t, "format = 1");
  TATU_CHECK(tatu_test_call(t, "example.count", NULL, 0).u.i == 1);
}
TATU_TESTS(waits, refuses, counts);
"#;
    place.write("mine/c_command.c", &template).write("mine/tests/values.c", tests);
    let tested = test(&place, "mine", &[]);
    tested.failed("waits", &["example.nextStep", "wait"]);
    tested.failed("refuses", &["example.refuse: not today", "help: call example.count() instead"]);
    tested.passed("counts");
}

#[test]
#[cfg_attr(no_cxx, ignore = "needs a C++ compiler")]
fn tests_in_cpp_run_destructors_and_survive_exceptions() {
    let place = TestFolder::new();
    let text = r#"#include "tatu/test.h"
#include <stdexcept>
struct Said {
  tatu_test *t;
  ~Said() { tatu_test_fail(t, __FILE__, __LINE__, "destroyed"); }
};
TATU_TEST(needs) { Said said{t}; TATU_REQUIRE(1 > 2); TATU_CHECK(!"reached"); }
TATU_TEST(throws) { TATU_CHECK(t != nullptr); throw std::runtime_error("no"); }
TATU_TEST(refused) { Said said{t}; tatu_test_scene(t, "format = 1\n[scen]\n"); }
TATU_TEST(passes) { tatu_test_scene(t, "format = 1\n[scene]\n"); tatu_test_step(t, 1); }
TATU_TESTS(needs, throws, refused, passes);
"#;
    place.write("mine/hello.c", &hello()).write("mine/tests/more.cpp", text);
    let tested = test(&place, "mine", &[]);
    tested.failed("needs", &["1 > 2 does not hold", "destroyed"]);
    assert_eq!(tested.test("needs")["failures"].as_array().map(Vec::len), Some(2));
    tested.failed("throws", &["an exception was thrown"]);
    tested.failed("refused", &["scen", "destroyed"]);
    tested.passed("passes");
}

#[test]
fn a_plugin_that_cannot_be_built_or_loaded_fails() {
    let place = TestFolder::new();
    place.write("bad/bad.c", "int x = ;\n").write("bad/tests/hello.c", &code("c", 0));
    let tested = test(&place, "bad", &[]);
    assert_eq!(tested.code, 1);
    tested.failed("build", &["cannot be built"]);
    // The library is not a plugin.
    place.write("none/none.c", "int x;\n").write("none/tests/hello.c", &code("c", 0));
    let tested = test(&place, "none", &[]);
    tested.failed("doubles_numbers", &["E301", "libtatu_none", "tatu_plugin"]);
    let tested = test(&place, "nowhere", &[]);
    assert!(tested.code == 2 && tested.err.contains("E620"), "{}", tested.err);
}

#[test]
fn the_page_s_tests_in_rust_pass() {
    let place = TestFolder::new();
    let template = fs::read_to_string(root().join("plugin-api/template/rust_sensor/src/lib.rs")).unwrap();
    krate(&place, "tatu-ranger", "", &format!("{template}\n{}", code("rust", 0)));
    let wrong = "use tatu_plugin_testkit::{Host, Result, plugin};
const SCENE: &str = \"format = 1\n[[object]]\nkind = 'sensor'\nsensor = 'example_range'\nalias = 'feeler'\n\";
#[test] fn misspells() -> Result {
    let world = Host::find()?.with_plugin(plugin!()?).scene(SCENE)?;
    world.step(1)?;
    world.reading(\"/feeler\")?.f64(\"proximity.distanse\").map(drop)
}
#[test] fn asserts() { assert_eq!(1, 2, \"numbers\") }
#[test] fn crashes() { std::process::abort() }
#[test] fn hangs() { loop { std::thread::park() } }
#[test] fn finds_no_library() -> Result { plugin!(\"tatu_other\").map(drop) }
#[test] #[ignore] fn is_ignored() { panic!() }
";
    place.write("tatu-ranger/tests/scene.rs", &code("rust", 2)).write("tatu-ranger/tests/wrong.rs", wrong);
    let tested = test(&place, "tatu-ranger", &["--timeout", "20"]);
    for name in ["distances_are_whole_steps", "nothing_is_no_distance", "takes_other_steps"] {
        tested.passed(&format!("tests::{name}"));
    }
    tested.passed("sees_the_wall");
    tested.failed("misspells", &["/feeler", "no field `proximity.distanse`", "proximity.distance"]);
    tested.failed("asserts", &["numbers", "left: 1"]);
    tested.failed("crashes", &["the test crashed: signal 6"]);
    tested.failed("hangs", &["did not end within 20 s"]);
    tested.failed("finds_no_library", &["libtatu_other", "crate-type", "plugin!("]);
    assert!(!tested.json.to_string().contains("is_ignored"));
}

#[test]
fn projects_of_tatu_new_are_tested_as_they_are() {
    let place = TestFolder::new();
    place.tatu(&["new", "plugin", "fan", "--lang", "c", "--kind", "command"]).good();
    place.write("fan/tests/empty.toml", "format = 1\n# steps: 2\n");
    let source = "#include \"tatu/test.h\"\nTATU_TEST(loads) { tatu_test_scene(t, \"format = 1\"); tatu_test_step(t, 1); }\nTATU_TESTS(loads);\n";
    place.write("fan/tests/fan.c", source);
    let tested = test(&place, "fan", &[]);
    tested.passed("loads");
    tested.passed("empty");

    // A crate with the manifest shown in the page.
    place.tatu(&["new", "plugin", "ranger", "--lang", "rust", "--kind", "sensor"]).good();
    let manifest = place.read("ranger/Cargo.toml").replace("[lib]\ncrate-type = [\"cdylib\"]\n", "");
    place.write("ranger/Cargo.toml", &format!("{manifest}\n{}", code("toml", 1)));
    let unit = "use tatu_plugin_testkit::{Host, Result, plugin};
#[test] fn loads() -> Result { Host::find()?.with_plugin(plugin!()?).scene(\"format = 1\")?.close() }\n";
    place.write("ranger/tests/loads.rs", unit);
    fs::copy(root().join("Cargo.lock"), place.path().join("ranger/Cargo.lock")).unwrap();
    let tested = test(&place, "ranger", &[]);
    tested.passed("loads");
}

#[test]
fn the_page_s_test_of_an_actuator_passes() {
    let place = TestFolder::new();
    let from = root().join("plugins/actuators/thruster/src");
    let source = fs::read_to_string(from.join("lib.rs")).unwrap();
    krate(&place, "tatu-pusher", "libm = \"0.2\"", &format!("{source}\n{}", code("rust", 1)));
    let thruster = fs::read_to_string(from.join("thruster.rs")).unwrap();
    place.write("tatu-pusher/src/thruster.rs", &thruster);
    let tested = test(&place, "tatu-pusher", &["--only", "pushes_along"]);
    tested.passed("tests::pushes_along_the_z_axis_of_its_mount");
    assert_eq!(tested.code, 0, "{}", tested.json);
}
