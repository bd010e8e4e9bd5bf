//! Tests of events: who receives which events, when, and in which order (docs/reference/events.md).

use std::{path::Path, process::Command};

use crate::kit::*;

/// Returns a dummy with a script.
fn with(script: &str) -> String {
    format!("{FLOOR}{}", watcher("ear", script))
}

/// Returns the lines of standard error that begin with `> `, in order and without this prefix.
fn marked_lines(done: &RunOutput) -> Vec<String> {
    done.err.lines().filter(|l| l.starts_with("> ")).map(|l| l[2..].to_owned()).collect()
}

#[test]
fn declared_events_are_listed() {
    let place = TestFolder::new();
    let all = place.tatu(&["list", "events", "--json"]).good().json();
    let all = all.as_array().unwrap();
    let names: Vec<&str> = all.iter().map(|e| e["name"].as_str().unwrap()).collect();
    for name in ["started", "stopped", "paused", "resumed", "object_added", "object_removed", "collision", "message"] {
        assert!(names.contains(&name), "{name} of {names:?}");
    }
    let collision = all.iter().find(|e| e["name"] == "collision").unwrap();
    let fields: Vec<_> = collision["fields"].as_array().unwrap().iter().map(|f| f.as_str().unwrap()).collect();
    assert_eq!(fields, ["a", "b", "a_path", "b_path", "point", "normal", "force"]);
    assert!(place.tatu(&["list", "events"]).good().out.contains("Two shapes have come into contact."));
}

/// A ball with a diameter of 0.1 m, whose lowest point is 0.5 m above the floor, lands after sqrt(2 * 0.5 / 9.81) =
/// 0.319 s, which is in the seventh step of 0.05 s. It rests on the floor and is removed at 1 s.
#[test]
fn a_ball_that_lands_collides_once_rests_and_is_removed() {
    let ball = "[[object]]\nkind = \"shape\"\nalias = \"ball\"\nprimitive = \"sphere\"\nsize_m = [0.1, 0.1, 0.1]\n\
        position_m = [0, 0, 0.55]\nrespondable = true\ndynamic = true\n";
    let script = "
        function sysCall_init()
          n = 0
          tatu.on('collision', function(e, name)
            print(string.format('> %s %s %s %.2f', name, e.a_path, e.b_path, sim.getSimulationTime()))
            up = e.normal[3]
          end)
          tatu.on('contact', function(e) n = n + 1 force = e.force end)
          tatu.on('separation', function(e, name) print('> ' .. name) end)
          tatu.on('object_removed', function(e, name) print('> ' .. name .. ' ' .. e.path .. ' ' .. e.kind) end)
        end
        function sysCall_sensing()
          if sim.getSimulationTime() > 0.97 and not gone then
            gone = true
            print(string.format('> %.2f %.1f %s', force, math.abs(up), tostring(n > 10)))
            sim.removeObject(sim.getObject('/ball'))
          end
        end";
    let done = TestFolder::scene(&format!("{}{ball}", with(script))).run(&["--seconds", "2"]).good();
    // At rest the contact force is the weight: 1000 kg/m^3 * 4/3 pi (0.05 m)^3 = 0.5236 kg, or 5.14 N.
    let lines = marked_lines(&done);
    assert_eq!(lines[0], "collision /floor /ball 0.30", "{lines:?}");
    assert!(lines.iter().filter(|l| l.starts_with("collision")).count() <= 2, "{lines:?}");
    let rest = lines.iter().find(|l| l.starts_with("5.")).unwrap();
    let force: f64 = rest.split(' ').next().unwrap().parse().unwrap();
    assert!((force - 5.14).abs() < 0.1 && rest.ends_with("1.0 true"), "{lines:?}");
    assert!(lines.contains(&"object_removed /ball shape".to_owned()), "{lines:?}");
    assert_eq!(lines.last().unwrap(), "separation");
}

