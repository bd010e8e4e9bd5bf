//! Tests of opening scenes, in a browser.

use super::drive::ScenePage;
use crate::kit::*;

#[test]
#[cfg_attr(no_browser, ignore = "needs Chromium, and npm at the build")]
fn scenes_are_opened() {
    let place = TestFolder::new();
    let ball =
        "# A ball on its own\nformat = 1\n[[object]]\nkind = \"shape\"\nalias = \"ball\"\nprimitive = \"sphere\"\n";
    place.write("scenes/red_ball.toml", ball);
    let mut shown = ScenePage::of(place, &["open", "--no-browser"]);
    // Without a scene the page lists the scenes in the working folder.
    shown.page.until("document.querySelector('#files button') !== null && document.getElementById('dialog').open");
    assert!(shown.page.text("#files").contains("red ballA ball on its own"));
    shown.page.js(
        "[...document.querySelectorAll('#files button')].find((b) => b.title === 'scenes/red_ball.toml').id = 'ball'",
    );
    shown.page.click_on("#ball");
    shown.until("of('ball') !== undefined && !document.getElementById('dialog').open");
    shown.page.click_on("#gallery");
    shown.page.until("document.getElementById('dialog').open");
    shown.end();
}
