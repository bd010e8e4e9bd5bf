//! `tatu.host.bodies`: velocities, forces and contacts of bodies.

use nalgebra::Vector3;
use tatu_physics::{BodyContact, BodyId, Twist};
use tatu_plugin_api::abi::*;
use tatu_scene::{ObjectKind, Scene};

use super::answer::{busy, fill, on_world, on_world_or_worker, require, slot, with_context};
use super::solids::BodyContext;
use crate::{
    cell::{HostFunction, WorldCell, scripts::stand_in_use},
    parts,
};

pub static TABLE: tatu_host_bodies = tatu_host_bodies {
    size: size_of::<tatu_host_bodies>() as u32,
    reserved: 0,
    twist: Some(twist),
    set_twist: Some(set_twist),
    push: Some(push),
    impulse: Some(impulse),
    contacts: Some(contacts),
    closest: Some(super::solids::closest),
    is_dynamic: Some(super::solids::is_dynamic),
    frictions: Some(frictions),
    closest_at: Some(super::solids::closest_at),
    hook: Some(hook),
};

extern "C" fn twist(w: WorldRef<'_>, object: tatu_object, out: Option<&mut [f64; 6]>) -> tatu_status {
    on_world_or_worker(w, HostFunction::read_only("bodies.twist"), |world| {
        let (Some(scene), Some(dynamics)) =
            (world.borrow_part(|w| &w.state.scene), world.borrow_part(|w| &w.state.dynamics))
        else {
            return Err(busy(world));
        };
        let s = slot(world, &scene, object)?;
        *require(world, "room for 6 numbers", out)? = world.state.twist(&scene, &dynamics, s);
        Ok(())
    })
}

/// Returns the body of a dynamic shape. If the shape is new, its body is created first.
fn body(world: &WorldCell, object: tatu_object) -> Result<BodyId, tatu_status> {
    match body_now(world, object) {
        Err(TATU_ERR_ARGUMENT) if stand_in_use::infer_kind(world, object, ObjectKind::Shape.name()) => {
            body_now(world, object)
        }
        body => body,
    }
}

fn body_now(world: &WorldCell, object: tatu_object) -> Result<BodyId, tatu_status> {
    let mut scene = world.state.scene.try_borrow_mut().map_err(|_| busy(world))?;
    let s = slot(world, &scene, object)?;
    world.state.dynamics.try_borrow_mut().map_err(|_| busy(world))?.update_bodies(&mut scene);
    let o = scene.get(s);
    let id = o.and_then(|o| o.shape()).filter(|s| s.dynamic).and_then(|s| s.body.0);
    id.ok_or_else(|| {
        let kind = o.map_or("nothing".into(), |o| tatu_errors::with_article(o.kind().name()));
        let text =
            format!("object {s} `{}` is {kind} that forces do not move; expected a dynamic shape", scene.path(s));
        world.run.calls.refuse(TATU_ERR_ARGUMENT, &text)
    })
}

/// Converts three numbers to a vector, which is zero for null. Returns `None` if a number is not finite.
fn finite_vector(v: Option<&[f64; 3]>) -> Option<Vector3<f64>> {
    let v = v.copied().unwrap_or_default();
    v.iter().all(|x| x.is_finite()).then(|| Vector3::from(v))
}

extern "C" fn set_twist(w: WorldRef<'_>, object: tatu_object, twist: Option<&[f64; 6]>) -> tatu_status {
    on_world(w, HostFunction::mutating("bodies.set_twist"), |world| {
        let (linear, angular) = require(world, "a velocity", twist)?.split_at(3);
        let (Some(linear), Some(angular)) = (finite_vector(linear.first_chunk()), finite_vector(angular.first_chunk()))
        else {
            return Err(world.run.calls.refuse(TATU_ERR_ARGUMENT, "a velocity must be 6 finite numbers"));
        };
        match body(world, object) {
            Ok(b) => {
                world.state.dynamics.borrow_mut().set_twist(b, &Twist { linear, angular });
                Ok(())
            }
            Err(status) => Err(status),
        }
    })
}

extern "C" fn push(
    w: WorldRef<'_>,
    object: tatu_object,
    force: Option<&[f64; 3]>,
    torque: Option<&[f64; 3]>,
) -> tatu_status {
    on_world(w, HostFunction::mutating("bodies.push"), |world| {
        let (Some(force), Some(torque)) = (finite_vector(force), finite_vector(torque)) else {
            return Err(world
                .run
                .calls
                .refuse(TATU_ERR_ARGUMENT, "a force and a torque must be 3 finite numbers each"));
        };
        match body(world, object) {
            Ok(b) => {
                world.state.dynamics.borrow_mut().push_from_script(b, force, torque);
                Ok(())
            }
            Err(status) => Err(status),
        }
    })
}

