//! Calls commands as the host, between two steps, for programs that drive a world.

use tatu_errors::{Fault, FaultKind, nearest};
use tatu_plugin_api::{
    abi::*,
    safe::{Owned, Value, ValueRef},
};

use super::World;
use crate::{
    calls::{call_command, read_error},
    cell::{Caller, WorldCell},
    scripts::ResultBuffer,
};

impl World {
    /// Calls a command of any plugin as the host, without a calling script or object, and returns its results, of which
    /// there can be at most 64.
    ///
    /// A command that waits fails, since nothing could resume it later. The call is not recorded in the input log.
    ///
    /// # Errors
    /// No plugin offers the command, an argument is invalid, or the command failed. The fault is not added to
    /// [`World::faults`].
    pub fn call(&self, name: &str, args: &[Value]) -> Result<Vec<Value>, Box<Fault>> {
        let cell = &**self.cell();
        let Some((command, alias)) = cell.model.registry.command(name) else { return Err(unknown(cell, name)) };
        let mut owned = Owned::default();
        let args: Vec<tatu_value> = args.iter().map(|v| owned.raw(v)).collect();
        let mut room = ResultBuffer::new();
        let mut frame = room.frame(&args);
        // Commands called by old-style names must report errors as well, instead of returning the values that stand for
        // an error.
        (frame.command, frame.alias, frame.flags) = (command, alias, TATU_CALL_RAISE);
        cell.run.calls.caller.set(Caller::HOST);
        let mark = cell.run.calls.arena.borrow().mark();
        // SAFETY: the frame, its arguments and the space for its results live through the call.
        let status = unsafe { call_command(cell, &mut frame, 0) };
        let done = if status < 0 { Err(failed(cell, status, &frame)) } else { results(&frame) };
        cell.run.calls.arena.borrow_mut().release(mark);
        cell.restore_process_state("a call of the program");
        done
    }
}

fn unknown(cell: &WorldCell, name: &str) -> Box<Fault> {
    let mut fault = Fault::new(FaultKind::UnknownFunction, format!("no plugin offers the command `{name}`"));
    let known = cell.model.registry.command_offers.commands.iter().map(|c| c.name());
    fault.help = nearest(name, known).map(|near| format!("did you mean `{near}`?"));
    Box::new(fault)
}

fn results(frame: &tatu_call) -> Result<Vec<Value>, Box<Fault>> {
    // SAFETY: the results of a command that succeeded have been checked, and live until the arena is released.
    let values = unsafe { ValueRef::slice(frame.results, frame.n_results as usize) };
    let copied: Result<_, _> = values.iter().map(|v| v.to_value()).collect();
    copied.map_err(|e| Box::new(Fault::new(FaultKind::Plugin, e.text())))
}

fn failed(cell: &WorldCell, status: tatu_status, frame: &tatu_call) -> Box<Fault> {
    let said = read_error(frame.error);
    let text = said.text.unwrap_or_else(|| format!("the command failed with status {status}"));
    let mut fault = Fault::new(FaultKind::of(status), text);
    (fault.help, fault.file, fault.traceback) = (said.help, said.file, said.traceback);
    fault.line = Some(said.line).filter(|line| *line > 0);
    let command = cell.model.registry.command_offers.commands.get((frame.command as usize).wrapping_sub(1));
    fault.plugin = command.map(|c| cell.model.registry.plugins[c.plugin].id.clone());
    Box::new(fault)
}
