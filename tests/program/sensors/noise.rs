//! Tests of noise, rates and presets of sensors: what a scene declares and what scripts read. Statistics are tested in
//! the core; these tests check which settings affect which sensor's random numbers.

use std::{fs, process::Command};

use crate::kit::*;

/// A wall whose face is 1 m ahead of sensors at the origin that face along x.
const WALL: &str = "[[object]]\nkind = \"shape\"\nalias = \"wall\"\nsize_m = [0.1, 40, 4]\nposition_m = [1.05, 0, 0]\n";
const NOISE_KEYS: &str = "noise.distance = { sigma = 0.01, walk = { sigma = 0.1, tau_s = 1 }, dropout = 0.1 }";

/// Returns a sensor with one ray along x.
fn eye(alias: &str, more: &str) -> String {
    format!(
        "[[object]]\nkind = \"sensor\"\nsensor = \"proximity\"\nalias = \"{alias}\"\nvolume = \"ray\"\nrange_m = 5\n\
         orientation_deg = [0, 90, 0]\n{more}\n"
    )
}

/// Returns the bit patterns of the distances that a sensor measured in each step.
fn distance_bits(scene: &str, path: &str, args: &[&str]) -> Vec<u64> {
    let place = TestFolder::scene(&format!("seed = 5\n{WALL}{scene}"));
    let lines = place.trace(&[path], &[&["--seconds", "2"], args].concat());
    lines.iter().map(|l| l.sensor(path, "proximity.distance").to_bits()).collect()
}

#[test]
fn other_sensors_do_not_change_the_noise_of_a_sensor() {
    let alone = distance_bits(&eye("eye", NOISE_KEYS), "/eye", &[]);
    assert!(alone.iter().collect::<std::collections::BTreeSet<_>>().len() > 30, "the readings have no noise");
    let second = eye("second", NOISE_KEYS);
    let second_in_front = format!("{second}{}", eye("eye", NOISE_KEYS));
    let model = |alias: &str, y: f64| {
        format!("[[model]]\nmodel = \"pioneer_p3dx\"\nalias = \"{alias}\"\nposition_m = [-3, {y}, 0]\n")
    };
    let moves = watcher(
        "mover",
        "function sysCall_init() second = sim.getObject('/second') end
        function sysCall_actuation()
            local t = sim.getSimulationTime()
            if t < 1 then
                sim.setObjectPosition(second, {-t, 1, 0})
                if t > 0.5 then sim.setObjectAlias(second, 'third') end
            elseif not gone then
                gone = true
                sim.removeObject(second)
            end
        end",
    );
    for (what, scene) in [
        ("a second one after it", format!("{}{second}", eye("eye", NOISE_KEYS))),
        ("a second one before it", second_in_front.clone()),
        ("a second one without noise", format!("{}{}", eye("second", ""), eye("eye", NOISE_KEYS))),
        ("robots", format!("{}{}{}", model("a", 2.0), eye("eye", NOISE_KEYS), model("b", -2.0))),
        ("one that is moved, renamed and removed", format!("{second_in_front}{moves}")),
    ] {
        assert_eq!(distance_bits(&scene, "/eye", &[]), alone, "{what}");
    }
    assert_eq!(distance_bits(&eye("eye", NOISE_KEYS), "/eye", &["--threads", "2"]), alone);
    // Noise of another field, a different seed, and another sensor.
    let more = format!("{NOISE_KEYS}\nnoise.point.sigma = 1");
    assert_eq!(distance_bits(&eye("eye", &more), "/eye", &[]), alone);
    assert_ne!(distance_bits(&eye("eye", NOISE_KEYS), "/eye", &["--seed", "6"]), alone);
    assert_ne!(distance_bits(&second_in_front, "/second", &[]), alone);
}

