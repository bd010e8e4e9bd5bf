//! Collisions and distances between shapes.

use crate::{Vrep, collections, kit::*};

/// From here on lie the handles of collision objects and their like in runs that make stand-ins.
const REGISTERED: i64 = 0x8_0000;

/// Whether a number is one of these.
pub(crate) fn is_registered(c: &Ctx<'_>, handle: i64) -> bool {
    (REGISTERED..=REGISTERED + 0xFFFF).contains(&handle) && c.world().makes_stand_ins()
}

pub(crate) fn offer(offer: &mut Offer<Vrep>) {
    let entity = |key: &str| Param::int(key).text("an object with what hangs below it, or a collection");
    let second = || Param::int("second").text("an object, a collection, or sim.handle_all: all other shapes");
    let notes = "Surfaces of meshes that are not convex are hollow: what is wholly inside does not touch them.";
    offer.command(
        both("sim.checkCollision", MINUS, |c| {
            let touching = closest(c, 1e-9)?.filter(|d| d.length() == 0.0);
            c.ret(i64::from(touching.is_some()));
            if version(c) >= (4, 0) {
                c.ret::<[i64]>(&touching.map_or([-1, -1], |d| d.0.pair.map(handle))[..]);
            }
            Ok(())
        })
        .param(entity("first"))
        .param(second())
        .returns(Param::int("result").text("1: they overlap"))
        .returns(Param::list("objects").text("the two shapes, since 4.0; -1 without"))
        .text("Tells whether shapes overlap.")
        .notes(notes),
    );
    offer.command(
        both("sim.checkDistance", NIL, |c| {
            let threshold = if c.has(2) { c.f64(2)? } else { 0.0 };
            let found = closest(c, threshold)?;
            let modern = version(c) >= (4, 0);
            c.ret(i64::from(found.is_some()));
            match found {
                Some(d) => {
                    let Closest { from: [a, b, x], to: [e, f, g], pair } = d.0;
                    c.ret::<[f64]>(&[a, b, x, e, f, g, d.length()][..]);
                    if modern {
                        c.ret::<[i64]>(&pair.map(handle)[..]);
                    }
                }
                None if modern => {
                    c.ret::<[f64]>(&[0.0; 7][..]);
                    c.ret::<[i64]>(&[-1, -1][..]);
                }
                None => {}
            }
            Ok(())
        })
        .param(entity("first"))
        .param(second())
        .param(Param::float("threshold").unit("m").default(0.0).optional().text("0: any distance"))
        .returns(Param::int("result").text("1; 0: they are farther apart"))
        .returns(Param::floats("data", 7).text("both ends of the shortest way, and its length"))
        .returns(Param::list("objects").text("the two shapes, since 4.0"))
        .text("Measures the shortest way between shapes.")
        .notes(notes),
    );
    for name in ["sim.readCollision", "sim.readDistance"] {
        offer.command(
            both(name, MINUS, |c| {
                c.ret(0_i64);
                Ok(())
            })
            .param(Param::int("object"))
            .returns(Param::int("result").text("0: never handled"))
            .text("Reads a registered collision or distance object: scenes here have none.")
            .stub("scenes have no registered collision and distance objects"),
        );
    }
    for (name, irregular, text) in [
        ("sim.getCollisionHandle", "simGetCollisionhandle", "collision object"),
        ("sim.getDistanceHandle", "simGetDistancehandle", "distance object"),
        ("sim.getIkGroupHandle", "simGetIkGrouphandle", "IK group"),
        ("sim.getMechanismHandle", "simGetMechanismhandle", "mechanism"),
    ] {
        offer.command(
            both(name, MINUS, move |c| -> Result {
                let name = c.text(0)?;
                let silent = name.contains("@silentError");
                if c.world().makes_stand_ins() && !silent {
                    // A number that names no object, and the same in each run.
                    let sum = name.bytes().fold(0_i64, |sum, b| (31 * sum + i64::from(b)) & 0xFFFF);
                    c.ret(REGISTERED + sum);
                    return Ok(());
                }
                Err(Fail::missing(format!("there is no {text} `{name}`")))
            })
            .old_name(irregular, MINUS)
            .param(Param::string("name"))
            .returns(Param::int("object"))
            .text(format!("Finds a registered {text}."))
            .partial(format!("Scenes here have no registered {text}s: none is ever found.")),
        );
    }
}

struct Way(Closest);

impl Way {
    fn length(&self) -> f64 {
        (0..3).map(|i| (self.0.from[i] - self.0.to[i]).powi(2)).sum::<f64>().sqrt()
    }
}

fn closest(c: &Ctx<'_>, limit: f64) -> Result<Option<Way>> {
    let first = collections::entity(c, 0)?;
    let second = if c.i64(1)? == HANDLE_ALL { Vec::new() } else { collections::entity(c, 1)? };
    if !second.is_empty() && first.iter().all(|o| second.contains(o)) {
        return Ok(None);
    }
    let shapes = |all: &[tatu_object]| all.iter().any(|o| c.world().look(*o).is_ok_and(|o| o.kind == TATU_KIND_SHAPE));
    if !shapes(&first) || !second.is_empty() && !shapes(&second) {
        return Ok(None);
    }
    Ok(c.world().closest(&first, &second, limit)?.map(Way))
}
