//! Tests of names that are declared twice: by two plugins, between which the scene decides, or by one plugin, whose
//! first declaration is used.

use crate::{kit::plugin_sources::*, kit::*};

#[test]
fn two_plugins_of_one_id_are_reported_with_both_paths() {
    let place = place("");
    compile(&place, "first", &PluginSource::new("twin").text());
    compile(&place, "second", &PluginSource::new("twin").text());
    let done = place.run(&["--steps", "1"]).good();
    done.reports(&["E302", "`org.test.twin`", &library("tatu_first"), &library("tatu_second"), "a different id"]);
}

#[test]
fn plugins_that_claim_one_name_are_reported_and_the_scene_decides() {
    let base = place("");
    compile(&base, "a", &all("a", "a").text());
    compile(&base, "b", &all("b", "b").text());
    // The scene uses none of the names, so the conflict is reported and the scene runs.
    let done = base.run(&["--steps", "1"]).good();
    done.reports(&["E303", "its sensor `eye`", "its model `thing`", "its language `tongue`", "[providers]"]);
    done.reports(&["its actuator `arm`", "its importer `reader`", "its service `butler`"]);
    let scene = base.read("scene.toml");
    let run = |more: &str| {
        base.write("scene.toml", &format!("{scene}{more}"));
        base.run(&["--steps", "1"])
    };
    let object = |key: &str| format!("[[object]]\nkind = \"sensor\"\nalias = \"s\"\nsensor = \"{key}\"\n");
    let model = "[[model]]\nmodel = \"thing\"\n";
    let script = "[[object]]\nkind = \"dummy\"\nscript = { text = '', language = \"tongue\" }\n";
    let actuator = "[[object]]\nkind = \"actuator\"\nalias = \"x\"\nactuator = \"arm\"\n";
    let import = "[[import]]\nfile = \"a.scroll\"\nimporter = \"reader\"\n";
    let service = "[[service]]\nid = \"butler\"\n";
    base.write("a.scroll", "");
    for used in [&object("eye"), &object("eye/1"), model, script, actuator, import, service] {
        run(used).refused(&[
            "E322",
            "`org.test.a`",
            "`org.test.b`",
            &library("tatu_a"),
            &library("tatu_b"),
            "[providers]",
        ]);
    }
    for (plugin, mark) in [("org.test.a", "a"), ("org.test.b", "b")] {
        let provider = |key: &str| format!("[providers]\n\"{key}\" = \"{plugin}\"\n");
        run(&(object("eye") + &provider("eye"))).good();
        run(&(object("eye/1") + &provider("eye/1"))).good();
        let built = run(&(model.to_owned() + &provider("thing"))).good().json();
        assert!(built["objects"][format!("/built_by_{mark}")].is_object(), "{built}");
        let read = run(&(import.to_owned() + &provider("reader"))).good().json();
        assert!(read["objects"][format!("/built_by_{mark}")].is_object(), "{read}");
        run(&(actuator.to_owned() + &provider("arm"))).good();
        run(&(service.to_owned() + &provider("butler"))).refused(&["E404", plugin, &format!("started by {mark}")]);
        let errors = run(&(script.to_owned() + &provider("tongue"))).errors();
        assert!(errors[0]["message"].as_str().unwrap().contains(&format!("loaded by {mark}")), "{errors:?}");
    }
    run(&(object("eye") + "[providers]\neye = \"org.test.c\"\n")).refused(&["E113", "org.test.a", "org.test.b"]);
    // Two plugins offer the same command. That of the plugin with the lower id is called, and both are reported.
    let place = place(&watcher("w", "function sysCall_init() assert(same.one() == 1) end"));
    compile(&place, "a", &PluginSource::new("same").with(|s| s.id = "\"org.test.a\"".into()).text());
    let other =
        PluginSource::new("same").with(|s| s.id = "\"org.test.b\"".into()).text().replace("tatu_int(1)", "tatu_int(2)");
    compile(&place, "b", &other);
    let done = place.run(&["--steps", "1"]).good();
    done.reports(&["E303", "`org.test.b`", "its command `same.one`", "`org.test.a`", "name space"]);
}

#[test]
fn of_two_things_of_one_id_in_a_plugin_the_first_is_used() {
    let twice = all("twice", "a").with(|s| {
        for (list, one) in [
            ("kinds[] = {", "&eye"),
            ("models[] = {", "&model"),
            ("languages[] = {", "&language"),
            ("arms[] = {", "&arm"),
            ("readers[] = {", "&reader"),
            ("services[] = {", "&butler"),
            ("commands[] = {", "&one_command"),
        ] {
            assert!(s.before.contains(list), "{list}");
            s.before = s.before.replace(list, &format!("{list}{one}, "));
        }
    });
    let used = "[[object]]\nkind = \"sensor\"\nalias = \"s\"\nsensor = \"eye\"\n[[model]]\nmodel = \"thing\"\n";
    let place = place(
        &format!("{used}{}", watcher("w", "function sysCall_init() assert(twice.one() == 1) end"))
            .replace("{ text", "{ language = \"lua\", text"),
    );
    compile(&place, "twice", &twice.text());
    let done = place.run(&["--steps", "2"]).good();
    for what in ["sensor `eye`", "model `thing`", "language `tongue`", "actuator `arm`", "importer `reader`"] {
        done.reports(&["E303", "`org.test.twice`", &format!("it offers the {what} twice; the first is used")]);
    }
    done.reports(&["the service `butler` twice", "the command `twice.one` twice"]);
}

#[test]
fn a_text_says_its_language_where_there_are_several() {
    let scene = watcher("w", "function sysCall_init() end");
    let place = place(&scene);
    compile(&place, "second", &all("second", "a").text());
    place.run(&["--steps", "1"]).refused(&["E109", "must specify its language", "`language = ...`", "`lua`, `tongue`"]);
    place.write("scene.toml", &place.read("scene.toml").replace("{ text", "{ language = \"lua\", text"));
    place.run(&["--steps", "1"]).good();
}