#[test]
fn zero_noise_is_exact_and_noise_can_be_removed() {
    let exact = distance_bits(&eye("eye", ""), "/eye", &[]);
    // The tests of beams check the accuracy of the distance. This one checks that it is the same in each step.
    assert!(exact.iter().all(|x| *x == exact[0]));
    let zero =
        "noise.distance = { sigma = [0, 0], uniform = 0, step = 0, walk = { sigma = 0, tau_s = 1 }, dropout = 0 }";
    assert_eq!(distance_bits(&eye("eye", zero), "/eye", &[]), exact);
    for none in ["/eye.noise=none", "/eye.noise={}", "/eye.noise={distance={}}"] {
        assert_eq!(distance_bits(&eye("eye", NOISE_KEYS), "/eye", &["--set", none]), exact, "{none}");
    }
    assert_ne!(distance_bits(&eye("eye", ""), "/eye", &["--set", "/eye.noise={distance={sigma=0.1}}"]), exact);
}

/// A sensor that approaches the wall has the readings that it would have had `latency` earlier without a latency.
#[test]
fn a_ramp_is_seen_late_by_the_latency() {
    let drive = watcher(
        "mover",
        "function sysCall_actuation()
            sim.setObjectPosition(sim.getObject('/eye'), {0.1 * sim.getSimulationTime(), 0, 0})
        end",
    );
    let run = |more: &str| {
        let place = TestFolder::scene(&format!("{WALL}{}{drive}", eye("eye", more)));
        let lines = place.trace(&["/eye"], &["--seconds", "2"]);
        lines.iter().map(|l| l.sensor("/eye", "proximity.distance")).collect::<Vec<_>>()
    };
    let now = run("");
    assert!((now[0] - 1.0).abs() < 1e-9 && (now[20] - 0.9).abs() < 1e-9, "{now:?}");
    // A step is 0.05 s. A latency that is not a multiple of the step is rounded up to the next multiple.
    for (latency, steps) in [(0.05, 1), (0.2, 4), (0.12, 3)] {
        let late = run(&format!("noise.latency_s = {latency}"));
        assert!(late[..steps].iter().all(|x| *x == 0.0), "a reading is available too early");
        assert_eq!(late[steps..], now[..now.len() - steps], "latency {latency}");
    }
    // With a rate, the sensor measures every 0.2 s, and each reading becomes available 0.15 s later.
    let late = run("rate_hz = 5\nnoise.latency_s = 0.15");
    for (i, x) in late.iter().enumerate().skip(3) {
        assert_eq!(*x, now[(i - 3) / 4 * 4], "step {i}");
    }
}

#[test]
fn a_sensor_with_a_rate_measures_when_a_period_begins() {
    let script = "function sysCall_init() eye = sim.getObject('/eye') end
        function sysCall_sensing() print('n=' .. sim.getIntProperty(eye, 'sensor.measured')) end";
    let counts = |more: &str, dt: &str, script: &str| {
        let place = TestFolder::scene(&format!("dt_s = {dt}\n{WALL}{}{}", eye("eye", more), watcher("w", script)));
        let done = place.run(&["--seconds", "10"]).good();
        // Ignores the passes after the last step.
        let steps = (10.0 / dt.parse::<f64>().unwrap()) as usize;
        let told = done.err.lines().filter_map(|l| l.strip_prefix("n=")?.parse().ok()).take(steps);
        let told: Vec<i64> = told.collect();
        assert_eq!(told.len(), steps, "{}", done.err);
        told
    };
    // The first measurement is in the first step. After n steps there is one measurement for each period that has
    // started: floor(rate * time) + 1.
    for (rate, dt) in [(10.0, "0.05"), (4.0, "0.05"), (7.0, "0.05"), (30.0, "0.01"), (3.0, "0.07"), (100.0, "0.05")] {
        let told = counts(&format!("rate_hz = {rate}"), dt, script);
        let dt: f64 = dt.parse().unwrap();
        for (i, n) in told.iter().enumerate() {
            let periods = (rate * i as f64 * dt + 1e-6).floor() as i64 + 1;
            assert_eq!(*n, periods.min(i as i64 + 1), "{rate} Hz, step {i} of {dt} s");
        }
    }
    assert_eq!(counts("", "0.05", script), (1..=200).collect::<Vec<_>>());
    // A script that handles the sensor makes it measure at any time. A change of the rate takes effect immediately.
    let handles = format!("{script}\nfunction sysCall_actuation() sim.handleProximitySensor(eye) end");
    let told = counts("rate_hz = 1", "0.05", &handles);
    assert_eq!((told[0], told[1], told[19], told[20]), (2, 3, 21, 23));
    let changes = script.replace(
        "function sysCall_sensing()",
        "function sysCall_sensing()
        if sim.getSimulationTime() > 4.98 then sim.setFloatProperty(eye, 'sensor.rate', 10) end",
    );
    let told = counts("rate_hz = 1", "0.05", &changes);
    assert_eq!((told[99], told[109], told[119]), (5, 11, 16));
}

