//! Tests that the host detects writes outside of the buffers of a plugin: a write one word too far is detected after
//! the call, and the refused reading is zero and not partly written.

use std::process::Command;

use crate::kit::*;

/// A plugin with a sensor and a command that write at an offset given by a parameter.
const WRITER: &str = r#"
#include <math.h>
#include <string.h>
#include "tatu.h"
typedef struct { int64_t how, n; } own;
static own all[8];
static int made;
static tatu_status TATU_CALL create(void *me, const tatu_instance *i, void **data, tatu_error *e) {
  own *o = &all[made++ % 8];
  (void)me; (void)e;
  o->how = i->params[0].u.i;
  o->n = 0;
  *data = o;
  return TATU_OK;
}
static void TATU_CALL destroy(void *data) { (void)data; }
static tatu_status TATU_CALL measure(void *me, const tatu_sensor_batch *b, tatu_error *e) {
  uint32_t i;
  (void)me;
  for (i = 0; i < b->n; i++) {
    own *o = b->data[i];
    double *x = b->fields[2 * i], *y = b->fields[2 * i + 1], *state = b->state[i];
    x[0] = x[1] = x[2] = 7;
    y[0] = 8;
    state[0] += 1;
    if (++o->n < 3) continue;
    if (o->how == 1) x[3] = 9;
    if (o->how == 2) y[1] = 9;
    if (o->how == 3) state[1] = 9;
    if (o->how == 4) x[1] = NAN;
    if (o->how == 5) { b->status[i] = TATU_ERR; e->say(e, TATU_ERR, tatu_text("it is dark")); }
  }
  return TATU_OK;
}
static const tatu_param how = {sizeof how, TATU_I64, 0, TATU_PARAM_REBUILDS, "how", 0, 0, 0, {TATU_I64, 0, {0}}, 0, "How.", 0};
static const tatu_param *const params[] = {&how, 0};
static const tatu_field x = {sizeof x, TATU_ELEM_F64, {3, 1, 1}, 0, "writer.x", "1", "Three.", 0, 0};
static const tatu_field y = {sizeof y, TATU_ELEM_F64, {1, 1, 1}, 0, "writer.y", "1", "One.", 0, 0};
static const tatu_field *const fields[] = {&x, &y, 0};
static const char *const schemas[] = {"writer/1", 0};
static const tatu_life life = {.size = sizeof life, .state_bytes = 8, .create = create, .destroy = destroy, .version = 1};
static const tatu_sensor kind = {sizeof kind, 0, "writer", "Writes.", schemas, params, fields, &life, 0, measure, 0, 0, 0, 0, 0};
static const tatu_sensor *const kinds[] = {&kind, 0};
static const tatu_ext_sensor sensors = {sizeof sensors, 0, kinds};

static tatu_status TATU_CALL world(void *me, const tatu_instance *i, void **data, tatu_error *e) {
  (void)me; (void)i; (void)e;
  *data = 0;
  return TATU_OK;
}
static const tatu_life per_world = {.size = sizeof per_world, .state_bytes = 16, .create = world, .destroy = destroy, .version = 1};
static tatu_status TATU_CALL poke(tatu_call *c) {
  ((int64_t *)c->state)[tatu_arg_int(c, 0)] = 1;
  return tatu_return(c, tatu_int(5));
}
static const tatu_param at = {sizeof at, TATU_I64, 0, 0, "at", 0, 0, 0, {TATU_NIL, 0, {0}}, 0, "Where.", 0};
static const tatu_param *const poked[] = {&at, 0};
static const tatu_name name = {sizeof name, 0, "writer.poke", 0, 0, 0, 0};
static const tatu_name *const names[] = {&name, 0};
static const tatu_command command = {sizeof command, 0, names, poked, 0, "Pokes.", 0, 0, 0, poke, 0, 0, 0, 0};
static const tatu_command *const list[] = {&command, 0};
static const tatu_ext_command ext = {sizeof ext, 0, list, 0, 0, &per_world, 0};
static const void *TATU_CALL extension(void *me, const char *id) {
  (void)me;
  if (!strcmp(id, TATU_SENSOR)) return &sensors;
  return strcmp(id, TATU_COMMAND) ? 0 : &ext;
}
TATU_EXPORT const tatu_plugin_t tatu_plugin = {sizeof tatu_plugin, TATU_ABI_MAJOR, TATU_ABI_MINOR, "org.example.writer", "Writer",
  "1.0.0", "MIT", 0, 0, 0, extension};
"#;

fn place(how: u32, script: &str) -> TestFolder {
    let sensor =
        |i, how| format!("[[object]]\nkind = \"sensor\"\nsensor = \"writer\"\nalias = \"eye{i}\"\nhow = {how}\n");
    let place = TestFolder::scene(&format!(
        "plugins = [\"mine\"]\n{}{}{}",
        sensor(0, how),
        sensor(1, 0),
        watcher("caller", script)
    ));
    place.write("mine/writer.c", WRITER);
    succeed(
        Command::new(compiler("cc"))
            .args(["-std=c11", "-Wall", "-Wextra", "-Werror", "-shared", "-fPIC", "-I"])
            .arg(root().join("plugin-api/include"))
            .args(["writer.c", "-o", &library("tatu_writer"), "-lm"])
            .current_dir(place.path().join("mine")),
    );
    place
}

