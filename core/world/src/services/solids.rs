//! Solids of shapes: the shortest way between them, and whether physics moves them.

use tatu_plugin_api::abi::*;
use tatu_scene::{Data, collision_parts};

use super::{busy, on, slot};

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