#[test]
fn the_state_of_noise_continues_from_a_snapshot() {
    let place = TestFolder::scene(&format!(
        "seed = 5\n{WALL}{}",
        eye("eye", &format!("rate_hz = 8\nnoise.latency_s = 0.3\n{NOISE_KEYS}"))
    ));
    let whole = place.trace(&["/eye"], &["--seconds", "3"]);
    place.run(&["--seconds", "1.4", "--snapshot-at", "1.35", "s.bin"]).good();
    let rest = place.trace(&["/eye"], &["--seconds", "3", "--from", "s.bin"]);
    let told = |lines: &[TraceLine]| {
        let distance = |l: &TraceLine| (l.sensor("/eye", "proximity.distance").to_bits(), l.time().to_bits());
        lines.iter().map(distance).collect::<Vec<_>>()
    };
    let (whole, rest) = (told(&whole), told(&rest));
    assert!(rest.len() > 20 && whole.ends_with(&rest), "{} lines", rest.len());
}

/// A plugin with a sensor kind that has valid and invalid presets. It measures an offset plus its gain times the time.
const PLUGIN: &str = r#"
#include "tatu.h"
#include <stdlib.h>
#include <string.h>
static const tatu_param gain = {.size = sizeof(tatu_param), .type = TATU_F64, .key = "gain", .lowest = 0, .highest = 100,
  .fallback = {.tag = TATU_F64, .u.f = 1}, .text = "How steep it is."};
static const tatu_param offset = {.size = sizeof(tatu_param), .type = TATU_F64, .key = "offset", .unit = "m", .lowest = 0,
  .highest = 100, .fallback = {.tag = TATU_F64, .u.f = 0}, .text = "Where it begins."};
