//! Tests of parts: when they are called, what a failure does, and what becomes of their state.

use crate::kit::{plugin_sources::compile, *};

/// A part that counts its calls in its state block and its readings, logs each call, and fails as its parameters say.
const PLUGIN: &str = r#"
#include "tatu/host.h"
#include "tatu/part.h"
#include <stdio.h>
#include <string.h>

typedef struct { const tatu_host_api *host; char says[16], fails[16]; double at; } part;
typedef struct { double calls, sum; } block;

static tatu_status create(void *self, const tatu_instance *given, void **data, tatu_error *error) {
  part *p = tatu_new(sizeof *p, data, error);
  if (!p) return TATU_ERR_SPACE;
  p->host = self;
  memcpy(p->says, given->params[0].u.s.ptr, given->params[0].u.s.len & 15);
  memcpy(p->fails, given->params[1].u.s.ptr, given->params[1].u.s.len & 15);
  p->at = given->params[2].u.f;
  return TATU_OK;
}
static tatu_status act(part *p, const tatu_part_call *c, const char *what, tatu_error *error) {
  block *b = c->state;
  char line[128];
  b->calls += 1;
  b->sum += c->command[0];
  ((double *)c->fields[0])[0] = b->calls;
  if (p->says[0]) {
    snprintf(line, sizeof line, "%s %s %.2f %g %u/%u %g", p->says, what, c->time, c->dt, c->physics_step, c->n_physics_steps, c->command[0]);
    tatu_log(p->host, c->world, TATU_LOG_STATUS, line);
  }
  if (c->time < p->at || strcmp(what, "actuate")) return TATU_OK;
  if (!strcmp(p->fails, "message")) return tatu_fail(error, TATU_ERR, "has had enough");
  if (!strcmp(p->fails, "host")) {
    double x[2];
    return p->host->scene->get_f64(c->world, 77777, p->host->scene->prop(p->host->host, "joint.position"), x, 1);
  }
  if (!strcmp(p->fails, "past")) b[1].calls = 1;
  if (!strcmp(p->fails, "nan")) ((double *)c->fields[0])[0] = NAN;
  if (!strcmp(p->fails, "rebuild")) {
    tatu_value v = tatu_float(3);
    return p->host->scene->set(c->world, c->part, p->host->scene->prop(p->host->host, "note.at"), &v);
  }
  if (!strcmp(p->fails, "stage")) return p->host->stage->run(c->world, TATU_STAGE_SENSE, 0);
  if (!strcmp(p->fails, "remove")) return p->host->scene->remove(c->world, &c->part, 1);
  return TATU_OK;
}
static tatu_status actuate(void *d, const tatu_part_call *c, tatu_error *e) { return act(d, c, "actuate", e); }
static tatu_status physics(void *d, const tatu_part_call *c, tatu_error *e) { return act(d, c, "physics", e); }
static tatu_status sense(void *d, const tatu_part_call *c, tatu_error *e) { return act(d, c, "sense", e); }
static tatu_status end(void *d, const tatu_part_call *c, tatu_error *e) { return act(d, c, "end", e); }
static tatu_status paused(void *d, const tatu_part_call *c, uint32_t moment, tatu_error *e) {
  static const char *const names[] = {"pause begins", "pause lasts", "pause ends"};
  return act(d, c, names[moment], e);
}
static const tatu_part note = {.size = sizeof(tatu_part), .id = "note", .text = "Notes its calls.",
  .params = TATU_PARAMS(TATU_PARAM(TATU_TEXT, "says", NULL, "Its name in the log.", TATU_DEFAULT_TEXT("")),
                        TATU_PARAM(TATU_TEXT, "fails", NULL, "How it fails.", TATU_DEFAULT_TEXT("")),
                        TATU_PARAM(TATU_F64, "at", "s", "When it fails.", TATU_DEFAULT_F64(0.1))),
  .commands = TATU_PARAMS(TATU_PARAM(TATU_F64, "given", NULL, "A number.", TATU_DEFAULT_F64(0))),
  .fields = TATU_FIELDS(TATU_FIELD(TATU_ELEM_F64, "note.calls", NULL, "Number of calls.")),
  .life = TATU_TABLE(tatu_life, .state_bytes = sizeof(block), .create = create, .destroy = tatu_delete,
                     .save = tatu_save_nothing, .load = tatu_load_nothing, .version = VERSION),
  .actuate = actuate, .physics_step = physics, .sense = sense, .paused = paused, .end = end};
