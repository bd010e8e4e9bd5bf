//! Commands that send and receive, and `poll`.
//!
//! A call that must wait suspends only its caller if that is a thread or coroutine, and is repeated in each step. In a
//! callback, it blocks the run.

use std::time::{Duration, Instant};

use tatu_plugin_api::safe::{Command, Offer, Outcome, Param, Result, Value};

use crate::{
    errors::Errno,
    operation::{Operation, What},
    recording::{SocketOutcome, denial, observe},
    routing::SocketState,
    world::{Ctx, WorldState, Zmq, fail, state},
};

pub const DONTWAIT: i64 = 1;
pub const SNDMORE: i64 = 2;
pub const POLLIN: i64 = 1;
pub const POLLOUT: i64 = 2;

/// Time for which a call from a thread blocks before it waits for the next step. A program on this machine usually
/// answers within this time.
const GRACE: Duration = Duration::from_millis(1);
/// Maximum time for which a call blocks before it checks whether the run is about to end.
const CHECK_INTERVAL: Duration = Duration::from_millis(20);
/// Interval at which `poll` checks its sockets.
const POLL_INTERVAL: Duration = Duration::from_millis(1);

impl Operation {
    /// Returns the timeout of the call, in ms; negative: no limit.
    fn timeout(&self, world: &mut WorldState) -> Result<i64, Errno> {
        Ok(match &self.what {
            What::Receive { wait: false, .. } | What::Send { wait: false, .. } => 0,
            What::Receive { socket, .. } => world.socket(socket)?.with(|s| s.options.receive_timeout),
            What::Send { socket, .. } => world.socket(socket)?.with(|s| s.options.send_timeout),
            // Without sockets, no event can end the wait.
            What::Poll { sockets, .. } if sockets.is_empty() => 0,
            What::Poll { timeout, .. } => *timeout,
        })
    }

    /// Attempts the call, and blocks for at most `most`.
    fn attempt(&self, world: &mut WorldState, most: Duration) -> Result<Vec<Value>, Errno> {
        match &self.what {
            What::Receive { socket, .. } => world.socket(socket)?.wait(most, |state: &mut SocketState| {
                let data = state.receive()?;
                Ok(vec![Value::Bytes(data), Value::Bool(state.more)])
            }),
            What::Send { socket, data, more, .. } => {
                world.socket(socket)?.wait(most, |state| state.send(data, *more)).map(|()| Vec::new())
            }
            What::Poll { sockets, .. } => {
                let mut ready = Vec::new();
                for (socket, events) in sockets {
                    ready.push(world.socket(socket)?.with(|state| events_of(state) & events));
                }
                if ready.iter().all(|r| *r == 0) {
                    std::thread::sleep(most.min(POLL_INTERVAL));
                    return Err(Errno::WOULD_BLOCK);
                }
                Ok(vec![Value::Ints(ready)])
            }
        }
    }

    /// Attempts the call until it succeeds, fails, or must wait for the next step.
    fn look(&mut self, c: &Ctx<'_>, world: &mut WorldState) -> Result<SocketOutcome, Errno> {
        let first = !std::mem::replace(&mut self.begun, true);
        if first {
            let timeout = u64::try_from(self.timeout(world)?);
            self.end = timeout.ok().map(|ms| Instant::now() + Duration::from_millis(ms.min(1 << 40)));
        }
        let suspends = c.can_wait();
        loop {
            let left = self.end.map(|end| end.saturating_duration_since(Instant::now()));
            let most = if suspends && !first {
                Duration::ZERO
            } else if suspends {
                GRACE
            } else {
                CHECK_INTERVAL
            };
            match self.attempt(world, left.map_or(most, |left| left.min(most))) {
                Err(Errno::WOULD_BLOCK) if left == Some(Duration::ZERO) => return Err(Errno::WOULD_BLOCK),
                Err(Errno::WOULD_BLOCK) if suspends => return Ok(SocketOutcome::Waits),
                Err(Errno::WOULD_BLOCK) if c.world().is_interrupted() => return Err(Errno::TERMINATED),
                Err(Errno::WOULD_BLOCK) => {}
                Err(errno) => return Err(errno),
                Ok(values) => return Ok(SocketOutcome::Values(values)),
            }
        }
    }