static const tatu_param *const params[] = {&gain, &offset, NULL};
typedef struct ramp { double gain, offset; } ramp;
static tatu_status create(void *self, const tatu_instance *info, void **data, tatu_error *error) {
  ramp *r = calloc(1, sizeof *r);
  (void)self; (void)error;
  if (!r) return TATU_ERR;
  r->gain = tatu_to_float(info->params[0]);
  r->offset = tatu_to_float(info->params[1]);
  *data = r;
  return TATU_OK;
}
static const tatu_life life = {.size = sizeof(tatu_life), .create = create, .destroy = free};
static tatu_status measure(void *self, const tatu_sensor_batch *b, tatu_error *error) {
  (void)self; (void)error;
  for (uint32_t i = 0; i < b->n; i++) {
    const ramp *r = b->data[i];
    double **fields = (double **)b->fields + i * b->n_fields;
    fields[0][0] = r->offset + r->gain * b->time;
    b->random->uniform(b->random, i, 0, 1, fields[1]);
    b->random->normal(b->random, i, 7, 1, fields[1] + 1);
  }
  return TATU_OK;
}
static const tatu_field value = {.size = sizeof(tatu_field), .elem = TATU_ELEM_F64, .dims = {1, 1, 1}, .name = "ramp.value"};
static const tatu_field drawn = {.size = sizeof(tatu_field), .elem = TATU_ELEM_F64, .dims = {2, 1, 1}, .name = "ramp.drawn"};
static const tatu_field *const fields[] = {&value, &drawn, NULL};
static const char *const schemas[] = {"ramp/1", NULL};
#define PRESET(name, words, lines) static const tatu_preset name = {.size = sizeof(tatu_preset), .id = #name, .text = words, .settings = lines}
PRESET(steep, "Twice as steep; an example.", "gain = 2\noffset_m = 5\nrate_hz = 10\n\n[noise]\nlatency_s = 0.1\n[noise.value]\nstep = 1\n[noise.drawn]\nstep = 0.5\n");
PRESET(flat, "Flat.", "gain = 0\noffset_m = 3\nnoise = 'none'\nrate_hz = 0\n");
PRESET(misspelt, "", "gain = 1\n\ngian = 2\n");
PRESET(too_much, "", "gain = 1000\n");
PRESET(wrong_noise, "", "gain = 1\n[noise.value]\nsigma = 1\nstpe = 1\n");
PRESET(no_toml, "", "gain = 1\noffset_m = = 2\n");
PRESET(itself, "", "preset = 'steep'\n");
static const tatu_preset *const presets[] = {&steep, &flat, &misspelt, &too_much, &wrong_noise, &no_toml, &itself, NULL};
static const tatu_sensor kind = {.size = sizeof(tatu_sensor), .id = "ramp", .text = "A ramp.", .schemas = schemas,
  .params = params, .fields = fields, .life = &life, .measure = measure, .presets = presets};
static const tatu_sensor *const sensors[] = {&kind, NULL};
static const tatu_ext_sensor ext_sensor = {.size = sizeof(tatu_ext_sensor), .kinds = sensors};
static const void *extension(void *self, const char *id) {
  (void)self;
  return strcmp(id, TATU_SENSOR) ? NULL : (const void *)&ext_sensor;
}
TATU_EXPORT const tatu_plugin_t tatu_plugin = {.size = sizeof(tatu_plugin_t), .abi_major = TATU_ABI_MAJOR,
  .abi_minor = TATU_ABI_MINOR, .id = "org.test.ramp", .name = "Ramp", .version = "1", .licence = "MIT",
  .extension = extension};
"#;

/// Creates a scene with a sensor `ramp`, which has these keys, and a script.
fn ramp(keys: &str, script: &str) -> TestFolder {
    let sensor = format!("[[object]]\nkind = \"sensor\"\nsensor = \"ramp\"\nalias = \"ramp\"\n{keys}\n");
    let script = format!("function sysCall_init() ramp = sim.getObject('/ramp') end\n{script}");
    let place = TestFolder::scene(&format!("plugins = [\"mine\"]\n{sensor}{}", watcher("w", &script)));
    fs::create_dir(place.path().join("mine")).unwrap();
    place.write("ramp.c", PLUGIN);
    let mut cc = Command::new(compiler("cc"));
    cc.args(["-std=c11", "-Wall", "-Wextra", "-shared", "-fPIC", "-fvisibility=hidden", "-I"]);
    let to = place.path().join("mine").join(library("tatu_ramp"));
    succeed(cc.arg(root().join("plugin-api/include")).arg("-o").args([to, place.path().join("ramp.c")]));
    place
}

/// Returns the reading in the step that starts at 1 s.
fn at_one_second(place: &TestFolder, args: &[&str]) -> f64 {
    let lines = place.trace(&["/ramp"], &[&["--steps", "21"], args].concat());
    lines[20].sensor("/ramp", "ramp.value")
}

