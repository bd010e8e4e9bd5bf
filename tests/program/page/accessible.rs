//! Tests of accessibility: the information for screen readers, and those rules of WCAG that a program can check.

use serde_json::{Value, json};

use super::{drive::ScenePage, program::ROBOT};
use crate::kit::*;

/// A scene with a block on a floor.
const SCENE: &str = "[[object]]\nkind = \"shape\"\nalias = \"floor\"\nprimitive = \"plane\"\nrespondable = true\n\
    [[object]]\nkind = \"shape\"\nalias = \"block\"\nsize_m = [0.2, 0.2, 0.2]\nposition_m = [0.0, 0.0, 0.1]\n";

/// Checks the visible page against the rules of WCAG 2.2, levels A and AA, that axe-core implements.
fn check(shown: &mut ScenePage, what: &str) {
    let found = shown
        .page
        .js("axe.run(document, { runOnly: ['wcag2a', 'wcag2aa', 'wcag21a', 'wcag21aa', 'wcag22aa'] }).then((r) => \
         r.violations.map((v) => v.id + ': ' + v.nodes.map((n) => n.html.slice(0, 160)).join(' | ')))");
    assert_eq!(found, json!([]), "{what}");
}

#[test]
#[cfg_attr(no_browser, ignore = "needs Chromium, and npm at the build")]
fn no_panel_breaks_a_rule_of_wcag() {
    let axe = std::fs::read_to_string(env!("TATU_AXE")).expect("axe-core, installed by npm for the build");
    for (scheme, language, new) in [("light", "en", "New"), ("dark", "pt", "Nova")] {
        let mut shown =
            ScenePage::of(TestFolder::new(), &["open", root().join(ROBOT).to_str().unwrap(), "--no-browser"]);
        let features = json!({ "features": [{ "name": "prefers-color-scheme", "value": scheme }] });
        shown.page.send("Emulation.setEmulatedMedia", features);
        if language != "en" {
            shown.page.until("document.readyState === 'complete'");
            shown.page.js(&format!("localStorage.setItem('tatu language', {language:?}); location.reload()"));
        }
        shown.page.until(&format!("document.documentElement?.lang === {language:?}"));
        assert_eq!(shown.page.text("#new .words"), new);
        shown.page.js(&format!("{axe}; true"));
        shown.until_shown("Pioneer_p3dx");
        check(&mut shown, "the page");
        shown.ask("store.select(of('Pioneer_p3dx').id)");
        shown.page.until("document.querySelectorAll('#rows .row').length > 20");
        check(&mut shown, "properties");
        shown.page.js("document.querySelector('.row[data-key=\"object.position\"] .chart').click()");
        shown.ask("import('tatu/windows/open_windows').then((p) => p.openWindow('sensors', {}))");
        shown.page.until("document.querySelectorAll('.pane').length === 2");
        check(&mut shown, "windows");
        shown.page.click_on("#windows");
        check(&mut shown, "the menu of windows");
        shown.page.key("Escape", 27);
        shown.page.js("document.querySelectorAll('.pane .title button').forEach((b) => b.click())");
        shown.page.click_on("#overlays");
        shown.page.click_on("#more-output");
        check(&mut shown, "overlays and output");
        shown.page.click_on("#add");
        shown.page.until("document.querySelectorAll('#palette .entry').length > 10");
        check(&mut shown, "the palette");
        shown.page.click_on("#exercise");
        shown.page.until("document.querySelector('dialog.question') !== null");
        check(&mut shown, "a dialog");
        shown.answer("Cancel");
        shown.page.click_on("#gallery");
        shown.page.until("document.querySelectorAll('#files li').length > 5");
        check(&mut shown, "the gallery");
        shown.end();
    }
}

/// The object tree, its items and the active item are exposed to screen readers.
#[test]
#[cfg_attr(no_browser, ignore = "needs Chromium, and npm at the build")]
fn the_tree_is_exposed_to_screen_readers() {
    let mut shown = ScenePage::new(SCENE);
    shown.until_shown("block");
    shown.ask("store.select(of('block').id)");
    shown.page.js("document.getElementById('tree').focus()");
    shown.page.send("Accessibility.enable", json!({}));
    let tree = shown.page.send("Accessibility.getFullAXTree", json!({}));
    let nodes = tree["nodes"].as_array().unwrap();
    let named = |node: &Value, role: &str, name: &str| node["role"]["value"] == role && node["name"]["value"] == name;
    assert!(nodes.iter().any(|n| named(n, "tree", "Scene")));
    let item = nodes.iter().find(|n| named(n, "treeitem", "block")).expect("the block is a tree item");
    assert!(
        item["properties"].as_array().unwrap().iter().any(|p| p["name"] == "selected" && p["value"]["value"] == true)
    );
    let buttons = nodes.iter().filter(|n| n["role"]["value"] == "button" && n["ignored"] == false);
    for button in buttons {
        let name = button["name"]["value"].as_str().unwrap_or("");
        assert!(name.chars().any(char::is_alphabetic), "a button has no name with letters: {button}");
    }
    let active =
        "document.getElementById(document.getElementById('tree').getAttribute('aria-activedescendant')).textContent";
    assert!(shown.page.js(active).as_str().unwrap().contains("block"));
    shown.end();
}
