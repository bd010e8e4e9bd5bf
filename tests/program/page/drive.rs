//! Helpers for tests in a browser: a page that shows a scene, and functions that query both.

use serde_json::Value;

use super::program::PageServer;
use crate::{
    kit::browser::{BrowserPage, browser},
    kit::*,
};

/// A program that serves a scene, and the page that shows the scene.
pub struct ScenePage {
    pub page: BrowserPage,
    pub served: PageServer,
    place: TestFolder,
}

impl ScenePage {
    /// Shows a scene whose text starts within the table `[scene]`.
    pub fn new(scene: &str) -> ScenePage {
        ScenePage::of(TestFolder::scene(scene), &["open", "scene.toml", "--no-browser"])
    }
    /// Starts the program in a folder, and shows the scene that it opens.
    pub fn of(place: TestFolder, args: &[&str]) -> ScenePage {
        let served = PageServer::new(place.path(), args);
        let mut page = BrowserPage::open(&browser(), &served.url);
        page.until("document.readyState === 'complete' && (document.getElementById('name')?.textContent ?? '') !== ''");
        ScenePage { page, served, place }
    }
    /// Returns the value of a JavaScript expression, which can use the modules `net`, `store`, `objects`, `view` and
    /// `three`, and `of(alias)`, which returns an object of the scene.
    pub fn ask(&mut self, expression: &str) -> Value {
        self.page.js(&asking(expression))
    }
    /// Waits until an expression, as in [`ScenePage::ask`], is true.
    pub fn until(&mut self, expression: &str) {
        self.page.until(&asking(expression));
    }
    /// Waits until an object is drawn and the camera is where the page puts it for a new scene. Before, the camera is at
    /// x = 3 but for rounding, and positions on the screen would be those of another view.
    pub fn until_shown(&mut self, alias: &str) {
        self.until(&format!("of({alias:?}) && view.drawn > 0 && Math.abs(view.camera.position.x - 3) > 1e-6"));
    }
    /// Returns the position on the page, in pixels, of a point in the frame of an object.
    // The camera moves to a new scene in the frame after the scene has changed.
    pub fn pixel(&mut self, alias: &str, point: [f64; 3]) -> [f64; 2] {
        let found = self.ask(&format!(
            "(async () => {{ const frame = () => new Promise(requestAnimationFrame); await frame(); await frame(); \
             const g = objects.groups.get(of({alias:?}).id); g.updateWorldMatrix(true, false); \
             view.camera.updateMatrixWorld(); \
             const p = g.localToWorld(new three.Vector3(...{point:?})).project(view.camera); \
             const b = view.renderer.domElement.getBoundingClientRect(); \
             return [b.left + (p.x + 1) / 2 * b.width, b.top + (1 - p.y) / 2 * b.height]; }})()"
        ));
        [0, 1].map(|i| found[i].as_f64().unwrap())
    }
    /// Presses a button of the open dialog.
    pub fn answer(&mut self, name: &str) {
        let button =
            format!("[...document.querySelectorAll('dialog.question button')].find((b) => b.value === {name:?})");
        self.page.until(&format!("{button} !== undefined"));
        self.page.js(&format!("{button}.id = 'answer'"));
        self.page.click_on("#answer");
        self.page.until("document.querySelector('dialog.question') === null");
    }
    /// Presses a key with Ctrl.
    pub fn ctrl(&mut self, key: &str, code: u32) {
        for kind in ["rawKeyDown", "keyUp"] {
            self.page.key_event(kind, key, code, 2);
        }
    }
    /// Returns the CSS selector of the row of an object in the tree.
    pub fn row(&mut self, alias: &str) -> String {
        format!("#tree [data-id='{}']", self.ask(&format!("of({alias:?}).id")))
    }
    /// Returns the working folder of the program.
    pub fn folder(&self) -> &std::path::Path {
        self.place.path()
    }
    /// Checks that the page reported no errors.
    pub fn end(self) {
        assert!(self.page.wrong.is_empty(), "{:#?}", self.page.wrong);
    }
}

fn asking(expression: &str) -> String {
    format!(
        "(async () => {{ const modules = ['tatu/net/connection', 'tatu/scene/store', 'tatu/view/objects', \
         'tatu/view/renderer', 'three']; \
         const [net, store, objects, view, three] = await Promise.all(modules.map((m) => import(m))); \
         const of = (alias) => [...store.scene.objects.values()].find((o) => o.alias === alias); \
         const get = async (alias, key) => (await net.call('tatu.get', of(alias).id, key))[0]; \
         return await ({expression}); }})()"
    )
}