#[test]
fn keys_of_an_object_override_its_preset() {
    // The sensor measures 5 + 2 t with a latency of 0.1 s, rounded to integers. At 0.9 s it measures 6.8, so it reads
    // 7.
    let place = ramp("preset = \"steep\"", "");
    assert_eq!(at_one_second(&place, &[]), 7.0);
    // The keys of the object take precedence over those of the preset, in any order. Noise is merged field by field.
    let place = ramp("offset_m = 1\nnoise.value = { step = 0.25 }\npreset = \"steep\"\nrate_hz = 20", "");
    assert_eq!(at_one_second(&place, &[]), 2.75);
    // `--set` is applied last, also to the preset.
    assert_eq!(at_one_second(&place, &["--set", "/ramp.preset=flat"]), 3.0);
    assert_eq!(at_one_second(&place, &["--set", "/ramp.preset=flat", "--set", "/ramp.gain=4"]), 7.0);
}

#[test]
fn a_preset_can_be_read_and_set_while_it_runs() {
    let script = "function sysCall_actuation()
        local t = sim.getSimulationTime()
        if t == 0 then
            assert(sim.getStringProperty(ramp, 'sensor.preset') == 'steep')
            assert(sim.getFloatProperty(ramp, 'sensor.rate') == 10)
            local noise = sim.getStringProperty(ramp, 'sensor.noise')
            assert(noise:find('latency_s = 0.1', 1, true) and noise:find('[\"ramp.value\"]', 1, true), noise)
            local function refused(why, set, ...)
                local ok, message = pcall(set, ramp, ...)
                assert(not ok and tostring(message):find(why, 1, true), tostring(message))
            end
            refused('did you mean `steep`', sim.setStringProperty, 'sensor.preset', 'stepe')
            refused('did you mean `value`', sim.setStringProperty, 'sensor.noise', 'valeu.step = 1')
            refused('line 2 of `noise`', sim.setStringProperty, 'sensor.noise', 'value.step = 1\\ndrawn.step = true')
            refused('expected a number, at least 0, found -1', sim.setFloatProperty, 'sensor.rate', -1)
            refused('expected a number from 0 to 100', sim.setStringProperty, 'sensor.preset', 'too_much')
            assert(sim.getStringProperty(ramp, 'sensor.preset') == 'steep')
        elseif t > 0.48 and not done then
            done = true
            sim.setStringProperty(ramp, 'sensor.preset', 'flat')
            assert(sim.getStringProperty(ramp, 'sensor.preset') == 'flat')
            assert(sim.getStringProperty(ramp, 'sensor.noise') == '')
            assert(sim.getFloatProperty(ramp, 'ramp.offset') == 3)
            sim.setStringProperty(ramp, 'sensor.noise', 'value.step = 2')
        end
    end";
    let place = ramp("preset = \"steep\"", script);
    assert_eq!(at_one_second(&place, &[]), 4.0, "3 in steps of 2 must be rounded to the even number of steps");
}

#[test]
fn errors_of_a_preset_are_reported_with_their_line() {
    for (preset, words) in [
        ("stepe", ["E102", "no preset `stepe`", "did you mean `steep`?"].as_slice()),
        ("misspelt", &["E101", "line 3 of the preset `misspelt`", "`ramp`", "org.test.ramp", "did you mean `gain`?"]),
        ("too_much", &["E102", "line 1 of the preset `too_much`", "from 0 to 100"]),
        ("wrong_noise", &["E101", "line 4 of the preset `wrong_noise`", "`stpe`", "did you mean `step`?"]),
        ("no_toml", &["E102", "line 2 of the preset `no_toml`", "not TOML"]),
        ("itself", &["E101", "line 1 of the preset `itself`", "`preset`"]),
    ] {
        ramp(&format!("preset = \"{preset}\""), "")
            .run(&["--steps", "1"])
            .refused(&[words, &["scene.toml:8"]].concat());
    }
    // This sensor kind has no presets.
    TestFolder::scene(&format!("{WALL}{}", eye("eye", "preset = \"x\"")))
        .run(&[])
        .refused(&["E102", "it has no presets"]);
}

