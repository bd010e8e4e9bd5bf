//! Packs tables into bytes, and unpacks them: `sim.packTable`, `sim.unpackTable`.

use crate::kit::*;

pub(crate) fn offer(offer: &mut Offer<Vrep>) {
    offer.command(
        both(["sim.packTable", "simPackTable"], NIL, |c| {
            if !is_table(c.arg(0)) {
                return Err(Fail::argument("argument 1: expected a table"));
            }
            let data = tables::pack(&c.arg(0).to_value()?)?;
            c.ret(Value::Bytes(data));
            Ok(())
        })
        .param(Param::any("table"))
        .param(Param::int("scheme").default(0).optional().text("ignored"))
        .returns(Param::bytes("data"))
        .text("Packs a table of booleans, numbers, strings and tables into a string of bytes.")
        .partial("The format is specific to Tatu, regardless of the scheme."),
    );
    offer.command(
        both(["sim.unpackTable", "simUnpackTable"], NIL, |c| {
            let value = match c.bytes(0)? {
                b"" => Value::List(Vec::new()),
                data => tables::unpack(data)?,
            };
            c.ret(value);
            Ok(())
        })
        .param(Param::string("data").text("empty: an empty table"))
        .returns(Param::any("table"))
        .text("Unpacks a table that was packed by `sim.packTable`, by V-REP, or as CBOR."),
    );
}
