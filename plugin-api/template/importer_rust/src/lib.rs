//! my_plugin: an importer in Rust. It reads text files `.my_plugin` that describe blocks:
//!
//! ```text
//! blocks 1                       the first line
//! # a comment
//! box X Y Z LENGTH WIDTH HEIGHT  a box: its centre and its size, m
//! ball X Y Z DIAMETER
//! ```
//!
//! Build: `tatu plugin build`. Run the demo: `tatu plugin run`. The manual: `cargo doc -p tatu-plugin-api --open`.
#![forbid(unsafe_code)]

use tatu_plugin_api::{safe::*, tatu_plugin};

/// The plugin, which has no data.
struct ThisPlugin;

impl Plugin for ThisPlugin {
    fn start(_: &Host) -> Result<Self> {
        Ok(ThisPlugin)
    }
    fn offer(offer: &mut Offer<Self>) {
        offer.importer::<Blocks>();
    }
}

const FIRST: &str = "blocks 1";

struct Blocks;

/// A block: the name of its form, and its centre and size, m.
#[derive(Debug, PartialEq)]
struct Block {
    form: &'static str,
    at: [f64; 3],
    size: [f64; 3],
}

/// Reads a line; returns `None` if it is empty or a comment.
fn block(line: &str, scale: f64) -> Result<Option<Block>> {
    let mut words = line.split_whitespace();
    let form = match words.next() {
        Some("box") => "box",
        Some("ball") => "ball",
        Some(word) if !word.starts_with('#') => {
            return Err(Fail::argument(format!("expected `box` or `ball`, found `{word}`")));
        }
        _ => return Ok(None),
    };
    let number = |word: &str| word.parse::<f64>().ok().map(|x| scale * x).filter(|x| x.is_finite());
    let numbers: Option<Vec<f64>> = words.map(number).collect();
    let (at, size) = match (form, numbers.as_deref()) {
        ("box", Some(&[x, y, z, length, width, height])) => ([x, y, z], [length, width, height]),
        ("ball", Some(&[x, y, z, diameter])) => ([x, y, z], [diameter; 3]),
        _ => return Err(Fail::argument("expected numbers: `box X Y Z LENGTH WIDTH HEIGHT`, `ball X Y Z DIAMETER`")),
    };
    if size.iter().any(|s| *s <= 0.0) {
        return Err(Fail::argument("a size must be above 0"));
    }
    Ok(Some(Block { form, at, size }))
}

impl Importer for Blocks {
    type Plugin = ThisPlugin;

    const ID: &'static str = "my_plugin";
    const TEXT: &'static str = "Blocks: boxes and balls, one per line.";
    const SUFFIXES: &'static [&'static str] = &[".my_plugin"];

    fn params() -> Vec<Param> {
        vec![
            Param::float("scale")
                .unit("1")
                .range(0.001, 1000.0)
                .default(1.0)
                .text("Factor for all numbers."),
        ]
    }
    fn sniff(head: &[u8]) -> u32 {
        if head.starts_with(FIRST.as_bytes()) { 100 } else { 0 }
    }

    /// Reads a file. Malformed content must lead to an error with a line number, never to a crash.
    fn load(bytes: &[u8], builder: &Builder<'_>, params: &Params<'_>) -> Result {
        let scale = params.f64("scale")?;
        let text = String::from_utf8_lossy(bytes);
        let mut lines = (1..).zip(text.lines());
        if lines.next().is_none_or(|(_, line)| line.trim_end() != FIRST) {
            return Err(Fail::argument("expected the line `blocks 1`").at("", 1));
        }
        let base = builder.object("dummy", None, "blocks")?; // the first object is the base of all others
        for (number, line) in lines {
            let Some(Block { form, at, size }) = block(line, scale).map_err(|e| e.at("", number))? else { continue };
            builder
                .object("shape", Some(base), form)?
                .set("primitive", if form == "ball" { "sphere" } else { form })?
                .set("position", Value::Floats(at.to_vec()))?
                .set("size", Value::Floats(size.to_vec()))?
                .set("respondable", true)?;
        }
        Ok(())
    }
}

tatu_plugin! {
    plugin: ThisPlugin, id: "org.example.my_plugin", name: "my_plugin", version: "0.1.0", licence: "MIT",
}

#[test]
fn lines() {
    let ball = block("ball 1 2 3 0.5 ", 2.0).unwrap().unwrap();
    assert_eq!(ball, Block { form: "ball", at: [2.0, 4.0, 6.0], size: [1.0; 3] });
    assert!(block("# nothing", 1.0).unwrap().is_none() && block("", 1.0).unwrap().is_none());
    assert!(block("ball 1 2 3", 1.0).is_err() && block("ball 1 2 3 0", 1.0).is_err() && block("cone 1", 1.0).is_err());
}