TATU_PLUGIN(TATU_PARTS(&note), .id = "org.test.note", .name = "Note", .version = "1", .licence = "MIT",
            .needs = TATU_NEEDS(TATU_NEED_SCENE, TATU_NEED_LOG), .init = tatu_init_host_api, .shutdown = tatu_delete);
"#;

fn bench(more: &str) -> TestFolder {
    let place = TestFolder::scene(&format!("plugins = [\"mine\"]\nphysics_dt_s = 0.025\n{more}"));
    compile(&place, "note", &PLUGIN.replace("VERSION", "1"));
    place
}

fn part(alias: &str, more: &str) -> String {
    format!("[[object]]\nkind = \"part\"\npart = \"note\"\nalias = \"{alias}\"\n{more}")
}

/// Returns the lines that parts and scripts have logged.
fn lines(done: &RunOutput) -> Vec<&str> {
    let own = |l: &&str| ["a ", "b ", "script "].iter().any(|name| l.starts_with(name));
    done.err.lines().map(|l| l.trim_start_matches("info: ")).chain(done.out.lines()).filter(own).collect()
}

#[test]
fn parts_are_called_between_scripts_and_physics() {
    let script = "function sysCall_actuation()
            sim.addStatusbarMessage('script actuation')
            tatu.set(sim.getObject('/two'), 'note.given', 5)
        end
        function sysCall_sensing()
            sim.addStatusbarMessage('script sensing ' .. tatu.read(sim.getObject('/two')).calls)
        end";
    let objects = format!("{}{}{}", part("two", "says = \"a\"\n"), part("one", "says = \"b\"\n"), watcher("s", script));
    let place = bench(&objects);
    let done = place.tatu(&["run", "scene.toml", "--steps", "1"]).good();
    let told: Vec<String> = lines(&done).into_iter().map(str::to_owned).collect();
    let want = [
        "script actuation",
        "a actuate 0.00 0.05 0/0 5",
        "b actuate 0.00 0.05 0/0 0",
        "a physics 0.00 0.025 0/2 5",
        "b physics 0.00 0.025 0/2 0",
        "a physics 0.03 0.025 1/2 5",
        "b physics 0.03 0.025 1/2 0",
        "a sense 0.00 0.05 0/0 5",
        "b sense 0.00 0.05 0/0 0",
        "script sensing 4.0",
    ];
    assert_eq!(told[..10], want, "{}", done.err);
    assert_eq!(told.iter().filter(|l| l.contains(" end ")).count(), 2, "{told:?}");
}

#[test]
fn failing_parts_are_switched_off_and_reported_once() {
    for (how, why) in [
        ("message", "failed: has had enough [tatu_part.actuate]; the part /bad is switched off"),
        ("host", "object 77777"),
        ("past", "broke the contract: it wrote past the end of its state block"),
        ("nan", "broke the contract: `note.calls` is not a number"),
        ("rebuild", "which is being called"),
    ] {
        let place = bench(&format!("{}{}", part("bad", &format!("fails = \"{how}\"\n")), part("good", "")));
        let done = place.run(&["--steps", "10"]);
        let (json, errors) = (done.json(), done.errors());
        assert_eq!((done.code, errors.len()), (1, 1), "{how}: {}", done.err);
        assert!(errors[0]["message"].as_str().unwrap().contains(why), "{how}: {}", errors[0]);
        assert_eq!((errors[0]["count"].as_u64(), errors[0]["object"].as_str()), (Some(1), Some("/bad")), "{how}");
        let told = |i: usize, key: &str| json["parts"][i][key].clone();
        assert_eq!((told(0, "off"), told(1, "off")), (true.into(), false.into()), "{how}");
        // Two steps with four calls each, and the call that failed.
        assert_eq!((told(0, "calls"), told(1, "calls")), (9.into(), 40.into()), "{how}");
    }
}

