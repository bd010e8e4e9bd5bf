//! Tests of actuators: thrusters against closed forms, and actuators of a plugin in C that is part of this file.
//!
//! The engine integrates each physics step by semi-implicit Euler. Under a constant force velocities are therefore
//! exact, and the position is ahead of the closed form by at most half a physics step times the velocity gained.

use std::{path::Path, process::Command, sync::Arc};

use tatu_core::{
    World, document,
    plugins::{Registry, SearchPath},
};

use crate::kit::*;

const MASS: f64 = 2.0;
const G: f64 = 9.81;

/// Returns a cube of 2 kg and 0.2 m that does not collide; `more` contains further keys.
fn hull(more: &str) -> String {
    cuboid("hull", [0.2, 0.2, 0.2], [0.0, 0.0, 5.0], &format!("dynamic = true\nmass_kg = {MASS}\n{more}"))
}

fn thruster(kind: &str, alias: &str, more: &str) -> String {
    format!(
        "[[object]]\nkind = \"actuator\"\nactuator = \"{kind}\"\nparent = \"/hull\"\nalias = \"{alias}\"\nmax_force_n = 50.0\n{more}\n"
    )
}

#[test]
fn a_constant_thrust_lifts_as_the_closed_form_says() {
    for kind in ["thruster", "thruster_substep"] {
        let mut ahead = Vec::new();
        for physics_dt in [0.01, 0.005] {
            let force = 30.0;
            let scene =
                format!("physics_dt_s = {physics_dt}\n{}{}", hull(""), thruster(kind, "jet", "thrust_n = 30.0"));
            let lines = TestFolder::scene(&scene).trace(&["/hull"], &["--seconds", "2"]);
            let a = force / MASS - G;
            for line in &lines {
                let t = line.time();
                let [_, _, v] = line.object("/hull", "linear_velocity");
                let [x, y, z] = line.object("/hull", "position");
                assert!((v - a * t).abs() < 1e-9, "{kind}: v({t}) = {v}, not {}", a * t);
                let over = z - (5.0 + 0.5 * a * t * t);
                assert!(over > 0.0 && over <= 0.5 * a * t * physics_dt + 1e-9, "{kind}: z({t}) is {over} m ahead");
                assert!(x.abs() + y.abs() < 1e-9, "{kind}: pushed aside");
            }
            let last = lines.last().unwrap();
            ahead.push(last.object::<3>("/hull", "position")[2] - (5.0 + 0.5 * a * last.time().powi(2)));
        }
        // The method is of first order, so half the step gives half the error.
        assert!((ahead[0] / ahead[1] - 2.0).abs() < 1e-3, "{kind}: {ahead:?}");
    }
}

#[test]
fn a_lag_follows_the_closed_form() {
    // With F(t) = F (1 - e^(-t/tau)), the velocity is v = F/m (t - tau (1 - e^(-t/tau))) - g t.
    let (force, tau) = (24.0, 0.4);
    for kind in ["thruster", "thruster_substep"] {
        let jet = thruster(kind, "jet", "thrust_n = 24.0\ntime_constant_s = 0.4");
        let lines = TestFolder::scene(&format!("{}{jet}", hull(""))).trace(&["/hull"], &["--seconds", "2"]);
        for line in lines {
            let t = line.time();
            let wanted = force / MASS * (t - tau * (1.0 - f64::exp(-t / tau))) - G * t;
            let [_, _, v] = line.object("/hull", "linear_velocity");
            assert!((v - wanted).abs() < 1e-9, "{kind}: v({t}) = {v}, not {wanted}");
        }
    }
}