    /// Executes the call. If it has no result yet, suspends the caller until the next step.
    fn run(mut self, c: &mut Ctx<'_>) -> Result<Outcome> {
        let name = self.name;
        let found = observe(c, name, |c, world| Ok(self.look(c, world).unwrap_or_else(SocketOutcome::Failed)))?;
        match found {
            SocketOutcome::Waits => {
                let number = {
                    let mut world = state(c)?;
                    let number = world.next_number();
                    world.waits.insert(number, self);
                    number
                };
                return c.wait_poll(number);
            }
            SocketOutcome::Values(values) => self.succeed(c, values)?,
            SocketOutcome::Failed(Errno::WOULD_BLOCK) if matches!(self.what, What::Poll { .. }) => {
                self.nothing_ready(c)
            }
            SocketOutcome::Failed(errno) => {
                fail(c, errno)?;
                c.ret(-1_i64);
                if self.has_data() {
                    c.ret(Value::Nil);
                }
            }
            SocketOutcome::Denied(text, help) => return Err(denial(text, help)),
        }
        Ok(Outcome::Done)
    }

    /// Returns whether the command returns data in addition to its numeric result.
    fn has_data(&self) -> bool {
        matches!(self.what, What::Receive { message: None, .. } | What::Poll { .. })
    }

    fn nothing_ready(&self, c: &mut Ctx<'_>) {
        if let What::Poll { sockets, .. } = &self.what {
            c.ret(0_i64);
            c.ret(Value::Ints(vec![0; sockets.len()]));
        }
    }

    fn succeed(self, c: &mut Ctx<'_>, mut values: Vec<Value>) -> Result {
        match self.what {
            What::Send { data, .. } => c.ret(data.len() as i64),
            What::Poll { .. } => {
                let ready = values.first().and_then(ints).unwrap_or_default();
                c.ret(ready.iter().filter(|r| **r != 0).count() as i64);
                c.ret(Value::Ints(ready));
            }
            What::Receive { most, message, .. } => {
                let more = matches!(values.get(1), Some(Value::Bool(true)));
                let mut data = match values.drain(..).next() {
                    Some(Value::Bytes(data) | Value::Text(data)) => data,
                    _ => Vec::new(),
                };
                c.ret(data.len() as i64);
                if let Some(message) = message {
                    if let Ok(place) = state(c)?.message(&message) {
                        (place.data, place.more) = (data, more);
                    }
                } else {
                    data.truncate(most);
                    c.ret(Value::Bytes(data));
                }
            }
        }
        Ok(())
    }
}

/// Returns the integers of a value that was read from JSON.
fn ints(value: &Value) -> Option<Vec<i64>> {
    match value {
        Value::Ints(all) => Some(all.clone()),
        Value::List(all) => all.iter().map(|v| if let Value::Int(i) = v { Some(*i) } else { None }).collect(),
        _ => None,
    }
}

/// Returns the events for which a socket is ready, as a sum of `POLLIN` and `POLLOUT`.
pub fn events_of(state: &mut SocketState) -> i64 {
    i64::from(state.can_receive()) * POLLIN + i64::from(state.can_send()) * POLLOUT
}

/// Builds a command that may wait for the network.
fn waiting(name: &'static str, what: impl Fn(&Ctx<'_>) -> Result<What> + Send + Sync + 'static) -> Command<Zmq> {
    Command::new(name, move |c| {
        if c.resumed() != 0 {
            return resume(c);
        }
        Operation::new(name, what(c)?).run(c)
    })
}

fn flags(c: &Ctx<'_>, i: usize) -> i64 {
    c.arg(i).as_i64().unwrap_or(0)
}

/// Builds a receiving call. `socket` and `flag` are the indices of the arguments with the socket and the flags.
fn receive(c: &Ctx<'_>, socket: usize, flag: usize, most: usize, message: Option<String>) -> Result<What> {
    Ok(What::Receive { socket: c.text(socket)?, wait: flags(c, flag) & DONTWAIT == 0, most, message })
}

fn flags_param(text: &'static str) -> Param {
    Param::int("flags").default(0_i64).text(text)
}

pub(crate) fn socket_param() -> Param {
    Param::string("socket")
}

