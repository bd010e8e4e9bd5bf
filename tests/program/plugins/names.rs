//! Tests of names declared by plugins that are invalid, hide others, or cannot be called by any script. Of two plugins,
//! the one that is loaded later is reported, and the earlier one continues to work.

use std::fmt::Write;

use crate::{kit::plugin_sources::*, kit::*};

/// Returns a plugin with one command per name, each of which is a C literal. The commands return 1, 2, ...
fn commands(plugin: &str, names: &[&str]) -> PluginSource {
    let mut before = String::new();
    let mut list = String::new();
    for (i, name) in names.iter().enumerate() {
        let _ = writeln!(
            before,
            "static tatu_status f{i}(tatu_call *c) {{ return tatu_return(c, tatu_int({i} + 1)); }}
static const tatu_name n{i} = {{.size = sizeof(tatu_name), .name = \"{name}\"}};
static const tatu_name *const l{i}[] = {{&n{i}, NULL}};
static const tatu_command c{i} = {{.size = sizeof(tatu_command), .names = l{i}, .text = \"Some.\", .call = f{i}}};"
        );
        let _ = write!(list, "&c{i}, ");
    }
    let _ = writeln!(before, "static const tatu_command *const commands[] = {{{list}NULL}};");
    before += "static const tatu_ext_command ext_command = {.size = sizeof(tatu_ext_command), .commands = commands};\n";
    PluginSource::new(plugin).with(|s| s.before = before)
}

/// Returns the number of warnings that contain all of these words.
fn warnings(done: &RunOutput, words: &[&str]) -> usize {
    let all = done.err.split("warning").skip(1).filter(|w| words.iter().all(|x| w.contains(x)));
    all.count()
}

#[track_caller]
fn warned_once(done: &RunOutput, words: &[&str]) {
    assert_eq!(warnings(done, words), 1, "{words:?}:\n{}", done.err);
}

#[test]
fn a_command_has_at_most_255_names() {
    let many = |n: usize| {
        let names: String = (0..n).map(|i| format!("\"many.n{i}\", ")).collect();
        PluginSource::new("many").with(|s| {
            s.before = format!(
                "static tatu_status one(tatu_call *c) {{ return tatu_return(c, tatu_int((int64_t)c->alias)); }}
static const char *const texts[] = {{{names}}};
static tatu_name all[{n}];
static const tatu_name *names[{n} + 1];
static const tatu_command c = {{.size = sizeof(tatu_command), .names = names, .text = \"Many.\", .call = one}};
static const tatu_command *const commands[] = {{&c, NULL}};
static const tatu_ext_command ext_command = {{.size = sizeof(tatu_ext_command), .commands = commands}};
"
            );
            s.init = format!(
                "for (int i = 0; i < {n}; i++) {{ all[i].size = sizeof(tatu_name); all[i].name = texts[i]; names[i] = &all[i]; }} return TATU_OK;"
            );
        })
    };
    let call = |n: usize| watcher("w", &format!("function sysCall_init() assert(many.n{n}() == {n}) end"));
    let good = place(&call(254));
    compile(&good, "many", &many(255).text());
    let done = good.run(&["--steps", "1"]).good();
    assert_eq!(warnings(&done, &["many"]), 0, "{}", done.err);
    let bad = place("");
    compile(&bad, "many", &many(300).text());
    let done = bad.run(&["--steps", "1"]).good();
    warned_once(&done, &["[E303]", "`org.test.many`", "command `many.n0` has 300 names; a command has at most 255"]);
}

#[test]
fn invalid_names_are_shown_and_not_used() {
    let bad = ["", "odd.a b", "odd.a\\nb", "odd.\\033[31mred", "odd.\\xff", "odd.tab\\t"];
    let shown = ["``", "`odd.a b`", "`odd.a\\nb`", "`odd.\\u{1b}[31mred`", "`odd.\\xff`", "`odd.tab\\t`"];
    let place = place(&watcher("w", "function sysCall_init() assert(odd.good() == 7) end"));
    compile(&place, "odd", &commands("odd", &[&bad[..], &["odd.good"]].concat()).text());
    let done = place.run(&["--steps", "1"]).good();
    for name in shown {
        warned_once(&done, &["[E303]", "`org.test.odd`", &format!("its command {name} has an invalid name: it ")]);
    }
    done.reports(&["it is empty", "it contains a space", "contains control characters", "mine.name"]);
    assert!(!done.err.contains('\u{1b}'), "{}", done.err);
}

#[test]
fn every_kind_of_name_is_checked() {
    let bad = "bad\\033name";
    let mut source = all("bad", "a").with(|s| {
        for id in ["eye", "thing", "tongue", "arm", "reader", "butler"] {
            let id = format!(".id = \"{id}\"");
            assert!(s.before.contains(&id), "{id}");
            s.before = s.before.replace(&id, &format!(".id = \"{bad}\""));
        }
        s.before += &format!(
            "static const tatu_event event = {{.size = sizeof(tatu_event), .name = \"bad.{bad}\", .text = \"Now.\"}};
static const tatu_event *const events[] = {{&event, NULL}};
static const tatu_ext_event ext_event = {{.size = sizeof(tatu_ext_event), .events = events}};
static const tatu_constant constant = {{.size = sizeof(tatu_constant), .name = \"bad.{bad}\"}};
static const tatu_constant *const constants[] = {{&constant, NULL}};
static const tatu_ext_command with_constant = {{.size = sizeof(tatu_ext_command), .commands = commands, .constants = constants}};
"
        );
        s.extension = s.extension.replace("(const void *)&ext_command", "(const void *)&with_constant");
        s.extension = format!("if (!strcmp(id, TATU_EVENT)) return &ext_event; {}", s.extension);
    });
    let base = place("");
    compile(&base, "bad", &source.text());
    let done = base.run(&["--steps", "1"]).good();
    for what in ["sensor", "model", "language", "actuator", "importer", "service"] {
        warned_once(
            &done,
            &["[E303]", "`org.test.bad`", &format!("its {what} `bad\\u{{1b}}name` has an invalid name")],
        );
    }
    warned_once(&done, &["[E303]", "its event `bad.bad\\u{1b}name` has an invalid name"]);
    warned_once(&done, &["[E303]", "its constant `bad.bad\\u{1b}name` has an invalid name"]);
    // The id of the plugin itself is invalid: it is not loaded.
    source.id = "\"org.test.a b\"".into();
    compile(&base, "bad", &source.text());
    warned_once(&base.run(&["--steps", "1"]).good(), &["[E301]", "its id `org.test.a b` contains a space"]);
    // The suffix `""` would match every file name.
    let base = place("");
    let suffix = all("end", "a").text().replace("\".tongue\"", "\"\"").replace("\".scroll\"", "\".a b\"");
    compile(&base, "end", &suffix);
    let done = base.run(&["--steps", "1"]).good();
    warned_once(&done, &["[E303]", "`org.test.end`", "its language `tongue` has the suffix ``, which is empty"]);
    warned_once(
        &done,
        &["[E303]", "`org.test.end`", "its importer `reader` has the suffix `.a b`, which contains a space"],
    );
    // Names of schemas, fields and parameters are also checked.
    let table = ", .fields = fields, .params = params";
    let fields = |field: &str| {
        format!(
            "static const tatu_field field = {{.size = sizeof(tatu_field), .elem = TATU_ELEM_F64, .dims = {{1, 1, 1}}, .name = \"{field}\"}};
static const tatu_field *const fields[] = {{&field, NULL}};
static const tatu_param param = {{.size = sizeof(tatu_param), .type = TATU_F64, .key = \"a\\nb\", .flags = TATU_PARAM_OPTIONAL}};
static const tatu_param *const params[] = {{&param, NULL}};
"
        )
    };
    let nose = |field: &str, schema: &str| {
        eye("nose", "nose", table).with(|s| {
            s.before = format!("{}{}", fields(field), s.before.replace("\"eye/1\"", &format!("\"{schema}\"")));
        })
    };
    let base = place("");
    compile(&base, "nose", &nose("smell.a b", "smell/1").text());
    let done = base.run(&["--steps", "1"]).good();
    warned_once(
        &done,
        &["[E303]", "the field `smell.a b` of its sensor `nose` has an invalid name: it contains a space"],
    );
    compile(&base, "nose", &nose("smell.what", "smell\\t/1").text());
    let done = base.run(&["--steps", "1"]).good();
    warned_once(&done, &["[E303]", "its sensor `nose` claims the schema `smell\\t/1`, which is not a valid name"]);
    warned_once(&done, &["[E310]", "its parameter `a\\nb` cannot be written"]);
}

#[test]
fn a_name_is_no_name_space() {
    // Of several declarations in one plugin, the first is used.
    let base = place(&watcher("w", "function sysCall_init() assert(reg.b() == 1 and type(reg) == 'table') end"));
    compile(&base, "reg", &commands("reg", &["reg.b", "reg"]).text());
    let done = base.run(&["--steps", "1"]).good();
    warned_once(
        &done,
        &["[E303]", "`org.test.reg`", "its command `reg` is also the name space of `reg.b` of the same plugin"],
    );
    // Of two plugins, the one that is loaded later is reported, whichever of the two names is the name space.
    let base = place(&watcher("w", "function sysCall_init() assert(one.b() == 1 and two() == 2) end"));
    compile(&base, "a", &commands("a", &["one.b", "two"]).text());
    compile(&base, "b", &commands("b", &["one", "two.b"]).text());
    let done = base.run(&["--steps", "1"]).good();
    warned_once(&done, &["[E303]", "`org.test.b`", "`one` is also the name space of `one.b` of `org.test.a`"]);
    warned_once(
        &done,
        &["[E303]", "`org.test.b`", "`two.b` could not be reached: `two` of `org.test.a` is not a name space"],
    );
}

#[test]
fn an_added_plugin_is_blamed_and_not_a_built_in_one() {
    // The id of this plugin precedes all others, and its folder is searched first.
    let script = "function sysCall_init()
        assert(sim.getObject('/w') > 0 and aaa.good() == 5)
        assert(sim.getTheAnswer() == 4)
    end";
    let scene = format!("{FLOOR}{}", watcher("w", script));
    let base = TestFolder::scene(&scene);
    std::fs::create_dir(base.path().join("mine")).unwrap();
    let newcomer =
        commands("aaa", &["sim", "sim.getObject", "sim.getObject.more", "sim.getTheAnswer", "aaa.good", "sim.another"])
            .with(|s| s.id = "\"aaa\"".into());
    compile(&base, "aaa", &newcomer.text());
    let done =
        run(program(), base.path(), &["run", "scene.toml", "--json", "--steps", "1"], &[("TATU_PLUGIN_PATH", "mine")]);
    let done = done.good();
    let mine = ["`aaa`", "libtatu_aaa"];
    warned_once(&done, &[&["[E303]", "its command `sim` is also the name space of"][..], &mine].concat());
    warned_once(&done, &[&["[E303]", "its command `sim.getObject` is already offered by"][..], &mine].concat());
    warned_once(&done, &[&["[E303]", "`sim.getObject.more` could not be reached"][..], &mine].concat());
    // There is one warning per name space, and the names work.
    warned_once(
        &done,
        &[&["[E310]", "`sim.another` and 1 more is in the name space `sim`", "if this is intended"][..], &mine]
            .concat(),
    );
    assert_eq!(warnings(&done, &["[E3"]), 4, "{}", done.err);
}

#[test]
fn names_of_the_languages_library_are_reported_once() {
    let script = "function sysCall_init() assert(dead.print() == 3 and string.format('%d', 1) == '1') end";
    let base = place(&format!("{}{}", watcher("v", script), watcher("w", script)));
    compile(&base, "dead", &commands("dead", &["print", "string.format", "dead.print", "string.anew"]).text());
    let done = base.run(&["--steps", "1"]).good();
    for name in ["print", "string.format", "string.anew"] {
        warned_once(&done, &[&format!("Lua scripts cannot call the command `{name}`"), "tatu describe"]);
    }
    assert_eq!(warnings(&done, &["dead.print"]), 0, "{}", done.err);
}