#[test]
fn a_thruster_beside_the_centre_turns_the_hull() {
    // The torque is (r, 0, 0) x (0, 0, F) = (0, -r F, 0), and the inertia of a cube is m s^2 / 6.
    let (r, force) = (0.1, 0.5);
    let alpha = -r * force / (MASS * 0.04 / 6.0);
    let scene = |kind: &str| {
        let jet = thruster(kind, "jet", "thrust_n = 0.5\nposition_m = [0.1, 0.0, 0.0]");
        TestFolder::scene(&format!("gravity_m_s2 = [0.0, 0.0, 0.0]\nphysics_dt_s = 0.005\n{}{jet}", hull("")))
    };
    // Under a force that rotates with the body, the velocity is F/m times the integral of (sin, cos) of the angle.
    let closed = |t: f64| {
        let (n, mut v) = (20_000, [0.0; 2]);
        for i in 0..n {
            let s = (f64::from(i) + 0.5) * t / f64::from(n);
            let angle = 0.5 * alpha * s * s;
            v[0] += force / MASS * angle.sin() * t / f64::from(n);
            v[1] += force / MASS * angle.cos() * t / f64::from(n);
        }
        v
    };
    let mut errors = Vec::new();
    for kind in ["thruster", "thruster_substep"] {
        let lines = scene(kind).trace(&["/hull"], &["--seconds", "1"]);
        let [_, first, _] = lines[0].object("/hull", "angular_velocity");
        assert!((first - alpha * 0.05).abs() < 1e-3 * alpha.abs() * 0.05, "{kind}: {first}, not {}", alpha * 0.05);
        let last = lines.last().unwrap();
        let ([vx, _, vz], wanted) = (last.object("/hull", "linear_velocity"), closed(last.time()));
        errors.push(f64::hypot(vx - wanted[0], vz - wanted[1]));
        if kind == "thruster_substep" {
            let [x, y, z] = last.object("/hull", "angular_velocity");
            assert!((y - alpha * last.time()).abs() < 1e-3 * alpha.abs(), "{y}, not {}", alpha * last.time());
            assert!(x.abs() + z.abs() < 1e-9);
        }
    }
    // The second kind is evaluated ten times as often and therefore follows the rotation more closely.
    assert!(errors[1] < errors[0] / 5.0, "{errors:?}");
}

#[test]
fn scripts_set_commands_by_name_within_bounds_and_get_errors() {
    let script = "function sysCall_init()
            jet = sim.getObject('/hull/jet')
            assert(sim.getFloatProperty(jet, 'thruster.thrust') == 3.5)
            assert(sim.getStringProperty(jet, 'actuator.kind') == 'thruster')
            assert(sim.getFloatProperty(jet, 'thruster.max_force') == 50)
            local function refused(words, ...)
                local ok, message = pcall(sim.setFloatProperty, ...)
                assert(not ok and tostring(message):find(words, 1, true), tostring(message))
            end
            refused('did you mean `thruster.thrust`?', jet, 'thruster.trust', 1)
            refused('has no property `thruster.thrust`', sim.getObject('/hull'), 'thruster.thrust', 1)
            refused('finite', jet, 'thruster.thrust', 1 / 0)
            refused('at least 0', jet, 'thruster.max_force', -1)
            sim.setFloatProperty(jet, 'thruster.thrust', 1e6)
            assert(sim.getFloatProperty(jet, 'thruster.thrust') == 1e6)
        end
        function sysCall_sensing()
            if not done then
                -- Limited to 50 N.
                local v = sim.getObjectVelocity(sim.getObject('/hull'))
                assert(math.abs(v[3] - (25 - 9.81) * 0.05) < 1e-9, v[3])
                sim.setFloatProperty(jet, 'thruster.max_force', 10)
                assert(sim.getFloatProperty(jet, 'thruster.thrust') == 1e6)
                done = true
            end
        end";
    let scene = format!("{}{}{}", hull(""), thruster("thruster", "jet", "thrust_n = 3.5"), watcher("pilot", script));
    let lines = TestFolder::scene(&scene).trace(&["/hull"], &["--steps", "2"]);
    let v = lines.iter().map(|l| l.object::<3>("/hull", "linear_velocity")[2]).collect::<Vec<_>>();
    assert!((v[1] - v[0] - (5.0 - G) * 0.05).abs() < 1e-9, "the parameter that was set has no effect: {v:?}");
}

