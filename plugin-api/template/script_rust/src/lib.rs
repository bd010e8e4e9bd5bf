//! my_plugin: a script language in Rust. Each line of a script names a callback or a function, and a command with
//! arguments:
//!
//! ```text
//! init        sim.setInt32Signal ready 1
//! actuation   my_robot.go 0.5
//! ```
//!
//! A line runs when its callback or function is called. Arguments are numbers or words.
//!
//! Build: `tatu plugin build`. Run the demo: `tatu plugin run`. The manual: `cargo doc -p tatu-plugin-api --open`.
#![forbid(unsafe_code)]

use std::cell::RefCell;

use tatu_plugin_api::{abi::TATU_ERR_SCRIPT, safe::*, tatu_plugin};

/// The plugin, which has no data.
struct ThisPlugin;

impl Plugin for ThisPlugin {
    fn start(_: &Host) -> Result<Self> {
        Ok(ThisPlugin)
    }
    fn offer(offer: &mut Offer<Self>) {
        offer.language::<Script>();
    }
}

/// A line: the name of a callback or function, and the command that it calls with these arguments.
#[derive(Clone)]
struct Line {
    when: String,
    command: String,
    args: Vec<Value>,
}

/// A script, whose only state is its text.
#[derive(Default)]
struct Script {
    text: RefCell<Vec<u8>>,
    /// One entry per line of the text; `None` for empty lines and comments.
    lines: RefCell<Vec<Option<Line>>>,
}

/// Converts a word to a number if possible, otherwise to a text.
fn value(word: &str) -> Value {
    let int = word.parse::<i64>().map(Value::Int);
    int.or_else(|_| word.parse::<f64>().map(Value::Float)).unwrap_or_else(|_| Value::text(word))
}

fn line(text: &str) -> Result<Option<Line>> {
    let mut words = text.split_whitespace();
    match (words.next(), words.next()) {
        (None, _) => Ok(None),
        (Some(when), _) if when.starts_with('#') => Ok(None),
        (Some(_), None) => Err(Fail::with_code(TATU_ERR_SCRIPT, "expected a command after the name")),
        (Some(when), Some(command)) => {
            Ok(Some(Line { when: when.into(), command: command.into(), args: words.map(value).collect() }))
        }
    }
}

impl Language for Script {
    type Plugin = ThisPlugin;

    const ID: &'static str = "my_plugin";
    const TEXT: &'static str = "Lines that name a callback and a command to call in it.";
    const SUFFIXES: &'static [&'static str] = &[".my_plugin"];

    fn create(_: &World<'_>, _: Instance) -> Result<Self> {
        Ok(Script::default())
    }

    /// Stores the text, and checks that each line has a command.
    fn load(&self, text: &[u8], chunk: &str, _: &str) -> Result<String> {
        let all = String::from_utf8_lossy(text);
        let lines = (1..).zip(all.lines()).map(|(number, text)| line(text).map_err(|e| e.at(chunk, number)));
        *self.lines.borrow_mut() = lines.collect::<Result<_>>()?;
        *self.text.borrow_mut() = text.to_vec();
        Ok("1".into())
    }

    /// Returns the number of the first line that begins with this name, or 0.
    fn find(&self, _: u32, name: &[u8]) -> u32 {
        let lines = self.lines.borrow();
        let first = lines.iter().position(|l| l.as_ref().is_some_and(|l| l.when.as_bytes() == name));
        first.map_or(0, |i| i as u32 + 1)
    }

    /// Runs the lines that begin with the same name as line `callable`, each once, so no limit is needed.
    fn call(&self, callable: u32, frame: &mut Frame<'_>, _: Budget, used: &mut u64) -> Result<Flow> {
        let lines = self.lines.borrow().clone(); // a command may call the script again
        let when = lines.get(callable as usize - 1).cloned().flatten().map(|l| l.when);
        for (number, line) in (1..).zip(&lines) {
            let Some(line) = line.as_ref().filter(|l| Some(&l.when) == when.as_ref()) else { continue };
            frame.world().call_command(&line.command, &line.args).map_err(|e| e.at("", number))?;
            *used += 1;
        }
        Ok(Flow::Done)
    }

    // Snapshots: the only state of a script is its text, which must be the same when it is restored.
    const STATE_VERSION: u32 = 1;
    fn save(&self) -> Result<Vec<u8>> {
        Ok(self.text.borrow().clone())
    }
    fn restore(&self, bytes: &[u8], version: u32) -> Result<()> {
        let same = version == Self::STATE_VERSION && *self.text.borrow() == bytes;
        if same { Ok(()) } else { Err(Fail::unsupported("the text of the script has changed since the snapshot")) }
    }

    // Scripts of this language cannot wait, and cannot pass functions.
    fn resume(&self, _: u64, _: Option<Fail>, _: &mut Frame<'_>, _: Budget, _: &mut u64) -> Result<Flow> {
        Err(Fail::unsupported("a script of my_plugin cannot wait"))
    }
    fn keep_func(&self, _: u32) -> u32 {
        0
    }
    fn drop_func(&self, _: u32) {}
    fn call_func(&self, _: u32, _: &mut Frame<'_>, _: Budget, _: &mut u64) -> Result<Flow> {
        Err(Fail::unsupported("a script of my_plugin has no functions that can be retained"))
    }
}

tatu_plugin! {
    plugin: ThisPlugin, id: "org.example.my_plugin", name: "my_plugin", version: "0.1.0", licence: "MIT",
}
