//! Computes the shortest distance between shapes, and whether physics moves an object.

use std::cell::RefCell;

use nalgebra::{Isometry3, Quaternion, Translation3, UnitQuaternion};
use tatu_plugin_api::abi::*;
use tatu_scene::{Dynamics, ObjectVariant, Scene, collision_parts};

use super::answer::{AnswerContext, busy, input_slice, require, slot, with_context};
use crate::cell::{
    HostFunction, WorldCell,
    calls::cost::{LOOKUP_COST, PAIR_COST},
};

/// Largest difference of the length of a quaternion from 1.
const MAX_NORM_ERROR: f64 = 1e-3;

/// The parts of the world that are required to read bodies.
pub(super) struct BodyContext<'a> {
    pub scene: &'a RefCell<Scene>,
    pub dynamics: &'a RefCell<Dynamics>,
    pub answer: AnswerContext<'a>,
}

impl<'a> From<&'a WorldCell> for BodyContext<'a> {
    fn from(world: &'a WorldCell) -> Self {
        BodyContext { scene: &world.state.scene, dynamics: &world.state.dynamics, answer: world.into() }
    }
}

/// Finds the two closest points between any shape of one list and any shape of the other. An empty second list stands
/// for all other shapes. `limit` is the maximum distance, m; if it is not positive, there is no limit.
#[allow(clippy::too_many_arguments, reason = "the ABI fixes the signature")]
pub(super) unsafe extern "C" fn closest(
    w: WorldRef<'_>,
    a: *const tatu_object,
    n_a: u32,
    b: *const tatu_object,
    n_b: u32,
    limit: f64,
    points: Option<&mut [f64; 6]>,
    pair: Option<&mut [tatu_object; 2]>,
) -> tatu_status {
    // SAFETY: the header requires the lists to be null or to hold as many handles as stated, for the whole call.
    unsafe {
        with_context(w, HostFunction::read_only("bodies.closest"), |context: BodyContext<'_>| {
            let list = |p: *const tatu_object, n: u32| input_slice(context.answer, "a list of objects", p, n);
            write_closest(&context, list(a, n_a)?, None, list(b, n_b)?, limit, (points, pair))
        })
    }
}

/// Finds the two closest points like [`closest`], with the shapes of the first list at other poses.
#[allow(clippy::too_many_arguments, reason = "the ABI fixes the signature")]
pub(super) unsafe extern "C" fn closest_at(
    w: WorldRef<'_>,
    a: *const tatu_object,
    poses: *const [f64; 7],
    n_a: u32,
    b: *const tatu_object,
    n_b: u32,
    limit: f64,
    points: Option<&mut [f64; 6]>,
    pair: Option<&mut [tatu_object; 2]>,
) -> tatu_status {
    // SAFETY: the header requires the lists to be null or to hold as many handles and poses as stated, for the whole call.
    unsafe {
        with_context(w, HostFunction::read_only("bodies.closest_at"), |context: BodyContext<'_>| {
            let list = |p: *const tatu_object, n: u32| input_slice(context.answer, "a list of objects", p, n);
            let given = input_slice(context.answer, "a list of poses", poses, n_a)?;
            let poses = given.iter().map(finite_pose).collect::<Option<Vec<_>>>().ok_or_else(|| {
                let text = "a pose must be 7 finite numbers: x y z and a unit quaternion x y z w";
                context.answer.calls.refuse(TATU_ERR_ARGUMENT, text)
            })?;
            write_closest(&context, list(a, n_a)?, Some(&poses), list(b, n_b)?, limit, (points, pair))
        })
    }
}

/// Returns the pose that finite numbers and a quaternion of a length near 1 describe.
fn finite_pose(p: &[f64; 7]) -> Option<Isometry3<f64>> {
    let turned = Quaternion::new(p[6], p[3], p[4], p[5]);
    let is_unit = p.iter().all(|x| x.is_finite()) && (turned.norm() - 1.0).abs() < MAX_NORM_ERROR;
    is_unit.then(|| Isometry3::from_parts(Translation3::new(p[0], p[1], p[2]), UnitQuaternion::new_normalize(turned)))
}

/// Writes the closest points of two lists of shapes, the first at `poses` if given, and these shapes.
fn write_closest(
    BodyContext { scene, answer, .. }: &BodyContext<'_>,
    a: &[tatu_object],
    poses: Option<&[Isometry3<f64>]>,
    b: &[tatu_object],
    limit: f64,
    (points, pair): (Option<&mut [f64; 6]>, Option<&mut [tatu_object; 2]>),
) -> Result<(), tatu_status> {
    let answer = *answer;
    let scene = scene.try_borrow().map_err(|_| busy(answer))?;
    let slots = |ids: &[tatu_object]| -> Result<Vec<u32>, tatu_status> {
        ids.iter().map(|o| slot(answer, &scene, *o)).collect()
    };
    let (a, mut b) = (slots(a)?, slots(b)?);
    if b.is_empty() {
        b = scene.slots().map(|(s, _)| s).filter(|s| !a.contains(s)).collect();
    }
    let solid = |s: u32, pose: Option<Isometry3<f64>>| {
        let parts = collision_parts(scene.get(s)?.shape()?);
        Some((s, pose.unwrap_or_else(|| scene.world(s)), parts))
    };
    let placed = |i: usize| poses.and_then(|p| p.get(i)).copied();
    let a: Vec<_> = a.iter().enumerate().filter_map(|(i, s)| solid(*s, placed(i))).collect();
    let b: Vec<_> = b.iter().filter_map(|s| solid(*s, None)).collect();
    let forms = |solids: &[(u32, _, Vec<_>)]| solids.iter().map(|(_, _, parts)| parts.len() as u64).sum::<u64>();
    let cost = LOOKUP_COST * (a.len() + b.len()) as u64 + PAIR_COST * forms(&a).saturating_mul(forms(&b));
    answer.calls.cost.charge(cost);
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
    *require(answer, "room for 6 numbers", points)? = numbers;
    *require(answer, "room for 2 objects", pair)? = [scene.id(sa), scene.id(sb)];
    Ok(())
}

/// Returns whether physics currently moves an object, which is the case for dynamic shapes and for joints between two
/// bodies of the engine.
pub(super) extern "C" fn is_dynamic(w: WorldRef<'_>, object: tatu_object, out: Option<&mut u32>) -> tatu_status {
    with_context(w, HostFunction::read_only("bodies.is_dynamic"), |BodyContext { scene, answer, .. }| {
        let out = require(answer, "a pointer for the answer", out)?;
        let scene = scene.try_borrow().map_err(|_| busy(answer))?;
        let s = slot(answer, &scene, object)?;
        *out = u32::from(match scene.get(s).map(|o| &o.data) {
            Some(ObjectVariant::Shape(s)) => s.dynamic && s.body.0.is_some(),
            Some(ObjectVariant::Joint(j)) => j.id.is_some(),
            _ => false,
        });
        Ok(())
    })
}