#[test]
fn errors_of_an_actuator_in_a_document_are_refused() {
    let scene = |kind: &str, more: &str| {
        TestFolder::scene(&format!("{}{}", hull(""), thruster(kind, "jet", more))).tatu(&["check", "scene.toml"])
    };
    scene("thruster", "thrust_n = -12.5").good();
    let set = |value: &str| {
        let place = TestFolder::scene(&format!("{}{}", hull(""), thruster("thruster", "jet", "")));
        place.run(&[
            "--steps",
            "1",
            "--set",
            &format!("/hull/jet.thrust_n={value}"),
            "--trace",
            "t",
            "--watch",
            "/hull",
        ])
    };
    set("20.0").good();
    set("\"much\"").refused(&["E102", "thrust"]);
    set("inf").refused(&["E102", "thrust", "not finite"]);
    scene("thruster", "trust_n = 1.0").refused(&["E101", "thrust_n"]);
    scene("thruster", "thrust = 1.0").refused(&["E103", "thrust_n"]);
    scene("thruster", "thrust_n = \"much\"").refused(&["E102", "thrust"]);
    scene("thruster", "time_constant_s = -1.0").refused(&["E102", "time_constant"]);
    scene("truster", "").refused(&["E108", "did you mean `thruster`?"]);
    let bare = "[[object]]\nkind = \"actuator\"\n";
    TestFolder::scene(bare).tatu(&["check", "scene.toml"]).refused(&["E104", "actuator = ", "tatu list actuators"]);
}

#[test]
fn an_actuator_without_anything_to_push_says_so_once() {
    let fixed = cuboid("hull", [0.2, 0.2, 0.2], [0.0, 0.0, 5.0], "");
    let place = TestFolder::scene(&format!("{fixed}{}", thruster("thruster", "jet", "thrust_n = 1.0")));
    let done = place.run(&["--steps", "5"]).good();
    done.reports(&["/hull/jet has no effect", "no dynamic shape above it"]);
    assert_eq!(done.err.matches("has no effect").count(), 1, "{}", done.err);
}

#[test]
fn a_robot_with_a_thruster_changes_no_other() {
    let script =
        "function sysCall_actuation() sim.setJointTargetVelocity(sim.getObject('./Pioneer_p3dx_leftMotor'), 2) end";
    let robot = format!("{FLOOR}{}", pioneer(script, ""));
    let hash = |scene: &str| {
        let result = TestFolder::scene(scene).run(&["--seconds", "2"]).good().json();
        (result["objects"]["/Pioneer_p3dx"].clone(), result["hash"].clone())
    };
    let (alone, total) = hash(&robot);
    for kind in ["thruster", "thruster_substep"] {
        let jet = thruster(kind, "jet", "thrust_n = 21.0\nposition_m = [0.01, 0.0, 0.0]");
        let (beside, more) = hash(&format!("{robot}{}{jet}", hull("model_base = true")));
        assert_eq!(alone, beside, "{kind}");
        assert_ne!(total, more);
    }
}

/// Loads the plugins that these tests need, whose libraries are next to the built program.
fn registry() -> Arc<Registry> {
    let names = ["tatu_commands_vrep", "tatu_scripts_lua", "tatu_actuators_thruster"];
    load_registry(SearchPath::standard(Some(program()), None, &names))
}

fn world(scene: &Path, registry: &Arc<Registry>) -> World {
    let document = document::load(scene, registry, &document::LoadOptions::default()).unwrap();
    World::new(Arc::new(document), registry.clone()).unwrap()
}

