//! Asks the process, and serves its questions until it answers.

use std::time::Duration;

use tatu_plugin_api::{abi::*, safe::*};

use crate::{
    message::{self, Message, from, to},
    process::{Lost, Patience},
    script::PythonScript,
    serve,
    wire::{Malformed, Reader},
};

/// Instructions of the budget that count as one second of the process. With the default budget, a call may take 10 s.
const INSTRUCTIONS_PER_SECOND: u64 = 5_000_000;

/// How the process answered.
pub(crate) enum Answer {
    /// The message that answers; its kind is `from::DONE`.
    Done(Message),
    /// The function waits in a command.
    Waiting,
}

/// Returns the time that the process may take in a call with this budget.
pub(crate) fn time_of(budget: Budget) -> Option<Duration> {
    (budget.instructions > 0).then(|| {
        let seconds = budget.instructions as f64 / INSTRUCTIONS_PER_SECOND as f64;
        Duration::from_secs_f64(seconds.clamp(1.0, 1e6))
    })
}

/// Sends a message that `message::begin` has begun, and serves the process until it answers.
pub(crate) fn ask(script: &PythonScript, mut question: Vec<u8>, time: Option<Duration>) -> Result<Answer> {
    refresh(script);
    let must_return = || {
        // The host does not treat a call that asks this as one that never returns.
        let _ = script.world().is_interrupted();
        script.world().must_return()
    };
    let mut patience = Patience { left: time, must_return: &must_return };
    let mut served = 0u32;
    let answer = loop {
        // A script that asks without end never lets the plugin wait.
        served = served.wrapping_add(1);
        if served.is_multiple_of(1024) && must_return() {
            return Err(give_up(script, Lost::Interrupted));
        }
        if !question.is_empty() {
            message::complete(&mut question);
        }
        let message = receive(script, &question, &mut patience)?;
        let reply = match message.kind {
            from::DONE => break Ok(Answer::Done(message)),
            from::WAITING => match script.numbers.waits.get().checked_sub(1) {
                Some(waits) => {
                    script.numbers.waits.set(waits);
                    break Ok(Answer::Waiting);
                }
                None => return Err(give_up(script, Lost::Malformed)),
            },
            from::FAILED => break Err(failure(script, &message)),
            from::LOG => log(script, &message).map(|()| Vec::new()),
            _ => serve::question(script, &message),
        };
        match reply {
            Ok(reply) => question = reply,
            Err(Malformed) => return Err(give_up(script, Lost::Malformed)),
        }
    };
    log_output(script);
    answer
}

/// Sends a message, which may be empty, and returns the next one of the process.
fn receive(script: &PythonScript, message: &[u8], patience: &mut Patience<'_>) -> Result<Message> {
    let received = {
        let mut child = script.child.borrow_mut();
        let Some(child) = child.as_mut() else {
            let lost = script.lost.borrow();
            return Err(Fail::with_code(TATU_ERR_GONE, format!("the script cannot be called any more: {lost}")));
        };
        if !message.is_empty() {
            child.channel.queue(message);
        }
        child.channel.exchange(patience)
    };
    received.map_err(|lost| give_up(script, lost))
}

/// Ends the process, which cannot be used any more, and returns the error of the call.
fn give_up(script: &PythonScript, lost: Lost) -> Fail {
    let Some(mut child) = script.child.borrow_mut().take() else {
        return Fail::with_code(TATU_ERR_GONE, "the process of the script has ended");
    };
    let (code, text, help) = match lost {
        Lost::Closed => {
            let end = child.end();
            (TATU_ERR_SCRIPT, format!("the process of the script has ended: {end}"), None)
        }
        Lost::Late => (
            TATU_ERR_BUDGET,
            "the script took too long, so its process was ended".to_owned(),
            Some("look for an endless loop, or increase `instructions` in [scene.budget]: 5000000 stand for 1 s"),
        ),
        Lost::Interrupted => (TATU_ERR_BUDGET, "the script did not return when it was asked to stop".to_owned(), None),
        Lost::Malformed => (
            TATU_ERR_SCRIPT,
            "the process of the script sent something that is not a message, so it was ended".to_owned(),
            Some("the script must not use the file descriptors that it did not open"),
        ),
    };
    child.kill();
    let last = child.channel.last_output();
    let mut fail = Fail::with_code(code, text.clone());
    if let Some(help) = help {
        fail = fail.help(help);
    } else if !last.is_empty() {
        fail = fail.help(format!("its last output: {last}"));
    }
    *script.lost.borrow_mut() = text;
    fail
}

/// Tells the process if commands were added or removed since its last call.
fn refresh(script: &PythonScript) {
    let now = script.commands.generation(script.world_ref());
    if script.numbers.generation.replace(now) != now {
        script.tell(to::REFRESH, &[]);
    }
}

/// Reads the error of a script.
fn failure(script: &PythonScript, message: &Message) -> Fail {
    let mut reader = Reader::new(&message.body, script.instance.id);
    let mut read = || -> Result<Fail, Malformed> {
        let (code, text) = (reader.i32()?, reader.text()?);
        let (help, file) = (reader.text()?, reader.text()?);
        let (line, traceback) = (reader.u32()?, reader.text()?);
        let mut fail = Fail::with_code(code, text);
        if !help.is_empty() {
            fail = fail.help(help);
        }
        if line > 0 {
            fail = fail.at(file, line.into());
        }
        if !traceback.is_empty() {
            fail = fail.traceback(traceback);
        }
        Ok(fail)
    };
    read().unwrap_or_else(|Malformed| give_up(script, Lost::Malformed))
}

fn log(script: &PythonScript, message: &Message) -> Result<(), Malformed> {
    let (level, text) = message.body.split_first().ok_or(Malformed)?;
    let level = match u32::from(*level) {
        level @ (TATU_LOG_WARNING | TATU_LOG_DEBUG) => level,
        _ => TATU_LOG_INFO,
    };
    script.world().log(level, text);
    Ok(())
}

/// Logs what libraries of the process have written to its standard output and error, around `sys.stdout`.
fn log_output(script: &PythonScript) {
    let lines = script.child.borrow_mut().as_mut().map_or(Vec::new(), |child| child.channel.output_lines());
    for line in lines {
        script.world().log(TATU_LOG_INFO, line.as_bytes());
    }
}

/// Returns the position of the script while it waits for the result of a command.
pub(crate) fn place(script: &PythonScript) -> Option<Fail> {
    if !script.serves.get() || script.child.try_borrow().is_err() {
        return None;
    }
    match ask(script, message::begin(to::PLACE), Some(Duration::from_secs(1))) {
        Err(place) if place.place().is_some() => Some(place),
        _ => None,
    }
}
