//! Calls that a plugin makes: of commands, and of functions of scripts and clients.

use crate::abi::*;
use crate::safe::{Fail, Result, Value, ValueRef, World, call::shared_world::service, value::owned::Owned};

/// The outcome of a call.
#[derive(Debug, Clone, PartialEq)]
pub enum Called {
    /// The command has finished, with these results.
    Done(Vec<Value>),
    /// The command finishes later; [`Service::resume`](crate::safe::Service::resume) will receive its token.
    Waits,
}

impl Called {
    /// Returns the results of a call that cannot wait.
    pub(crate) fn done(self) -> Vec<Value> {
        match self {
            Called::Done(results) => results,
            Called::Waits => Vec::new(),
        }
    }
}

impl World<'_> {
    /// Calls a command by any of its names; it must not wait. Returns its results.
    pub fn call_command(&self, name: &str, args: &[Value]) -> Result<Vec<Value>> {
        call_by_name(self, name, args, 0).map(Called::done)
    }
}

/// Calls a command by any of its names. If `token` is 0, the command must not wait.
pub(crate) fn call_by_name(world: &World<'_>, name: &str, args: &[Value], token: u64) -> Result<Called> {
    let (find, run) = (service!(world.commands.find), service!(world.commands.call));
    let mut alias = 0;
    let command = find(world.raw(), name.into(), Some(&mut alias));
    if command == 0 {
        return Err(Fail::with_code(TATU_ERR_UNKNOWN, format!("there is no command `{name}`")));
    }
    let frame = tatu_call { command, alias, wait_token: token, ..tatu_call::empty() };
    // SAFETY: `call` passes a complete frame that lives during the call.
    call(world, frame, args, |world, frame| unsafe { run(world, frame) })
}

/// Calls a host function that accepts a frame, whose fields in `frame` select the command or function to call. Returns
/// at most 64 results.
pub(crate) fn call(
    world: &World<'_>,
    frame: tatu_call,
    args: &[Value],
    function: impl FnOnce(WorldRef<'_>, &mut tatu_call) -> tatu_status,
) -> Result<Called> {
    let (mark, release) = (service!(world.commands.mark), service!(world.commands.release));
    let mut owned = Owned::default();
    let args = owned.values(args);
    let mut results = [ValueRef::NIL; 64];
    let mut frame = tatu_call {
        size: size_of::<tatu_call>() as u32,
        args: args.as_ptr().cast(),
        n_args: args.len() as u32,
        results: results.as_mut_ptr().cast(),
        results_cap: results.len() as u32,
        ..frame
    };
    let here = mark(world.raw());
    let out = match function(world.raw(), &mut frame) {
        TATU_WAIT => Ok(Called::Waits),
        // SAFETY: `frame.error` is null or points to the host's error of this call, which lives until the next call and
        // is copied at once.
        status if status < 0 => Err(unsafe { Fail::read(status, frame.error) }),
        _ => {
            let results = results.iter().take(frame.n_results as usize);
            results.map(|v| v.to_value()).collect::<Result<_>>().map(Called::Done)
        }
    };
    // SAFETY: `here` was returned by `mark` above, and everything allocated after it has been copied.
    unsafe { release(world.raw(), here) };
    out
}
