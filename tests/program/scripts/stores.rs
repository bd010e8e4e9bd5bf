//! Tests that the amount of data that scripts store in a world is limited, and that exceeding the limit is an error of
//! the script.

use crate::kit::*;

/// Runs a script that executes `body` 100 times per step in a world with little memory.
fn greedy(body: &str) -> RunOutput {
    let script = format!(
        "big = ('x'):rep(1000000)\nfunction sysCall_init() me = sim.getObject('.') n = 0 end\n\
         function sysCall_actuation()\n  for i = 1, 100 do n = n + 1\n{body}\nend\nend"
    );
    let place = TestFolder::scene(&format!("budget.memory_mb = 8\n{}", watcher("d", &script)));
    place.run(&["--steps", "3"])
}

#[track_caller]
fn refused(body: &str, words: &str) {
    let errors = greedy(body).errors();
    let text = errors.iter().map(|e| e["message"].as_str().unwrap()).collect::<Vec<_>>().join("\n");
    assert!(text.contains(words) && text.contains("would exceed 8 MB"), "{text}");
    assert!(errors[0]["line"].is_u64(), "{errors:?}");
}

#[test]
fn values_stored_by_scripts_are_limited() {
    refused("sim.setStringSignal('s' .. n, big)", "signals of the scene");
    refused("sim.writeCustomDataBlock(sim.createDummy(0.01), 'tag', big)", "custom data of the scene");
    refused("sim.writeCustomDataBlock(me, 'tag' .. n, big)", "custom data of the scene");
    refused(
        "d = d or sim.addDrawingObject(sim.drawing_lines, 1, 0, -1, 1000000)\n\
         for k = 1, 1000 do sim.addDrawingObjectItem(d, {n, k, 0, 1, 1, 1}) end",
        "drawings of the scene",
    );
    refused("if n == 1 then tatu.on('a.b', function() end) end tatu.emit('a.b', {text = big})", "events of the scene");
}

#[test]
fn replaced_and_removed_values_free_their_space() {
    for body in [
        "sim.setStringSignal('s', big .. n)",
        "sim.setStringSignal('s' .. n, big) sim.clearStringSignal('s' .. n)",
        "sim.writeCustomDataBlock(me, 'tag', big)",
        "local d = sim.createDummy(0.01) sim.writeCustomDataBlock(d, 'tag', big) sim.removeObjects({d})",
    ] {
        greedy(body).good();
    }
}

#[test]
fn log_lines_beyond_the_limit_are_left_out() {
    let done = greedy("print(big .. n)").good();
    assert!(done.err.len() < 60_000_000, "{} bytes", done.err.len());
    done.reports(&["the log lines of one step exceed 8 MB"]);
}

/// After as many removals as the reference guarantees, an old handle still causes an error and never refers to another
/// object.
#[test]
fn an_old_handle_never_refers_to_another_object() {
    let script = "
        function sysCall_init() old = sim.createDummy(0.01) sim.removeObjects({old}) end
        function sysCall_actuation()
          for i = 1, 3000 do
            local new = sim.createDummy(0.01)
            assert(new ~= old)
            sim.removeObjects({new})
          end
          assert(not sim.isHandle(old))
        end";
    TestFolder::scene(&watcher("d", script)).run(&["--steps", "4"]).good();
}
