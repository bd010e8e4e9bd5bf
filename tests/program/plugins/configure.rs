//! Tests of parameters that change during a run: an instance in C receives the new values, and is recreated only if it
//! requests that.

use std::{fs, process::Command};

use crate::kit::*;

const PLUGIN: &str = r#"
#include "tatu.h"
#include <stdlib.h>
#include <string.h>
#define NUMBER(name, what, how) static const tatu_param name = {.size = sizeof(tatu_param), .type = TATU_F64, \
  .key = #name, .flags = how, .lowest = 0, .highest = 100, .fallback = {.tag = TATU_F64, .u.f = 1}, .text = what}
NUMBER(range, "How far it sees.", 0);
NUMBER(rays, "How many rays it has.", 0);
NUMBER(mass, "Cannot change while it lives.", TATU_PARAM_REBUILDS);
static const tatu_param *const params[] = {&range, &rays, &mass, NULL};

/* An instance: its parameters, the number of calls to `configure`, and the bit mask of the last changed parameters. */
typedef struct gauge { double params[3], configured, changed; } gauge;
static tatu_status create(void *self, const tatu_instance *info, void **data, tatu_error *error) {
  gauge *g = calloc(1, sizeof *g);
  (void)self; (void)error;
  for (int i = 0; g && i < 3; i++) g->params[i] = tatu_to_float(info->params[i]);
  *data = g;
  return g ? TATU_OK : TATU_ERR;
}
static tatu_status configure(void *data, const tatu_value *values, uint32_t n, uint64_t changed, tatu_error *error) {
  gauge *g = data;
  if (n != 3 || changed & 4) return tatu_fail(error, TATU_ERR, "configured as it must not be");
  if (tatu_to_float(values[0]) > 5) return tatu_fail(error, TATU_ERR_ARGUMENT, "sees 5 m at most");
  for (int i = 0; i < 3; i++) g->params[i] = tatu_to_float(values[i]);
  g->configured += 1;
  g->changed = (double)changed;
  return TATU_OK;
}
static const tatu_life life = {.size = sizeof(tatu_life), .state_bytes = 8, .create = create, .destroy = free,
  .configure = configure};
static const tatu_life other_life = {.size = sizeof(tatu_life), .create = create, .destroy = free};

static const double ahead[] = {0, 0, 1, 0, 0, 1};
static tatu_status beams(void *data, tatu_beams *out, tatu_error *error) {
  const gauge *g = data;
  if (g->params[1] > 2) return tatu_fail(error, TATU_ERR, "has two rays at most");
  out->form = TATU_BEAMS_RAYS;
  out->count[0] = (uint32_t)g->params[1];
  out->count[1] = 1;
  out->far_m = g->params[0];
  out->directions = ahead;
  return TATU_OK;
}
static tatu_status measure(void *self, const tatu_sensor_batch *b, tatu_error *error) {
  (void)self; (void)error;
  for (uint32_t i = 0; i < b->n; i++) {
    const gauge *g = b->data[i];
    uint64_t rays = b->first_beam[i + 1] - b->first_beam[i];
    double **fields = (double **)b->fields + i * b->n_fields;
    fields[0][0] = g->configured;
    fields[1][0] = g->changed;
    fields[2][0] = 0;
    for (uint64_t k = 0; k < rays; k++) fields[2][0] += b->distance[b->first_beam[i] + k] < 1e9;
    for (uint64_t k = 0; k < rays; k++) fields[3][k] = 1;
  }
  return TATU_OK;
}
static const tatu_field f0 = {.size = sizeof(tatu_field), .elem = TATU_ELEM_F64, .dims = {1, 1, 1}, .name = "gauge.configured"};
static const tatu_field f1 = {.size = sizeof(tatu_field), .elem = TATU_ELEM_F64, .dims = {1, 1, 1}, .name = "gauge.changed"};
static const tatu_field f2 = {.size = sizeof(tatu_field), .elem = TATU_ELEM_F64, .dims = {1, 1, 1}, .name = "gauge.seen"};
static const tatu_field f3 = {.size = sizeof(tatu_field), .elem = TATU_ELEM_F64, .dims = {0, 1, 1}, .name = "gauge.per_ray"};
static const tatu_field *const fields[] = {&f0, &f1, &f2, &f3, NULL};
static const char *const schemas[] = {"gauge/1", NULL};
static const tatu_sensor live = {.size = sizeof(tatu_sensor), .inputs = TATU_IN_DISTANCE, .id = "gauge", .text = "A gauge.",
  .schemas = schemas, .params = params, .fields = fields, .life = &life, .beams = beams, .measure = measure};