pub(crate) fn offer(offer: &mut Offer<Zmq>) {
    offer.command(
        waiting("simZMQ.send", |c| {
            let flags = flags(c, 2);
            let (wait, more) = (flags & DONTWAIT == 0, flags & SNDMORE != 0);
            Ok(What::Send { socket: c.text(0)?, wait, data: c.bytes(1)?.to_vec(), more })
        })
        .param(socket_param())
        .param(Param::string("data"))
        .param(flags_param("`DONTWAIT`: fails with EAGAIN instead of waiting; `SNDMORE`: further parts follow"))
        .returns(Param::int("result").unit("B").text("size of the data; -1: failed"))
        .text("Sends a part of a message.")
        .example("assert(simZMQ.send('none', 'data', 0) == -1 and simZMQ.errnum() == simZMQ.ENOTSOCK)"),
    );
    offer.command(
        waiting("simZMQ.recv", |c| {
            let most = c.arg(2).as_i64().and_then(|n| usize::try_from(n).ok()).unwrap_or(usize::MAX);
            receive(c, 0, 1, most, None)
        })
        .param(socket_param())
        .param(flags_param("`DONTWAIT`: fails with EAGAIN instead of waiting"))
        .param(Param::int("max_buf_size").unit("B").optional().text("longer data is truncated"))
        .returns(Param::int("result").unit("B").text("size of the data; -1: failed"))
        .returns(Param::string("data").optional())
        .text(
            "Receives a part of a message, and waits until one arrives: in a thread or coroutine, only the caller \
             waits; in a callback, the whole run.",
        )
        .example("local rc, data = simZMQ.recv('none', simZMQ.DONTWAIT)\nassert(rc == -1 and data == nil)"),
    );
    offer.command(
        waiting("simZMQ.poll", |c| {
            let names = c.arg(0).list().unwrap_or_default();
            let events = c.arg(1).numbers().unwrap_or_default();
            let names = names.iter().map(|v| v.as_str().unwrap_or_default().into_owned());
            let sockets = names.zip(events.into_iter().map(|n| n as i64)).collect();
            Ok(What::Poll { sockets, timeout: c.arg(2).as_i64().unwrap_or(0) })
        })
        .param(Param::list("sockets"))
        .param(Param::list("events").text("for each socket `POLLIN`, `POLLOUT` or both"))
        .param(Param::int("timeout").unit("ms").default(0_i64).text("negative: no limit"))
        .returns(Param::int("result").text("number of sockets that are ready; -1: failed"))
        .returns(Param::list("revents").optional().text("the events for which each socket is ready"))
        .text(
            "Waits until at least one socket is ready, and returns for which events each socket is ready. Returns \
             immediately if there are no sockets.",
        )
        .example("assert(simZMQ.poll({}, {}, 0) == 0)"),
    );
    offer.command(
        Command::new("simZMQ.msg_send", |c| {
            if c.resumed() != 0 {
                return resume(c);
            }
            let message = c.text(0)?;
            let data = state(c)?.message(&message).map(|m| m.data.clone());
            let data = match data {
                Ok(data) => data,
                Err(errno) => return return_failure(c, errno),
            };
            let flags = flags(c, 2);
            let (wait, more) = (flags & DONTWAIT == 0, flags & SNDMORE != 0);
            Operation::new("simZMQ.msg_send", What::Send { socket: c.text(1)?, wait, data, more }).run(c)
        })
        .param(Param::string("msg"))
        .param(socket_param())
        .param(flags_param("as for `simZMQ.send`"))
        .returns(Param::int("result").unit("B").text("size of the data; -1: failed"))
        .text("Sends the data of a message object as a part of a message.")
        .example("assert(simZMQ.msg_send('none', 'none', 0) == -1)"),
    );
    offer.command(
        Command::new("simZMQ.msg_recv", |c| {
            if c.resumed() != 0 {
                return resume(c);
            }
            let message = c.text(0)?;
            let known = state(c)?.message(&message).map(drop);
            if let Err(errno) = known {
                return return_failure(c, errno);
            }
            let what = receive(c, 1, 2, usize::MAX, Some(message))?;
            Operation::new("simZMQ.msg_recv", what).run(c)
        })
        .param(Param::string("msg"))
        .param(socket_param())
        .param(flags_param("as for `simZMQ.recv`"))
        .returns(Param::int("result").unit("B").text("size of the data; -1: failed"))
        .text("Receives a part of a message into a message object, whose data `simZMQ.msg_data` returns.")
        .example("assert(simZMQ.msg_recv('none', 'none', simZMQ.DONTWAIT) == -1)"),
    );
}

/// Stores the error for `simZMQ.errnum`, and returns -1 to the script.
fn return_failure(c: &mut Ctx<'_>, errno: Errno) -> Result<Outcome> {
    fail(c, errno)?;
    c.ret(-1_i64);
    Ok(Outcome::Done)
}

/// Repeats a call that was waiting for the next step.
fn resume(c: &mut Ctx<'_>) -> Result<Outcome> {
    let operation = state(c)?.waits.remove(&c.resumed());
    match operation {
        Some(operation) => operation.run(c),
        // The call is unknown because the world was restored from a snapshot, which does not contain sockets.
        None => return_failure(c, Errno::NOT_SOCKET),
    }
}