/// One script publishes in actuation, and another in a handler. All events are delivered directly after the stage, in
/// order.
#[test]
fn events_follow_the_stage_in_the_order_of_publishing_and_subscribing() {
    let ear = "
        function sysCall_init()
          tatu.on('test.a', function(e) print('> first a' .. e.n) tatu.emit('test.b', {n = e.n}) end)
          tatu.on('test.a', function(e) print('> second a' .. e.n) end)
          tatu.on('test.b', function(e) print('> b' .. e.n) end)
        end
        function sysCall_sensing() print('> sensing') end";
    let mouth = "
        function sysCall_actuation()
          tatu.emit('test.a', {n = 1})
          tatu.emit('test.a', {n = 2})
          print('> published')
        end";
    let scene = format!("{}{}", watcher("ear", ear), watcher("mouth", mouth));
    let place = TestFolder::scene(&scene);
    let done = place.run(&["--steps", "1"]).good();
    let lines: Vec<String> = marked_lines(&done);
    // The events of the first step, which are the same in all later passes.
    let expected =
        ["published", "first a1", "second a1", "first a2", "second a2", "b1", "b2", "sensing"].map(str::to_owned);
    assert_eq!(lines[..8], expected);
    let other = place.run(&["--steps", "1"]).good();
    assert_eq!(marked_lines(&other), lines);
}

#[test]
fn a_handler_that_fails_is_named_and_left_out_and_the_rest_goes_on() {
    let script = "
        function sysCall_init()
          tatu.on('test.tick', function(e)
            count = (count or 0) + 1
            local x = nil + 1
          end)
          tatu.on('test.tick', function(e) other = (other or 0) + 1 end)
        end
        function sysCall_actuation() tatu.emit('test.tick') end
        function sysCall_cleanup() print('> ' .. count .. ' ' .. other) end";
    let done = TestFolder::scene(&with(script)).run(&["--steps", "5"]);
    let errors = done.errors();
    assert_eq!(errors.len(), 1, "{errors:?}");
    assert_eq!((&errors[0]["line"], &errors[0]["count"]), (&5.into(), &1.into()), "{errors:?}");
    let help = errors[0]["help"].as_str().unwrap();
    assert!(help.contains("its handler of the event `test.tick` is not called any more"), "{help}");
    // Five steps, and the three passes from the stop request to the end.
    assert_eq!(marked_lines(&done), ["1 8"]);
}

#[test]
fn misspelt_names_and_names_of_the_host_are_refused_with_what_to_do() {
    let script = "
        function sysCall_init()
          print('> ' .. tostring(select(2, pcall(tatu.on, 'colision', function() end))))
          print('> ' .. tostring(select(2, pcall(tatu.emit, 'collision', {}))))
          print('> ' .. tostring(select(2, pcall(tatu.emit, 'test.x', {1, 2}))))
          print('> ' .. tostring(select(2, pcall(tatu.off, 77))))
        end";
    let done = TestFolder::scene(&with(script)).run(&["--steps", "1"]).good();
    let lines = marked_lines(&done);
    assert!(lines[0].contains("there is no event `colision`; did you mean `collision`?"), "{lines:?}");
    assert!(lines[1].contains("names without a dot are reserved for the host"), "{lines:?}");
    assert!(lines[2].contains("expected a table with keys"), "{lines:?}");
    assert!(lines[3].contains("no subscription 77"), "{lines:?}");
}

#[test]
fn handlers_that_call_each_other_without_end_are_stopped() {
    let script = "
        function sysCall_init()
          tatu.on('test.ping', function() tatu.emit('test.pong') end)
          tatu.on('test.pong', function() tatu.emit('test.ping') end)
          tatu.emit('test.ping')
        end";
    let errors = TestFolder::scene(&with(script)).run(&["--steps", "3"]).errors();
    assert!(errors[0]["message"].as_str().unwrap().contains("more than 10000 events in one delivery"), "{errors:?}");
}