#[test]
fn a_stop_brings_commands_parameters_and_removed_thrusters_back() {
    let script = "function sysCall_actuation()
            n = (n or 0) + 1
            local jet = sim.getObject('/hull/jet')
            if n == 2 then sim.setFloatProperty(jet, 'thruster.thrust', 40) end
            if n == 4 then sim.setFloatProperty(jet, 'thruster.max_force', 25) end
            if n == 6 then sim.removeObject(sim.getObject('/hull/other')) end
        end";
    let (jet, other) = ("thrust_n = 10.0\ntime_constant_s = 0.2", "thrust_n = 5.0");
    let place = TestFolder::scene(&format!(
        "{}{}{}{}",
        hull(""),
        thruster("thruster", "jet", jet),
        thruster("thruster_substep", "other", other),
        watcher("pilot", script)
    ));
    let (registry, file) = (registry(), place.path().join("scene.toml"));
    let world = world(&file, &registry);
    let mut runs = Vec::new();
    for _ in 0..3 {
        world.start();
        let mut hashes = Vec::new();
        for _ in 0..20 {
            world.step();
            hashes.push(world.hash().total);
        }
        runs.push(hashes);
        assert!(world.observe("/hull/other").is_none());
        world.stop();
        assert!(world.observe("/hull/other").is_some());
    }
    assert!(world.faults().is_empty(), "{:?}", world.faults());
    assert_eq!(runs[0], runs[1]);
    assert_eq!(runs[0], runs[2]);
}

/// A plugin in C with actuators: a motor that applies its command as the effort of its joint, evaluated once per step
/// or before each physics step, and two faulty kinds. The values 1 to 5 of the command `fail` make the motor fail in
/// different ways.
const MOTOR: &str = r#"
#include "tatu.h"
#include <math.h>
static const tatu_param effort = {.size = sizeof(tatu_param), .type = TATU_F64, .key = "effort", .lowest = -5,
  .highest = 5, .fallback = {.tag = TATU_F64}, .text = "What it gives."};
static const tatu_param fail = {.size = sizeof(tatu_param), .type = TATU_F64, .key = "fail",
  .fallback = {.tag = TATU_F64}, .text = "1: fails; 2: gives nonsense; 3: all fail."};
static const tatu_param *const commands[] = {&effort, &fail, 0};
static tatu_status apply(void *self, const tatu_actuator_batch *b, tatu_error *error) {
  (void)self;
  for (uint32_t i = 0; i < b->n; i++) {
    const double *c = b->command[i];
    if (c[1] == 1) { b->status[i] = tatu_fail(error, TATU_ERR, "it broke down"); continue; }
    if (c[1] == 3) return tatu_fail(error, TATU_ERR, "all broke down");
    b->effort[i] = c[1] == 2 ? sqrt(-1.0 - b->dt) : c[0];
    double *told = b->fields[i * b->n_fields];
    told[0] = c[0];
    told[1] = b->joint[2 * i + 1];
    if (c[1] == 4) told[b->lengths[i][0]] = 1;
    if (c[1] == 5) told[1] = sqrt(-1.0 - b->dt);
  }
  return TATU_OK;
}
static const tatu_field state = {.size = sizeof(tatu_field), .elem = TATU_ELEM_F64, .dims = {2, 1, 1},
  .name = "motor.state", .text = "Effort and speed."};
static const tatu_field *const fields[] = {&state, 0};
static const char *const schemas[] = {"motor/1", 0};
static const tatu_actuator motor = {.size = sizeof motor, .n_commands = 2, .id = "motor", .text = "A motor.",
  .commands = commands, .apply = apply, .schemas = schemas, .fields = fields};
static const tatu_actuator inner = {.size = sizeof inner, .flags = TATU_ACTUATOR_EVERY_SUBSTEP, .n_commands = 2,
  .id = "inner_motor", .text = "A motor asked more often.", .commands = commands, .apply = apply, .schemas = schemas,
  .fields = fields};
