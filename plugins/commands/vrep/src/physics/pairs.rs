//! Commands on the collision objects and distance objects of old scenes, each of which is a pair of entities.
//!
//! Pairs with explicit handling are evaluated when a script handles them, all others when they are read.

use super::distances::closest;
use crate::{
    kit::*,
    lookup::{
        entities::{self, Entity},
        registered::{by_name, is_stand_in, return_handle},
    },
    state::{
        registered::{PairResult, RegisteredPair, Registrations},
        state,
    },
};

const NOTES: &str = "Objects without explicit handling are evaluated when they are read, not in the sensing stage.";

/// What a registered pair of entities computes.
#[derive(Clone, Copy)]
enum PairKind {
    Collision,
    Distance,
}
use PairKind::{Collision, Distance};

impl PairKind {
    fn phrase(self) -> &'static str {
        match self {
            Collision => "collision object",
            Distance => "distance object",
        }
    }
    fn all(self, registered: &Registrations) -> &[RegisteredPair] {
        match self {
            Collision => &registered.collisions,
            Distance => &registered.distances,
        }
    }
}

pub(crate) fn offer(offer: &mut Offer<Vrep>) {
    for (sort, get, irregular) in [
        (Collision, ["sim.getCollisionHandle", "simGetCollisionHandle"], "simGetCollisionhandle"),
        (Distance, ["sim.getDistanceHandle", "simGetDistanceHandle"], "simGetDistancehandle"),
    ] {
        let run = move |c: &mut Ctx<'_>| {
            let name = c.text(0)?;
            let known: Vec<(String, i64)> =
                sort.all(&state(c)?.registered).iter().map(|p| (p.name.clone(), p.handle)).collect();
            let found = by_name(c, &name, known.iter().map(|(n, h)| (n.as_str(), *h)))?;
            return_handle(c, &name, sort.phrase(), found)
        };
        offer.command(
            both(get, MINUS_ONE, run)
                .old_name(irregular, MINUS_ONE)
                .param(Param::string("name"))
                .returns(Param::int("object"))
                .text(format!("Finds a {} of the scene.", sort.phrase())),
        );
    }
    for (sort, names) in
        [(Collision, ["sim.readCollision", "simReadCollision"]), (Distance, ["sim.readDistance", "simReadDistance"])]
    {
        offer.command(
            both(names, MINUS_ONE, move |c| {
                let found = read(c, sort)?;
                return_result(c, sort, found)
            })
            .param(Param::int("object"))
            .returns(Param::int("result").text("1: a result was found; 0: none, or the object was never handled"))
            .returns(Param::any("found").text("the two shapes that touch, or the distance in m"))
            .text(format!("Reads a {}.", sort.phrase()))
            .partial(NOTES),
        );
    }
    for (sort, names) in [
        (Collision, ["sim.handleCollision", "simHandleCollision"]),
        (Distance, ["sim.handleDistance", "simHandleDistance"]),
    ] {
        offer.command(
            both(names, MINUS_ONE, move |c| handle_pairs(c, sort))
                .param(Param::int("object").text("sim.handle_all, sim.handle_all_except_explicit, or a handle"))
                .returns(Param::int("result").text("number of results found; for a single object: 1 or 0"))
                .returns(
                    Param::any("found").text("for a single object: the two shapes that touch, or the distance in m"),
                )
                .text(format!("Evaluates {}s.", sort.phrase()))
                .partial(NOTES),
        );
    }
    for (sort, names) in [
        (Collision, ["sim.resetCollision", "simResetCollision"]),
        (Distance, ["sim.resetDistance", "simResetDistance"]),
    ] {
        offer.command(
            both(names, MINUS_ONE, move |c| {
                let which = c.i64(0)?;
                let handles: Vec<i64> = pairs_of_handle(c, sort, which)?.iter().map(|p| p.handle).collect();
                state(c)?.registered.found.retain(|h, _| !handles.contains(h));
                finish_setter(c)
            })
            .param(Param::int("object"))
            .returns(Param::int("result"))
            .text(format!("Discards the result of a {}.", sort.phrase())),
        );
    }
}

/// Returns the pairs for a handle, which may be `sim.handle_all` or `sim.handle_all_except_explicit`.
fn pairs_of_handle(c: &Ctx<'_>, sort: PairKind, which: i64) -> Result<Vec<RegisteredPair>> {
    let all = sort.all(&state(c)?.registered).to_vec();
    let chosen: Vec<RegisteredPair> = match which {
        HANDLE_ALL => all,
        HANDLE_ALL_EXCEPT_EXPLICIT => all.into_iter().filter(|p| !p.explicit).collect(),
        one => all.into_iter().filter(|p| p.handle == one).collect(),
    };
    match chosen.is_empty() && which >= 0 && !is_stand_in(c, which) {
        true => Err(Fail::missing(format!("there is no {} {which}", sort.phrase()))),
        false => Ok(chosen),
    }
}

/// Evaluates a pair. Returns the two closest shapes and their distance, or `None` if the entities do not collide or,
/// for a distance object, are farther apart than its threshold.
fn evaluate(c: &Ctx<'_>, sort: PairKind, pair: &RegisteredPair) -> Result<Option<PairResult>> {
    let entity = |handle: i64| -> Result<Entity> {
        match handle {
            -1 => Ok(Entity::All),
            h if entities::is_collection(c, h)? => Ok(Entity::Objects(entities::objects(c, h)?)),
            h => {
                let id = state(c)?.registered.object(h);
                Ok(Entity::Objects(if id == 0 { Vec::new() } else { vec![id] }))
            }
        }
    };
    let limit = match sort {
        Collision => 1e-9,
        Distance => pair.threshold,
    };
    let found = closest(c, &entity(pair.of[0])?, &entity(pair.of[1])?, limit)?;
    let found = found.map(|w| PairResult { length: w.length(), pair: w.0.pair });
    Ok(match sort {
        Collision => found.filter(|f| f.length == 0.0),
        Distance => found,
    })
}

/// Returns the result of the pair in argument 0. A pair with explicit handling has a stored result; any other pair is
/// evaluated now.
fn read(c: &Ctx<'_>, sort: PairKind) -> Result<Option<PairResult>> {
    let which = c.i64(0)?;
    match pairs_of_handle(c, sort, which)?.as_slice() {
        [one] if !one.explicit => evaluate(c, sort, one),
        [one] => Ok(state(c)?.registered.found.get(&one.handle).copied().flatten()),
        _ => Ok(None),
    }
}

fn handle_pairs(c: &mut Ctx<'_>, sort: PairKind) -> Result {
    let which = c.i64(0)?;
    let pairs = pairs_of_handle(c, sort, which)?;
    let mut all = Vec::new();
    for pair in &pairs {
        let found = evaluate(c, sort, pair)?;
        state(c)?.registered.found.insert(pair.handle, found);
        all.push(found);
    }
    match (which >= 0, all.as_slice()) {
        (true, [one]) => return_result(c, sort, *one),
        _ => {
            let count = all.iter().flatten().count() as i64;
            c.ret(count);
            Ok(())
        }
    }
}

fn return_result(c: &mut Ctx<'_>, sort: PairKind, found: Option<PairResult>) -> Result {
    c.ret(i64::from(found.is_some()));
    match (sort, found) {
        (Collision, found) => c.ret(&found.map_or([-1, -1], |f| f.pair.map(handle))[..]),
        (Distance, Some(found)) => c.ret(found.length),
        (Distance, None) => {}
    }
    Ok(())
}
