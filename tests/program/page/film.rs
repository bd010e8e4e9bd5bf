//! Tests of films, in a browser.

use std::process::Command;

use serde_json::Value;

use super::program::ROBOT;
use crate::{
    kit::browser::{BrowserPage, browser},
    kit::*,
};

#[test]
#[cfg_attr(no_browser, ignore = "needs Chromium, and npm at the build")]
fn a_film_shows_any_time_of_a_run() {
    let browser = browser();
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name).display().to_string();
    let (film, trace) = (at("film.html"), at("trace.jsonl"));
    let run = |more: &[&str]| {
        let args = [&["run", ROBOT, "--seconds", "20"], more].concat();
        let out = Command::new(env!("CARGO_BIN_EXE_tatu")).current_dir(root()).args(args).output().unwrap();
        let text = String::from_utf8_lossy(&out.stderr).into_owned();
        assert!(out.status.success(), "{text}");
        text.split("hash ").nth(1).unwrap()[..16].to_owned()
    };
    // Recording a film does not change the run.
    assert_eq!(run(&["--html", &film]), run(&["--trace", &trace, "--watch", "/Pioneer_p3dx"]));
    assert!(std::fs::metadata(&film).unwrap().len() < 5 << 20);
    let mut page = BrowserPage::open(&browser, &format!("file://{film}#3"));
    page.until("(document.getElementById('time')?.textContent ?? '').startsWith('3.00 of 20')");
    let lines: Vec<Value> = std::fs::read_to_string(&trace)
        .unwrap()
        .lines()
        .filter_map(|l| serde_json::from_str(l).ok())
        .filter(|l: &Value| l["objects"].is_object())
        .collect();
    for time in [12.5, 0.05, 19.95, 7.0] {
        page.js(&format!(
            "(() => {{ const s = document.getElementById('slider'); s.value = {time}; s.oninput(); }})()"
        ));
        let seen = page.js(
            "Promise.all([import('tatu/view/objects'), import('tatu/scene/store')]).then(([o, s]) => \
             o.groups.get([...s.scene.objects.values()].find((x) => x.alias === 'Pioneer_p3dx').id).position.toArray())",
        );
        let then = lines.iter().find(|l| (l["time"].as_f64().unwrap_or(0.0) - time).abs() < 1e-6).unwrap();
        assert_eq!(seen, then["objects"]["/Pioneer_p3dx"]["position"], "{time}");
    }
    page.click("#tree .tool");
    page.until("document.getElementById('editor').textContent.includes('cruise = 3.0')");
    page.click("#play");
    page.until("Number(document.getElementById('slider').value) > 8");
    assert!(page.wrong.is_empty(), "{:#?}", page.wrong);
}

#[test]
#[cfg_attr(no_browser, ignore = "needs Chromium, and npm at the build")]
fn a_film_shows_colors_as_they_were_at_its_time() {
    let place = TestFolder::scene(
        "[[object]]\nkind = \"shape\"\nalias = \"lamp\"\ncolor = [0.0, 0.0, 1.0]\nscript = { text = \"\"\"\n\
         function sysCall_actuation()\n if sim.getSimulationTime() > 1 then\n\
         sim.setShapeColor(sim.getObject('..'), nil, sim.colorcomponent_ambient_diffuse, {1, 0, 0})\n end\nend\"\"\" }\n",
    );
    let args = ["run", "scene.toml", "--seconds", "2", "--html", "film.html"];
    succeed(Command::new(env!("CARGO_BIN_EXE_tatu")).current_dir(place.path()).args(args));
    let mut page = BrowserPage::open(&browser(), &format!("file://{}#0.5", place.path().join("film.html").display()));
    page.until("(document.getElementById('time')?.textContent ?? '').startsWith('0.50 of 2')");
    for (time, color) in [(0.5, "0000ff"), (1.5, "ff0000"), (0.2, "0000ff"), (1.9, "ff0000")] {
        page.js(&format!(
            "(() => {{ const s = document.getElementById('slider'); s.value = {time}; s.oninput(); }})()"
        ));
        let seen = page.js(
            "import('tatu/view/objects').then((o) => [...o.groups.values()].find((g) => g.userData.bodies.length) \
             .userData.bodies[0].material.color.getHexString())",
        );
        assert_eq!(seen, color, "{time}");
    }
    assert!(page.wrong.is_empty(), "{:#?}", page.wrong);
}
