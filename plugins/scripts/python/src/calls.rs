//! Calls of the host into the script: callbacks, functions, the ends of waits.

use tatu_plugin_api::{abi::*, safe::*};

use crate::{
    exchange::{Answer, ask, time_of},
    message::{self, Message, to},
    script::PythonScript,
    serve,
    wire::{self, Reader},
};

/// Returns the number of a callable, or 0 if the script does not define it.
pub(crate) fn find(script: &PythonScript, how: u32, name: &[u8]) -> u32 {
    if script.child.borrow().is_none() || how == TATU_FIND_CALLBACK && script.source.borrow().is_cleaned_up {
        return 0;
    }
    let mut question = message::begin(to::FIND);
    question.push(how as u8);
    wire::write_text(&mut question, name);
    let found = match ask(script, question, Some(std::time::Duration::from_secs(10))) {
        Ok(Answer::Done(answer)) => answer.body.first() == Some(&1),
        _ => false,
    };
    if !found {
        return 0;
    }
    let callables = &mut script.source.borrow_mut().callables;
    let known = callables.iter().position(|c| c.0 == how && *c.1 == *name);
    let at = known.unwrap_or_else(|| {
        callables.push((how, name.into()));
        callables.len() - 1
    });
    at as u32 + 1
}

/// Calls the callable with the given number.
pub(crate) fn call(
    script: &PythonScript,
    callable: u32,
    frame: &mut Frame<'_>,
    budget: Budget,
    used: &mut u64,
) -> Result<Flow> {
    let (how, name) = {
        let source = script.source.borrow();
        let found = source.callables.get((callable as usize).wrapping_sub(1)).cloned();
        found.ok_or_else(|| Fail::with_code(TATU_ERR_GONE, "the script has no callable with this number"))?
    };
    if how == TATU_FIND_CALLBACK && script.child.borrow().is_none() {
        // The end of the process has been reported.
        return Ok(Flow::Done);
    }
    let mut question = message::begin(to::CALL);
    question.push(how as u8);
    wire::write_text(&mut question, &name);
    wire::write_all(&mut question, frame.args(), script.instance.id);
    let result = run(script, question, frame, budget, used);
    if how == TATU_FIND_CALLBACK && *name == *b"cleanup" {
        script.source.borrow_mut().is_cleaned_up = true;
    }
    result
}

/// Calls a function by its local number.
pub(crate) fn call_function(
    script: &PythonScript,
    local: u32,
    frame: &mut Frame<'_>,
    budget: Budget,
    used: &mut u64,
) -> Result<Flow> {
    let mut question = message::begin(to::CALL_FUNCTION);
    question.extend(local.to_le_bytes());
    wire::write_all(&mut question, frame.args(), script.instance.id);
    run(script, question, frame, budget, used)
}

/// Ends the wait with this token: continues the thread of the script that waits.
pub(crate) fn resume(
    script: &PythonScript,
    token: u64,
    failed: Option<Fail>,
    frame: &mut Frame<'_>,
    budget: Budget,
    used: &mut u64,
) -> Result<Flow> {
    if script.child.borrow().is_none() {
        return Ok(Flow::Done);
    }
    let mut question = message::begin(to::RESUME);
    question.extend(token.to_le_bytes());
    question.push(u8::from(failed.is_some()));
    match failed {
        Some(fail) => serve::write_fail(&mut question, &fail),
        None => wire::write_all(&mut question, frame.args(), script.instance.id),
    }
    run(script, question, frame, budget, used)
}

fn run(
    script: &PythonScript,
    question: Vec<u8>,
    frame: &mut Frame<'_>,
    budget: Budget,
    used: &mut u64,
) -> Result<Flow> {
    let before = script.calls.get();
    let answer = ask(script, question, time_of(budget));
    *used = script.calls.get() - before;
    match answer? {
        Answer::Waiting => Ok(Flow::Waiting),
        Answer::Done(answer) => {
            take_results(script, &answer, frame)?;
            Ok(Flow::Done)
        }
    }
}

/// Copies the results of a function to the frame.
fn take_results(script: &PythonScript, answer: &Message, frame: &mut Frame<'_>) -> Result {
    let Ok(values) = Reader::new(&answer.body, script.instance.id).values() else {
        return Err(Fail::new("the process of the script returned something that is not a list of values"));
    };
    for value in &values {
        let raw = value.to_raw(&mut FrameRoom(frame)).ok_or_else(|| {
            Fail::with_code(TATU_ERR_SPACE, "the result exceeds the world's memory for the values of a single call")
        })?;
        // SAFETY: the value's data is in memory of the frame, which is valid until the caller has read the results.
        unsafe { frame.push(raw) }?;
    }
    Ok(())
}

/// Memory for results, from the frame of the call.
struct FrameRoom<'f, 'a>(&'f mut Frame<'a>);

impl Room for FrameRoom<'_, '_> {
    fn words(&mut self, n: usize) -> Option<&mut [std::mem::MaybeUninit<u64>]> {
        let memory = self.0.alloc(n.checked_mul(8)?);
        // SAFETY: `alloc` returns null or memory of this size, aligned to 8 bytes, that nothing else uses.
        (!memory.is_null()).then(|| unsafe { std::slice::from_raw_parts_mut(memory.cast(), n) })
    }
}
