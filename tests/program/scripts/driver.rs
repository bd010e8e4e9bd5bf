//! Tests of drivers: scripts of kind `main` that run the stages of a step themselves.

use crate::kit::*;

/// Returns a dummy with a main script.
fn main_script(text: &str, dialect: &str) -> String {
    format!(
        "[[object]]\nkind = \"dummy\"\nalias = \"driver\"\nscript = {{ kind = \"main\", dialect = \"{dialect}\", text = '''\n{text}\n''' }}\n"
    )
}

/// A main script with the order of stages in the default main scripts of current versions.
const MODERN_MAIN: &str = "
function sysCall_init()
    sim.handleSimulationStart()
    sim.openModule(sim.handle_all)
    sim.handleGraph(sim.handle_all_except_explicit, 0)
end
function sysCall_actuation()
    sim.resumeThreads(sim.scriptthreadresume_default)
    sim.launchThreadedChildScripts()
    called = sim.handleSimulationScripts(sim.syscb_actuation)
    sim.handleCustomizationScripts(sim.syscb_actuation)
    sim.handleAddOnScripts(sim.syscb_actuation)
    sim.handleSandboxScript(sim.syscb_actuation)
    sim.handleModule(sim.handle_all, false)
    sim.handleJointMotion()
    sim.handleIkGroup(sim.handle_all_except_explicit)
    steps = sim.handleDynamics(sim.getSimulationTimeStep())
    assert(called == COUNT and steps == 10, called .. ' ' .. steps)
end
function sysCall_sensing()
    sim.handleSensingStart()
    sim.handleCollision(sim.handle_all_except_explicit)
    sim.handleDistance(sim.handle_all_except_explicit)
    sim.handleProximitySensor(sim.handle_all_except_explicit)
    sim.handleVisionSensor(sim.handle_all_except_explicit)
    sim.handleSimulationScripts(sim.syscb_sensing)
    sim.handleCustomizationScripts(sim.syscb_sensing)
    sim.handleModule(sim.handle_all, true)
    sim.handleGraph(sim.handle_all_except_explicit, sim.getSimulationTime() + sim.getSimulationTimeStep())
end
function sysCall_cleanup()
    sim.handleSimulationScripts(sim.syscb_cleanup)
    sim.resetCollision(sim.handle_all_except_explicit)
    sim.resetProximitySensor(sim.handle_all_except_explicit)
    sim.closeModule(sim.handle_all)
    sim.addStatusbarMessage('main cleans up')
end";

/// The default main script of 2015, whose whole text runs at each call and has one branch for the step.
const OLD_MAIN: &str = "
if (sim_call_type==sim_mainscriptcall_initialization) then
    simOpenModule(sim_handle_all)
    simHandleGraph(sim_handle_all_except_explicit,0)
    runs=0
end
if (sim_call_type==sim_mainscriptcall_regular) then
    runs=runs+1
    if runs~=math.floor(simGetSimulationTime()/simGetSimulationTimeStep()+1.5) then error('called '..runs) end
    simResumeThreads(sim_scriptthreadresume_default)
    simResumeThreads(sim_scriptthreadresume_actuation_first)
    simLaunchThreadedChildScripts()
    simHandleChildScripts(sim_childscriptcall_actuation)
    simResumeThreads(sim_scriptthreadresume_actuation_last)
    simHandleCustomizationScripts(sim_customizationscriptcall_simulationactuation)
    simHandleModule(sim_handle_all,false)
    simHandleMechanism(sim_handle_all_except_explicit)
    simHandleIkGroup(sim_handle_all_except_explicit)
    simHandleDynamics(simGetSimulationTimeStep())
    simHandleVarious()
    simHandleMill(sim_handle_all_except_explicit)
    simHandleCollision(sim_handle_all_except_explicit)
    simHandleDistance(sim_handle_all_except_explicit)
    simHandleProximitySensor(sim_handle_all_except_explicit)
    simHandleVisionSensor(sim_handle_all_except_explicit)
    simResumeThreads(sim_scriptthreadresume_sensing_first)
    simHandleChildScripts(sim_childscriptcall_sensing)
    simResumeThreads(sim_scriptthreadresume_sensing_last)
    simHandleCustomizationScripts(sim_customizationscriptcall_simulationsensing)
    simHandleModule(sim_handle_all,true)
    simResumeThreads(sim_scriptthreadresume_allnotyetresumed)
    simHandleGraph(sim_handle_all_except_explicit,simGetSimulationTime()+simGetSimulationTimeStep())