static const tatu_actuator lame = {.size = sizeof lame, .id = "lame", .text = "Cannot act."};
static const tatu_actuator taken = {.size = sizeof taken, .id = "motor", .text = "Again.", .apply = apply};
static const tatu_actuator *const kinds[] = {&motor, &inner, &lame, &taken, 0};
static const tatu_ext_actuator actuators = {.size = sizeof actuators, .kinds = kinds};
static const tatu_host_scene *scene;
static tatu_prop key;
static tatu_status init(const tatu_host *host, void **self, tatu_error *error) {
  (void)self; (void)error;
  scene = host->service(host, TATU_HOST_SCENE);
  key = scene->prop(host, "motor.effort");
  return TATU_OK;
}
/* Increases the effort of a motor, through the functions for scalar properties. */
static tatu_status add(tatu_call *call) {
  tatu_object object = tatu_arg_object(call, 0);
  double x = 0;
  tatu_status status = scene->get_f64(call->world, object, key, &x, 1);
  x += tatu_arg_float(call, 1);
  if (status == TATU_OK) status = scene->set_f64(call->world, object, key, &x, 1);
  return status == TATU_OK ? tatu_return(call, tatu_float(x)) : status;
}
static const tatu_name add_name = {.size = sizeof add_name, .name = "motor.add"};
static const tatu_name *const add_names[] = {&add_name, 0};
static const tatu_command add_command = {.size = sizeof add_command, .flags = TATU_COMMAND_RAW, .names = add_names,
  .call = add};
static const tatu_command *const adders[] = {&add_command, 0};
static const tatu_ext_command command = {.size = sizeof command, .commands = adders};
static const void *extension(void *self, const char *id) {
  const char *a = TATU_ACTUATOR, *c = TATU_COMMAND, *i = id;
  (void)self;
  while (*a && *a == *i) a++, i++;
  if (*a == *i) return &actuators;
  while (*c && *c == *id) c++, id++;
  return *c == *id ? &command : 0;
}
TATU_EXPORT const tatu_plugin_t tatu_plugin = {.size = sizeof tatu_plugin, .abi_major = TATU_ABI_MAJOR,
  .abi_minor = TATU_ABI_MINOR, .id = "org.example.motor", .name = "Motor", .version = "0.1.0", .licence = "MIT",
  .init = init, .extension = extension};
"#;

/// Creates a scene beside the built C plugin.
fn with_motor(scene: &str) -> TestFolder {
    let place = TestFolder::scene(&format!("plugins = [\".\"]\ngravity_m_s2 = [0.0, 0.0, 0.0]\n{scene}"));
    place.write("motor.c", MOTOR);
    let (include, out) = (root().join("plugin-api/include"), library("tatu_motor"));
    let mut cc = Command::new(compiler("cc"));
    cc.args(["-std=c11", "-Wall", "-Wextra", "-Wno-missing-field-initializers", "-shared", "-fPIC", "-I"]);
    succeed(cc.arg(include).args(["-o", &out, "motor.c", "-lm"]).current_dir(place.path()));
    place
}

/// Returns a static base, a joint along z with a motor of this kind as a child, and a body of 2 kg on the joint.
fn jointed(kind: &str, joint: &str, more: &str) -> String {
    format!(
        "{}[[object]]\nkind = \"joint\"\ntype = \"{joint}\"\nalias = \"axle\"\nparent = \"/base\"\n
        [[object]]\nkind = \"shape\"\nalias = \"load\"\nparent = \"/base/axle\"\nsize_m = [0.2, 0.2, 0.2]\ndynamic = true\nmass_kg = 2.0\n
        [[object]]\nkind = \"actuator\"\nactuator = \"{kind}\"\nalias = \"motor\"\nparent = \"/base/axle\"\n{more}\n",
        cuboid("base", [0.1, 0.1, 0.1], [0.0, 0.0, 1.0], "")
    )
}

