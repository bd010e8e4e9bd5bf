//! Solids of shapes: copies of objects, and the shortest way between shapes.

use tatu_plugin_api::abi::*;
use tatu_scene::{Data, Scene, collision_parts};

use super::{busy, on, slot};

/// Copies objects: with their place in the world; below the copy of their parent if that is copied too, else below none.
pub(super) unsafe extern "C" fn copy(
    w: *mut tatu_world,
    objects: *const tatu_object,
    n: u32,
    out: *mut tatu_object,
) -> tatu_status {
    // SAFETY: by the contract: `objects` has `n`, `out` has room for `n`.
    unsafe {
        on(w, |world| {
            let objects = if n == 0 { &[] } else { std::slice::from_raw_parts(objects, n as usize) };
            let mut scene = world.scene.try_borrow_mut().map_err(|_| busy(world))?;
            let mut from = Vec::with_capacity(objects.len());
            for o in objects {
                from.push(slot(world, &scene, *o)?);
            }
            if let Some(s) = from.iter().find(|s| scene.get(**s).is_none_or(|o| !is_copied(&o.data))) {
                let kind = scene.get(*s).map_or("nothing", |o| tatu_scene::rows::kind_name(o.kind()));
                let text =
                    format!("object {s} `{}` is a {kind}, which is not copied while the world lives", scene.path(*s));
                return Err(world.calls.refuse(TATU_ERR_UNSUPPORTED, &text));
            }
            let to = copies(&mut scene, &from)
                .ok_or_else(|| world.calls.refuse(TATU_ERR_SPACE, "the world holds a million objects, and no more"))?;
            for (i, s) in to.iter().enumerate() {
                *out.add(i) = scene.id(*s);
            }
            Ok(())
        })
    }
}

/// Devices and scripts have instances, which are made with the world.
fn is_copied(data: &Data) -> bool {
    matches!(data, Data::Shape(_) | Data::Joint(_) | Data::Dummy(_) | Data::ForceSensor(_))
}

fn copies(scene: &mut Scene, from: &[u32]) -> Option<Vec<u32>> {
    // Parents before children, whatever the order of the list.
    let mut order: Vec<usize> = (0..from.len()).collect();
    let depth = |scene: &Scene, mut s: u32| {
        let mut n = 0;
        while let Some(o) = scene.get(s) {
            (s, n) = (o.parent, n + 1);
        }
        n
    };
    order.sort_by_key(|i| depth(scene, from[*i]));
    let mut to = vec![0; from.len()];
    for i in order {
        let o = scene.get(from[i])?;
        let (alias, world, mut data) = (o.alias().to_owned(), scene.world(from[i]), o.data.clone());
        let (model_base, visible, layer, notes) = (scene.is_model_base(from[i]), o.visible, o.layer, o.notes.clone());
        let parent = from.iter().position(|s| *s == o.parent).map_or(0, |p| to[p]);
        match &mut data {
            Data::Shape(s) => s.body = tatu_scene::Body(None),
            Data::Joint(j) => j.id = None,
            _ => {}
        }
        to[i] = scene.add(parent, &alias, scene.frame(parent).inverse() * world, data)?;
        scene.set_model_base(to[i], model_base);
        let o = scene.get_mut(to[i])?;
        (o.visible, o.layer, o.notes) = (visible, layer, notes);
    }
    scene.make_unique(&to);
    Some(to)
}

/// The shortest way between any shape of one list and any of another; an empty second list: all other shapes.
#[allow(clippy::too_many_arguments, reason = "the contract's")]
pub(super) unsafe extern "C" fn closest(
    w: *mut tatu_world,
    a: *const tatu_object,
    n_a: u32,
    b: *const tatu_object,
    n_b: u32,
    limit: f64,
    points: *mut f64,
    pair: *mut tatu_object,
) -> tatu_status {
    // SAFETY: by the contract: the lists have as many as told, `points` room for 6, `pair` for 2.
    unsafe {
        on(w, |world| {
            let scene = world.scene.try_borrow().map_err(|_| busy(world))?;
            let list = |p: *const tatu_object, n: u32| -> Result<Vec<u32>, tatu_status> {
                let ids = if n == 0 { &[] } else { std::slice::from_raw_parts(p, n as usize) };
                ids.iter().map(|o| slot(world, &scene, *o)).collect()
            };
            let (a, mut b) = (list(a, n_a)?, list(b, n_b)?);
            if n_b == 0 {
                b = scene.slots().map(|(s, _)| s).filter(|s| !a.contains(s)).collect();
            }
            let solid = |s: &u32| scene.get(*s).and_then(|o| Some((*s, scene.world(*s), collision_parts(o.shape()?))));
            let (a, b): (Vec<_>, Vec<_>) = (a.iter().filter_map(solid).collect(), b.iter().filter_map(solid).collect());
            let limit = if limit > 0.0 { limit } else { f64::MAX };
            let mut best = None;
            let mut reach = limit;
            for (sa, wa, pa) in &a {
                for (sb, wb, pb) in b.iter().filter(|(sb, ..)| sb != sa) {
                    let Some((p, q)) = tatu_physics::closest((wa, pa), (wb, pb), reach) else { continue };
                    let d = (p - q).norm();
                    if best.is_none() || d < reach {
                        reach = d;
                        best = Some((p, q, *sa, *sb));
                    }
                }
            }
            let Some((p, q, sa, sb)) = best else { return Err(TATU_ERR_MISSING) };
            let numbers = [p.x, p.y, p.z, q.x, q.y, q.z];
            std::ptr::copy_nonoverlapping(numbers.as_ptr(), points, 6);
            std::ptr::copy_nonoverlapping([scene.id(sa), scene.id(sb)].as_ptr(), pair, 2);
            Ok(())
        })
    }
}

/// Whether physics moves an object now: dynamic shapes, and joints that tie two bodies of the engine.
pub(super) unsafe extern "C" fn is_dynamic(w: *mut tatu_world, object: tatu_object, out: *mut u32) -> tatu_status {
    // SAFETY: by the contract.
    unsafe {
        on(w, |world| {
            let scene = world.scene.try_borrow().map_err(|_| busy(world))?;
            let s = slot(world, &scene, object)?;
            *out = u32::from(match scene.get(s).map(|o| &o.data) {
                Some(Data::Shape(s)) => s.dynamic && s.body.0.is_some(),
                Some(Data::Joint(j)) => j.id.is_some(),
                _ => false,
            });
            Ok(())
        })
    }
}