#[test]
fn parts_that_run_stages_or_remove_themselves_are_not_called_meanwhile() {
    let place = bench(&format!("{}{}", part("one", "fails = \"stage\"\nat_s = 0.0\n"), part("two", "says = \"b\"\n")));
    let done = place.run(&["--steps", "2"]).good();
    let told = |i: usize| done.json()["parts"][i]["calls"].as_u64();
    // The nested stage calls the other part, which is called in its own stage as well.
    assert_eq!((told(0), told(1)), (Some(8), Some(10)));
    let place = bench(&part("one", "says = \"a\"\nfails = \"remove\"\n"));
    let done = place.tatu(&["run", "scene.toml", "--steps", "6"]).good();
    let all = lines(&done);
    assert_eq!(all.iter().filter(|l| l.contains("actuate")).count(), 3, "{all:?}");
    assert!(all.last().unwrap().starts_with("a end 0.15"), "{all:?}");
}

#[test]
fn state_blocks_of_parts_are_hashed_and_saved() {
    let set = |x: f64| {
        let script = format!(
            "function sysCall_actuation()
                local one = sim.getObject('/one')
                if sim.getSimulationTime() < 0.11 then tatu.set(one, 'note.given', {x}) else tatu.set(one, 'note.given', 0) end
            end"
        );
        let place = bench(&format!("{}{}", part("one", ""), watcher("s", &script)));
        let hash = |more: &[&str]| {
            let done = place.run(&[&["--steps", "10"], more].concat()).good();
            assert!(!done.err.contains("replay"), "{}", done.err);
            done.json()["hash"].clone()
        };
        let whole = hash(&["--snapshot-at", "0.3", "half"]);
        assert_eq!(hash(&["--from", "half"]), whole);
        assert_eq!(hash(&["--threads", "4"]), whole);
        whole
    };
    // The command is 0 at the end of both runs; only the sum in the state block differs.
    assert_ne!(set(1.0), set(2.0));
}

#[test]
fn parts_are_called_during_pauses() {
    let pause = "local n = 0
        function sysCall_sensing() if sim.getSimulationTime() > 0.14 then sim.pauseSimulation() end end
        function sysCall_suspended() n = n + 1 if n > 2 then sim.startSimulation() end end";
    let script = format!("language = \"lua\", kind = \"customization\", text = '''{pause}'''");
    let pauser = format!("[[object]]\nkind = \"dummy\"\nalias = \"p\"\nscript = {{ {script} }}\n");
    let place = bench(&format!("{}{pauser}", part("one", "says = \"a\"\n")));
    place.write("pause.lua", pause);
    let done = place.tatu(&["run", "scene.toml", "--steps", "8", "--addon", "pause.lua"]);
    let all = lines(&done);
    assert!(all.iter().any(|l| l.starts_with("a pause begins")), "{}", done.err);
    let at = |what: &str| all.iter().position(|l| l.starts_with(what));
    if let (Some(lasts), Some(ends)) = (at("a pause lasts"), at("a pause ends")) {
        assert!(at("a pause begins").unwrap() < lasts && lasts < ends, "{all:?}");
    }
}

#[test]
fn unknown_and_misplaced_kinds_of_parts_are_refused() {
    let place = bench("[[object]]\nkind = \"actuator\"\nactuator = \"note\"\nalias = \"x\"\n");
    place.tatu(&["check", "scene.toml"]).refused(&["E108", "actuator kind"]);
    let place = bench("[[object]]\nkind = \"part\"\npart = \"notes\"\nalias = \"x\"\n");
    place.tatu(&["check", "scene.toml"]).refused(&["E108", "part kind", "note"]);
    let place = bench("[[object]]\nkind = \"part\"\nalias = \"x\"\n");
    place.tatu(&["check", "scene.toml"]).refused(&["E104", "a part has no kind"]);
    let told = place.tatu(&["list", "parts", "--json", "--scene", "scene.toml"]);
    assert!(told.out.contains("\"note\"") || told.err.contains("note"), "{}{}", told.out, told.err);
}
