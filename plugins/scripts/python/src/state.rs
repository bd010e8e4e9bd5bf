//! What a script saves of its state: the value that its callback `savestate` returns.
//!
//! The state of the interpreter itself cannot be saved.

use std::time::Duration;

use tatu_plugin_api::safe::*;

use crate::{
    exchange::{Answer, ask},
    message::{self, to},
    script::PythonScript,
};

/// Version of the saved data.
pub(crate) const VERSION: u32 = 1;
/// How long the callbacks for saving and restoring may take.
const TIME: Duration = Duration::from_secs(10);

/// Saves the state of the script: a hash of its text, and the value that the script returned.
pub(crate) fn save(script: &PythonScript) -> Result<Vec<u8>> {
    let Answer::Done(answer) = ask(script, message::begin(to::SAVE), Some(TIME))? else {
        return Err(Fail::unsupported("a callback that saves the state of a script must not wait"));
    };
    let mut out = hash(&script.source.borrow().text).to_le_bytes().to_vec();
    out.extend(answer.body);
    Ok(out)
}

/// Passes saved data to the script. Before the script has run, its text must be the one that saved the data.
pub(crate) fn restore(script: &PythonScript, bytes: &[u8], version: u32) -> Result<()> {
    let Some((saved, body)) = bytes.split_first_chunk::<8>().filter(|_| version == VERSION) else {
        return Err(Fail::unsupported(format!("the saved state has the unknown version {version}")));
    };
    let same = u64::from_le_bytes(*saved) == hash(&script.source.borrow().text);
    let mut question = message::begin(to::RESTORE);
    question.push(u8::from(same));
    question.extend_from_slice(body);
    match ask(script, question, Some(TIME))? {
        Answer::Done(_) => Ok(()),
        Answer::Waiting => Err(Fail::unsupported("a callback that restores the state of a script must not wait")),
    }
}

/// FNV-1a, which is the same in every version of the program.
fn hash(text: &[u8]) -> u64 {
    text.iter().fold(0xCBF2_9CE4_8422_2325, |hash, byte| (hash ^ u64::from(*byte)).wrapping_mul(0x100_0000_01B3))
}
