//! Answers the questions of the process: commands, names, functions of other scripts.

use std::mem::MaybeUninit;

use tatu_plugin_api::{abi::*, safe::*};

use crate::{
    host::Meaning,
    message::{self, Message, from, to},
    script::PythonScript,
    wire::{self, Malformed, Reader},
};

/// Maximum number of results of a command.
const MAX_RESULTS: usize = 64;

/// Kinds of names in the answer to `from::LOOKUP`.
mod name {
    pub const NOTHING: u8 = 0;
    pub const COMMAND: u8 = 1;
    pub const CONSTANT: u8 = 2;
    pub const NAME_SPACE: u8 = 3;
}

/// Answers a question; the answer has been begun with `message::begin`.
pub(crate) fn question(script: &PythonScript, message: &Message) -> Result<Vec<u8>, Malformed> {
    let mut reader = Reader::new(&message.body, script.instance.id);
    let (commands, world) = (&script.commands, script.world_ref());
    let mut reply = message::begin(to::RESULT);
    match message.kind {
        from::COMMAND => {
            let (packed, can_wait) = (reader.u32()?, reader.u8()? != 0);
            let args = reader.values()?;
            return Ok(call(script, Target::Command(packed), can_wait, &args));
        }
        from::FUNCTION => {
            let func = reader.u64()?;
            let args = reader.values()?;
            return Ok(call(script, Target::Function(func), false, &args));
        }
        from::LOOKUP => match commands.meaning(world, reader.bytes()?) {
            Meaning::Nothing => reply.push(name::NOTHING),
            Meaning::NameSpace => reply.push(name::NAME_SPACE),
            Meaning::Command(packed) => {
                reply.push(name::COMMAND);
                reply.extend(packed.to_le_bytes());
            }
            Meaning::Constant(value) => {
                reply.push(name::CONSTANT);
                wire::write(&mut reply, value, script.instance.id);
            }
        },
        from::MODULE => {
            let wanted = reader.bytes()?;
            let found = commands.preludes(world).find(|(module, _)| !module.is_empty() && *module == wanted);
            reply.push(u8::from(found.is_some()));
            wire::write_text(&mut reply, found.map_or(&[], |(_, text)| text));
        }
        from::NEAREST => {
            let near = commands.nearest(world, &reader.text()?);
            wire::write_text(&mut reply, near.unwrap_or_default().as_bytes());
        }
        from::DESCRIBE => wire::write_text(&mut reply, commands.describe(world, reader.u32()? >> 8).as_bytes()),
        _ => return Err(Malformed),
    }
    Ok(reply)
}

enum Target {
    /// A command: id << 8 | alias.
    Command(u32),
    /// A function of another script.
    Function(tatu_func),
}

/// Calls a command or function, and returns the message with its results or its error.
fn call(script: &PythonScript, target: Target, can_wait: bool, args: &[Value]) -> Vec<u8> {
    let world = script.world_ref();
    let mut owned = Owned::default();
    let args = owned.values(args);
    let mut results = [const { MaybeUninit::<tatu_value>::uninit() }; MAX_RESULTS];
    let mut frame = tatu_call {
        size: size_of::<tatu_call>() as u32,
        args: args.as_ptr().cast(),
        n_args: args.len() as u32,
        results: results.as_mut_ptr().cast(),
        results_cap: MAX_RESULTS as u32,
        flags: TATU_CALL_RAISE,
        ..tatu_call::empty()
    };
    if can_wait {
        frame.wait_token = script.numbers.token.get() + 1;
        script.numbers.token.set(frame.wait_token);
    }
    script.calls.set(script.calls.get() + 1);
    let outer = script.serves.replace(true);
    let reply = script.commands.released(world, || {
        // SAFETY: the frame is complete, and everything that it points to lives during the call.
        let status = unsafe {
            match target {
                Target::Command(packed) => {
                    (frame.command, frame.alias) = (packed >> 8, packed & 0xFF);
                    (script.commands.call)(world, &raw mut frame)
                }
                Target::Function(func) => (script.commands.call_func)(world, func, &raw mut frame),
            }
        };
        reply(script, status, &frame)
    });
    script.serves.set(outer);
    reply
}

fn reply(script: &PythonScript, status: tatu_status, frame: &tatu_call) -> Vec<u8> {
    if status == TATU_WAIT && frame.wait_token != 0 {
        script.numbers.waits.set(script.numbers.waits.get() + 1);
        let mut out = message::begin(to::WAIT);
        out.extend(frame.wait_token.to_le_bytes());
        return out;
    }
    if status != TATU_OK {
        let fail = match status {
            // SAFETY: the frame's error belongs to the host, which keeps it valid until its next error; it is copied.
            ..0 => unsafe { Fail::read(status, frame.error) },
            _ => Fail::unsupported("this command waits, but the calling code cannot be suspended")
                .help("call it from `sysCall_thread`"),
        };
        let mut out = message::begin(to::ERROR);
        write_fail(&mut out, &fail);
        return out;
    }
    // SAFETY: the host has written `n_results` values, at most as many as the buffer holds; what they point to is valid
    // until the arena is released.
    let results = unsafe { ValueRef::slice(frame.results, frame.n_results.min(MAX_RESULTS as u32) as usize) };
    let mut out = message::begin(to::RESULT);
    wire::write_all(&mut out, results, script.instance.id);
    out
}

/// Appends code, text and help of an error.
pub(crate) fn write_fail(out: &mut Vec<u8>, fail: &Fail) {
    out.extend(fail.code().to_le_bytes());
    wire::write_text(out, fail.text().as_bytes());
    wire::write_text(out, fail.help_text().unwrap_or_default().as_bytes());
}
