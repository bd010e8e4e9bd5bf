//! What a script saves of its state: the value that its callback `savestate` returns.
//!
//! The state of the interpreter itself cannot be saved.

use std::time::Duration;

use tatu_plugin_api::safe::*;

use crate::{
    exchange::{Answer, ask},
    message::{self, to},
    script::PythonScript,
    wire::{self, Malformed, Reader},
};

/// Version of the saved data.
pub(crate) const VERSION: u32 = 1;
/// How long the callbacks for saving and restoring may take.
const TIME: Duration = Duration::from_secs(10);

/// Saves the state of the script: a hash of its text, the callables that the host knows by number, and the value that
/// the script returned.
pub(crate) fn save(script: &PythonScript) -> Result<Vec<u8>> {
    let Answer::Done(answer) = ask(script, message::begin(to::SAVE), Some(TIME))? else {
        return Err(Fail::unsupported("a callback that saves the state of a script must not wait"));
    };
    let source = script.source.borrow();
    let mut out = hash(&source.text).to_le_bytes().to_vec();
    out.extend((source.callables.len() as u32).to_le_bytes());
    for (how, name) in &source.callables {
        out.push(*how as u8);
        wire::write_text(&mut out, name);
    }
    out.extend(answer.body);
    Ok(out)
}

/// What was saved, except the script's own value.
struct Saved<'a> {
    hash: u64,
    callables: Vec<(u32, Box<[u8]>)>,
    value: &'a [u8],
}

fn read(bytes: &[u8]) -> Result<Saved<'_>, Malformed> {
    let mut reader = Reader::new(bytes, 0);
    let hash = reader.u64()?;
    let mut callables = Vec::new();
    for _ in 0..reader.u32()? {
        callables.push((reader.u8()?.into(), reader.bytes()?.into()));
    }
    Ok(Saved { hash, callables, value: reader.rest() })
}

/// Passes saved data to the script. Before the script has run, its text must be the one that saved the data.
pub(crate) fn restore(script: &PythonScript, bytes: &[u8], version: u32) -> Result<()> {
    if version != VERSION {
        return Err(Fail::unsupported(format!("the saved state has the unknown version {version}")));
    }
    let saved = read(bytes).map_err(|Malformed| Fail::argument("the saved state of the script is damaged"))?;
    let same = saved.hash == hash(&script.source.borrow().text);
    let mut question = message::begin(to::RESTORE);
    question.push(u8::from(same));
    question.extend_from_slice(saved.value);
    match ask(script, question, Some(TIME))? {
        Answer::Done(_) => {
            let callables = &mut script.source.borrow_mut().callables;
            if callables.is_empty() {
                *callables = saved.callables;
            }
            Ok(())
        }
        Answer::Waiting => Err(Fail::unsupported("a callback that restores the state of a script must not wait")),
    }
}

/// FNV-1a, which is the same in every version of the program.
fn hash(text: &[u8]) -> u64 {
    text.iter().fold(0xCBF2_9CE4_8422_2325, |hash, byte| (hash ^ u64::from(*byte)).wrapping_mul(0x100_0000_01B3))
}