/// Listening does not affect the simulation, and errors of one script are delivered to the handlers of others.
#[test]
fn listeners_leave_the_run_alone_and_learn_of_errors() {
    let bad = "function sysCall_actuation() if sim.getSimulationTime() > 0.2 then error('oh') end end";
    let ear = "
        function sysCall_init()
          tatu.on('script_error', function(e) print('> ' .. e.message .. ' ' .. e.object .. ' ' .. e.line) end)
          tatu.on('message', function(e) if e.text == 'hello' then print('> ' .. e.level) end end)
        end";
    let drive = "function sysCall_actuation() if sim.getSimulationTime() > 0.1 and not x then x = 1 print('hello') end
        sim.setJointTargetVelocity(sim.getObjectHandle('Pioneer_p3dx_leftMotor'), 2) end";
    let scene = |ear: &str| {
        let robot = pioneer(drive, "");
        format!("{robot}{}{}", watcher("bad", bad), watcher("ear", ear))
    };
    let run = |ear: &str| TestFolder::scene(&scene(ear)).run(&["--seconds", "2"]);
    let (quiet, heard) = (run("function sysCall_init() end"), run(ear));
    assert_eq!(quiet.json()["hash"], heard.json()["hash"]);
    let lines = marked_lines(&heard);
    assert!(lines.iter().any(|l| l.starts_with("oh /bad 1")), "{lines:?}\n{}", heard.err);
    assert!(lines.iter().any(|l| l == "info" || l == "status"), "{lines:?}");
}

/// A plugin with an event of its own, an event whose name belongs to the host, a command that publishes, and a service
/// that subscribes to events.
const BELL: &str = r#"
#include "tatu.h"

static const tatu_host *the_host; /* a test may: it is started once */
static const tatu_host_events *events;
static const tatu_host_log *log_;

static const tatu_param times = {.size = sizeof(tatu_param), .type = TATU_I64, .key = "times", .text = "how often"};
static const tatu_param *const fields[] = {&times, 0};
static const tatu_event rang = {sizeof rang, 0, "bell.rang", "The bell was rung.", fields};
static const tatu_event taken = {sizeof taken, 0, "collision", "Not its to declare.", 0};
static const tatu_event *const declared[] = {&rang, &taken, 0};
static const tatu_ext_event ext_event = {.size = sizeof ext_event, .events = declared};

static tatu_status TATU_CALL ring(tatu_call *c) {
  tatu_pair pair = {tatu_string("times"), tatu_int(tatu_arg_int(c, 0))};
  tatu_value payload = tatu_span(TATU_MAP, &pair, 1);
  tatu_status status = events->publish(c->world, tatu_text("bell.rang"), &payload);
  if (status < 0) return status;
  return tatu_return(c, tatu_int(events->wanted(c->world, tatu_text("bell.rang"))));
}
static const tatu_name ring_name = {.size = sizeof(tatu_name), .name = "bell.ring"};
static const tatu_name *const ring_names[] = {&ring_name, 0};
static const tatu_command ring_command = {.size = sizeof(tatu_command), .flags = TATU_COMMAND_RAW,
  .names = ring_names, .text = "Rings.", .example = "bell.ring(1)", .call = ring};
static const tatu_command *const commands[] = {&ring_command, 0};
static const tatu_ext_command ext_command = {.size = sizeof(tatu_ext_command), .commands = commands};

