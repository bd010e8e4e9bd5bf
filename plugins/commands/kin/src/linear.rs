//! The command `tatu.linearize`: a linear model of a mechanism.

use nalgebra::Vector3;
use tatu_mechanisms::{Dynamics, Joint, TreeState};
use tatu_plugin_api::{
    abi::{TATU_KIND_JOINT, tatu_object},
    safe::{Fail, Offer, Param, Result, ValueRef},
};

use crate::{
    mechanism::path,
    plugin::{CallMechanism, Cmd, Ctx, Kin, check_options, gravity, model, numbers, rows, wrong},
    state::advanced,
};

/// Half of the difference of positions and velocities for derivatives: the cube root of the precision of numbers.
const DIFFERENCE: f64 = 6e-6;

/// Damping and springs of the joints, which act besides the inputs.
struct PassiveForces {
    damping: Vec<f64>,
    /// For each velocity, the index of its position, the stiffness and the rest position.
    springs: Vec<Option<(usize, f64, f64)>>,
}

impl PassiveForces {
    fn read(c: &Ctx<'_>, call: &CallMechanism) -> Result<Self> {
        let (world, p, n) = (c.world(), &c.plugin().props, call.tree.velocities());
        let mut all = PassiveForces { damping: vec![0.0; n], springs: vec![None; n] };
        for (i, (link, record)) in call.mechanism.links.iter().zip(&call.mechanism.records).enumerate() {
            let Some((at, v)) = call.tree.offsets(i).filter(|_| !matches!(link.joint, Joint::Free)) else { continue };
            all.damping[v..v + link.joint.velocities()].fill(link.damping);
            if link.joint.positions() == 1 {
                let [stiffness, rest] = [world.f64(record.owner, p.spring[0])?, world.f64(record.owner, p.spring[1])?];
                all.springs[v] = Some((at, stiffness, rest)).filter(|_| stiffness != 0.0);
            }
        }
        Ok(all)
    }

    fn add_to(&self, state: &TreeState, forces: &mut [f64]) {
        for (d, force) in forces.iter_mut().enumerate() {
            *force -= self.damping[d] * state.v[d];
            if let Some((at, stiffness, rest)) = self.springs[d] {
                *force -= stiffness * (state.q[at] - rest);
            }
        }
    }
}

/// What is needed for accelerations in many states.
struct Model<'a> {
    call: &'a CallMechanism,
    passive: PassiveForces,
    dynamics: Dynamics,
    gravity: Vector3<f64>,
    inputs: Vec<f64>,
}

impl Model<'_> {
    fn acceleration(&mut self, state: &TreeState) -> Result<Vec<f64>> {
        let mut forces = self.inputs.clone();
        self.passive.add_to(state, &mut forces);
        let mut out = vec![0.0; forces.len()];
        self.dynamics.update(&self.call.tree, state).map_err(wrong)?;
        self.dynamics.forward(&self.call.tree, &forces, self.gravity, &mut out).map_err(wrong)?;
        Ok(out)
    }

    /// Returns the derivative of the accelerations by a position or, with `of_velocity`, by a velocity.
    fn derivative(&mut self, k: usize, of_velocity: bool) -> Result<Vec<f64>> {
        let at = |by: f64| {
            if !of_velocity {
                return advanced(&self.call.mechanism, &self.call.tree, &self.call.state, k, by);
            }
            let mut moved = self.call.state.clone();
            moved.v[k] += by;
            moved
        };
        let (high, low) = (at(DIFFERENCE), at(-DIFFERENCE));
        let (high, low) = (self.acceleration(&high)?, self.acceleration(&low)?);
        Ok(high.iter().zip(low).map(|(high, low)| (high - low) / (2.0 * DIFFERENCE)).collect())
    }
}

/// Returns the objects in a list of handles.
fn objects(c: &Ctx<'_>, i: usize) -> Result<Vec<tatu_object>> {
    let wrong = || Fail::argument(format!("argument {}: expected a list of handles", i + 1));
    let handles = c.arg(i).numbers().ok_or_else(wrong)?;
    handles.iter().map(|h| Ok(c.world().look(*h as u64)?.id)).collect()
}

/// Returns the index of the only velocity of a joint.
fn velocity_of(c: &Ctx<'_>, call: &CallMechanism, joint: tatu_object) -> Result<usize> {
    let link = call.mechanism.records.iter().position(|r| r.owner == joint);
    let single = link.filter(|i| call.mechanism.links[*i].joint.velocities() == 1).and_then(|i| call.tree.offsets(i));
    single.map(|(_, v)| v).ok_or_else(|| {
        let path = path(&c.world(), &c.plugin().props, joint);
        Fail::argument(format!("`{path}` is not a revolute or prismatic joint of this mechanism"))
            .help("`tatu.kin.joints` lists the joints of a mechanism")
    })
}

/// Sets the state, and returns the forces, from the table in argument 4.
fn working_point(c: &Ctx<'_>, call: &mut CallMechanism) -> Result<Vec<f64>> {
    let at = c.arg(3);
    check_options(at, 4, &["q", "qd", "forces"])?;
    let of = |key: &str| at.get(key).unwrap_or(ValueRef::NIL);
    let (q, v) = (call.tree.positions(), call.tree.velocities());
    if let Some(q) = numbers(of("q"), "argument 4: `q`", q, "its positions")? {
        call.set_q(q, "argument 4: `q`")?;
    }
    if let Some(qd) = numbers(of("qd"), "argument 4: `qd`", v, "its velocities")? {
        call.state.v = qd;
    }
    Ok(numbers(of("forces"), "argument 4: `forces`", v, "one for each velocity")?.unwrap_or_else(|| vec![0.0; v]))
}

