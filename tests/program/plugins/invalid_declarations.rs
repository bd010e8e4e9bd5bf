//! Tests of invalid fields and slots that plugins declare, and of invalid objects and events that they create. Each is
//! refused with an error that names the plugin, and the rest works.

use crate::{kit::plugin_sources::*, kit::*};

/// Returns a sensor `eye` with one field `smell.what`.
fn field(elem: &str, dims: &str) -> PluginSource {
    eye("eye", "eye", ", .fields = fields").with(|s| {
        s.before = format!(
            "static const tatu_field field = {{.size = sizeof(tatu_field), .elem = {elem}, .dims = {{{dims}}}, .name = \"smell.what\"}};
static const tatu_field *const fields[] = {{&field, NULL}};
{}",
            s.before
        );
    })
}

#[test]
fn fields_of_invalid_size_or_type_are_reported() {
    let base = place("");
    for (elem, dims, said) in [
        ("TATU_ELEM_F64", "100000, 100000, 1", "has 100000 x 100000 x 1 elements, but at most 268435456"),
        ("TATU_ELEM_U8", "4000000000u, 4000000000u, 4000000000u", "elements, but at most 268435456"),
        ("TATU_ELEM_U8", "0, 300000000, 1", "has 0 x 300000000 x 1 elements"),
        ("0", "1, 1, 1", "has elements of the unknown type 0"),
        ("9", "1, 1, 1", "has elements of the unknown type 9"),
    ] {
        compile(&base, "eye", &field(elem, dims).text());
        let done = base.run(&["--steps", "1"]).good();
        done.reports(&["E303", "`org.test.eye`", "the field `smell.what` of its sensor `eye`", said]);
    }
    let used = place("[[object]]\nkind = \"sensor\"\nsensor = \"eye\"\n");
    for dims in ["16384, 16384, 1", "0, 3, 1", "TATU_DIM_OWN, TATU_DIM_OWN + 3, 1"] {
        compile(&used, "eye", &field("TATU_ELEM_U8", dims).text());
        let done = used.run(&["--steps", "1"]);
        assert!(!done.err.contains("E303"), "{dims}: {}", done.err);
    }
}

#[test]
fn inputs_are_those_of_the_stage_in_which_a_sensor_measures() {
    let base = place("");
    let table =
        |inputs: &str, flags: &str| eye("eye", "eye", &format!(", .inputs = {inputs}, .flags = {flags}")).text();
    for (inputs, flags, said) in [
        ("TATU_IN_JOINT", "0", "requests acceleration, joint, contacts or wrench without"),
        ("TATU_IN_POSE | TATU_IN_CONTACTS", "0", "requests acceleration, joint, contacts or wrench without"),
        ("TATU_IN_DISTANCE", "TATU_SENSOR_EVERY_PHYSICS_STEP", "requests inputs of beams or images"),
    ] {
        compile(&base, "eye", &table(inputs, flags));
        base.run(&["--steps", "1"]).good().reports(&["E303", "`org.test.eye`", "its sensor `eye`", said]);
    }
    compile(&base, "eye", &table("TATU_IN_POSE | TATU_IN_WRENCH", "TATU_SENSOR_EVERY_PHYSICS_STEP"));
    let done = base.run(&["--steps", "1"]).good();
    assert!(!done.err.contains("E303"), "{}", done.err);
}

