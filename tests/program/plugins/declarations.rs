//! Tests of invalid declarations in plugins: each is reported with plugin, kind and parameter, and the rest works.

use std::process::Command;

use crate::kit::*;

/// A plugin with a sensor and a command most of whose declarations are invalid, and a command that works.
const INVALID_PLUGIN: &str = r#"
#include "tatu.h"

static const tatu_param low_high = {sizeof(tatu_param), TATU_F64, 0, 0, "span", "m", 3, 1, {0}, 0, "from 3 to 1"};
static const tatu_param outside = {sizeof(tatu_param), TATU_F64, 0, 0, "gain", 0, 0, 1, {TATU_F64, 0, {.f = 5}}, 0, "too much"};
static const char *const colors[] = {"red", "green", 0};
static const tatu_param choice = {sizeof(tatu_param), TATU_TEXT, 0, 0, "tint", 0, 0, 0, {TATU_TEXT, 0, {.s = {"blue", 4}}}, colors, "none of them"};
static const tatu_param unit = {sizeof(tatu_param), TATU_F64, 0, 0, "reach", "metres", 0, 0, {TATU_F64, 0, {.f = 1}}, 0, "far"};
static const tatu_param type = {sizeof(tatu_param), 99, 0, TATU_PARAM_OPTIONAL, "odd", 0, 0, 0, {0}, 0, "of no type"};
static const tatu_param empty = {sizeof(tatu_param), TATU_F64, 0, TATU_PARAM_OPTIONAL, "", 0, 0, 0, {0}, 0, "without a key"};
static const tatu_param space = {sizeof(tatu_param), TATU_F64, 0, TATU_PARAM_OPTIONAL, "a b", 0, 0, 0, {0}, 0, "no key of TOML"};
static const tatu_param good = {sizeof(tatu_param), TATU_F64, 0, 0, "range", "m", 0, 5, {TATU_F64, 0, {.f = 1}}, 0, "as it should be"};
static const tatu_param *const params[] = {&low_high, &outside, &choice, &unit, &type, &empty, &space, &good, &good, 0};

static const tatu_field detected = {sizeof(tatu_field), TATU_ELEM_F64, {1, 1, 1}, 0, "proximity.detected", 0, "not an i32", 0, 0};
static const tatu_field distance = {sizeof(tatu_field), TATU_ELEM_F64, {1, 1, 1}, 0, "proximity.distance", "s", "not in m", 0, 0};
static const tatu_field point = {sizeof(tatu_field), TATU_ELEM_F64, {2, 1, 1}, 0, "proximity.point", "m", "not 3 of them", 0, 0};
static const tatu_field object = {sizeof(tatu_field), TATU_ELEM_OBJECT, {1, 1, 1}, 0, "proximity.object", 0, "right", 0, 0};
static const tatu_field *const fields[] = {&detected, &distance, &point, &object, 0};
static const char *const schemas[] = {"proximity/1", "org.example.smell/1", 0};

static tatu_status create(void *self, const tatu_instance *i, void **data, tatu_error *e) {
  (void)self; (void)i; (void)data; (void)e;
  return TATU_OK;
}
static void destroy(void *data) { (void)data; }
static tatu_status measure(void *self, const tatu_sensor_batch *b, tatu_error *e) {
  (void)self; (void)b; (void)e;
  return TATU_OK;
}
static const tatu_life life = {.size = sizeof(tatu_life), .create = create, .destroy = destroy};
static const tatu_sensor nose = {sizeof(tatu_sensor), 0, "nose", "smells", schemas, params, fields, &life, 0, measure};
static const tatu_sensor *const kinds[] = {&nose, 0};
static const tatu_ext_sensor sensors = {sizeof(tatu_ext_sensor), 0, kinds};

static tatu_status three(tatu_call *c) { return tatu_return(c, tatu_int(3 + tatu_arg_int(c, 0))); }
static const tatu_param whole = {sizeof(tatu_param), TATU_I64, 0, 0, "n", 0, 0, 0, {TATU_I64, 0, {.i = 0}}, 0, "an integer"};
static const tatu_param *const three_params[] = {&whole, 0};
static const tatu_param *const odd_params[] = {&outside, 0};
static const tatu_name three_name = {sizeof(tatu_name), 0, "wrong.three", 0, 0, 0};
static const tatu_value minus_one = {TATU_I64, 0, {.i = -1}};
static const tatu_name three_old = {sizeof(tatu_name), TATU_NAME_OLD_ERRORS, "wrongThree", 1, 0, &minus_one};
static const tatu_name *const three_names[] = {&three_name, &three_old, 0};
static const tatu_name odd_name = {sizeof(tatu_name), 0, "wrong.odd", 0, 0, 0};
static const tatu_name *const odd_names[] = {&odd_name, 0};
static const tatu_command c_three = {sizeof(tatu_command), 0, three_names, three_params, 0, "three", "", 0, 0, three};
static const tatu_command c_odd = {sizeof(tatu_command), 0, odd_names, odd_params, 0, "odd", "", 0, 0, three};
static const tatu_command *const commands[] = {&c_three, &c_odd, 0};
static const tatu_ext_command ext = {sizeof(tatu_ext_command), 0, commands, 0, 0, 0};

