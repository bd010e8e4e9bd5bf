//! Tests of models, importers and script languages.

use std::path::Path;

use tatu_core::{beams::bounds, errors::Error, plugins::border, scene::visible_parts};
use tatu_plugin_api::abi::*;

use super::{
    finding::{self, error, note},
    stage,
    subject::TestedPlugin,
};

/// Tolerance for the height of a model's lowest point above or below the floor, m.
const FLOOR_TOLERANCE_M: f64 = 0.003;

/// Runs the test `models`.
pub fn models(file: &Path) -> Result<(), Error> {
    let subject = TestedPlugin::load(file)?;
    for m in subject.registry.model_offers.models.iter().filter(|m| m.plugin == subject.plugin) {
        let place = format!("model `{}`", m.id);
        let Some(lines) = stage::required(&m.params) else {
            note(&place, "it is not tested: a required parameter cannot be set in a scene");
            continue;
        };
        finding::report_activity(&place, "when it is built");
        let scene = format!("format = 1\n[[model]]\nmodel = \"{}\"\n{lines}", m.id);
        let world = match subject.world(&scene, &[], 1) {
            Ok(world) => world,
            Err(e) => {
                error(&place, format!("it cannot be built with its defaults: {}", e.text));
                continue;
            }
        };
        let lowest = world.with_scene(|scene, _| {
            let shapes = scene.slots().filter_map(|(slot, o)| Some((slot, o.shape()?)));
            let parts = shapes.flat_map(|(slot, shape)| {
                visible_parts(shape).into_iter().filter_map(move |p| bounds(&p.form, &(scene.world(slot) * p.pose)))
            });
            parts.map(|[low, _]| low.z).min_by(f64::total_cmp)
        });
        match lowest {
            Some(z) if z < -FLOOR_TOLERANCE_M => {
                let text = format!(
                    "its lowest point is {:.1} mm below the floor z = 0, on which models must stand",
                    -1000.0 * z
                );
                error(&place, text);
            }
            Some(z) if z > FLOOR_TOLERANCE_M => {
                note(&place, format!("its lowest point is {:.1} mm above the floor z = 0", 1000.0 * z))
            }
            _ => {}
        }
        finding::report_activity(&place, "when it runs");
        world.start();
        (0..10).for_each(|_| {
            world.step();
        });
        subject.report_faults(&world);
    }
    Ok(())
}

/// Runs the test `importers`.
pub fn importers(file: &Path) -> Result<(), Error> {
    let subject = TestedPlugin::load(file)?;
    for i in subject.registry.importers.iter().filter(|i| i.plugin == subject.plugin) {
        let place = format!("importer `{}`", i.id);
        let Some(suffix) = i.suffixes.first() else { continue };
        let name = format!("part{suffix}");
        let lines = stage::required(&i.params).unwrap_or_default();
        let scene = format!("format = 1\n[[import]]\nfile = \"{name}\"\n{lines}");
        let mut heads = library_strings(&subject.file);
        heads.retain(|head| subject.registry.sniff(i, head) > 0);
        for (what, bytes) in malformed(&samples(&subject.file, &i.suffixes), &heads) {
            finding::report_activity(&place, format!("when it reads {what}"));
            if let Ok(world) = subject.world(&scene, &[(&name, &bytes)], 1) {
                world.start();
                world.step();
                subject.report_faults(&world);
            }
        }
    }
    Ok(())
}

/// Returns the contents of at most four files with one of these suffixes that are next to the plugin, or in the parent
/// folder, and smaller than 1 MB.
fn samples(plugin: &Path, suffixes: &[String]) -> Vec<Vec<u8>> {
    let folders = plugin.ancestors().skip(1).take(2).filter_map(|f| std::fs::read_dir(f).ok()).flatten();
    let mut files: Vec<_> = folders.filter_map(|e| e.ok().map(|e| e.path())).collect();
    files.retain(|f| suffixes.iter().any(|s| f.to_string_lossy().ends_with(s.as_str())));
    files.sort();
    files.iter().filter_map(|f| std::fs::read(f).ok()).filter(|b| b.len() < 1 << 20).take(4).collect()
}

/// Returns the printable strings in a library, among which is probably the signature of its file format.
fn library_strings(library: &Path) -> Vec<Vec<u8>> {
    let bytes = std::fs::read(library).unwrap_or_default();
    let texts = bytes.split(|b| !(b.is_ascii_graphic() || *b == b' ')).filter(|t| (3..=40).contains(&t.len()));
    let mut all: Vec<Vec<u8>> = texts.map(<[u8]>::to_vec).collect();
    all.sort();
    all.dedup();
    all.truncate(MAX_STRINGS);
    all
}