end
if (sim_call_type==sim_mainscriptcall_cleanup) then
    simResetMilling(sim_handle_all)
    simResetMill(sim_handle_all_except_explicit)
    simResetCollision(sim_handle_all_except_explicit)
    simResetProximitySensor(sim_handle_all_except_explicit)
    simCloseModule(sim_handle_all)
    simAddStatusbarMessage('main cleans up')
end";

/// Returns a scene with a robot that avoids a wall by its sonars, a thruster, and a script that prints readings with
/// the time.
fn lively() -> String {
    let avoid = "function sysCall_init()
            left, right = sim.getObject('./Pioneer_p3dx_leftMotor'), sim.getObject('./Pioneer_p3dx_rightMotor')
            eyes = {sim.getObject('./Pioneer_p3dx_ultrasonicSensor4'), sim.getObject('./Pioneer_p3dx_ultrasonicSensor5')}
        end
        function sysCall_actuation()
            local near = 1
            for _, eye in ipairs(eyes) do
                local seen, distance = sim.readProximitySensor(eye)
                if seen == 1 then near = math.min(near, distance) end
            end
            sim.setJointTargetVelocity(left, 3 * near)
            sim.setJointTargetVelocity(right, 3)
        end
        function sysCall_sensing()
            local seen, distance = sim.readProximitySensor(eyes[1])
            sim.addStatusbarMessage(string.format('%.17g %d %.17g', sim.getSimulationTime(), seen, distance))
        end
        function sysCall_thread()
            for i = 1, 5 do sim.wait(0.2) sim.addStatusbarMessage('waited') end
        end
        function sysCall_cleanup() sim.addStatusbarMessage('robot cleans up') end";
    let hull = cuboid("hull", [0.2, 0.2, 0.2], [0.0, 3.0, 2.0], "dynamic = true\nmass_kg = 2.0");
    let jet = "[[object]]\nkind = \"actuator\"\nactuator = \"thruster_substep\"\nparent = \"/hull\"\nmax_force_n = 50.0\nthrust_n = 18.0\n";
    format!(
        "{FLOOR}{}{hull}{jet}{}",
        cuboid("wall", [0.1, 3.0, 1.0], [1.2, 0.0, 0.5], "respondable = true"),
        pioneer(avoid, "")
    )
}

/// Returns hash, time and status lines of each step.
fn story(scene: &str, args: &[&str]) -> Vec<(String, f64, Vec<String>)> {
    let lines = TestFolder::scene(scene).trace(&[], args);
    let told = |l: &TraceLine| l.status().iter().map(|s| s.to_string()).collect();
    lines.iter().map(|l| (l.hash().to_owned(), l.time(), told(l))).collect()
}

#[test]
fn the_default_order_by_a_main_script_leads_to_the_same_bits() {
    let without =
        story(&format!("{}[[object]]\nkind = \"dummy\"\nalias = \"driver\"\n", lively()), &["--seconds", "3"]);
    assert!(without.iter().flat_map(|s| &s.2).any(|t| t.contains(" 1 0.")), "no sonar detects the wall: {without:?}");
    for (text, dialect) in [(MODERN_MAIN, "4.9"), (OLD_MAIN, "3.2"), (OLD_MAIN, "")] {
        let text = text.replace("COUNT", "1");
        let with = story(&format!("{}{}", lively(), main_script(&text, dialect)), &["--seconds", "3"]);
        assert_eq!(with.len(), without.len());
        for (i, (a, b)) in with.iter().zip(&without).enumerate() {
            assert_eq!(a, b, "step {i}, dialect `{dialect}`");
        }
    }
}

