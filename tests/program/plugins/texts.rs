//! Tests of texts from plugins: log lines contain the id of their plugin, and texts are sanitised and truncated.

use crate::{kit::plugin_sources::*, kit::*};

/// Returns a plugin that uses the log, with a command `<name>.one` that has the given body.
fn speaker(name: &str, body: &str) -> PluginSource {
    PluginSource::new(name).with(|s| {
        s.before = s.before.replace("return tatu_return(c, tatu_int(1));", body);
        s.before =
            format!("#include <stdlib.h>\nstatic const tatu_host *h; static const tatu_host_log *l;\n{}", s.before);
        s.init = "h = host; l = (const tatu_host_log *)host->service(host, TATU_HOST_LOG); return TATU_OK;".into();
    })
}

#[test]
fn a_line_carries_the_name_of_its_plugin() {
    let body = "l->write(h, c->world, TATU_LOG_INFO, tatu_text(\"with a world\"));
      l->write(h, 0, TATU_LOG_INFO, tatu_text(\"without one\"));
      l->write(0, c->world, TATU_LOG_WARNING, tatu_text(\"without a host\"));
      l->write(h, c->world, TATU_LOG_STATUS, tatu_text(\"for the status bar\"));
      return tatu_return(c, tatu_int(1));";
    let script = "function sysCall_init() speak.one() print('of the script') sim.addLog(sim.verbosity_scriptinfos, 'logged') end";
    let place = place(&watcher("w", script));
    compile(&place, "speak", &speaker("speak", body).text());
    let done = place.run(&["--steps", "1"]).good();
    let line = |text: &str| done.err.lines().filter(|l| *l == text).count();
    for text in [
        "plugin `org.test.speak`: with a world",
        "plugin `org.test.speak`: without one",
        "warning: plugin `org.test.speak`: without a host",
        "for the status bar",
        "of the script",
    ] {
        assert_eq!(line(text), 1, "{text}:\n{}", done.err);
    }
    assert!(done.err.lines().any(|l| l.ends_with("logged") && !l.contains("plugin `")), "{}", done.err);
}

#[test]
#[cfg(unix)]
fn a_line_of_a_thread_carries_it_too() {
    let body = "pthread_t t; pthread_create(&t, 0, run, 0); pthread_join(t, 0); return tatu_return(c, tatu_int(1));";
    let source = speaker("thread", body).with(|s| {
        let run = "#include <pthread.h>\nstatic void *run(void *p) { l->write(h, 0, TATU_LOG_INFO, tatu_text(\"from a thread\")); return p; }\n";
        s.before = s.before.replace("static tatu_status one(", &format!("{run}static tatu_status one("));
    });
    let place = place(&watcher("w", "function sysCall_init() thread.one() end"));
    compile(&place, "thread", &source.text());
    let done = place.run(&["--steps", "1"]).good();
    assert_eq!(done.err.matches("plugin `org.test.thread`: from a thread\n").count(), 1, "{}", done.err);
}

#[test]
fn control_characters_do_not_reach_the_terminal() {
    let body = "l->write(h, c->world, TATU_LOG_INFO, tatu_text(\"a \\033[31mred\\a line\\twith\\r\\na second\"));
      tatu_fail(c->error, TATU_ERR, \"a \\033]0;title\\a failure\");
      if (TATU_HAS(c->error, add)) c->error->add(c->error, TATU_PART_HELP, tatu_text(\"do \\033[2J nothing\"), 0);
      return TATU_ERR;";
    let source = speaker("dirty", body).with(|s| {
        s.before = s.before.replace("\"One.\"", "\"One \\033[5mblinks.\"");
    });
    let place = place(&watcher("w", "function sysCall_init() dirty.one() end"));
    compile(&place, "dirty", &source.text());
    let done = place.run(&["--steps", "1"]);
    done.reports(&[
        "a \\u{1b}[31mred\\u{7} line\twith\na second",
        "a \\u{1b}]0;title\\u{7} failure",
        "do \\u{1b}[2J nothing",
    ]);
    assert!(!done.err.contains(['\u{1b}', '\u{7}', '\r']), "{}", done.err);
    let shown = run(program(), place.path(), &["list", "commands"], &[("TATU_PLUGIN_PATH", "mine")]).good();
    assert!(shown.out.contains("One \\u{1b}[5mblinks."), "{}", shown.out);
    assert!(!shown.out.contains('\u{1b}'));
}

#[test]
fn script_output_is_not_changed() {
    let place = TestFolder::scene(&watcher("w", "function sysCall_init() print('\\27[31mred') end"));
    place.run(&["--steps", "1"]).good().reports(&["\u{1b}[31mred"]);
}

#[test]
fn a_very_long_error_text_is_truncated() {
    let body = "size_t n = 1 << 20; char *t = malloc(n + 1); memset(t, 'x', n); t[n] = 0;
      tatu_fail(c->error, TATU_ERR, t); free(t); return TATU_ERR;";
    let script = "function sysCall_init()
        local ok, said = pcall(long.one)
        assert(not ok and #tostring(said) < 17000, #tostring(said))
        error(said, 0)
    end";
    let place = place(&watcher("w", script));
    compile(&place, "long", &speaker("long", body).text());
    let done = place.run(&["--steps", "1"]);
    let errors = done.errors();
    let said = errors[0]["message"].as_str().unwrap();
    assert!(said.contains("xxx... (1032192 more bytes are left out)"), "{}", &said[said.len() - 200..]);
}