static int same(const char *a, const char *b) {
  while (*a && *a == *b) a++, b++;
  return *a == *b;
}
static const void *extension(void *self, const char *id) {
  (void)self;
  return same(id, TATU_SENSOR) ? (const void *)&sensors : same(id, TATU_COMMAND) ? (const void *)&ext : 0;
}
const tatu_plugin_t tatu_plugin = {sizeof(tatu_plugin_t), TATU_ABI_MAJOR, TATU_ABI_MINOR, "org.example.wrong", "Wrong",
                                   "1", "MIT", 0, 0, 0, extension};
"#;

/// Creates a scene that loads the plugin and contains `more`.
fn with_wrong(more: &str) -> TestFolder {
    let place = TestFolder::scene(&format!("plugins = [\".\"]\n{more}"));
    place.write("wrong.c", INVALID_PLUGIN);
    succeed(
        Command::new(compiler("cc"))
            .args(["-shared", "-fPIC", "-I"])
            .arg(root().join("plugin-api/include"))
            .args(["-o", &library("tatu_wrong"), "wrong.c"])
            .current_dir(place.path()),
    );
    place
}

#[test]
fn invalid_declarations_are_reported_and_the_rest_works() {
    let script = "function sysCall_init() assert(wrong.three(4) == 7) end";
    let place = with_wrong(&format!(
        "{}[[object]]\nkind = \"sensor\"\nsensor = \"nose\"\nspan_m = 2.0\n",
        watcher("caller", script)
    ));
    // No value is valid for one parameter of the sensor. The error must name the plugin as the cause, not the scene.
    let done = place.run(&["--steps", "1"]);
    let told = |words: &[&str]| {
        let found = done.err.split("warning[E310]").any(|w| words.iter().all(|x| w.contains(x)));
        assert!(found, "no warning contains all of {words:?}:\n{}", done.err);
    };
    for (parameter, words) in [
        ("`span`", &["from 3 to 1"][..]),
        ("`gain`", &["default", "from 0 to 1", "found 5"]),
        ("`tint`", &["default", "\"red\"", "\"blue\""]),
        ("`reach`", &["the unit `metres`", "was `m` meant?"]),
        ("`odd`", &["unknown type 99"]),
        ("parameter 6", &["no key"]),
        ("`a b`", &["cannot be written"]),
        ("`range`", &["declared twice"]),
        ("`proximity.detected`", &["element i32", "declares f64"]),
        ("`proximity.distance`", &["unit m", "declares s"]),
        ("`proximity.point`", &["shape 3", "declares 2"]),
        ("`proximity.normal`", &["lacks its field"]),
    ] {
        told(&[words, &["org.example.wrong", "libtatu_wrong", "sensor `nose`", parameter]].concat());
    }
    told(&["command `wrong.odd`", "`gain`"]);
    assert_eq!(done.err.matches("warning[E310]").count(), 13, "expected no other warnings:\n{}", done.err);
    assert!(!done.err.contains("smell"), "schemas of other plugins are not checked");
    // A value for this parameter is refused with the same error as an invalid value in a scene.
    done.refused(&["E102", "span"]);
    with_wrong(&watcher("caller", script)).run(&["--steps", "1"]).good();
}

#[test]
fn integers_have_no_fractions() {
    let script = "function sysCall_init()
        assert(wrong.three(4.0) == 7)
        local ok, message = pcall(wrong.three, 2.5)
        assert(not ok and tostring(message):find('expected an integer, found 2.5', 1, true), message)
        ok, message = pcall(wrong.three, 0/0)
        assert(not ok, message)
        -- The names of old dialects truncate numbers.
        assert(wrongThree(2.9) == 5 and wrongThree(-2.9) == 1)
        ok, message = pcall(sim.getObjectPosition, 1.5)
        assert(not ok and tostring(message):find('found 1.5', 1, true), message)
    end";
    with_wrong(&watcher("caller", script)).run(&["--steps", "1"]).good();
    let place = TestFolder::scene(&cuboid("a", [1.0; 3], [0.0; 3], "layer = 1.5"));
    place.run(&[]).refused(&["E102", "`object.layer`: expected an integer from 0 to 4294967295, found 1.5"]);
}
