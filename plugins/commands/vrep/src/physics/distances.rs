//! Commands on collisions and distances between shapes.

use crate::{
    kit::*,
    lookup::{
        entities::{self, Entity},
        registered::{by_name, return_handle},
    },
    state::state,
};

pub(crate) fn offer(offer: &mut Offer<Vrep>) {
    let entity = |key: &str| Param::int(key).text("a shape or a collection");
    let second = || {
        Param::int("second").text("a shape, a collection, or sim.handle_all: all other shapes; the same collection twice: its shapes among each other, without those of one link and of links that a joint connects")
    };
    let notes = "Meshes that are not convex are hollow surfaces: a shape entirely inside does not touch them.";
    offer.command(
        both(["sim.checkCollision", "simCheckCollision"], MINUS_ONE, |c| {
            let touching =
                closest(c, &entities::entity(c, 0)?, &entities::entity(c, 1)?, 1e-9)?.filter(|d| d.length() == 0.0);
            c.ret(i64::from(touching.is_some()));
            if version(c) >= (4, 0) {
                c.ret(&touching.map_or([-1, -1], |d| d.0.pair.map(handle))[..]);
            }
            Ok(())
        })
        .param(entity("first"))
        .param(second())
        .returns(Param::int("result").text("1: they overlap"))
        .returns(Param::list("objects").text("the two shapes, since 4.0; -1 if none overlap"))
        .text("Returns whether shapes overlap.")
        .notes(notes),
    );
    offer.command(
        both(["sim.checkDistance", "simCheckDistance"], NIL, |c| {
            let threshold = if c.has(2) { c.f64(2)? } else { 0.0 };
            let found = closest(c, &entities::entity(c, 0)?, &entities::entity(c, 1)?, threshold)?;
            let modern = version(c) >= (4, 0);
            c.ret(i64::from(found.is_some()));
            match found {
                Some(d) => {
                    let Closest { from: [a, b, x], to: [e, f, g], pair } = d.0;
                    c.ret(&[a, b, x, e, f, g, d.length()][..]);
                    if modern {
                        c.ret(&pair.map(handle)[..]);
                    }
                }
                None if modern => {
                    c.ret(&[0.0; 7][..]);
                    c.ret(&[-1_i64, -1][..]);
                }
                None => {}
            }
            Ok(())
        })
        .param(entity("first"))
        .param(second())
        .param(Param::float("threshold").unit("m").default(0.0).optional().text("0: any distance"))
        .returns(Param::int("result").text("1; 0: they are farther apart"))
        .returns(Param::floats("data", 7).text("both ends of the shortest connection, and its length"))
        .returns(Param::list("objects").text("the two shapes, since 4.0"))
        .text("Computes the shortest distance between shapes.")
        .notes(notes),
    );
    for (names, irregular, text) in [
        (["sim.getIkGroupHandle", "simGetIkGroupHandle"], "simGetIkGrouphandle", "IK group"),
        (["sim.getMechanismHandle", "simGetMechanismHandle"], "simGetMechanismhandle", "mechanism"),
    ] {
        let command = both(names, MINUS_ONE, move |c| -> Result {
            let name = c.text(0)?;
            let known: Vec<(String, i64)> = match text {
                "IK group" => state(c)?.registered.ik_groups.iter().map(|g| (g.name.clone(), g.handle)).collect(),
                _ => Vec::new(),
            };
            let found = by_name(c, &name, known.iter().map(|(n, h)| (n.as_str(), *h)))?;
            return_handle(c, &name, text, found)
        })
        .old_name(irregular, MINUS_ONE)
        .param(Param::string("name"))
        .returns(Param::int("object"))
        .text(format!("Finds the {text} with this name in the scene."));
        offer.command(match text {
            "IK group" => command,
            _ => command.partial(format!("There is no solver for {text}s.")),
        });
    }
}

/// The shortest segment between two entities.
pub(crate) struct ShortestSegment(pub(crate) Closest);

impl ShortestSegment {
    pub(crate) fn length(&self) -> f64 {
        (0..3).map(|i| (self.0.from[i] - self.0.to[i]).powi(2)).sum::<f64>().sqrt()
    }
}

