//! Named counters: commands that have state per world, call functions of scripts, wait, and run in parallel.
#![forbid(unsafe_code)]

use std::{
    cell::{Cell, RefCell},
    collections::BTreeMap,
};

use tatu_plugin_api::{safe::*, tatu_plugin};

struct Tally {
    time: Prop,
}

/// The counters and waiting calls of a world.
#[derive(Default)]
struct Counts {
    counts: RefCell<BTreeMap<Vec<u8>, i64>>,
    /// Waiting calls by their token: the counter's name, and the value for which each call waits.
    waits: RefCell<BTreeMap<u64, (Vec<u8>, i64)>>,
    /// The token that was last assigned.
    word: Cell<u64>,
}

impl Counts {
    fn of(&self, name: &[u8]) -> i64 {
        self.counts.borrow().get(name).copied().unwrap_or(0)
    }
}

impl Plugin for Tally {
    fn start(host: &Host) -> Result<Self> {
        Ok(Tally { time: host.prop("scene.time") })
    }

    fn offer(offer: &mut Offer<Self>) {
        offer.per_world();
        let name = || Param::string("name").text("name of the counter");
        offer.command(
            Command::<Self>::new("tally.add", |c| {
                let (name, n) = (c.bytes(0)?, c.i64(1)?);
                let mut counts = c.instance().counts.borrow_mut();
                let count = counts.entry(name.to_vec()).or_default();
                *count = count.checked_add(n).ok_or_else(|| Fail::argument("the count would be too large"))?;
                c.ret(*count);
                Ok(())
            })
            .param(name())
            .param(Param::int("n").default(1).text("number that is added"))
            .returns(Param::int("count").text("new value of the counter"))
            .text("Adds to a counter, which is initially 0.")
            .example("assert(tally.add('example', 2) == 2 and tally.add('example') == 3)"),
        );
        offer.command(
            Command::<Self>::new("tally.each", |c| {
                let f = c.arg(0).as_func().ok_or_else(|| Fail::argument("expected a function"))?;
                // A copy, because the function may change counters.
                let counts = c.instance().counts.borrow().clone();
                for (name, count) in &counts {
                    c.call_func(f, &[Value::text(name), Value::from(*count)])?;
                }
                c.ret(counts.len() as i64);
                Ok(())
            })
            .param(Param::func("f").text("called with the name and value of each counter, in the order of names"))
            .returns(Param::int("n").text("number of counters"))
            .text("Calls a function for each counter.")
            .example("tally.add('example')\ntally.each(function(name, count) assert(count >= 1) end)"),
        );
        offer.command(
            Command::<Self>::new("tally.wait", |c| {
                let kept = c.instance();
                let word = match c.resumed() {
                    0 => {
                        let (name, n) = (c.bytes(0)?, c.i64(1)?);
                        if kept.of(name) >= n {
                            c.ret(c.world().f64(0, c.plugin().time)?);
                            return Ok(Outcome::Done);
                        }
                        let word = kept.word.get() + 1;
                        kept.word.set(word);
                        kept.waits.borrow_mut().insert(word, (name.to_vec(), n));
                        word
                    }
                    word => {
                        let mut waits = kept.waits.borrow_mut();
                        let (name, n) = waits
                            .get(&word)
                            .ok_or_else(|| Fail::new(format!("no call waits with the number {word}")))?;
                        if kept.of(name) >= *n {
                            waits.remove(&word);
                            c.ret(c.world().f64(0, c.plugin().time)?);
                            return Ok(Outcome::Done);
                        }
                        word
                    }
                };
                let outcome = c.wait_poll(word);
                if outcome.is_err() {
                    kept.waits.borrow_mut().remove(&word);
                }
                outcome
            })
            .param(name())
            .param(Param::int("n").text("value that the counter must reach"))
            .returns(Param::float("time").unit("s").text("simulation time at which the counter reached the value"))
            .text("Waits until a counter has reached a value.")
            .no_wait("call it in sysCall_thread, or read the counter with tally.each"),
        );
        offer.command(
            Command::<Self>::side_by_side("tally.digits", |c| {
                let x = c.i64(0)?;
                let digits: Vec<i64> = x.unsigned_abs().to_string().bytes().map(|b| i64::from(b - b'0')).collect();
                c.ret(digits.len() as i64);
                c.ret(digits);
                Ok(())
            })
            .param(Param::int("x").text("an integer"))
            .returns(Param::int("n").text("number of digits"))
            .returns(Param::list("digits").text("digits, most significant first"))
            .text("Returns the decimal digits of a number.")
            .example("local n, digits = tally.digits(-407)\nassert(n == 3 and digits[1] == 4 and digits[3] == 7)"),
        );
    }
}

impl PerWorld for Tally {
    type World = Counts;

    fn world(&self, _: &World<'_>) -> Result<Counts> {
        Ok(Counts::default())
    }

    const STATE_VERSION: u32 = 1;
    fn save(world: &Counts) -> Result<Vec<u8>> {
        let mut out = Vec::new();
        let number = |out: &mut Vec<u8>, x: u64| out.extend(x.to_le_bytes());
        let text = |out: &mut Vec<u8>, t: &[u8]| {
            number(out, t.len() as u64);
            out.extend(t);
        };
        let counts = world.counts.borrow();
        number(&mut out, counts.len() as u64);
        for (name, count) in counts.iter() {
            text(&mut out, name);
            number(&mut out, *count as u64);
        }
        let waits = world.waits.borrow();
        number(&mut out, waits.len() as u64);
        for (word, (name, count)) in waits.iter() {
            number(&mut out, *word);
            text(&mut out, name);
            number(&mut out, *count as u64);
        }
        number(&mut out, world.word.get());
        Ok(out)
    }
    fn load(world: &Counts, bytes: &[u8], version: u32) -> Result<()> {
        if version != Self::STATE_VERSION {
            return Err(Fail::unsupported(format!("counters saved in version {version} are not supported")));
        }
        let mut from = Bytes(bytes);
        let mut counts = BTreeMap::new();
        for _ in 0..from.number()? {
            counts.insert(from.text()?, from.number()? as i64);
        }
        let mut waits = BTreeMap::new();
        for _ in 0..from.number()? {
            waits.insert(from.number()?, (from.text()?, from.number()? as i64));
        }
        world.word.set(from.number()?);
        world.counts.replace(counts);
        world.waits.replace(waits);
        Ok(())
    }
}

/// The unread part of a saved state.
struct Bytes<'a>(&'a [u8]);

impl<'a> Bytes<'a> {
    fn take(&mut self, n: usize) -> Result<&'a [u8]> {
        let (taken, rest) = self.0.split_at_checked(n).ok_or_else(|| Fail::new("the saved counters are truncated"))?;
        self.0 = rest;
        Ok(taken)
    }
    fn number(&mut self) -> Result<u64> {
        Ok(u64::from_le_bytes(self.take(8)?.try_into().unwrap_or_default()))
    }
    fn text(&mut self) -> Result<Vec<u8>> {
        let n = self.number()?;
        Ok(self.take(n as usize)?.to_vec())
    }
}

tatu_plugin! {
    plugin: Tally, id: "org.example.tally", name: "Tally", version: "1.0.0", licence: "MIT",
}
