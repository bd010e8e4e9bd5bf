//! Commands on the scene tree: parents, children, lists, removal.

use super::handles::{kinds_of, type_of};
use crate::kit::*;

pub(crate) fn offer(offer: &mut Offer<Vrep>) {
    offer.command(
        Cmd::new("sim.getObjectParent", |c| {
            let object = id(c, 0)?;
            let up = parent(c, object)?;
            if up == 0 {
                c.world().missed_parent(object);
            }
            c.ret(handle(up));
            Ok(())
        })
        .old_name("simGetObjectParent", MINUS_ONE)
        .param(object("object"))
        .returns(Param::int("parent").text("-1: none"))
        .text("Returns the parent of an object.")
        .example("robot = sim.getObjectParent(motor)"),
    );
    offer.command(
        Cmd::new("sim.setObjectParent", set_parent)
            .old_name("simSetObjectParent", MINUS_ONE)
            .param(flagged("object"))
            .param(Param::int("parent").text("-1: none"))
            .param(Param::any("keepInPlace").default(true).optional().text(
                "true: the object keeps its pose in the world; false: it keeps its pose relative to \
                    its parent",
            ))
            .text("Makes an object the child of another.")
            .example("sim.setObjectParent(box, gripper, true)"),
    );
    offer.command(
        Cmd::new("sim.getObjectChild", |c| {
            let base = base(c, 0)?;
            let index = usize::try_from(c.i64(1)?).ok();
            let below = c.world().list(base, 0, TATU_LIST_CHILDREN | TATU_LIST_SKIP_BASE)?;
            let child = index.and_then(|i| below.get(i).copied()).unwrap_or(0);
            if child == 0 {
                c.world().missed_child(base, "");
            }
            c.ret(handle(child));
            Ok(())
        })
        .old_name("simGetObjectChild", MINUS_ONE)
        .param(Param::int("object").text("a handle, or sim.handle_scene"))
        .param(Param::int("index").text("from 0"))
        .returns(Param::int("child").text("-1: the index is past the last child"))
        .text("Returns a child of an object, by index.")
        .example("first = sim.getObjectChild(robot, 0)"),
    );
    offer.command(
        Cmd::new("sim.getObjectsInTree", |c| {
            let (base, kind) = (base(c, 0)?, int_or(c, 1, HANDLE_ALL)?);
            let options = int_or(c, 2, 0)?;
            let mut flags = 0;
            if options & 1 != 0 {
                flags |= TATU_LIST_SKIP_BASE;
            }
            if options & 2 != 0 {
                flags |= TATU_LIST_CHILDREN;
            }
            let all = typed(c, base, kind, flags)?;
            if let (true, Some((_, kind))) = (all.is_empty(), STAND_IN_KINDS.iter().find(|(n, _)| *n == kind)) {
                c.world().missed_child(base, kind);
            }
            c.ret(all.as_slice());
            Ok(())
        })
        .old_name("simGetObjectsInTree", NIL)
        .param(Param::int("object").text("a handle, or sim.handle_scene"))
        .param(Param::int("type").default(-2).optional().text("sim.object_..._type, or sim.handle_all"))
        .param(
            Param::int("options").default(0).optional().text("1: excludes the object itself, 2: only direct children"),
        )
        .returns(Param::list("objects"))
        .text("Lists an object and its descendants, level by level.")
        .example("joints = sim.getObjectsInTree(robot, sim.object_joint_type)"),
    );
    offer.command(
        Cmd::new("sim.getObjects", |c| {
            let (index, kind) = (usize::try_from(c.i64(0)?).ok(), int_or(c, 1, HANDLE_ALL)?);
            let all = typed(c, 0, kind, 0)?;
            let one = index.and_then(|i| all.get(i).copied()).unwrap_or(-1);
            c.ret(one);
            Ok(())
        })
        .old_name("simGetObjects", MINUS_ONE)
        .param(Param::int("index").text("from 0"))
        .param(Param::int("type").default(-2).optional().text("sim.object_..._type, or sim.handle_all"))
        .returns(Param::int("object").text("-1: the index is past the last object"))
        .text("Returns an object of a type, by index.")
        .example("firstShape = sim.getObjects(0, sim.object_shape_type)"),
    );
    offer.command(
        Cmd::new("sim.removeObject", |c| {
            if c.i64(0)? == HANDLE_ALL {
                let all = c.world().list(0, 0, 0)?;
                c.world().remove(&all)?;
            } else {
                let o = existing_object(c, 0)?;
                c.world().remove(&[o.id])?;
            }
            finish_setter(c)
        })
        .old_name("simRemoveObject", MINUS_ONE)
        .param(flagged("object"))
        .text("Removes an object; its children become children of its parent.")
        .example("sim.removeObject(box)"),
    );
    offer.command(
        Cmd::new("sim.removeObjects", |c| {
            let v = c.arg(0);
            let all = (0..v.len())
                .map(|i| {
                    let n = v.number(i).unwrap_or(-1.0) as i64;
                    let id = u64::try_from(n & HANDLE_BITS).unwrap_or(0);
                    match c.world().look(id) {
                        Ok(o) if n > 0 => Ok(o.id),
                        _ => Err(Fail::missing(format!("element {}: there is no object {n}", i + 1))),
                    }
                })
                .collect::<Result<Vec<_>>>()?;
            c.world().remove(&all)
        })
        .param(Param::list("objects").text("handles"))
        .param(Param::any("delayed").optional().text("ignored: scripts of removed objects end at the next stage"))
        .text("Removes objects; their children become children of the removed objects' parents.")
        .example("sim.removeObjects({box, ball})"),
    );
    offer.command(
        Cmd::new("sim.removeModel", |c| {
            let o = existing_object(c, 0)?;
            if !bool_of(c, o.id, c.plugin().p.model_base)? {
                return Err(Fail::argument(format!(
                    "object {} `{}` is not the base of a model",
                    o.handle(),
                    path(c, o.id)
                )));
            }
            let all = c.world().list(o.id, 0, 0)?;
            c.world().remove(&all)?;
            c.ret(all.len() as i64);
            Ok(())
        })
        .old_name("simRemoveModel", MINUS_ONE)
        .param(flagged("model"))
        .returns(Param::int("count"))
        .text("Removes a model: its base and all descendants.")
        .example("sim.removeModel(robot)"),
    );
}