static const tatu_sensor stiff = {.size = sizeof(tatu_sensor), .inputs = TATU_IN_DISTANCE, .id = "stiff", .text = "A gauge.",
  .schemas = schemas, .params = params, .fields = fields, .life = &other_life, .beams = beams, .measure = measure};
static const tatu_sensor *const sensors[] = {&live, &stiff, NULL};
static const tatu_ext_sensor ext_sensor = {.size = sizeof(tatu_ext_sensor), .kinds = sensors};

/* Pushes along x with a force of `range` newtons times the number of calls so far, which is in the state. */
static tatu_status apply(void *self, const tatu_actuator_batch *b, tatu_error *error) {
  (void)self; (void)error;
  for (uint32_t i = 0; i < b->n; i++) {
    double *calls = b->state[i];
    *calls += 1;
    b->wrench[6 * i] = ((const gauge *)b->data[i])->params[0] * *calls;
  }
  return TATU_OK;
}
static const tatu_actuator pusher = {.size = sizeof(tatu_actuator), .id = "pusher", .text = "Pushes.", .params = params,
  .life = &life, .apply = apply};
static const tatu_actuator *const actuators[] = {&pusher, NULL};
static const tatu_ext_actuator ext_actuator = {.size = sizeof(tatu_ext_actuator), .kinds = actuators};

static const void *extension(void *self, const char *id) {
  (void)self;
  if (!strcmp(id, TATU_SENSOR)) return &ext_sensor;
  return strcmp(id, TATU_ACTUATOR) ? NULL : (const void *)&ext_actuator;
}
TATU_EXPORT const tatu_plugin_t tatu_plugin = {.size = sizeof(tatu_plugin_t), .abi_major = TATU_ABI_MAJOR,
  .abi_minor = TATU_ABI_MINOR, .id = "org.test.live", .name = "Live", .version = "1", .licence = "MIT",
  .extension = extension};
"#;

/// Returns a scene with a sensor of this kind, a wall 2 m ahead of it, and a script.
fn looking(kind: &str, script: &str) -> TestFolder {
    let sensor = format!("[[object]]\nkind = \"sensor\"\nsensor = \"{kind}\"\nalias = \"gauge\"\n");
    let wall = cuboid("wall", [1.0, 1.0, 0.2], [0.0, 0.0, 2.1], "");
    with(&format!("{wall}{sensor}{}", watcher("caller", script)))
}

fn with(scene: &str) -> TestFolder {
    let place = TestFolder::scene(&format!("plugins = [\"mine\"]\ngravity_m_s2 = [0.0, 0.0, 0.0]\n{scene}"));
    fs::create_dir(place.path().join("mine")).unwrap();
    place.write("live.c", PLUGIN);
    let mut cc = Command::new(compiler("cc"));
    cc.args(["-std=c11", "-Wall", "-Wextra", "-Wno-override-init", "-shared", "-fPIC", "-fvisibility=hidden", "-I"]);
    let to = place.path().join("mine").join(library("tatu_live"));
    succeed(cc.arg(root().join("plugin-api/include")).arg("-o").args([to, place.path().join("live.c")]));
    place
}

/// Runs lines of Lua in the first and the second step. Returns the reading of the gauge after each of three steps: the
/// number of calls to `configure`, the bit mask of the last change, and the number of rays that hit.
fn gauge_readings(kind: &str, first: &str, second: &str) -> Vec<[f64; 3]> {
    let script = format!(
        "local n = 0
        local function refused(why, key, value)
            local ok, message = pcall(sim.setFloatProperty, gauge, key, value)
            assert(not ok and tostring(message):find(why, 1, true), tostring(message))
        end
        function sysCall_actuation()
            gauge, n = sim.getObject('/gauge'), n + 1
            if n == 2 then {first} elseif n == 3 then {second} end
        end"
    );
    let place = looking(kind, &script);
    place.run(&["--steps", "3"]).good();
    let lines = place.trace(&["/gauge"], &["--steps", "3"]);
    let names = ["gauge.configured", "gauge.changed", "gauge.seen"];
    lines.iter().map(|l| names.map(|name| l.sensor("/gauge", name))).collect()
}

