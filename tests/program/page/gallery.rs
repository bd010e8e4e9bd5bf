//! Tests of the gallery: the user's scenes, those that come with the program, and recent ones.

use serde_json::{Value, json};
use tungstenite::Message;

use super::program::{PageServer, next};
use crate::kit::{
    browser::{BrowserPage, browser},
    *,
};

/// The path of a scene that comes with the program, relative to the repository.
const BUILT_IN_SCENE: &str = "scenes/first/pioneer_avoids_walls.toml";

/// Creates a folder with a scene of the user. The program stores its state in the subfolder `state`.
fn place() -> TestFolder {
    let place = TestFolder::new();
    place.write("project/scenes/mine.toml", "# A ball.\n# Try: nothing.\nformat = 1\n");
    place.write("project/elsewhere/other.toml", "format = 1\n");
    place
}

fn served(place: &TestFolder) -> PageServer {
    PageServer::with_state(&place.path().join("project"), &["open", "--no-browser"], &place.path().join("state"))
}

#[test]
fn scenes_of_the_program_open_from_any_folder() {
    let place = place();
    let served = served(&place);
    let mut socket = served.socket();
    let look = next(&mut socket, "hello")["look"].as_str().unwrap().to_owned();
    let mut say = |message: Value, key: &str| {
        socket.send(Message::text(message.to_string())).unwrap();
        next(&mut socket, key)
    };
    let list = say(json!({ "type": "files" }), "files");
    assert_eq!(list["folder"], "project");
    let files = list["files"].as_array().unwrap();
    assert_eq!(
        files[0],
        json!({ "in": "own", "file": "scenes/mine.toml", "about": "A ball.", "try": "nothing.", "picture": null })
    );
    assert!(files[1..].iter().all(|f| f["in"] == "program"), "{list}");
    let of = |end: &str| files.iter().find(|f| f["file"].as_str().unwrap().ends_with(end));
    let card = of(BUILT_IN_SCENE).unwrap();
    assert!(card["try"].as_str().unwrap().starts_with("press Play") && card["picture"].is_string(), "{card}");
    assert!(of("models/manta/demo.toml").is_some() && of("model.toml").is_none());
    // Other scenes outside of the run's folders are not opened.
    let other = place.path().join("state/other.toml");
    place.write("state/other.toml", "format = 1\n");
    let up = format!("{}/../../state/other.toml", root().join("scenes").display());
    for bad in [other.to_str().unwrap(), &up, "../state/other.toml"] {
        assert!(say(json!({ "type": "open", "file": bad, "id": 1 }), "error")["error"].is_string(), "{bad}");
    }
    let opened = say(json!({ "type": "open", "file": card["file"], "id": 2 }), "scene");
    assert_eq!(opened["file"], card["file"]);
    assert!(opened["objects"].as_array().unwrap().len() > 5);
    // The scene is now listed as recent, but not for viewers.
    let list = say(json!({ "type": "files" }), "files");
    assert_eq!((&list["files"][0]["in"], &list["files"][0]["file"]), (&json!("recent"), &card["file"]));
    let mut eye = tungstenite::connect(look.replace("http", "ws").replace("/?", "/ws?")).unwrap().0;
    eye.send(Message::text(json!({ "type": "files" }).to_string())).unwrap();
    assert!(next(&mut eye, "files")["files"].as_array().unwrap().iter().all(|f| f["in"] != "recent"));
    eye.send(Message::text(json!({ "type": "open", "file": card["file"], "id": 1 }).to_string())).unwrap();
    assert!(next(&mut eye, "error")["error"].as_str().unwrap().contains("may only view"));
    // A recent scene can be opened from any folder.
    drop(served);
    place.write("apart/.keep", "");
    let served = PageServer::with_state(
        &place.path().join("apart"),
        &["open", "../project/elsewhere/other.toml", "--no-browser"],
        &place.path().join("state"),
    );
    let mut socket = served.socket();
    next(&mut socket, "scene");
    let mut say = |message: Value, key: &str| {
        socket.send(Message::text(message.to_string())).unwrap();
        next(&mut socket, key)
    };
    let list = say(json!({ "type": "files" }), "files");
    let recent = list["files"][0]["file"].as_str().unwrap().to_owned();
    assert!(recent.ends_with("elsewhere/other.toml") && list["files"][1]["file"] == card["file"], "{list}");
    assert_eq!(say(json!({ "type": "open", "file": recent, "id": 3 }), "result")["results"], json!([]));
}

#[test]
#[cfg_attr(no_browser, ignore = "needs Chromium, and npm at the build")]
fn a_scene_is_found_opened_and_pictured() {
    let place = place();
    let served = served(&place);
    let mut page = BrowserPage::open(&browser(), &served.url);
    let shown = "[...document.querySelectorAll('#files .scene')].filter((b) => b.offsetParent)";
    page.until(&format!("document.getElementById('dialog')?.open && {shown}.length > 15"));
    let headings = "[...document.querySelectorAll('#files h3')].map((h) => h.textContent)";
    let expected = ["Yours: project", "Course", "First steps", "Learning", "Showcase", "Models"];
    assert_eq!(page.js(headings).as_array().unwrap()[..6], expected.map(|name| json!(name)));
    let find = |text: &str| {
        format!("(() => {{ const f = document.getElementById('find-scene'); f.value = {text:?}; f.oninput(); }})()")
    };
    page.js(&find("no such scene"));
    assert_eq!(page.js(&format!("{shown}.length")), 0);
    assert_eq!(page.text("#no-scene"), "No scene matches the search.");
    page.js(&find("AVOIDS walls"));
    assert_eq!(page.js(&format!("{shown}.length")), 1);
    assert!(page.js(&format!("{shown}[0].textContent")).as_str().unwrap().contains("Try: press Play"));
    page.js(&format!("{shown}[0].click()"));
    page.until("document.getElementById('name').textContent === 'pioneer_avoids_walls.toml'");
    // Once the page has drawn the scene, the card shows the picture that the page has saved, not the one next to the
    // scene file.
    page.until("import('tatu/view/renderer').then((v) => v.drawn > 0)");
    page.click("#gallery");
    page.until(&format!("{headings}[0] === 'Recent'"));
    let mut socket = served.socket();
    socket.send(Message::text(json!({ "type": "files" }).to_string())).unwrap();
    let card = next(&mut socket, "files")["files"][0].clone();
    let beside = std::fs::read(root().join(BUILT_IN_SCENE).with_extension("png")).unwrap();
    use base64::{Engine, engine::general_purpose::STANDARD};
    let picture = STANDARD.decode(card["picture"].as_str().unwrap()).unwrap();
    assert_ne!(picture, beside);
    assert_eq!(picture[16..24], [0, 0, 0, 240, 0, 0, 0, 150], "width and height");
    assert!(page.wrong.is_empty(), "{:#?}", page.wrong);
}