#[test]
fn an_effort_in_c_moves_its_joint() {
    // The inertia of a cube is m s^2 / 6.
    for (joint, effort, per_unit, what, axis) in [
        ("revolute", 0.02, 1.0 / (MASS * 0.04 / 6.0), "angular_velocity", 2),
        ("prismatic", 3.0, 1.0 / MASS, "linear_velocity", 2),
    ] {
        for kind in ["motor", "inner_motor"] {
            let scene = jointed(kind, joint, &format!("effort = {effort}"));
            let lines = with_motor(&scene).trace(&["/base/axle/load"], &["--seconds", "1"]);
            for line in lines {
                let v = line.object::<3>("/base/axle/load", what)[axis];
                let wanted = effort * per_unit * line.time();
                assert!(
                    (v - wanted).abs() < 1e-3 * wanted.abs(),
                    "{kind} {joint}: {v} at {}, not {wanted}",
                    line.time()
                );
            }
        }
    }
}

#[test]
fn commands_are_numbers_for_the_fast_functions_too() {
    let script = "function sysCall_init()
            local motor = sim.getObject('/base/axle/motor')
            local add = _G.motor.add
            assert(add(motor, 0.5) == 2.5 and add(motor, 1) == 3.5)
            assert(sim.getFloatProperty(motor, 'motor.effort') == 3.5)
            local ok, message = pcall(add, motor, 100)
            assert(not ok and tostring(message):find('from -5 to 5', 1, true), message)
            ok, message = pcall(add, sim.getObject('/base'), 1)
            assert(not ok and tostring(message):find('has no property `motor.effort`', 1, true), message)
        end";
    with_motor(&(jointed("motor", "revolute", "effort = 2.0") + &watcher("caller", script)))
        .run(&["--steps", "1"])
        .good();
}

#[test]
fn flawed_kinds_in_c_are_refused_and_bounds_are_enforced() {
    let done = with_motor(&jointed("motor", "revolute", "effort = 6.0")).tatu(&["check", "scene.toml"]);
    done.refused(&["E303", "`lame` has no `apply`", "it offers the actuator `motor` twice"]);
    done.refused(&["E102", "from -5 to 5"]);
}

#[test]
fn a_failing_actuator_in_c_is_switched_off_and_named_once() {
    for (value, text) in [(1, "it broke down"), (2, "finite numbers"), (3, "all broke down")] {
        for kind in ["motor", "inner_motor"] {
            let script = format!(
                "function sysCall_actuation()
                    if sim.getSimulationTime() > 0.19 then
                        sim.setFloatProperty(sim.getObject('/base/axle/motor'), '{kind}.fail', {value})
                    end
                end"
            );
            let scene = jointed(kind, "revolute", "effort = 0.02") + &watcher("saboteur", &script);
            let place = with_motor(&scene);
            let done = place.run(&["--seconds", "1", "--trace", "trace.jsonl", "--watch", "/base/axle/load"]);
            let errors = done.errors();
            assert_eq!(errors.len(), 1, "{kind} {value}: {errors:?}");
            let e = &errors[0];
            assert_eq!((e["kind"].as_str(), e["count"].as_u64()), (Some("plugin"), Some(1)), "{e}");
            assert_eq!(e["plugin"], "org.example.motor");
            let message = e["message"].as_str().unwrap();
            let off = "the actuator /base/axle/motor is switched off";
            assert!(message.contains(text) && message.contains(off), "{kind} {value}: {message}");
            // The motor drives the body up to the failure; afterwards the body coasts.
            let lines = place.lines("trace.jsonl");
            let spin = |i: usize| lines[i].object::<3>("/base/axle/load", "angular_velocity")[2];
            assert!(spin(3) > 1.9 * spin(1) && (spin(19) - spin(4)).abs() < 1e-6, "{kind} {value}");
        }
    }
}