#[test]
fn threads_change_no_bit() {
    let scene = format!("{}{}", lively(), main_script(&MODERN_MAIN.replace("COUNT", "1"), "4.9"));
    let one = story(&scene, &["--seconds", "1", "--threads", "1"]);
    assert_eq!(one, story(&scene, &["--seconds", "1", "--threads", "3"]));
}

#[test]
fn each_script_cleans_up_once() {
    for (text, dialect) in [(MODERN_MAIN, "4.9"), (OLD_MAIN, "3.2")] {
        let scene = format!("{}{}", lively(), main_script(&text.replace("COUNT", "1"), dialect));
        let done = TestFolder::scene(&scene).tatu(&["run", "scene.toml", "--steps", "3"]).good();
        for line in ["main cleans up", "robot cleans up"] {
            assert_eq!(done.out.matches(line).count(), 1, "{dialect}: {}", done.out);
        }
    }
}

/// Returns time and height of a falling box at the end of each step, if the main script executes `actuation` in each
/// step.
fn fall(actuation: &str, steps: &str) -> Vec<(f64, f64)> {
    let falling = cuboid("falling", [0.1, 0.1, 0.1], [0.0, 0.0, 9.0], "dynamic = true");
    let text = format!("function sysCall_actuation() n = (n or 0) + 1 {actuation} end");
    let scene = format!("{falling}{}", main_script(&text, "4.9"));
    let lines = TestFolder::scene(&scene).trace(&["/falling"], &["--steps", steps]);
    lines.iter().map(|l| (l.time(), l.object::<3>("/falling", "position")[2])).collect()
}

#[test]
fn without_physics_time_passes_and_bodies_stay() {
    // Measured in release 4.9: each pass of the main script advances the time by a step.
    let seen = fall("assert(math.abs(sim.getSimulationTime() - (n - 1) * 0.05) < 1e-12)", "10");
    let wanted: Vec<(f64, f64)> = (1..=10).map(|n| (f64::from(n) * 0.05, 9.0)).collect();
    assert_eq!(seen, wanted, "without dynamics, the box may not move");
    // Dynamics are handled in every second step.
    let seen = fall("if n % 2 == 0 then sim.handleDynamics(sim.getSimulationTimeStep()) end", "40");
    for (n, (time, _)) in (1..).zip(&seen) {
        assert!((time - f64::from(n) * 0.05).abs() < 1e-12, "{time} after {n} steps");
    }
    let plain = fall("sim.handleDynamics(sim.getSimulationTimeStep())", "20");
    assert_eq!(seen[39].1, plain[19].1, "the fall must be the same in twice the number of steps");
}

#[test]
fn physics_twice_is_twice_the_time() {
    let twice = fall("local dt = sim.getSimulationTimeStep() sim.handleDynamics(dt) sim.handleDynamics(dt)", "10");
    let once = fall("sim.handleDynamics(sim.getSimulationTimeStep())", "20");
    for (i, seen) in twice.iter().enumerate() {
        assert_eq!(*seen, once[2 * i + 1]);
    }
    // With other step lengths, the time is their sum, and the body falls for that time.
    let seen = fall("assert(sim.handleDynamics(0.005) == 1) assert(sim.handleDynamics(0.02) == 4)", "10");
    let (t, z) = seen[9];
    assert!((t - 0.25).abs() < 1e-12, "{t}");
    assert!((z - (9.0 - 0.5 * 9.81 * t * t)).abs() < 0.5 * 9.81 * t * 0.01, "{z}");
}