static tatu_status TATU_CALL create(void *self, const tatu_instance *i, void **data, tatu_error *e) {
  (void)self; (void)i; (void)data; (void)e;
  return TATU_OK;
}
static void TATU_CALL destroy(void *data) { (void)data; }
static const tatu_life life = {.size = sizeof(tatu_life), .create = create, .destroy = destroy};
static tatu_status TATU_CALL barrier(void *data, tatu_world *w, uint64_t step, tatu_error *e) {
  (void)data; (void)w; (void)step; (void)e;
  return TATU_GO;
}
static tatu_status TATU_CALL event(void *data, tatu_world *w, tatu_str name, const tatu_value *payload, tatu_error *e) {
  (void)data; (void)e;
  if (payload->tag == TATU_MAP) log_->write(the_host, w, TATU_LOG_STATUS, name);
  return TATU_OK;
}
static const char *const wants[] = {"bell.rang", "collision", 0};
static const tatu_service ear = {.size = sizeof(tatu_service), .id = "ear", .text = "Hears.", .life = &life,
  .barrier = barrier, .event = event, .events = wants};
static const tatu_service *const services[] = {&ear, 0};
static const tatu_ext_service ext_service = {sizeof ext_service, 0, services};

static tatu_status TATU_CALL init(const tatu_host *h, void **self, tatu_error *e) {
  (void)self; (void)e;
  the_host = h;
  events = h->service(h, TATU_HOST_EVENTS);
  log_ = h->service(h, TATU_HOST_LOG);
  return TATU_HAS(events, publish) && TATU_HAS(log_, write) ? TATU_OK : TATU_ERR;
}
static int is(const char *a, const char *b) {
  while (*a && *a == *b) a++, b++;
  return *a == *b;
}
static const void *TATU_CALL extension(void *self, const char *id) {
  (void)self;
  return is(id, TATU_EVENT) ? (const void *)&ext_event : is(id, TATU_COMMAND) ? (const void *)&ext_command
    : is(id, TATU_SERVICE) ? (const void *)&ext_service : 0;
}
TATU_EXPORT const tatu_plugin_t tatu_plugin = {sizeof tatu_plugin, TATU_ABI_MAJOR, TATU_ABI_MINOR, "org.example.bell",
  "Bell", "1.0.0", "MIT", 0, init, 0, extension};
"#;

#[test]
fn a_plugin_in_c_declares_publishes_and_receives_events() {
    let script = "
        function sysCall_init()
          tatu.on('bell.rang', function(e, name) print('> ' .. name .. ' ' .. e.times) end)
        end
        function sysCall_actuation()
          if not rung then rung = true print('> ' .. bell.ring(3)) end
        end";
    let ball = "[[object]]\nkind = \"shape\"\nalias = \"ball\"\nprimitive = \"sphere\"\nsize_m = [0.1, 0.1, 0.1]\n\
        position_m = [0, 0, 0.05]\nrespondable = true\ndynamic = true\n";
    let place = TestFolder::scene(&format!("plugins = [\"plugins\"]\n{}{ball}", with(script)));
    place.write("bell.c", BELL).write("plugins/.keep", "");
    succeed(
        Command::new(compiler("cc"))
            .args(["-std=c11", "-Wall", "-Wextra", "-Werror", "-shared", "-fPIC", "-I"])
            .arg(root().join("plugin-api/include"))
            .args(["bell.c", "-o"])
            .arg(Path::new("plugins").join(library("tatu_bell")))
            .current_dir(place.path()),
    );
    let listed = place.tatu(&["list", "events", "--json", "--scene", "scene.toml"]).good();
    listed.reports(&["E303", "`collision` has no name space"]);
    let all = listed.json();
    let rang = all.as_array().unwrap().iter().find(|e| e["name"] == "bell.rang").unwrap().clone();
    assert_eq!((&rang["by"], &rang["fields"][0]), (&"org.example.bell".into(), &"times".into()));
    let done = place.run(&["--steps", "3", "--service", "ear"]).good();
    assert_eq!(marked_lines(&done), ["1", "bell.rang 3"], "the event must be delivered after the stage");
    // The service receives events at the barrier after the first step, and only those to which it has subscribed.
    let heard: Vec<&str> = done.err.lines().filter(|l| ["bell.rang", "collision", "started"].contains(l)).collect();
    assert_eq!(heard, ["bell.rang", "collision"], "{}", done.err);
}