/// Returns the shortest segment between the shapes of two entities. If `limit`, m, is greater than 0, segments longer
/// than `limit` are ignored. If both entities have the same objects, the segment is the shortest among their shapes that
/// are not neighbours. Returns `None` if there is no such segment: one of the entities has no shapes, the second one
/// contains the first and more, or both are the whole scene.
pub(crate) fn closest(c: &Ctx<'_>, first: &Entity, second: &Entity, limit: f64) -> Result<Option<ShortestSegment>> {
    let (first, second) = match (first, second) {
        (Entity::Objects(a), Entity::Objects(b)) => (a.as_slice(), b.as_slice()),
        (Entity::Objects(a), Entity::All) | (Entity::All, Entity::Objects(a)) => (a.as_slice(), &[][..]),
        (Entity::All, Entity::All) => return Ok(None),
    };
    if !second.is_empty() && first.iter().all(|o| second.contains(o)) {
        return if first.len() == second.len() { among_each_other(c, first, limit) } else { Ok(None) };
    }
    let shapes = |all: &[tatu_object]| all.iter().any(|o| c.world().look(*o).is_ok_and(|o| o.kind == TATU_KIND_SHAPE));
    if !shapes(first) || !second.is_empty() && !shapes(second) {
        return Ok(None);
    }
    Ok(c.world().closest(first, second, limit)?.map(ShortestSegment))
}

/// Returns the shortest segment between two of these shapes that are not neighbours in a chain.
fn among_each_other(c: &Ctx<'_>, objects: &[tatu_object], limit: f64) -> Result<Option<ShortestSegment>> {
    let is_shape = |o: &tatu_object| c.world().look(*o).is_ok_and(|o| o.kind == TATU_KIND_SHAPE);
    let shapes: Vec<tatu_object> = objects.iter().copied().filter(is_shape).collect();
    let groups = shapes.iter().map(|shape| rigid_group(c, *shape)).collect::<Result<Vec<_>>>()?;
    let mut shortest: Option<ShortestSegment> = None;
    for (i, shape) in shapes.iter().enumerate() {
        let rest: Vec<tatu_object> =
            (i + 1..shapes.len()).filter(|j| !groups[i].is_neighbour(&groups[*j])).map(|j| shapes[j]).collect();
        if rest.is_empty() {
            continue;
        }
        let reach = shortest.as_ref().map_or(limit, ShortestSegment::length);
        if let Some(found) = c.world().closest(&[*shape], &rest, reach)?.map(ShortestSegment)
            && shortest.as_ref().is_none_or(|known| found.length() < known.length())
        {
            shortest = Some(found);
        }
        if shortest.as_ref().is_some_and(|s| s.length() == 0.0) {
            break;
        }
    }
    Ok(shortest)
}

/// A shape's place in a chain of links: the topmost object that no joint separates from it, and the link above, on which
/// a joint holds it.
struct RigidGroup {
    root: tatu_object,
    above: tatu_object,
}

impl RigidGroup {
    /// Returns whether nothing, or a single joint, separates the shapes of two groups.
    fn is_neighbour(&self, other: &RigidGroup) -> bool {
        self.root == other.root || self.above == other.root || other.above == self.root
    }
}

/// Returns the group of an object. Links without shapes, between the joints of a wrist, are skipped.
fn rigid_group(c: &Ctx<'_>, object: tatu_object) -> Result<RigidGroup> {
    let (root, joint) = rigid_root(c, object)?;
    let mut above = 0;
    let mut next = if joint == 0 { 0 } else { parent(c, joint)? };
    while next != 0 {
        let (root, joint) = rigid_root(c, next)?;
        above = root;
        // The objects from `next` up to `root` are of this link.
        let mut has_shape = false;
        let mut at = next;
        loop {
            has_shape |= c.world().look(at)?.kind == TATU_KIND_SHAPE;
            if at == root {
                break;
            }
            at = parent(c, at)?;
        }
        if has_shape || joint == 0 {
            break;
        }
        next = parent(c, joint)?;
    }
    Ok(RigidGroup { root, above })
}

/// Returns the topmost object that no joint separates from an object, and the joint above it, or 0.
fn rigid_root(c: &Ctx<'_>, mut object: tatu_object) -> Result<(tatu_object, tatu_object)> {
    loop {
        let above = parent(c, object)?;
        if above == 0 {
            return Ok((object, 0));
        }
        if c.world().look(above)?.kind == TATU_KIND_JOINT {
            return Ok((object, above));
        }
        object = above;
    }
}
