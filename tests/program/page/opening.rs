//! Tests of the gallery and of the list of models, in a browser.

use super::drive::Shown;
use crate::kit::*;

#[test]
#[cfg_attr(no_browser, ignore = "needs Chromium, and npm at the build")]
fn scenes_are_opened_and_models_added() {
    let place = Place::new();
    let ball =
        "# A ball on its own\nformat = 1\n[[object]]\nkind = \"shape\"\nalias = \"ball\"\nprimitive = \"sphere\"\n";
    place.write("scenes/red_ball.toml", ball);
    let mut shown = Shown::of(place, &["open", "--no-browser"]);
    // Without a scene the page offers those that are here.
    shown.page.until("document.querySelector('#files button') !== null && document.getElementById('dialog').open");
    assert!(shown.page.text("#files").contains("red ballA ball on its own"));
    shown.page.js(
        "[...document.querySelectorAll('#files button')].find((b) => b.title === 'scenes/red_ball.toml').id = 'ball'",
    );
    shown.page.click_on("#ball");
    shown.until("of('ball') !== undefined && !document.getElementById('dialog').open");
    shown.page.click_on("#add-model");
    shown.page.until("document.getElementById('models-dialog').open");
    let pioneer =
        "[...document.querySelectorAll('#models button')].find((b) => b.textContent.includes('pioneer_p3dx'))";
    shown.page.until(&format!("{pioneer} !== undefined"));
    shown.page.js(&format!("{pioneer}.id = 'pioneer'"));
    shown.page.click_on("#pioneer");
    shown.until("of('Pioneer_p3dx') !== undefined && store.selected() === of('Pioneer_p3dx').id");
    shown.until("!document.getElementById('unsaved').hidden");
    shown.page.click_on("#gallery");
    shown.page.until("document.getElementById('dialog').open");
    shown.end();
}
