//! Tests of objects that scripts remove while physics runs: their contacts are no longer reported.

use crate::kit::*;

/// Returns boxes that fall on each other and on a floor.
fn boxes() -> String {
    let more = "dynamic = true\nrespondable = true";
    (0..8)
        .map(|i| cuboid(&format!("b{i}"), [0.1; 3], [0.02 * f64::from(i % 2), 0.0, 0.06 + 0.11 * f64::from(i)], more))
        .collect()
}

/// Returns a script that removes the boxes one by one in a callback and creates new objects, which reuse their slots.
fn remover(callback: &str, more: &str) -> String {
    format!(
        "function sysCall_init()\n  boxes = {{}}\n  for i = 0, 7 do boxes[#boxes + 1] = sim.getObject('/b' .. i) end\n  calls = 0\nend\n\
         function {callback}(data)\n  calls = calls + 1\n  if calls % 3 == 0 and #boxes > 0 then\n    pcall(sim.removeObjects, {{table.remove(boxes, 1)}})\n    if calls % 2 == 0 then sim.createDummy(0.01) end\n  end\nend\n{more}"
    )
}

#[test]
fn removed_objects_have_no_contacts() {
    let contact = "function sysCall_contact(data) seen = (seen or 0) + 1 end";
    for (callback, more) in [
        ("sysCall_dyn", ""),
        ("sysCall_dyn", contact),
        ("sysCall_contact", ""),
        ("sysCall_joint", contact),
        ("sysCall_actuation", contact),
        ("sysCall_sensing", contact),
    ] {
        let place = TestFolder::scene(&format!("{FLOOR}{}{}", boxes(), watcher("w", &remover(callback, more))));
        let done = place.run(&["--seconds", "2", "--trace", "t.jsonl"]);
        assert!(done.code == 0 && !done.err.contains("panicked"), "{callback}: exit {}\n{}", done.code, done.err);
    }
    // An add-on removes the boxes while a script of the scene receives contacts.
    let place = TestFolder::scene(&format!("{FLOOR}{}{}", boxes(), watcher("w", contact)));
    place.write("addons/remove.lua", &remover("sysCall_dyn", contact));
    let done = place.run(&["--seconds", "2", "--addon", "addons/remove.lua"]);
    assert!(done.code == 0 && !done.err.contains("panicked"), "exit {}\n{}", done.code, done.err);
}
