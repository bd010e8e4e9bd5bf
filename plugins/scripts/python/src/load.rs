//! Loads a script: starts its process, and sends the runtime and the text.

use std::{path::Path, time::Duration};

use tatu_plugin_api::safe::*;

use crate::{
    exchange::{Answer, ask},
    message::{self, to},
    process::Child,
    script::{PERMISSION, PythonScript, Source},
    wire::{self, Malformed, Reader},
};

/// How long the interpreter may take to start and to compile the text.
const START: Duration = Duration::from_secs(60);

/// The modules of the runtime, in the order in which they are loaded.
const RUNTIME: &[(&str, &str)] = &[
    ("wire", include_str!("../runtime/wire.py")),
    ("link", include_str!("../runtime/link.py")),
    ("limits", include_str!("../runtime/limits.py")),
    ("output", include_str!("../runtime/output.py")),
    ("threads", include_str!("../runtime/threads.py")),
    ("api", include_str!("../runtime/api.py")),
    ("repeat", include_str!("../runtime/repeat.py")),
    ("source", include_str!("../runtime/source.py")),
    ("errors", include_str!("../runtime/errors.py")),
    ("script", include_str!("../runtime/script.py")),
    ("main", include_str!("../runtime/main.py")),
];

/// Starts the process of a script and loads its text. Returns its dialect.
pub(crate) fn load(script: &PythonScript, text: &[u8], chunk: &str, dialect: &str) -> Result<String> {
    let allowed = script.property(0, "scene.allow");
    let allows = |word: &str| allowed.split(',').any(|a| a == word);
    if !allows(PERMISSION) {
        // A host that does not know the permissions of languages would load the script.
        return Err(Fail::unsupported("Python scripts can do anything that your account can")
            .help("if you trust the scene, allow its scripts with `--allow python`"));
    }
    let folder = script.scene_folder();
    let mut child = Child::start(&script.settings, folder.as_deref(), script.instance.seed)?;
    child.channel.queue(&runtime());
    *script.child.borrow_mut() = Some(child);
    *script.source.borrow_mut() = Source { text: text.to_vec(), ..Source::default() };
    let question = description(script, text, chunk, dialect, folder.as_deref(), allows("exec"));
    match ask(script, question, Some(START))? {
        Answer::Done(answer) => read_loaded(script, &answer.body).map_err(|Malformed| not_loaded()),
        Answer::Waiting => Err(not_loaded()),
    }
}

fn not_loaded() -> Fail {
    Fail::new("the process of the script did not load it")
}

/// Reads the dialect, and the orders in which scripts are called.
fn read_loaded(script: &PythonScript, body: &[u8]) -> Result<String, Malformed> {
    let mut reader = Reader::new(body, script.instance.id);
    let dialect = reader.text()?;
    for _ in 0..reader.u32()? {
        let (since, order) = (reader.text()?, reader.text()?);
        script.source.borrow_mut().orders.push((since, order));
    }
    Ok(dialect)
}

/// Returns the runtime as the first message: pairs of name and text.
fn runtime() -> Vec<u8> {
    let mut out = message::begin(0);
    for (name, text) in RUNTIME {
        wire::write_text(&mut out, name.as_bytes());
        wire::write_text(&mut out, text.as_bytes());
    }
    message::complete(&mut out);
    out
}

/// Returns the message that loads the script.
fn description(
    script: &PythonScript,
    text: &[u8],
    chunk: &str,
    dialect: &str,
    folder: Option<&Path>,
    exec: bool,
) -> Vec<u8> {
    let mut out = message::begin(to::LOAD);
    let folder = folder.map_or(String::new(), |f| f.to_string_lossy().into_owned());
    let kind = script.property(script.instance.owner, "script.kind");
    for part in [text, chunk.as_bytes(), dialect.as_bytes(), kind.as_bytes(), folder.as_bytes()] {
        wire::write_text(&mut out, part);
    }
    out.extend(script.instance.seed.to_le_bytes());
    out.push(u8::from(exec));
    let preludes: Vec<&[u8]> = script
        .commands
        .preludes(script.world_ref())
        .filter_map(|(module, text)| module.is_empty().then_some(text))
        .collect();
    out.extend((preludes.len() as u32).to_le_bytes());
    preludes.iter().for_each(|text| wire::write_text(&mut out, text));
    out
}
