//! Commands for joints, Jacobians and the equations of motion.

use tatu_plugin_api::{
    abi::tatu_slot,
    safe::{Fail, Offer, Param, Result, Value},
};

use crate::{
    mechanism::Mechanism,
    plugin::{CallMechanism, Cmd, Ctx, Kin, gravity, model, object, q, qd, rows, wrong},
};

/// Returns the objects that have positions, and where their positions and velocities begin, from 1.
fn joints(c: &mut Ctx<'_>) -> Result {
    let (world, p) = (c.world(), &c.plugin().props);
    let all = Mechanism::read(&world, p, object(c, 0)?)?;
    let (mut first, mut begin) = ([1, 1], [Vec::new(), Vec::new()]);
    for link in &all.links {
        let counts = [link.joint.positions(), link.joint.velocities()];
        for ((first, begin), count) in first.iter_mut().zip(&mut begin).zip(counts) {
            begin.push(*first);
            *first += count as i64;
        }
    }
    let handles: Vec<i64> = all.records.iter().map(|r| i64::from(tatu_slot(r.owner))).collect();
    let [q, v] = begin;
    c.ret(handles);
    c.ret(q);
    c.ret(v);
    Ok(())
}

fn jacobian(c: &mut Ctx<'_>) -> Result {
    let mut call = CallMechanism::read(c)?;
    call.take_q(c, 2)?;
    let (world, p) = (c.world(), &c.plugin().props);
    let tip = object(c, 1)?;
    let link = call.mechanism.link_of(&world, p, tip)?;
    let in_link = call.mechanism.records[link].pose.inverse() * tatu_kinematics_common::pose_of(world.pose(tip, 0)?);
    let dynamics = call.dynamics()?;
    let n = call.tree.velocities();
    let mut out = vec![0.0; 6 * n];
    let at = dynamics.kinematics().pose(link).unwrap_or_default() * in_link;
    dynamics.kinematics().jacobian(&call.tree, link, at.translation.vector, &mut out).map_err(wrong)?;
    let (t, r) = (at.translation, at.rotation);
    c.ret(rows(&out, n));
    c.ret([t.x, t.y, t.z, r.i, r.j, r.k, r.w]);
    Ok(())
}

fn mass_matrix(c: &mut Ctx<'_>) -> Result {
    let mut call = CallMechanism::read(c)?;
    call.refuse_large()?;
    call.take_q(c, 1)?;
    let n = call.tree.velocities();
    let mut out = vec![0.0; n * n];
    call.dynamics()?.mass_matrix(&call.tree, &mut out).map_err(wrong)?;
    call.massless_velocities().iter().for_each(|d| out[d * n + d] -= 1.0);
    c.ret(rows(&out, n));
    Ok(())
}

fn gravity_torques(c: &mut Ctx<'_>) -> Result {
    let mut call = CallMechanism::read(c)?;
    call.take_q(c, 1)?;
    call.state.v.fill(0.0);
    let mut out = vec![0.0; call.tree.velocities()];
    call.dynamics()?.bias(&call.tree, gravity(c)?, &mut out).map_err(wrong)?;
    return_finite(c, out)
}

fn inverse_dynamics(c: &mut Ctx<'_>) -> Result {
    let mut call = CallMechanism::read(c)?;
    call.take_q(c, 1)?;
    call.take_qd(c, 2)?;
    let n = call.tree.velocities();
    let acceleration = call.velocities(c, 3, "qdd")?.unwrap_or_else(|| vec![0.0; n]);
    let mut out = vec![0.0; n];
    call.dynamics()?.inverse(&call.tree, &acceleration, gravity(c)?, &mut out).map_err(wrong)?;
    call.massless_velocities().iter().for_each(|d| out[*d] -= acceleration[*d]);
    return_finite(c, out)
}

fn forward_dynamics(c: &mut Ctx<'_>) -> Result {
    let mut call = CallMechanism::read(c)?;
    call.take_q(c, 2)?;
    call.take_qd(c, 3)?;
    let n = call.tree.velocities();
    call.refuse_massless(c)?;
    let force = call.velocities(c, 1, "forces")?.unwrap_or_else(|| vec![0.0; n]);
    let mut out = vec![0.0; n];
    call.dynamics()?.forward(&call.tree, &force, gravity(c)?, &mut out).map_err(wrong)?;
    return_finite(c, out)
}

