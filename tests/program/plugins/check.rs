//! Tests of `tatu plugin check` with small plugins that break one rule each in a way that a first run does not show,
//! and of what the program says about state that a new version of a plugin cannot take over.

#![cfg(all(target_os = "linux", target_env = "gnu"))]

use serde_json::Value;

use crate::kit::{plugin_sources::compile_with, *};

/// Compiles a plugin with these offers into `mine`.
fn plugin(code: &str, offers: &str, more: &[&str]) -> TestFolder {
    let place = TestFolder::new();
    compile_into(&place, code, offers, more);
    place
}

fn compile_into(place: &TestFolder, code: &str, offers: &str, more: &[&str]) {
    let source = format!(
        "#define _GNU_SOURCE\n#include \"tatu.h\"\n#include <time.h>\n#include <unistd.h>\n{code}\nTATU_PLUGIN({offers}, \
         .id = \"org.example.tried\", .name = \"Tried\", .version = \"1.0.0\", .licence = \"MIT\");\n"
    );
    compile_with(place, "tried", &source, more);
}

/// A life whose instances have a number of their own, of which `save` writes nothing.
const LIFE: &str = "
typedef struct { double n; tatu_func hook; } own;
static tatu_status TATU_CALL create(void *self, const tatu_instance *given, void **data, tatu_error *error) {
  (void)self, (void)given;
  return tatu_new(sizeof(own), data, error) ? TATU_OK : TATU_ERR_SPACE;
}
#define LIFE TATU_TABLE(tatu_life, .create = create, .destroy = tatu_delete, .save = tatu_save_nothing, \\
                        .load = tatu_load_nothing, .version = 1)
";

/// Runs tests of the check; returns the tests as JSON.
fn check(place: &TestFolder, tests: &str, code: i32) -> Vec<Value> {
    let done = place.tatu(&["plugin", "check", "mine", "--only", tests, "--json"]);
    assert_eq!(done.code, code, "{}\n{}", done.out, done.err);
    done.json()["tests"].as_array().unwrap().clone()
}

/// Asserts that a test finds an error with these words.
#[track_caller]
fn finds(place: &TestFolder, test: &str, words: &[&str]) {
    let all = check(place, test, 1);
    let errors: Vec<String> = all
        .iter()
        .flat_map(|t| t["findings"].as_array().unwrap().clone())
        .filter(|f| f["level"] == "error")
        .map(|f| format!("{}: {}", f["place"].as_str().unwrap(), f["text"].as_str().unwrap()))
        .collect();
    assert!(errors.iter().any(|e| words.iter().all(|w| e.contains(w))), "{words:?} in {errors:#?}");
}