#[test]
fn writes_past_the_end_are_detected_and_refused_fields_are_zero() {
    // The script prints the readings of both sensors after each step.
    let look = "function sysCall_init() one, two = sim.getObject('/eye0'), sim.getObject('/eye1') end
        function sysCall_sensing()
            local a, b = tatu.read(one), tatu.read(two)
            print('read', a.x and table.concat(a.x, ' '), a.y, table.concat(b.x, ' '), b.y)
        end";
    for (how, words) in [
        (1, "it wrote past the end of the field `writer.x`"),
        (2, "it wrote past the end of the field `writer.y`"),
        (3, "it wrote past the end of its state block"),
        (4, "`writer.x` is not a number"),
        (5, "it is dark"),
    ] {
        for threads in ["1", "2"] {
            let done = place(how, look).run(&["--steps", "4", "--threads", threads]);
            let errors = done.errors();
            assert_eq!(errors.len(), 1, "{errors:?}");
            let e = &errors[0];
            assert!(e["message"].as_str().unwrap().contains(words), "{how}: {e}");
            assert_eq!(
                (e["plugin"].as_str(), e["object"].as_str()),
                (Some("org.example.writer"), Some("/eye0")),
                "{e}"
            );
            // The other sensor continues, and the reading of the first is not partly written.
            let read: Vec<&str> = done.err.lines().filter(|l| l.contains("read")).collect();
            assert!(read.len() >= 4, "{}", done.err);
            assert!(read[1].contains("7.0 7.0 7.0") && read[3].contains("7.0 7.0 7.0"), "{read:?}");
            assert_eq!(read[3].matches('7').count(), 3, "{read:?}");
        }
    }
}

#[test]
fn a_command_that_writes_past_its_state_fails() {
    let script = "function sysCall_init()
        assert(writer.poke(0) == 5 and writer.poke(1) == 5)
        local ok, why = pcall(writer.poke, 2)
        assert(not ok and why:find('past the end of its state block', 1, true) and why:find('org.example.writer', 1, true), why)
        assert(writer.poke(1) == 5)
    end";
    place(0, script).run(&["--steps", "2"]).good();
}

#[test]
fn a_field_is_valid_by_another_of_its_kind() {
    let place = place(0, "");
    let text = WRITER.replace("\"One.\", 0, 0}", "\"One.\", \"writer.z\", 0}");
    assert_ne!(text, WRITER);
    place.write("mine/writer.c", &text).write("scene.toml", "format = 1\n[scene]\nplugins = [\"mine\"]\n");
    succeed(
        Command::new(compiler("cc"))
            .args(["-std=c11", "-shared", "-fPIC", "-I"])
            .arg(root().join("plugin-api/include"))
            .args(["writer.c", "-o", &library("tatu_writer"), "-lm"])
            .current_dir(place.path().join("mine")),
    );
    let done = place.run(&["--steps", "1"]).good();
    done.reports(&["the field `writer.y` of its sensor `writer` refers to `writer.z` as the field that marks valid \
                  elements, but its sensor `writer` has no such field"]);
}

#[test]
fn state_alone_needs_no_functions() {
    let source = r#"
#include <string.h>
#include "tatu.h"
static tatu_status TATU_CALL next(tatu_call *c) { return tatu_return(c, tatu_int(++*(int64_t *)c->state)); }
static const tatu_life life = {.size = sizeof(tatu_life), .state_bytes = 8};
static const tatu_name name = {.size = sizeof(tatu_name), .name = "plain.next"};
static const tatu_name *const names[] = {&name, 0};
static const tatu_command command = {.size = sizeof(tatu_command), .names = names, .text = "Counts.", .call = next};
static const tatu_command *const commands[] = {&command, 0};
static const tatu_ext_command offer = {.size = sizeof(tatu_ext_command), .commands = commands, .per_world = &life};
static tatu_status TATU_CALL init(const tatu_host *h, void **me, tatu_error *e) { (void)h; (void)e; *me = 0; return TATU_OK; }
static const void *TATU_CALL extension(void *me, const char *id) { (void)me; return strcmp(id, TATU_COMMAND) ? 0 : &offer; }
TATU_EXPORT const tatu_plugin_t tatu_plugin = {.size = sizeof(tatu_plugin_t), .abi_major = TATU_ABI_MAJOR,
  .abi_minor = TATU_ABI_MINOR, .id = "org.test.plain", .name = "Plain", .version = "1", .licence = "MIT",
  .init = init, .extension = extension};
"#;
    let place = TestFolder::new();
    place.write("mine/plain.c", source);
    let to = place.path().join("mine").join(library("tatu_plain"));
    let include = root().join("plugin-api/include");
    succeed(
        Command::new(compiler("cc"))
            .args(["-std=c11", "-Wall", "-Werror", "-shared", "-fPIC", "-fvisibility=hidden", "-I"])
            .arg(include)
            .arg("-o")
            .args([to, place.path().join("mine/plain.c")]),
    );
    let script = "function sysCall_actuation()
        local n = plain.next()
        assert(n == 1 + math.floor(sim.getSimulationTime() / sim.getSimulationTimeStep() + 0.5), n)
    end";
    let scene = format!("format = 1\n[scene]\nplugins = [\"mine\"]\n{}", watcher("counter", script));
    place.write("scene.toml", &scene);
    let whole = place.run(&["--steps", "8"]).good().json()["hash"].clone();
    place.run(&["--steps", "8", "--snapshot-at", "0.2", "state"]).good();
    assert_eq!(place.run(&["--from", "state", "--steps", "8"]).good().json()["hash"], whole);
}
