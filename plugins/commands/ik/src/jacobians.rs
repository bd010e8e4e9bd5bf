//! Commands that return Jacobians.

use tatu_kinematics::{Constraints, GroupJacobian, IkTask, group_jacobian};
use tatu_plugin_api::safe::{Command, Fail, Offer, Param, Result};

use crate::{
    arguments::{command, frame, frame_or_world, pose},
    environment::{Ctx, Ik, environment},
    groups::group_command,
};

/// Returns the elements of a Jacobian, row by row.
fn rows(jacobian: &GroupJacobian) -> Vec<f64> {
    jacobian.matrix.transpose().as_slice().to_vec()
}

/// Returns sqrt(det(J J')), or 0 if there are more rows than columns.
pub fn manipulability(jacobian: &GroupJacobian) -> f64 {
    let j = &jacobian.matrix;
    if j.nrows() == 0 || j.nrows() > j.ncols() {
        return 0.0;
    }
    (j * j.transpose()).determinant().max(0.0).sqrt()
}

/// Returns the Jacobian of the group in argument 2.
fn of_group(c: &Ctx<'_>) -> Result<GroupJacobian> {
    let mut environment = environment(c)?;
    let tasks = environment.group(c.i64(1)?)?.group.tasks.clone();
    Ok(group_jacobian(&environment.copy.linkage, &tasks))
}

/// Stores the Jacobian of a group, which `getJacobian` and `getManipulability` return later.
fn store(c: &mut Ctx<'_>) -> Result {
    let found = of_group(c)?;
    let stored = (rows(&found), [found.matrix.nrows(), found.matrix.ncols()], manipulability(&found));
    let is_found = !stored.0.is_empty();
    environment(c)?.group(c.i64(1)?)?.jacobian = Some(stored);
    c.ret(is_found);
    Ok(())
}

/// Returns the Jacobian of a chain to the script. Arguments 2 to 7 are the base, the last joint, the constraints, the
/// pose of the tip, and optionally the pose of the target and the object whose axes are used.
fn of_chain(c: &mut Ctx<'_>) -> Result {
    let found = {
        let mut environment = environment(c)?.clone();
        let (base, last) = (frame_or_world(c, &environment, 1)?, frame(c, &environment, 2)?);
        let mask = u32::try_from(c.i64(3)?).ok().filter(|m| *m < 32);
        let mask = mask.ok_or_else(|| Fail::argument("argument 4: expected a sum of constraints from 0 to 31"))?;
        let at = pose(c, 4)?;
        let tip = environment.copy.linkage.add_frame(Some(last), nalgebra::Isometry3::identity());
        environment.copy.linkage.set_pose(tip, &at);
        let target = environment.copy.linkage.add_frame(None, if c.has(5) { pose(c, 5)? } else { at });
        let axes = frame_or_world(c, &environment, 6)?;
        let task = IkTask { base, axes, constraints: Constraints(mask), ..IkTask::new(tip, target) };
        group_jacobian(&environment.copy.linkage, &[task])
    };
    c.ret(rows(&found));
    c.ret(found.error.as_slice());
    Ok(())
}

fn stored(c: &Ctx<'_>) -> Result<(Vec<f64>, [usize; 2], f64)> {
    let stored = environment(c)?.group(c.i64(1)?)?.jacobian.clone();
    stored
        .ok_or_else(|| Fail::new("no Jacobian was computed for this group").help("call `simIK.computeJacobian` first"))
}

pub fn offer(offer: &mut Offer<Ik>) {
    offer.command(
        group_command("computeGroupJacobian", |c| {
            let found = of_group(c)?;
            c.ret(rows(&found));
            c.ret(found.error.as_slice());
            Ok(())
        })
        .returns(Param::floats("jacobian", 0).text("row by row: x, y, z, alpha, beta, gamma, as far as constrained"))
        .returns(Param::floats("error", 0).text("remaining error of each constrained coordinate, m or rad"))
        .text("Returns the Jacobian of a group, with a column per degree of freedom, from base to tip."),
    );
    let compute: Command<Ik> = command("computeJacobian", |c| {
        // Up to version 4.4, the command stored the Jacobian of a group instead of returning that of a chain.
        if c.has(3) { of_chain(c) } else { store(c) }
    });
    offer.command(
        compute
            .param(Param::int("base").text("-1: the world"))
            .param(Param::any("last_joint"))
            .param(Param::int("constraints").optional())
            .param(Param::any("tip_pose").optional())
            .param(Param::any("target_pose").optional())
            .param(Param::any("axes").optional())
            .returns(Param::any("jacobian").text("row by row"))
            .returns(Param::floats("error", 0).optional())
            .text("Returns the Jacobian of a chain of joints.")
            .notes(
                "With a group and options, as until version 4.4, it stores that of the group for `simIK.getJacobian`, \
                 and returns whether there is one.",
            ),
    );
    offer.command(
        group_command("getJacobian", |c| {
            let (rows, [m, n], _) = stored(c)?;
            c.ret(rows);
            c.ret([m as i64, n as i64]);
            Ok(())
        })
        .returns(Param::floats("jacobian", 0).text("row by row"))
        .returns(Param::ints("size", 2).text("rows and columns"))
        .text("Returns the Jacobian that `simIK.computeJacobian` has stored."),
    );
    offer.command(
        group_command("getManipulability", |c| {
            let found = stored(c)?.2;
            c.ret(found);
            Ok(())
        })
        .returns(Param::float("manipulability"))
        .text("Returns the manipulability of the stored Jacobian J: the square root of the determinant of J J'."),
    );
}