#[test]
fn a_sensor_is_handed_new_values_and_asked_for_its_beams() {
    let set = |key: &str, value: u32| format!("sim.setFloatProperty(gauge, 'gauge.{key}', {value})");
    // The gauge detects the wall when its range is long enough. The second ray adds an element to its fields.
    let told_now = gauge_readings("gauge", &set("range", 3), &set("rays", 2));
    assert_eq!(told_now, [[0.0, 0.0, 0.0], [1.0, 1.0, 1.0], [2.0, 2.0, 2.0]]);
    // A change of a parameter that is declared to rebuild recreates the sensor, with the values that were set.
    let told_now = gauge_readings("gauge", &set("range", 3), &set("mass", 2));
    assert_eq!(told_now[1..], [[1.0, 1.0, 1.0], [0.0, 0.0, 1.0]]);
    // A sensor whose kind has no `configure` is recreated.
    let told_now = gauge_readings("stiff", "sim.setFloatProperty(gauge, 'stiff.range', 3)", "");
    assert_eq!(told_now[1..], [[0.0, 0.0, 1.0], [0.0, 0.0, 1.0]]);
}

#[test]
fn a_sensor_that_is_made_anew_measures_when_the_old_one_did() {
    // A sensor that is measured only on request remains so after a change of parameters.
    let script = "local n = 0
        function sysCall_actuation()
            gauge, n = sim.getObject('/gauge'), n + 1
            if n == 2 then sim.setFloatProperty(gauge, 'stiff.range', 3) end
            assert(tatu.read(gauge).sequence == math.max(n - 5, 0), 'it has measured unasked')
            if n == 5 then sim.setExplicitHandling(gauge, 0) end
        end";
    let sensor = "[[object]]\nkind = \"sensor\"\nsensor = \"stiff\"\nalias = \"gauge\"\nexplicit = true\n";
    let wall = cuboid("wall", [1.0, 1.0, 0.2], [0.0, 0.0, 2.1], "");
    with(&format!("{wall}{sensor}{}", watcher("caller", script))).run(&["--steps", "8"]).good();
}

#[test]
fn a_refused_value_stays_as_it_was() {
    let kept = "assert(sim.getFloatProperty(gauge, 'gauge.range') == 3)
        assert(sim.getFloatProperty(gauge, 'gauge.rays') == 1)";
    let first = "sim.setFloatProperty(gauge, 'gauge.range', 3)
        refused('`gauge.range` of /gauge: plugin `org.test.live`: sees 5 m at most [tatu_life.configure]', 'gauge.range', 6)";
    let told_now = gauge_readings("gauge", &format!("{first} {kept}"), kept);
    assert_eq!(told_now[1..], [[1.0, 1.0, 1.0]; 2]);
    // `configure` accepts the change, but `beams` then fails, so the sensor is recreated with the old values.
    let second = format!("refused('has two rays at most [tatu_sensor.beams]', 'gauge.rays', 3) {kept}");
    let told_now = gauge_readings("gauge", first, &second);
    assert_eq!(told_now[1..], [[1.0, 1.0, 1.0], [0.0, 0.0, 1.0]]);
}

#[test]
fn a_configured_actuator_preserves_its_state() {
    let pushed = |key: &str| {
        let script = format!(
            "local n = 0
            function sysCall_actuation()
                n = n + 1
                if n == 4 then sim.setFloatProperty(sim.getObject('/ball/engine'), 'pusher.{key}', 2) end
            end"
        );
        let ball = cuboid("ball", [0.1; 3], [0.0, 0.0, 1.0], "dynamic = true\nmass_kg = 1.0");
        let engine = "[[object]]\nkind = \"actuator\"\nactuator = \"pusher\"\nalias = \"engine\"\nparent = \"/ball\"\n";
        let place = with(&format!("{ball}{engine}{}", watcher("caller", &script)));
        let lines = place.trace(&["/ball"], &["--steps", "6"]);
        let speed: Vec<f64> = lines.iter().map(|l| l.object::<3>("/ball", "linear_velocity")[0]).collect();
        // The forces, N, computed from the speeds of a body of 1 kg on which each acts for 0.05 s.
        let gained = (0..6).map(|i| (speed[i] - if i > 0 { speed[i - 1] } else { 0.0 }) / 0.05);
        gained.map(|x| x.round() as i32).collect::<Vec<_>>()
    };
    assert_eq!(pushed("range"), [1, 2, 3, 8, 10, 12]);
    assert_eq!(pushed("mass"), [1, 2, 3, 1, 2, 3]);
}