/// Returns the object in argument `i`, or 0 for the scene.
fn base(c: &Ctx<'_>, i: usize) -> Result<tatu_object> {
    if c.i64(i)? == HANDLE_SCENE {
        return Ok(0);
    }
    Ok(existing_object(c, i)?.id)
}

/// V-REP types, and the kinds of the substitute objects that a run without a scene creates if a search by type finds no
/// object.
const STAND_IN_KINDS: &[(i64, &str)] = &[(0, "shape"), (1, "joint"), (5, "proximity/1"), (12, "force_sensor")];

/// Returns the objects of a V-REP type at and below `base`.
fn typed(c: &Ctx<'_>, base: tatu_object, kind: i64, flags: u32) -> Result<Vec<i64>> {
    let Some(kinds) = kinds_of(kind) else {
        return Ok(Vec::new());
    };
    let w = c.world();
    let mut all = w.list(base, kinds, flags)?;
    if matches!(kind, 5 | 9) {
        // `list` selects by kinds of the core, which do not distinguish V-REP's types of sensors.
        all.retain(|o| w.look(*o).is_ok_and(|o| type_of(c, o) == kind));
    }
    Ok(all.into_iter().map(handle).collect())
}

fn set_parent(c: &mut Ctx<'_>) -> Result {
    let (o, p, w) = (existing_object(c, 0)?.id, &c.plugin().p, c.world());
    let up = if c.i64(1)? == -1 { 0 } else { existing_object(c, 1)?.id };
    let keep = !c.has(2) || c.arg(2).truthy();
    if keep {
        let pose = w.pose(o, 0)?;
        w.set(o, p.parent, &Value::Object(up))?;
        w.set_pose(o, 0, &pose)?;
    } else {
        let pose = w.f64s::<7>(o, p.local_pose)?;
        w.set(o, p.parent, &Value::Object(up))?;
        w.set_f64s(o, p.local_pose, &pose)?;
    }
    finish_setter(c)
}