#[test]
fn of_two_in_c_only_the_one_that_fails_is_switched_off() {
    let good = jointed("motor", "revolute", "effort = 0.02");
    let bad = jointed("motor", "revolute", "effort = 0.02\nfail = 1.0").replace("base", "other");
    let place = with_motor(&format!("{good}{bad}"));
    let done = place.run(&[
        "--steps",
        "10",
        "--trace",
        "trace.jsonl",
        "--watch",
        "/base/axle/load",
        "--watch",
        "/other/axle/load",
    ]);
    let errors = done.errors();
    assert!(errors.len() == 1 && errors[0]["object"] == "/other/axle/motor", "{errors:?}");
    let last = &place.lines("trace.jsonl")[9];
    let spin = |path: &str| last.object::<3>(path, "angular_velocity")[2];
    assert!(spin("/base/axle/load") > 0.1 && spin("/other/axle/load") == 0.0);
}

#[test]
fn lists_contain_actuators() {
    let list = TestFolder::new().tatu(&["list", "actuators", "--json"]).good().json();
    let found = list.as_array().unwrap().iter().find(|a| a["id"] == "thruster_substep").unwrap();
    assert_eq!(found["every_substep"], true);
    assert_eq!((&found["commands"][0]["name"], &found["commands"][0]["unit"]), (&"thrust".into(), &"N".into()));
    assert_eq!(found["parameters"][0]["name"], "max_force");
}

#[test]
fn the_state_of_a_thruster_is_in_a_snapshot() {
    // At 0.3 s the lagged thrust is still rising, so the snapshot must contain its current value.
    let more = "thrust_n = 40.0\ntime_constant_s = 0.4";
    let place = TestFolder::scene(&format!("{}{}", hull(""), thruster("thruster", "jet", more)));
    let hash = |more: &[&str]| {
        let done = place.run(&[&["--steps", "20"], more].concat()).good();
        assert!(!done.err.contains("replay"), "{}", done.err);
        done.json()["hash"].clone()
    };
    let whole = hash(&["--snapshot-at", "0.3", "half"]);
    assert_eq!(hash(&["--from", "half"]), whole);
}

#[test]
fn reports_of_an_actuator_are_read_like_a_sensor() {
    // Under a constant effort of 2 N m, the speed grows by 2 / I per second.
    let script = "function sysCall_sensing()
            local r = tatu.read(sim.getObject('/base/axle/motor'))
            print(string.format('R %.12g %.12g %.12g', r.time, r.state[1], r.state[2]))
        end";
    for kind in ["motor", "inner_motor"] {
        let place = with_motor(&format!("{}{}", jointed(kind, "revolute", "effort = 2.0"), watcher("eye", script)));
        let done = place.run(&["--seconds", "0.5"]).good();
        let rows: Vec<Vec<f64>> = (done.err.lines())
            .filter_map(|l| l.split_once("R "))
            .map(|(_, l)| l.split(' ').map(|x| x.parse().unwrap()).collect())
            .collect();
        assert!(rows.len() >= 10, "{}", done.err);
        // A cube of 2 kg and 0.2 m has the inertia 2 * 0.2^2 / 6.
        let growth = 2.0 / (2.0 * 0.04 / 6.0);
        for (i, row) in rows.iter().enumerate() {
            let called = if kind == "motor" { 0.05 * i as f64 } else { 0.05 * (i + 1) as f64 - 0.005 };
            assert!((row[0] - called).abs() < 1e-9 && row[1] == 2.0, "{kind}: {row:?}");
            assert!((row[2] - growth * called).abs() < 1e-6 * growth, "{kind}: {row:?}, not {}", growth * called);
        }
    }
    let place = with_motor(&jointed("motor", "revolute", "fail = 4.0"));
    place.run(&["--seconds", "0.2"]).reports(&["outside the fields that it reports", "org.example.motor"]);
    let place = with_motor(&jointed("motor", "revolute", "fail = 5.0"));
    place.run(&["--seconds", "0.2"]).reports(&["`motor.state` is not a number", "org.example.motor"]);
}