extern "C" fn impulse(
    w: WorldRef<'_>,
    object: tatu_object,
    linear: Option<&[f64; 3]>,
    angular: Option<&[f64; 3]>,
) -> tatu_status {
    on_world(w, HostFunction::mutating("bodies.impulse"), |world| {
        let (Some(linear), Some(angular)) = (finite_vector(linear), finite_vector(angular)) else {
            return Err(world.run.calls.refuse(TATU_ERR_ARGUMENT, "an impulse must be 3 finite numbers"));
        };
        let b = body(world, object)?;
        let (Ok(scene), Ok(mut dynamics)) = (world.state.scene.try_borrow(), world.state.dynamics.try_borrow_mut())
        else {
            return Err(busy(world));
        };
        let Some((s, shape)) = scene.resolve(object).ok().and_then(|s| Some((s, scene.get(s)?.shape()?))) else {
            return Err(busy(world));
        };
        let props = tatu_scene::mass_props(shape);
        let r = scene.world(s).rotation.to_rotation_matrix();
        let inertia = r.matrix() * props.inertia * r.matrix().transpose();
        let mut t = dynamics.twist(shape).unwrap_or_default();
        t.linear += linear / props.mass;
        t.angular += inertia.try_inverse().map_or(Vector3::zeros(), |i| i * angular);
        dynamics.set_twist(b, &t);
        Ok(())
    })
}

extern "C" fn hook(w: WorldRef<'_>, part: tatu_object, a: tatu_object, b: tatu_object, on: u32) -> tatu_status {
    on_world(w, HostFunction::mutating("bodies.hook"), |world| {
        let shape = |object: tatu_object| {
            let scene = world.state.scene.try_borrow().map_err(|_| busy(world))?;
            let s = slot(world, &scene, object)?;
            match scene.get(s).is_some_and(|o| o.shape().is_some()) {
                true => Ok(scene.id(s)),
                false => {
                    let text = format!("object {s} `{}` is not a shape", scene.path(s));
                    Err(world.run.calls.refuse(TATU_ERR_ARGUMENT, &text))
                }
            }
        };
        let pair = (shape(a)?, if b == 0 { 0 } else { shape(b)? });
        let at = world.devices.actuators.try_borrow().map_err(|_| busy(world))?.index(part);
        let decides = |i: &usize| {
            let actuators = world.devices.actuators.borrow();
            world.model.registry.actuators[actuators.devices[*i].kind].part.is_some_and(|p| p.contact.is_some())
        };
        let Some(at) = at.filter(decides) else {
            let text = "`bodies.hook`: the object is not a part with the function `contact`";
            return Err(world.run.calls.refuse(TATU_ERR_ARGUMENT, text));
        };
        parts::register_contact(world, at, pair, on != 0);
        Ok(())
    })
}

unsafe extern "C" fn contacts(
    w: WorldRef<'_>,
    object: tatu_object,
    out: *mut tatu_contact,
    cap: u32,
    n: Option<&mut u32>,
) -> tatu_status {
    // SAFETY: the header requires `out` to be null or to have room for `cap` elements for the whole call.
    unsafe {
        with_context(w, HostFunction::read_only("bodies.contacts"), |c: BodyContext<'_>| {
            let all = contacts_of(&c, object, |scene, (a, b, c)| tatu_contact {
                shape: [scene.id(a), scene.id(b)],
                point: c.point.coords.into(),
                normal: c.normal.into(),
                force: c.force,
            })?;
            fill(&all, out, cap, n)
        })
    }
}

unsafe extern "C" fn frictions(
    w: WorldRef<'_>,
    object: tatu_object,
    out: *mut f64,
    cap: u32,
    n: Option<&mut u32>,
) -> tatu_status {
    // SAFETY: the header requires `out` to be null or to have room for `cap` elements for the whole call.
    unsafe {
        with_context(w, HostFunction::read_only("bodies.frictions"), |c: BodyContext<'_>| {
            let all = contacts_of(&c, object, |_, (_, _, c)| [c.friction.x, c.friction.y, c.friction.z])?;
            fill(all.as_flattened(), out, cap, n)
        })
    }
}

/// Returns the contacts of a shape, or of all shapes if `object` is 0, converted by `show`.
fn contacts_of<T>(
    context: &BodyContext<'_>,
    object: tatu_object,
    show: impl Fn(&Scene, (u32, u32, BodyContact)) -> T,
) -> Result<Vec<T>, tatu_status> {
    let (Ok(scene), Ok(dynamics)) = (context.scene.try_borrow(), context.dynamics.try_borrow()) else {
        return Err(busy(context.answer));
    };
    let wanted = match object {
        0 => None,
        o => Some(slot(context.answer, &scene, o)?),
    };
    let touching = dynamics.contacts(&scene).filter(|(a, b, _)| wanted.is_none_or(|s| *a == s || *b == s));
    Ok(touching.map(|c| show(&scene, c)).collect())
}
