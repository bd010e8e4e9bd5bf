//! Makes the pictures of the page in the guide.

use super::program::Served;
use crate::{
    kit::browser::{Page, browser},
    kit::*,
};

#[test]
#[ignore = "makes the picture of the guide: docs/pictures.sh"]
fn picture_for_the_guide() {
    let served = Served::new(root(), &["open", "scenes/first/pioneer_looks_around.toml", "--no-browser"]);
    let mut page = Page::open(&browser(), &format!("{}#select=eye&script&play", served.url));
    page.until("(document.querySelector('.cm-content')?.textContent ?? '').includes('cruise')");
    std::fs::write(root().join("docs/images/page.png"), page.picture([1180, 680])).unwrap();
}

#[test]
#[ignore = "makes the picture of the guide: docs/pictures.sh"]
fn picture_of_a_window() {
    let served = Served::new(root(), &["open", "plugins/commands/simui/demo.toml", "--no-browser"]);
    let mut page = Page::open(&browser(), &format!("{}#select=Pioneer_p3dx&play", served.url));
    page.until("(document.getElementById('time')?.textContent ?? '').includes(':06.')");
    page.click("#pause");
    page.click("#fit");
    // The robot is next to the window, not behind it.
    page.js("import('tatu/view').then((v) => { v.camera.setViewOffset(100, 100, -26, 0, 100, 100); v.redraw(); })");
    std::fs::write(root().join("docs/images/window.png"), page.picture([1180, 620])).unwrap();
}