#[test]
fn a_sensor_is_handled_while_a_joint_is_moved() {
    // A ray is mounted on an arm that rotates by half a turn within one step. It hits a ball with a radius of 0.2 m at
    // a distance of 1 m only within asin(0.2) = 11.54 degrees of its direction.
    let text = "function sysCall_actuation()
            local arm, eye = sim.getObject('/arm'), sim.getObject('/arm/eye')
            local hits = {}
            for degrees = -90, 90 do
                sim.setJointPosition(arm, math.rad(degrees))
                local seen, distance = sim.handleProximitySensor(eye)
                if seen == 1 then
                    hits[#hits + 1] = degrees
                    -- The intersection of a line through the origin with a circle about (1, 0).
                    local a = math.rad(degrees)
                    local wanted = math.cos(a) - math.sqrt(0.04 - math.sin(a) ^ 2)
                    assert(math.abs(distance - wanted) < 1e-9, degrees .. ': ' .. distance)
                end
            end
            assert(hits[1] == -11 and hits[#hits] == 11 and #hits == 23, #hits)
            sim.addStatusbarMessage('swept')
        end";
    let scene = format!(
        "[[object]]\nkind = \"joint\"\nalias = \"arm\"\nmode = \"kinematic\"\nposition_m = [0.0, 0.0, 1.0]\n
        [[object]]\nkind = \"sensor\"\nsensor = \"proximity\"\nparent = \"/arm\"\nalias = \"eye\"\nrange_m = 2.0\nexplicit = true\norientation_deg = [0.0, 90.0, 0.0]\n
        [[object]]\nkind = \"shape\"\nalias = \"ball\"\nprimitive = \"sphere\"\nsize_m = [0.4, 0.4, 0.4]\nposition_m = [1.0, 0.0, 1.0]\n{}",
        main_script(text, "4.9")
    );
    let told = story(&scene, &["--steps", "3"]);
    assert_eq!(told.iter().filter(|s| s.2 == ["swept"]).count(), 3, "{told:?}");
}

#[test]
fn a_stage_within_itself_is_refused_with_the_chain() {
    // A child calls the main script, which runs the stage that called the child.
    let child = "function sysCall_actuation()
            sim.callScriptFunction('again', sim.getScript(sim.scripttype_mainscript))
        end";
    let text = "function again() sim.handleChildScripts(sim.syscb_actuation) end
        function sysCall_actuation()
            sim.handleChildScripts(sim.syscb_actuation)
            sim.handleDynamics(sim.getSimulationTimeStep())
        end";
    let place = TestFolder::scene(&format!("{}{}", watcher("child", child), main_script(text, "4.9")));
    let done = place.run(&["--steps", "3"]);
    let errors = done.errors();
    assert_eq!(errors.len(), 1, "{errors:?}");
    let e = &errors[0];
    assert_eq!(e["object"], "/child");
    let message = e["message"].as_str().unwrap();
    let chain = "`actuate` was requested from within itself: /driver -> actuate -> /driver -> actuate";
    assert!(message.contains(chain), "{message}");
    assert_eq!(done.json()["sim_time_s"].as_f64().map(|t| (t / 0.05).round()), Some(3.0), "the driver must continue");
}

#[test]
fn scripts_other_than_the_main_script_cannot_run_physics() {
    let script = "function sysCall_actuation() sim.handleDynamics(0.05) end";
    let done = TestFolder::scene(&watcher("child", script)).run(&["--steps", "3"]);
    let errors = done.errors();
    assert!(errors[0]["message"].as_str().unwrap().contains("only a main script"), "{errors:?}");
    done.reports(&["kind `main`"]);
}

/// A plugin in C with a command that runs a stage, as drivers in other languages would.
const STAGE_PLUGIN: &str = r#"
#include "tatu.h"
static const tatu_host_stage *stage;
static tatu_status init(const tatu_host *host, void **self, tatu_error *error) {
  (void)self; (void)error;
  stage = host->service(host, TATU_HOST_STAGE);
  return stage ? TATU_OK : TATU_ERR;
}
static tatu_status run(tatu_call *call) {
  return stage->run(call->world, (uint32_t)tatu_arg_int(call, 0), tatu_arg_float(call, 1));
}
static const tatu_name name = {.size = sizeof name, .name = "stage.run"};
static const tatu_name *const names[] = {&name, 0};
static const tatu_command command = {.size = sizeof command, .flags = TATU_COMMAND_RAW, .names = names, .call = run};
static const tatu_command *const commands[] = {&command, 0};
static const tatu_ext_command ext = {.size = sizeof ext, .commands = commands};
static const void *extension(void *self, const char *id) {
  (void)self;
  const char *want = TATU_COMMAND;
  while (*want && *want == *id) want++, id++;
  return *want == *id ? &ext : 0;
}
TATU_EXPORT const tatu_plugin_t tatu_plugin = {.size = sizeof tatu_plugin, .abi_major = TATU_ABI_MAJOR,
  .abi_minor = TATU_ABI_MINOR, .id = "org.example.stager", .name = "Stager", .version = "0.1.0", .licence = "MIT",
  .init = init, .extension = extension};
"#;

#[test]
fn a_plugin_runs_stages_and_is_refused_those_that_run() {
    let script = "local function refused(words, ...)
            local ok, message = pcall(stage.run, ...)
            assert(not ok and tostring(message):find(words, 1, true), tostring(message))
        end
        function sysCall_actuation()
            refused('requested from within itself: the step -> actuate -> /child -> actuate', 1, 0)
            refused('unknown stage 9', 9, 0)
            refused('must be finite', 2, 0 / 0)
            refused('at least 0 s', 2, -1)
            refused('at most 100 s', 2, 1e6)
            -- Runs physics once more than the step itself.
            stage.run(2, sim.getSimulationTimeStep())
        end
        function sysCall_sensing() refused('the step -> react -> /child -> react', 4, 0) stage.run(3, 0) end";
    let place = TestFolder::scene(&format!("plugins = [\".\"]\n{}", watcher("child", script)));
    place.write("stager.c", STAGE_PLUGIN);
    let (include, out) = (root().join("plugin-api/include"), library("tatu_stager"));
    let mut cc = std::process::Command::new(compiler("cc"));
    cc.args(["-std=c11", "-Wall", "-Wextra", "-Wno-missing-field-initializers", "-shared", "-fPIC", "-I"]).arg(include);
    succeed(cc.args(["-o", &out, "stager.c"]).current_dir(place.path()));
    let result = place.run(&["--steps", "4"]).good().json();
    assert!((result["sim_time_s"].as_f64().unwrap() - 0.4).abs() < 1e-12, "{result}");
}

#[test]
fn two_main_scripts_are_refused_at_the_second_one() {
    let one = main_script("", "4.9");
    let other = one.replace("\"driver\"", "\"other\"");
    let done = TestFolder::scene(&format!("{one}{other}")).tatu(&["check", "scene.toml"]);
    done.refused(&["E118", "scene.toml:", "the scene already has a main script, on `driver`", "at most one"]);
    let unknown = one.replace("\"main\"", "\"mian\"");
    TestFolder::scene(&unknown).tatu(&["check", "scene.toml"]).refused(&["E102", "`mian`", "did you mean `main`?"]);
}

#[test]
fn a_scene_used_as_a_model_leaves_its_main_script_out() {
    let place = TestFolder::scene("[[model]]\nmodel = \"inner.toml\"\n");
    place.write("inner.toml", &format!("format = 1\n{}", main_script("error('called')", "4.9")));
    let result = place.run(&["--steps", "2"]).good().json();
    assert_eq!(result["sim_time_s"].as_f64(), Some(0.1));
}

#[test]
fn a_main_script_with_an_error_stops_time_and_is_reported() {
    for text in ["function sysCall_actuation( end", "function sysCall_init() error('mine') end"] {
        let done = TestFolder::scene(&main_script(text, "4.9")).run(&["--steps", "3"]);
        let result = done.json();
        assert_eq!(done.errors().len(), 1, "{text}: {}", done.out);
        assert_eq!((result["steps"].as_u64(), result["sim_time_s"].as_f64()), (Some(3), Some(0.0)), "{text}");
    }
}