/// Returns the rows of C that select the outputs.
fn output_rows(c: &Ctx<'_>, call: &CallMechanism, dynamics: &mut Dynamics) -> Result<Vec<f64>> {
    let n = call.tree.velocities();
    let (world, p) = (c.world(), &c.plugin().props);
    let mut out = Vec::new();
    if !c.has(2) {
        for k in 0..2 * n {
            out.extend((0..2 * n).map(|j| f64::from(u8::from(j == k))));
        }
        return Ok(out);
    }
    dynamics.update(&call.tree, &call.state).map_err(wrong)?;
    for object in objects(c, 2)? {
        if world.look(object)?.kind == TATU_KIND_JOINT {
            let d = velocity_of(c, call, object)?;
            out.extend((0..2 * n).map(|j| f64::from(u8::from(j == d))));
            continue;
        }
        let link = call.mechanism.link_of(&world, p, object)?;
        let pose = tatu_kinematics_common::pose_of(world.pose(object, 0)?);
        let in_link = call.mechanism.records[link].pose.inverse() * pose;
        let at = dynamics.kinematics().pose(link).unwrap_or_default() * in_link;
        let mut jacobian = vec![0.0; 6 * n];
        dynamics.kinematics().jacobian(&call.tree, link, at.translation.vector, &mut jacobian).map_err(wrong)?;
        for row in jacobian[..3 * n].chunks(n.max(1)) {
            out.extend_from_slice(row);
            out.extend(std::iter::repeat_n(0.0, n));
        }
    }
    Ok(out)
}

fn linearize(c: &mut Ctx<'_>) -> Result {
    let mut call = CallMechanism::read(c)?;
    call.refuse_large()?;
    call.refuse_massless(c)?;
    let forces = working_point(c, &mut call)?;
    let inputs = objects(c, 1)?.iter().map(|o| velocity_of(c, &call, *o)).collect::<Result<Vec<_>>>()?;
    let n = call.tree.velocities();
    let passive = PassiveForces::read(c, &call)?;
    let dynamics = Dynamics::new(&call.tree);
    let mut model = Model { call: &call, passive, dynamics, gravity: gravity(c)?, inputs: forces };
    let (mut a, mut b) = (vec![0.0; 4 * n * n], vec![0.0; 2 * n * inputs.len()]);
    for k in 0..n {
        a[k * 2 * n + n + k] = 1.0;
        for of_velocity in [false, true] {
            let column = model.derivative(k, of_velocity)?;
            for (row, value) in column.iter().enumerate() {
                a[(n + row) * 2 * n + if of_velocity { n + k } else { k }] = *value;
            }
        }
    }
    add_turning(&call, &mut a);
    model.dynamics.update(&call.tree, &call.state).map_err(wrong)?;
    for (k, d) in inputs.iter().enumerate() {
        let mut column = vec![0.0; n];
        column[*d] = 1.0;
        model.dynamics.solve(&call.tree, &mut column).map_err(wrong)?;
        for (row, value) in column.iter().enumerate() {
            b[(n + row) * inputs.len() + k] = *value;
        }
    }
    if !a.iter().chain(&b).all(|x| x.is_finite()) {
        return Err(Fail::argument("the linear model is not finite: velocities or forces are too large"));
    }
    let outputs = output_rows(c, &call, &mut model.dynamics)?;
    let count = outputs.len() / (2 * n).max(1);
    c.ret(rows(&a, 2 * n));
    c.ret(rows(&b, inputs.len()));
    c.ret(rows(&outputs, 2 * n));
    c.ret(rows(&vec![0.0; count * inputs.len()], inputs.len()));
    Ok(())
}

/// Adds how small turns about a link's own axes turn with the link: their derivative has the part -w x turn.
fn add_turning(call: &CallMechanism, a: &mut [f64]) {
    let n = call.tree.velocities();
    for (i, link) in call.mechanism.links.iter().enumerate() {
        let first = match link.joint {
            Joint::Free => 3,
            Joint::Spherical => 0,
            _ => continue,
        };
        let Some((_, v)) = call.tree.offsets(i) else { continue };
        let w = Vector3::from_column_slice(&call.state.v[v + first..v + first + 3]);
        let cross = w.cross_matrix();
        for r in 0..3 {
            for k in 0..3 {
                a[(v + first + r) * 2 * n + v + first + k] -= cross[(r, k)];
            }
        }
    }
}

pub fn offer(offer: &mut Offer<Kin>) {
    offer.command(
        Cmd::new("tatu.linearize", linearize)
            .param(model())
            .param(Param::list("inputs").text("handles of joints whose forces are the inputs u, N m or N"))
            .param(Param::list("outputs").optional().text(
                "handles: of a joint, its position; of another object, its x, y and z, m; omitted: the whole state",
            ))
            .param(Param::map("at").optional().text(
                "the working point: `q`, `qd` (omitted: present) and `forces` of all joints (omitted: 0), such as those \
                 of `tatu.kin.gravityTorques`",
            ))
            .returns(Param::list("A").text("rows; the state x is that of small changes of positions, then of velocities"))
            .returns(Param::list("B").text("rows, with a column for each input"))
            .returns(Param::list("C").text("rows, one for each output"))
            .returns(Param::list("D").text("rows of zeros"))
            .text(
                "Returns the linear model dx/dt = A x + B u, y = C x + D u of a mechanism near a working point, by \
                 central differences. With damping and springs of joints; without dry friction, limits, motors and \
                 contacts. Nothing in the scene moves.",
            ),
    );
}