/// Returns numbers as a result, unless one is not finite.
fn return_finite(c: &mut Ctx<'_>, numbers: Vec<f64>) -> Result {
    if numbers.iter().any(|x| !x.is_finite()) {
        return Err(Fail::argument("the result is not finite: positions, velocities or forces are too large"));
    }
    c.ret(numbers);
    Ok(())
}

fn energy(c: &mut Ctx<'_>) -> Result {
    let mut call = CallMechanism::read(c)?;
    call.take_q(c, 1)?;
    call.take_qd(c, 2)?;
    let (kinetic, potential) = call.dynamics()?.energy(&call.tree, gravity(c)?).map_err(wrong)?;
    let surplus: f64 = call.massless_velocities().iter().map(|d| 0.5 * call.state.v[*d] * call.state.v[*d]).sum();
    if !(kinetic - surplus).is_finite() || !potential.is_finite() {
        return Err(Fail::argument("the energy is not finite: velocities or positions are too large"));
    }
    c.ret(Value::Float(kinetic - surplus));
    c.ret(Value::Float(potential));
    Ok(())
}

pub fn offer(offer: &mut Offer<Kin>) {
    offer.command(
        Cmd::new("tatu.kin.joints", joints)
            .param(model())
            .returns(Param::ints("joints", 0).text("handles; a base that is not fixed comes first, with its shape"))
            .returns(Param::ints("first_q", 0).text("for each, the index of its first position, from 1"))
            .returns(Param::ints("first_qd", 0).text("for each, the index of its first velocity, from 1"))
            .text("Returns the joints of a mechanism, in the order of all arrays of positions, velocities and forces."),
    );
    offer.command(
        Cmd::new("tatu.kin.jacobian", jacobian)
            .param(model())
            .param(Param::int("tip").text("the handle of an object that the mechanism moves"))
            .param(q())
            .returns(Param::list("jacobian").text("6 rows, with a column for each velocity: the tip's velocity, m/s, then its angular velocity, rad/s, in the world frame"))
            .returns(Param::floats("pose", 7).unit("m").text("of the tip: x y z, then the quaternion x y z w"))
            .text("Returns the Jacobian of an object: its velocity for velocities of the joints."),
    );
    offer.command(
        Cmd::new("tatu.kin.massMatrix", mass_matrix)
            .param(model())
            .param(q())
            .returns(Param::list("matrix").text("kg m^2 or kg m or kg: rows, with `joint.armature` on the diagonal"))
            .text("Returns the mass matrix of a mechanism: the forces of the joints per acceleration."),
    );
    offer.command(
        Cmd::new("tatu.kin.gravityTorques", gravity_torques)
            .param(model())
            .param(q())
            .returns(Param::floats("forces", 0).text("N m or N"))
            .text("Returns the forces of the joints that hold a mechanism against gravity."),
    );
    offer.command(
        Cmd::new("tatu.kin.inverseDynamics", inverse_dynamics)
            .param(model())
            .param(q())
            .param(qd())
            .param(Param::floats("qdd", 0).optional().text("rad/s^2 or m/s^2: accelerations; omitted: 0"))
            .returns(Param::floats("forces", 0).text("N m or N"))
            .text(
                "Returns the forces of the joints that cause accelerations, against gravity and centrifugal forces. \
                 Without damping, friction, springs and contacts.",
            ),
    );
    offer.command(
        Cmd::new("tatu.kin.forwardDynamics", forward_dynamics)
            .param(model())
            .param(Param::floats("forces", 0).optional().text("N m or N: of the joints; omitted: 0"))
            .param(q())
            .param(qd())
            .returns(Param::floats("qdd", 0).text("rad/s^2 or m/s^2"))
            .text("Returns the accelerations of the joints. Without damping, friction, springs and contacts."),
    );
    offer.command(
        Cmd::new("tatu.kin.energy", energy)
            .param(model())
            .param(q())
            .param(qd())
            .returns(Param::float("kinetic").unit("J"))
            .returns(Param::float("potential").unit("J").text("0 at the origin of the world"))
            .text("Returns the energy of a mechanism."),
    );
}