/// Maximum number of a library's strings that are tried as the beginning of a file.
const MAX_STRINGS: usize = 20_000;

/// Returns malformed contents of files, with descriptions. `heads` are beginnings that the importer recognizes.
fn malformed(samples: &[Vec<u8>], heads: &[Vec<u8>]) -> Vec<(String, Vec<u8>)> {
    let mut out: Vec<(String, Vec<u8>)> = vec![
        ("an empty file".into(), Vec::new()),
        ("64 zero bytes".into(), vec![0; 64]),
        ("4 KB of 0xff".into(), vec![0xff; 4096]),
        ("a line of text".into(), b"not a file of this format\n".to_vec()),
        ("numbers".into(), b"1 2 3\n-1e999 nan 4\n".to_vec()),
        ("brackets 10,000 deep".into(), vec![b'['; 10_000]),
        ("tags".into(), b"<?xml version=\"1.0\"?><a><b></a>".to_vec()),
        ("an object in JSON".into(), b"{\"a\": [1, {\"b\": null}]}".to_vec()),
        ("a line of 1 MB".into(), vec![b'x'; 1 << 20]),
    ];
    let noise =
        |n: u64| (0..n).map(|i| (i.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1) >> 56) as u8).collect();
    out.push(("random bytes".into(), noise(5000)));
    for head in heads.iter().take(4) {
        let name = String::from_utf8_lossy(head).into_owned();
        for rest in
            ["", "\n", "\nx", "\n1 2", "\n1 2 3\n1 2 x\n", "\n\0\n", " 99999999999999999999\n", "\n-1 nan inf\n"]
        {
            out.push((format!("a file that begins with `{name}` and is malformed"), [head, rest.as_bytes()].concat()));
        }
    }
    for sample in samples {
        for part in 1..16 {
            let n = sample.len() * part / 16;
            out.push((format!("the first {n} bytes of a sample"), sample[..n].to_vec()));
            let mut changed = sample.clone();
            if let Some(b) = changed.get_mut(n) {
                *b ^= 0x15;
                out.push((format!("a sample with byte {n} changed"), changed));
            }
        }
    }
    out
}

/// Runs the test `languages`.
pub fn languages(file: &Path) -> Result<(), Error> {
    let subject = TestedPlugin::load(file)?;
    for l in subject.registry.scripting.languages.iter().filter(|l| l.plugin == subject.plugin) {
        let place = format!("language `{}`", l.id);
        let Some(suffix) = l.suffixes.first() else { continue };
        let name = format!("check{suffix}");
        let dialects = dialects(&subject, l);
        for dialect in std::iter::once(String::new()).chain(dialects) {
            for text in ["", "\u{0}\u{1}", "((((", "x: y\n", "end end end", "\u{fffd}"] {
                finding::report_activity(&place, format!("when it loads the text {text:?}"));
                let key = if dialect.is_empty() { String::new() } else { format!(", dialect = {dialect:?}") };
                let scene = format!(
                    "format = 1\n[[object]]\nkind = \"dummy\"\nalias = \"d\"\nscript = {{ file = \"{name}\"{key} }}\n"
                );
                if let Ok(world) = subject.world(&scene, &[(&name, text.as_bytes())], 1) {
                    world.start();
                    (0..3).for_each(|_| {
                        world.step();
                    });
                    world.stop();
                    world.end();
                    subject.report_faults(&world);
                }
            }
        }
    }
    Ok(())
}

/// Returns dialects that a language accepts, taken from its error message about an unknown dialect.
fn dialects(subject: &TestedPlugin, language: &tatu_core::plugins::ScriptLanguage) -> Vec<String> {
    let Some(knows) = language.raw.knows_dialect else { return Vec::new() };
    let me = subject.registry.plugins[subject.plugin].me;
    let ask = |dialect: &str| {
        let mut error = border::ErrorSlot::new();
        let text = border::raw(dialect.as_bytes());
        // SAFETY: the plugin's function `knows_dialect` may be called in any context; the text and the error object are
        // valid during the call.
        let status = unsafe { knows(me, text, error.raw()) };
        (status == TATU_OK, error.text())
    };
    let (_, said) = ask("no such dialect");
    let words = said.split(|c: char| !(c.is_ascii_alphanumeric() || "._-".contains(c))).filter(|w| !w.is_empty());
    let mut all: Vec<String> = words.filter(|w| ask(w).0).map(str::to_owned).collect();
    all.dedup();
    all.truncate(4);
    all
}