/// A command that doubles its argument; `end` are its last statements.
fn doubling(end: &str, example: &str) -> TestFolder {
    let code = format!(
        "static tatu_status TATU_CALL twice(tatu_call *call) {{
           tatu_status status = tatu_return(call, tatu_float(2 * tatu_arg_float(call, 0)));
           {end}
         }}
         static const tatu_command command = {{.size = sizeof(tatu_command), .names = TATU_NAME(\"tried.twice\"),
           .call = twice, .params = TATU_PARAMS(TATU_PARAM(TATU_F64, \"x\", NULL, \"Any number.\")), .text = \"Doubles.\",
           .example = \"{example}\"}};"
    );
    plugin(&code, "TATU_COMMANDS(&command)", &[])
}

#[test]
fn a_breach_of_a_command_is_an_error_of_each_test_that_calls_it() {
    let unknown_status = doubling("return status < 0 ? status : 9;", "tried.twice(2)");
    for test in ["examples", "arguments", "repeat", "worlds", "snapshots"] {
        finds(&unknown_status, test, &["command `tried.twice`", "broke the contract", "the status 9"]);
    }
    let past_end = "call->results[call->results_cap] = tatu_int(7);\nreturn status;";
    finds(&doubling(past_end, "tried.twice(2)"), "arguments", &["wrote outside its space for"]);
}

#[test]
fn an_example_that_raises_an_error_fails_unless_it_is_allowed() {
    let wrong = doubling("return status;", "assert(tried.twice(21) == 43)");
    finds(&wrong, "examples", &["command `tried.twice`", "its example raises an error", "assertion failed"]);
    let allow = "[[allow]]\ntest = \"examples\"\nplace = \"tried.twice\"\nreason = \"shows an error\"\n";
    wrong.write("mine/tatu-check.toml", allow);
    check(&wrong, "examples", 0);
}

/// A sensor with one field, whose `measure` writes `value` for each sensor.
fn counting(value: &str, life: &str) -> String {
    format!(
        "static tatu_status TATU_CALL measure(void *self, const tatu_sensor_batch *b, tatu_error *e) {{
           (void)self, (void)e;
           for (uint32_t i = 0; i < b->n; i++) *(double *)tatu_field_of(b, i, 0) = {value};
           return TATU_OK;
         }}
         static const tatu_sensor kind = {{.size = sizeof(tatu_sensor), .id = \"tried\", .text = \"Counts.\",
           .schemas = TATU_TEXTS(\"tried/1\"), .measure = measure, .life = {life},
           .fields = TATU_FIELDS(TATU_FIELD(TATU_ELEM_F64, \"tried.n\", NULL, \"Count.\"))}};"
    )
}

#[test]
fn readings_that_a_snapshot_or_a_reload_loses_are_found() {
    let place = plugin(&format!("{LIFE}{}", counting("++((own *)b->data[i])->n", "LIFE")), "TATU_SENSORS(&kind)", &[]);
    finds(&place, "snapshots", &["sensor `tried`", "the readings of the restored run differ"]);
    finds(&place, "reload", &["sensor `tried`", "after a reload"]);
}

#[test]
fn a_retained_function_that_a_snapshot_loses_is_found() {
    let code = format!(
        "{LIFE}
         static tatu_status TATU_CALL init(const tatu_host *host, void **self, tatu_error *error) {{
           return tatu_init_host_api(host, self, error);
         }}
         static tatu_status TATU_CALL set(tatu_call *c) {{
           const tatu_host_api *h = c->self;
           return h->commands->retain(c->world, tatu_arg_func(c, 0), &((own *)c->instance)->hook);
         }}
         static tatu_status TATU_CALL fire(tatu_call *c) {{
           tatu_func f = ((own *)c->instance)->hook;
           tatu_value r;
           if (!f) return tatu_return(c, tatu_string(\"no hook\"));
           tatu_status s = tatu_call_func(c->self, c->world, c->error, f, NULL, 0, &r);
           return s < 0 ? s : tatu_return(c, r);
         }}
         static const tatu_command a = {{.size = sizeof(tatu_command), .names = TATU_NAME(\"tried.set\"), .call = set,
           .text = \"Sets the hook.\", .params = TATU_PARAMS(TATU_PARAM(TATU_FUNC, \"hook\", NULL, \"Called by fire.\")),
           .example = \"tried.set(function() end)\"}},
         b = {{.size = sizeof(tatu_command), .names = TATU_NAME(\"tried.fire\"), .call = fire, .text = \"Calls it.\",
           .example = \"tried.fire()\"}};"
    );
    let offers = "TATU_COMMANDS_PER_WORLD(LIFE, &a, &b), .needs = TATU_NEEDS(TATU_NEED_COMMANDS), .init = init, \
                  .shutdown = tatu_delete";
    finds(&plugin(&code, offers, &[]), "snapshots", &["command `tried.fire`", "no hook"]);
}

/// A service with this `barrier`.
fn service(barrier: &str) -> (String, String) {
    let code = format!(
        "{LIFE}
         static const tatu_host_api *api;
         static tatu_status TATU_CALL init(const tatu_host *host, void **self, tatu_error *error) {{
           tatu_status status = tatu_init_host_api(host, self, error);
           api = *self;
           return status;
         }}
         static tatu_status TATU_CALL barrier(void *data, tatu_world *world, uint64_t step, tatu_error *error) {{
           (void)data, (void)world, (void)step, (void)error;
           {barrier}
         }}
         static const tatu_service it = {{.size = sizeof(tatu_service), .id = \"tried\", .text = \"Runs.\",
           .barrier = barrier, .life = LIFE}};"
    );
    let offers = "TATU_SERVICES(&it), .needs = TATU_NEEDS(TATU_NEED_SCENE), .init = init, .shutdown = tatu_delete";
    (code, offers.to_owned())
}

#[test]
fn services_that_hold_pass_and_those_that_block_are_reported() {
    let (code, offers) = service("return TATU_HOLD;");
    let all = check(&plugin(&code, &offers, &[]), "services", 0);
    assert!(all[0]["tried"].as_bool().unwrap() && all[0].to_string().contains("held the session"), "{all:?}");
    let (code, offers) = service("usleep(300000);\nreturn TATU_GO;");
    let blocks = plugin(&code, &offers, &[]);
    finds(&blocks, "services", &["service `tried`", "`barrier` blocks"]);
    finds(&blocks, "services", &["calls `usleep`"]);
}

#[test]
fn a_service_whose_changes_are_not_in_the_input_log_fails() {
    let barrier = "struct timespec t;
           clock_gettime(CLOCK_MONOTONIC, &t);
           double g[3] = {1e-3 * (double)(t.tv_nsec % 1000 + 1), 0, -9.81};
           return api->scene->set_f64(world, 0, api->scene->prop(api->host, \"scene.gravity\"), g, 3);";
    let (code, offers) = service(barrier);
    finds(&plugin(&code, &offers, &[]), "services", &["service `tried`", "a replay of the input log differs"]);
}

/// A language, whose `load` fails with the address that it got as its state block.
#[test]
fn languages_get_their_state_block() {
    let code = "typedef struct { uint64_t *block; } own;
         static tatu_status TATU_CALL create(void *self, const tatu_instance *g, void **data, tatu_error *e) {
           (void)self;
           own *it = tatu_new(sizeof(own), data, e);
           if (!g->state) return tatu_fail(e, TATU_ERR, \"there is no state block\");
           it->block = g->state;
           return TATU_OK;
         }
         static tatu_status TATU_CALL load(void *d, tatu_str t, tatu_str c, tatu_str di, tatu_str *ch, tatu_error *e) {
           (void)d, (void)t, (void)c, (void)di, (void)e;
           *ch = tatu_text(\"1\");
           return TATU_OK;
         }
         static uint32_t TATU_CALL find(void *d, uint32_t h, tatu_str n) {
           (void)d, (void)h;
           return n.len == 7 && n.ptr[0] == 's' && n.ptr[1] == 'e' ? 1 : 0; // sensing
         }
         static tatu_status TATU_CALL call(void *d, uint32_t f, tatu_call *fr, const tatu_budget *b, uint64_t *u, tatu_error *e) {
           (void)f, (void)fr, (void)b, (void)u;
           own *it = d;
           return ++*it->block < 28 ? TATU_OK : tatu_fail(e, TATU_ERR_SCRIPT, \"too many calls\");
         }
         static tatu_status TATU_CALL resume(void *d, uint64_t f, tatu_status s, tatu_call *fr, const tatu_budget *b, uint64_t *u, tatu_error *e) {
           (void)d, (void)f, (void)s, (void)fr, (void)b, (void)u, (void)e;
           return TATU_OK;
         }
         static uint32_t TATU_CALL keep(void *d, uint32_t f) { (void)d; return f; }
         static void TATU_CALL drop(void *d, uint32_t f) { (void)d, (void)f; }
         static const tatu_language it = {.size = sizeof(tatu_language), .id = \"tried\", .text = \"Counts.\",
           .suffixes = TATU_TEXTS(\".tried\"), .load = load, .find = find, .call = call, .resume = resume,
           .keep_func = keep, .drop_func = drop, .call_func = call,
           .life = TATU_TABLE(tatu_life, .state_bytes = 8, .create = create, .destroy = tatu_delete,
                              .save = tatu_save_nothing, .load = tatu_load_nothing, .version = 1)};";
    let place = plugin(code, "TATU_LANGUAGES(&it)", &[]);
    place.write("scene.toml", "format = 1\n[[object]]\nkind = \"dummy\"\nalias = \"d\"\nscript = \"a.tried\"\n");
    place.write("a.tried", "# nothing\n");
    let env = [("TATU_PLUGIN_PATH", "mine")];
    let run_with = |args: &[&str]| run(program(), place.path(), &[&["run", "scene.toml"], args].concat(), &env);
    run_with(&["--steps", "20", "--snapshot-at", "0.9", "s.snap"]).good();
    // The block goes on in the restored run: most of the calls come before the snapshot.
    let done = run_with(&["--steps", "40", "--from", "s.snap"]);
    assert!(format!("{}{}", done.out, done.err).contains("too many calls"), "{}{}", done.out, done.err);
}

#[test]
fn dropped_state_blocks_are_reported_and_fail_strict_runs() {
    let code =
        "#ifndef V\n#define V 1\n#endif\ntypedef struct { double n;\n#ifdef GROWN\n double more;\n#endif\n} state;\n";
    let life = "TATU_TABLE(tatu_life, .state_bytes = sizeof(state), .save = tatu_save_nothing, .load = \
                tatu_load_nothing, .version = V)";
    let code = format!("{code}{}", counting("++((state *)b->state[i])->n", life));
    let place = plugin(&code, "TATU_SENSORS(&kind)", &[]);
    place.write("scene.toml", "format = 1\n[[object]]\nkind = \"sensor\"\nsensor = \"tried\"\nalias = \"c\"\n");
    let env = [("TATU_PLUGIN_PATH", "mine")];
    let run_with = |args: &[&str]| run(program(), place.path(), &[&["run", "scene.toml"], args].concat(), &env);
    run_with(&["--steps", "4", "--snapshot-at", "0.2", "s.snap"]).good();
    let same = run_with(&["--steps", "2", "--from", "s.snap", "--strict"]).good();
    assert!(!same.err.contains("starts over"), "{}", same.err);
    for (define, why) in
        [("-DV=2", "has version 1, but the plugin declares 2"), ("-DGROWN", "has 8 bytes, but the plugin declares 16")]
    {
        compile_into(&place, &code, "TATU_SENSORS(&kind)", &[define]);
        let told = run_with(&["--steps", "2", "--from", "s.snap"]).good();
        let all = format!("{}{}", told.out, told.err);
        assert!(all.contains("the sensor /c starts over") && all.contains(why), "{all}");
        assert_ne!(run_with(&["--steps", "2", "--from", "s.snap", "--strict"]).code, 0);
    }
}

#[test]
fn importers_without_a_sample_are_not_reported_as_tested() {
    // The file must begin with the sum of its own bytes, which cannot be composed from the texts in the library.
    let code = "static tatu_status TATU_CALL load(void *self, tatu_str bytes, const tatu_builder *to, const tatu_value *p, tatu_error *e) {
           (void)self, (void)p;
           uint8_t sum = 0;
           for (uint64_t i = 4; i < bytes.len; i++) sum = (uint8_t)(3 * sum + (uint8_t)bytes.ptr[i]);
           if (bytes.len < 12 || (uint8_t)bytes.ptr[0] != sum || bytes.ptr[1] != 1 || bytes.ptr[2] != 2 || bytes.ptr[3] != 3)
             return tatu_fail(e, TATU_ERR_ARGUMENT, \"the sum is wrong\");
           return to->object(to, \"dummy\", 0, tatu_text(\"d\")) ? TATU_OK : TATU_ERR;
         }
         static const tatu_importer it = {.size = sizeof(tatu_importer), .id = \"tried\", .text = \"Reads sums.\",
           .suffixes = TATU_TEXTS(\".tried\"), .load = load};";
    let place = plugin(code, "TATU_IMPORTERS(&it)", &[]);
    let all = check(&place, "importers", 0);
    assert!(!all[0]["tried"].as_bool().unwrap() && all[0].to_string().contains("no sample was found"), "{all:?}");
    let body = [0u8; 8];
    std::fs::write(place.path().join("mine/sample.tried"), [[0, 1, 2, 3].as_slice(), &body].concat()).unwrap();
    assert!(check(&place, "importers", 0)[0]["tried"].as_bool().unwrap());
}

#[test]
fn results_on_the_stack_of_a_command_are_named_as_such() {
    let code = "static tatu_status TATU_CALL name(tatu_call *call) {
           char text[24];
           snprintf(text, sizeof text, \"object %d\", (int)tatu_arg_int(call, 0));
           tatu_value value = {.tag = TATU_TEXT};
           value.u.s.ptr = text;
           value.u.s.len = strlen(text);
           return tatu_return(call, value);
         }
         static const tatu_command command = {.size = sizeof(tatu_command), .names = TATU_NAME(\"tried.name\"), .call = name,
           .params = TATU_PARAMS(TATU_PARAM(TATU_I64, \"n\", NULL, \"Any number.\")),
           .returns = TATU_PARAMS(TATU_PARAM(TATU_TEXT, \"name\", NULL, \"The name.\")), .text = \"Names.\",
           .example = \"tried.name(2)\"};";
    let code = format!("#include <stdio.h>\n#include <string.h>\n{code}");
    let place = plugin(&code, "TATU_COMMANDS(&command)", &["-Wno-return-local-addr"]);
    for test in ["arguments", "worlds"] {
        finds(&place, test, &["command `tried.name`", "its result 1 points to its own stack", "tatu_copy_text"]);
        let all = check(&place, test, 1);
        assert!(!all[0].to_string().contains("global or static"), "{all:?}");
    }
}

#[test]
fn an_instance_without_data_and_state_needs_no_functions() {
    let code = counting("1", "TATU_TABLE(tatu_life, .version = 1)");
    let place = plugin(&code, "TATU_SENSORS(&kind)", &[]);
    place.write("scene.toml", "format = 1\n[[object]]\nkind = \"sensor\"\nsensor = \"tried\"\nalias = \"c\"\n");
    let env = [("TATU_PLUGIN_PATH", "mine")];
    let done = run(program(), place.path(), &["run", "scene.toml", "--steps", "2", "--strict"], &env).good();
    assert!(!done.err.contains("tried"), "{}", done.err);
}

#[test]
fn the_error_of_a_call_is_the_last_error_of_its_world() {
    let barrier = "tatu_value got;
           static int done;
           if (done++) return TATU_GO;
           tatu_value args[] = {tatu_string(\"object.alias\")};
           tatu_status status = tatu_call_command(api, world, NULL, CALLED, args, 1, &got);
           const tatu_error *why = api->log->last_error(world);
           char line[400];
           snprintf(line, sizeof line, \"%d: %.*s\", (int)status, why ? (int)why->text.len : 0, why ? why->text.ptr : \"\");
           api->log->write(api->host, world, TATU_LOG_STATUS, tatu_text(line));
           return TATU_GO;";
    let (code, offers) = service(barrier);
    let offers = offers.replace("TATU_NEED_SCENE", "TATU_NEED_SCENE, TATU_NEED_COMMANDS, TATU_NEED_LOG");
    for (called, told) in [("sim.getObjectAlias", "argument 1"), ("tried.none", "command")] {
        let code = format!("#include <stdio.h>\n#define CALLED \"{called}\"\n{code}");
        let place = plugin(&code, &offers, &[]);
        place.write("scene.toml", "format = 1\n[[service]]\nid = \"tried\"\n");
        let env = [("TATU_PLUGIN_PATH", "mine")];
        let done = run(program(), place.path(), &["run", "scene.toml", "--steps", "2"], &env).good();
        let line = done.out.lines().next().unwrap_or_default();
        assert!(line.starts_with('-') && line.contains(told), "{called}: {}\n{}", done.out, done.err);
    }
}

#[test]
fn events_that_do_not_exist_are_reported_when_a_plugin_loads() {
    let code = "static tatu_status TATU_CALL heard(void *s, void *i, void *b, tatu_world *w, tatu_str n, const tatu_value *p, tatu_error *e) {
           (void)s, (void)i, (void)b, (void)w, (void)n, (void)p, (void)e;
           return TATU_OK;
         }";
    let place = plugin(code, "TATU_LISTENS(heard, \"separated\", \"mine.own\", \"*\", \"contact\")", &[]);
    place.write("scene.toml", "format = 1\n[[object]]\nkind = \"dummy\"\nalias = \"d\"\n");
    let told = run(program(), place.path(), &["run", "scene.toml", "--steps", "1"], &[("TATU_PLUGIN_PATH", "mine")]);
    let all = format!("{}{}", told.out, told.err);
    assert!(all.contains("E310") && all.contains("the event `separated`, which does not exist"), "{all}");
    assert!(all.matches("which does not exist").count() == 1, "{all}");
}