#[test]
fn wrong_noise_is_reported_with_its_line() {
    for (more, words) in [
        ("[object.noise.distance]\nsgima = 1", ["E101", "scene.toml:17", "did you mean `sigma`?"]),
        ("[object.noise.distanse]\nsigma = 1", ["E101", "scene.toml:16", "did you mean `distance`?"]),
        ("[object.noise]\nlatency_ms = 1", ["E101", "scene.toml:17", "did you mean `latency_s`?"]),
        ("noise.point.uniform = [1, 2]", ["E102", "scene.toml:16", "one number, or 3"]),
        ("noise = 3", ["E102", "scene.toml:16", "expected a table, or"]),
    ] {
        TestFolder::scene(&format!("\n{WALL}{}", eye("eye", more))).run(&[]).refused(&words);
    }
    let scene = format!("{WALL}{}", eye("eye", ""));
    TestFolder::scene(&scene)
        .run(&["--set", "/eye.noise={distance={sigma='x'}}"])
        .refused(&["E102", "`sigma`: expected"]);
}

#[test]
fn presets_are_described() {
    let place = ramp("", "");
    let fact = place.tatu(&["describe", "ramp", "--scene", "scene.toml", "--json"]).good().json();
    let presets = fact["presets"].as_array().unwrap();
    assert_eq!((&presets[0]["id"], &presets[0]["text"]), (&"steep".into(), &"Twice as steep; an example.".into()));
    assert!(presets[0]["settings"].as_str().unwrap().contains("gain = 2"));
    let shown = place.tatu(&["describe", "ramp", "--scene", "scene.toml"]).good().out;
    for words in ["presets:", "steep  Twice as steep; an example.", "    [noise.value]"] {
        assert!(shown.contains(words), "{words}\n{shown}");
    }
}

/// The random numbers that a plugin draws depend only on the sensor and on the number of its measurements.
#[test]
fn a_plugin_draws_by_key() {
    let place = ramp("", "");
    let drawn = |place: &TestFolder| -> Vec<Vec<f64>> {
        let lines = place.trace(&["/ramp"], &["--steps", "50"]);
        lines.iter().map(|l| numbers(&l.0["readings"]["/ramp"]["ramp.drawn"])).collect()
    };
    let alone = drawn(&place);
    assert!(alone.iter().all(|d| (0.0..1.0).contains(&d[0])) && alone[0] != alone[1]);
    let text = place.read("scene.toml");
    place.write(
        "scene.toml",
        &text.replace(
            "alias = \"ramp\"\n",
            "alias = \"ramp\"\n\n[[object]]\nkind = \"sensor\"\nsensor = \"ramp\"\nalias = \"other\"\n",
        ),
    );
    assert_eq!(drawn(&place), alone);
    // The sensor's noise comes from a separate stream of random numbers.
    place.write("scene.toml", &text.replace("alias = \"ramp\"\n", "alias = \"ramp\"\nnoise.value.sigma = 1\n"));
    assert_eq!(drawn(&place), alone);
}

#[test]
fn a_rate_beyond_that_of_the_steps_is_noted() {
    let scene = |step: &str, rate: f64| format!("{step}{}", eye("near", &format!("rate_hz = {rate}\n")));
    let noted = |scene: &str| {
        let place = TestFolder::scene(scene);
        place.run(&["--steps", "1", "--strict"]).good().err
    };
    let err = noted(&(scene("", 75.0) + &eye("far", "rate_hz = 30.0\n")));
    let told = "the sensor `near` (and another sensor) has a rate of 75 Hz, but measures at 20 Hz";
    assert!(err.contains(told) && err.contains("at most 0.0133 s") && err.contains("scene.toml:"), "{err}");
    for (step, rate) in [("", 20.0), ("dt_s = 0.0133\n", 75.0), ("dt_s = 0.01\n", 75.0)] {
        let err = noted(&scene(step, rate));
        assert!(!err.contains("has a rate of"), "{err}");
    }
}
