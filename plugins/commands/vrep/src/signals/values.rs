//! Commands on signals: named values of the world, with a separate namespace per kind.

use crate::kit::*;

/// Kinds of signals (integer, float, string), numbered as in `sim.getSignalName`.
pub(crate) const SIGNAL_KINDS: [u32; 3] = [0, 1, 2];

const INTEGER_KIND: u32 = SIGNAL_KINDS[0];

pub(crate) fn offer(offer: &mut Offer<Vrep>) {
    kind(offer, 0, "integer", &INT32_NAMES, Param::int("value"));
    kind(offer, 1, "float", &FLOAT_NAMES, Param::float("value"));
    kind(offer, 2, "string", &STRING_NAMES, Param::string("value").text("any bytes"));
    offer.command(
        Cmd::new("sim.getBufferSignal", |c| {
            let value = c.world().signal(SIGNAL_KINDS[2], c.bytes(0)?)?.to_value()?;
            match value {
                Value::Nil if c.world().stands_in(0, &format!("signal 2 {}", c.text(0)?)) => c.ret(STAND_IN_DATA),
                Value::Text(data) => c.ret(Value::Bytes(data)),
                value => c.ret(value),
            }
            Ok(())
        })
        .param(Param::string("name"))
        .returns(Param::bytes("value").text("no value if the signal is not set"))
        .text("Returns the string signal with this name as bytes, in languages that distinguish them from texts.")
        .example("v = sim.getBufferSignal('state')"),
    );
    offer.command(
        Cmd::new("sim.getSignalName", |c| {
            let (index, kind) = (c.i64(0)?, c.i64(1)?);
            let (Ok(index), Ok(kind)) = (u32::try_from(index), u32::try_from(kind)) else {
                return Ok(());
            };
            if let Some(name) = c.world().signal_name(kind, index)? {
                c.ret(name.as_slice());
            }
            Ok(())
        })
        .old_name("simGetSignalName", NIL)
        .param(Param::int("index").text("from 0, in the order of the names"))
        .param(Param::int("type").text("0: integer, 1: float, 2: string"))
        .returns(Param::string("name").text("no value past the last signal"))
        .text("Returns the name of a signal that is set, by index.")
        .example("name = sim.getSignalName(0, 1)"),
    );
}

/// The names of a command: the current one, the flat one, and an alias that is still accepted.
type SignalCommandNames = (&'static str, &'static str, Option<&'static str>);

/// Names of the commands that set, get and clear an integer signal.
const INT32_NAMES: [SignalCommandNames; 3] = [
    ("sim.setInt32Signal", "simSetIntegerSignal", Some("sim.setIntegerSignal")),
    ("sim.getInt32Signal", "simGetIntegerSignal", Some("sim.getIntegerSignal")),
    ("sim.clearInt32Signal", "simClearIntegerSignal", Some("sim.clearIntegerSignal")),
];
/// Names of the commands for float signals, in the same order.
const FLOAT_NAMES: [SignalCommandNames; 3] = [
    ("sim.setFloatSignal", "simSetFloatSignal", None),
    ("sim.getFloatSignal", "simGetFloatSignal", None),
    ("sim.clearFloatSignal", "simClearFloatSignal", None),
];
/// Names of the commands for string signals, in the same order.
const STRING_NAMES: [SignalCommandNames; 3] = [
    ("sim.setStringSignal", "simSetStringSignal", Some("sim.setBufferSignal")),
    ("sim.getStringSignal", "simGetStringSignal", None),
    ("sim.clearStringSignal", "simClearStringSignal", Some("sim.clearBufferSignal")),
];

/// Adds the three commands for a kind of signal; `word` denotes the kind in descriptions.
fn kind(offer: &mut Offer<Vrep>, kind: u32, word: &str, names: &'static [SignalCommandNames; 3], value: Param) {
    let [set, get, clear] = names;
    let named =
        |(name, flat, other): &SignalCommandNames, on_error: [Value; 1], run: fn(&mut Ctx<'_>, u32) -> Result| {
            let command = Cmd::new(*name, move |c| run(c, kind)).old_name(*flat, on_error);
            match other {
                Some(other) => command.alias(*other),
                None => command,
            }
        };
    offer.command(
        named(set, MINUS_ONE, |c, kind| {
            match INTEGER_KIND == kind {
                // Fractions are truncated.
                true => c.world().set_signal(kind, c.bytes(0)?, truncate(c.f64(1)?))?,
                false => c.world().set_signal(kind, c.bytes(0)?, c.arg(1))?,
            }
            c.ret(1_i64);
            Ok(())
        })
        .param(Param::string("name"))
        .param(if kind == INTEGER_KIND { Param::float("value").text("fractions are truncated") } else { value.clone() })
        .returns(Param::int("done"))
        .text(format!("Sets the {word} signal with this name, for all scripts."))
        .example(format!("{}('state', '3')", set.0)),
    );
    offer.command(
        named(get, NIL, |c, kind| {
            let v = c.world().signal(kind, c.bytes(0)?)?;
            if !v.is_nil() {
                c.ret(v);
            } else if c.world().stands_in(0, &format!("signal {kind} {}", c.text(0)?)) {
                // In a run without a scene, a neutral value replaces the missing signal.
                match kind {
                    0 => c.ret(1_i64),
                    1 => c.ret(1.0),
                    _ => c.ret(STAND_IN_DATA),
                }
            }
            Ok(())
        })
        .param(Param::string("name"))
        .returns(value.text("no value if the signal is not set"))
        .text(format!("Returns the {word} signal with this name."))
        .example(format!("v = {}('state')", get.0)),
    );
    offer.command(
        named(clear, MINUS_ONE, |c, kind| {
            let w = c.world();
            let n = match c.has(0).then(|| c.bytes(0)).transpose()? {
                Some(b"") => 0,
                Some(name) => w.clear_signal(kind, name)?,
                None => w.clear_signal(kind, b"")?,
            };
            c.ret(i64::from(n));
            Ok(())
        })
        .param(Param::string("name").optional().text("nil: all signals of this kind"))
        .returns(Param::int("count").text("the number of signals removed"))
        .text(format!("Removes the {word} signal with this name."))
        .example(format!("{}('state')", clear.0)),
    );
}

fn truncate<'a>(x: f64) -> ValueRef<'a> {
    // SAFETY: the tag is `TATU_I64`, so the payload is an integer and not a pointer; the value borrows nothing.
    unsafe { ValueRef::new(tatu_value { tag: TATU_I64, reserved: 0, u: tatu_payload { i: x as i64 } }) }
}