/// Returns a model `thing` whose `build` has this body.
fn model(body: &str, more: &str) -> PluginSource {
    PluginSource::new("maker").with(|s| {
        s.before += &format!(
            "static const char *const slots[] = {{\"deck\", NULL}};
static tatu_status build(void *s, const tatu_builder *b, const tatu_value *p, tatu_error *e) {{ (void)s; (void)p; (void)e; (void)b; {body} return TATU_OK; }}
static const tatu_model model = {{.size = sizeof(tatu_model), .id = \"thing\", .text = \"A thing.\", .build = build{more}}};
static const tatu_model *const models[] = {{&model, NULL}};
static const tatu_ext_model ext_model = {{.size = sizeof(tatu_ext_model), .models = models}};
"
        );
        s.extension = format!("if (!strcmp(id, TATU_MODEL)) return &ext_model; {}", s.extension);
    })
}

#[test]
fn slots_must_be_objects_that_the_model_builds() {
    let base = place("[[model]]\nmodel = \"thing\"\n");
    let one = |alias: &str| {
        format!(
            "uint32_t o = b->object(b, \"dummy\", 0, tatu_text(\"base\")); b->object(b, \"dummy\", o, tatu_text(\"{alias}\"));"
        )
    };
    compile(&base, "maker", &model(&one("desk"), ", .slots = slots").text());
    base.run(&["--steps", "1"]).refused(&[
        "E111",
        "the model `thing` declares the slot `deck`",
        "slot",
        "`org.test.maker`",
    ]);
    compile(&base, "maker", &model(&one("deck"), ", .slots = slots").text());
    base.run(&["--steps", "1"]).good();
}

#[test]
fn aliases_that_do_not_fit_in_a_path_are_refused() {
    let base = place("[[model]]\nmodel = \"thing\"\n");
    for (alias, shown) in [("a/b", "`a/b`"), ("a\\033[2Jb", "`a\\u{1b}[2Jb`"), ("a\\nb", "`a\\nb`")] {
        compile(&base, "maker", &model(&format!("b->object(b, \"dummy\", 0, tatu_text(\"{alias}\"));"), "").text());
        let done = base.run(&["--steps", "1"]);
        done.refused(&[
            "E102",
            "the model `thing`",
            &format!("{shown} cannot be an alias"),
            "`org.test.maker`",
            "without `/`",
        ]);
        assert!(!done.err.contains('\u{1b}'), "{}", done.err);
    }
    // Without an alias, an object is named after its kind.
    compile(&base, "maker", &model("b->object(b, \"dummy\", 0, tatu_text(\"\"));", "").text());
    assert!(base.run(&["--steps", "1"]).good().json()["objects"]["/dummy"].is_object());
}

/// Returns a plugin with a command `<name>.one` that has the given body and uses services of the host.
fn actor(name: &str, body: &str) -> PluginSource {
    PluginSource::new(name).with(|s| {
        s.before = s.before.replace("return tatu_return(c, tatu_int(1));", body);
        s.before = format!(
            "static const tatu_host *h; static const tatu_host_scene *scene; static const tatu_host_events *events;\n{}",
            s.before
        );
        s.init = "h = host; scene = (const tatu_host_scene *)host->service(host, TATU_HOST_SCENE); \
                  events = (const tatu_host_events *)host->service(host, TATU_HOST_EVENTS); return TATU_OK;"
            .into();
    })
}

#[test]
fn objects_created_or_renamed_in_a_run_need_a_valid_alias() {
    for (alias, shown) in [("a/b", "`a/b`"), ("a\\033[2Jb", "`a\\u{1b}[2Jb`")] {
        let made = format!("tatu_object o; return scene->create(c->world, \"dummy\", 0, tatu_text(\"{alias}\"), &o);");
        let renamed = format!(
            "tatu_object o = 0; tatu_value v = tatu_string(\"{alias}\"); scene->create(c->world, \"dummy\", 0, tatu_text(\"x\"), &o);
             return scene->set(c->world, o, scene->prop(h, \"object.alias\"), &v);"
        );
        let named = renamed.replace("object.alias", "object.name");
        for (body, said) in [(made, "cannot be an alias"), (renamed, "cannot be an alias"), (named, "is not a name")] {
            let base = place(&watcher("w", "function sysCall_init() act.one() end"));
            compile(&base, "act", &actor("act", &body).text());
            let done = base.run(&["--steps", "1"]);
            let errors = done.errors();
            let text = errors[0].to_string();
            let said = format!("{shown} {said}").replace('\\', "\\\\");
            assert!(text.contains(&said) && text.contains("act.one"), "{said}: {text}");
            assert!(!done.err.contains('\u{1b}'), "{}", done.err);
        }
    }
}

#[test]
fn an_event_payload_must_be_a_map() {
    let body = "tatu_value v = tatu_int(3); return events->publish(c->world, tatu_text(\"act.done\"), &v);";
    let base = place(&watcher("w", "function sysCall_init() act.one() end"));
    compile(&base, "act", &actor("act", body).text());
    let done = base.run(&["--steps", "1"]);
    let text = done.errors()[0].to_string();
    assert!(text.contains("the payload of `act.done` is 3; expected a table with keys"), "{text}");
    assert!(text.contains("act.one"), "{text}");
}

#[test]
fn a_default_can_be_read() {
    let param = "static const tatu_param odd = {.size = sizeof(tatu_param), .type = TATU_F64, .key = \"odd\", .fallback = {.tag = 77}};
static const tatu_param wide = {.size = sizeof(tatu_param), .type = TATU_F32S, .key = \"wide\", .flags = TATU_PARAM_OPTIONAL};
static const tatu_param *const params[] = {&odd, &wide, NULL};
";
    let base = place("");
    compile(
        &base,
        "eye",
        &eye("eye", "eye", ", .params = params").with(|s| s.before = format!("{param}{}", s.before)).text(),
    );
    let done = base.run(&["--steps", "1"]).good();
    done.reports(&["E310", "`org.test.eye`", "parameter `odd` has a default that cannot be read"]);
    done.reports(&["parameter `wide` has the unknown type 7"]);
}
