//! Commands for arithmetic on matrices, poses, angles and bits. They do not access the scene.

use crate::kit::{
    algebra::{self as al, Matrix, Pose},
    *,
};

pub(crate) fn offer(offer: &mut Offer<Vrep>) {
    matrices(offer);
    poses(offer);
    angles(offer);
    for ([name, flat, oldest], symbol, run) in [
        (["sim.boolOr32", "simBoolOr32", "simBoolOr16"], "or", (|a, b| a | b) as fn(i64, i64) -> i64),
        (["sim.boolAnd32", "simBoolAnd32", "simBoolAnd16"], "and", |a, b| a & b),
        (["sim.boolXor32", "simBoolXor32", "simBoolXor16"], "xor", |a, b| a ^ b),
    ] {
        offer.command(
            Cmd::side_by_side(name, move |c| {
                let bits = run(c.i64(0)?, c.i64(1)?);
                c.ret(bits);
                Ok(())
            })
            .old_name(oldest, MINUS_ONE)
            .old_name(flat, MINUS_ONE)
            .param(Param::int("a"))
            .param(Param::int("b"))
            .returns(Param::int("bits"))
            .text(format!("Returns the bitwise {symbol} of two integers."))
            .example(format!("bits = {name}(a, b)")),
        );
    }
}

/// Builds a command with a current and a flat name, which may run in parallel with others.
fn command(names: CommandNames, run: impl Fn(&mut SharedCtx<'_>) -> Result + Send + Sync + 'static) -> Cmd {
    both_parallel(names, NIL, run)
}
fn modern(name: &str, run: impl Fn(&mut SharedCtx<'_>) -> Result + Send + Sync + 'static) -> Cmd {
    Cmd::side_by_side(name, run)
}
fn matrix(key: &str) -> Param {
    table(key, "12 numbers: rows of {x axis, y axis, z axis, position}")
}
fn pose(key: &str) -> Param {
    table(key, "{x, y, z, qx, qy, qz, qw}")
}
fn return_numbers<const N: usize>(c: &mut SharedCtx<'_>, numbers: [f64; N]) -> Result {
    c.ret(&numbers[..]);
    Ok(())
}
/// Returns the pose in argument `i`, with its quaternion normalized.
fn read_pose(c: &SharedCtx<'_>, i: usize) -> Result<Pose> {
    let p: Pose = numbers(c, i)?;
    Ok(al::pose(al::position(&p), unit(al::rotation(&p), i)?))
}

fn matrices(offer: &mut Offer<Vrep>) {
    let out = || Param::floats("matrix", 12);
    offer.command(
        command(["sim.buildIdentityMatrix", "simBuildIdentityMatrix"], |c| {
            return_numbers(c, al::matrix(&al::IDENTITY))
        })
        .returns(out())
        .text("Returns the identity matrix.")
        .example("m = sim.buildIdentityMatrix()"),
    );
    offer.command(
        command(["sim.buildMatrix", "simBuildMatrix"], |c| {
            let q = al::from_euler(numbers(c, 1)?);
            return_numbers(c, al::matrix(&al::pose(numbers(c, 0)?, q)))
        })
        .param(table("position", "{x, y, z}"))
        .param(table("angles", "{alpha, beta, gamma} rad"))
        .returns(out())
        .text("Returns the matrix of a position and Euler angles.")
        .example("m = sim.buildMatrix({0, 0, 1}, {0, 0, math.pi})"),
    );
    offer.command(
        command(["sim.buildMatrixQ", "simBuildMatrixQ"], |c| {
            let q = unit(numbers(c, 1)?, 1)?;
            return_numbers(c, al::matrix(&al::pose(numbers(c, 0)?, q)))
        })
        .param(table("position", "{x, y, z}"))
        .param(table("quaternion", "{x, y, z, w}"))
        .returns(out())
        .text("Returns the matrix of a position and a quaternion.")
        .example("m = sim.buildMatrixQ({0, 0, 1}, {0, 0, 0, 1})"),
    );
    offer.command(
        command(["sim.multiplyMatrices", "simMultiplyMatrices"], |c| {
            let product = al::multiply(&numbers(c, 0)?, &numbers(c, 1)?);
            return_numbers(c, product)
        })
        .param(matrix("a"))
        .param(matrix("b"))
        .returns(out())
        .text("Returns the product of two matrices.")
        .example("m = sim.multiplyMatrices(worldFromBody, bodyFromSensor)"),
    );
    offer.command(
        command(["sim.multiplyVector", "simMultiplyVector"], multiply_vector)
            .old_name("simTransformVector", NIL)
            .param(matrix("matrix").text("or a pose {x, y, z, qx, qy, qz, qw}"))
            .param(table("vector", "{x, y, z}, or several concatenated vectors"))
            .returns(Param::floats("vector", 0))
            .text("Returns points transformed by a matrix.")
            .example("p = sim.multiplyVector(m, {0, 0, 1})"),
    );
    offer.command(
        command(["sim.getInvertedMatrix", "simGetInvertedMatrix"], |c| return_numbers(c, al::invert(&numbers(c, 0)?)))
            .alias("sim.getMatrixInverse")
            .param(matrix("matrix"))
            .returns(out())
            .text("Returns the inverse of a matrix.")
            .example("m = sim.getInvertedMatrix(m)"),
    );
    offer.command(
        command(["sim.copyMatrix", "simCopyMatrix"], |c| return_numbers::<12>(c, numbers(c, 0)?))
            .param(matrix("matrix"))
            .returns(out())
            .text("Returns a copy of a matrix.")
            .example("m2 = sim.copyMatrix(m)"),
    );
    offer.command(
        command(["sim.interpolateMatrices", "simInterpolateMatrices"], |c| {
            let (a, b): (Matrix, Matrix) = (numbers(c, 0)?, numbers(c, 1)?);
            let between = al::interpolate(&al::of_matrix(&a), &al::of_matrix(&b), c.f64(2)?);
            return_numbers(c, al::matrix(&between))
        })
        .param(matrix("a"))
        .param(matrix("b"))
        .param(Param::float("t").text("0: a, 1: b"))
        .returns(out())
        .text("Interpolates between two matrices, along a straight line and the shortest rotation.")
        .example("m = sim.interpolateMatrices(a, b, 0.5)"),
    );
    offer.command(
        command(["sim.getEulerAnglesFromMatrix", "simGetEulerAnglesFromMatrix"], |c| {
            let p = al::of_matrix(&numbers(c, 0)?);
            return_numbers(c, al::to_euler(al::rotation(&p)))
        })
        .param(matrix("matrix"))
        .returns(Param::floats("angles", 3).unit("rad"))
        .text("Returns the Euler angles of a matrix.")
        .example("angles = sim.getEulerAnglesFromMatrix(m)"),
    );
    offer.command(
        command(["sim.getQuaternionFromMatrix", "simGetQuaternionFromMatrix"], |c| {
            let p = al::of_matrix(&numbers(c, 0)?);
            return_numbers(c, al::rotation(&p))
        })
        .param(matrix("matrix"))
        .returns(Param::floats("quaternion", 4))
        .text("Returns the quaternion {x, y, z, w} of a matrix.")
        .example("q = sim.getQuaternionFromMatrix(m)"),
    );
    offer.command(
        command(["sim.getRotationAxis", "simGetRotationAxis"], |c| {
            let read = |i: usize| -> Result<Pose> {
                if c.arg(i).len() >= 12 { Ok(al::of_matrix(&numbers(c, i)?)) } else { read_pose(c, i) }
            };
            let (a, b) = (al::rotation(&read(0)?), al::rotation(&read(1)?));
            let (axis, angle) = al::axis_angle(al::compose_rotations(b, al::conjugate(a)));
            return_numbers(c, axis)?;
            c.ret(angle);
            Ok(())
        })
        .param(matrix("start").text("or a pose"))
        .param(matrix("goal").text("or a pose"))
        .returns(Param::floats("axis", 3))
        .returns(Param::float("angle").unit("rad"))
        .text("Returns the axis and angle of the rotation from one frame to another.")
        .example("axis, angle = sim.getRotationAxis(a, b)"),
    );
    offer.command(
        command(["sim.rotateAroundAxis", "simRotateAroundAxis"], |c| {
            let (axis, at, angle) = (numbers(c, 1)?, numbers::<3>(c, 2)?, c.f64(3)?);
            let turn = al::about(axis, angle).ok_or_else(|| Fail::argument("argument 2: the axis must not be zero"))?;
            let there = al::pose(al::sub(at, al::rotate(turn, at)), turn);
            if c.arg(0).len() >= 12 {
                let m: Matrix = numbers(c, 0)?;
                return_numbers(c, al::multiply(&al::matrix(&there), &m))
            } else {
                let p = read_pose(c, 0)?;
                return_numbers(c, al::compose(&there, &p))
            }
        })
        .param(matrix("matrix").text("or a pose"))
        .param(table("axis", "{x, y, z}"))
        .param(table("axisPosition", "a point on the axis, m"))
        .param(Param::float("angle").unit("rad"))
        .returns(out())
        .text("Rotates a matrix about an axis.")
        .example("m = sim.rotateAroundAxis(m, {0, 0, 1}, {0, 0, 0}, math.pi / 2)"),
    );
}

fn multiply_vector(c: &mut SharedCtx<'_>) -> Result {
    let m: Matrix = match c.arg(0).len() {
        7 => al::matrix(&read_pose(c, 0)?),
        _ => numbers(c, 0)?,
    };
    let all = c.arg(1).numbers().unwrap_or_default();
    if all.is_empty() || !all.len().is_multiple_of(3) {
        numbers::<3>(c, 1)?;
    }
    let points: Vec<f64> = all.chunks_exact(3).flat_map(|p| al::multiply_vector(&m, [p[0], p[1], p[2]])).collect();
    c.ret(points.as_slice());
    Ok(())
}

fn poses(offer: &mut Offer<Vrep>) {
    let out = || Param::floats("pose", 7);
    offer.command(
        modern("sim.buildPose", |c| {
            let q = if c.arg(1).len() >= 4 { unit(numbers(c, 1)?, 1)? } else { al::from_euler(numbers(c, 1)?) };
            return_numbers(c, al::pose(numbers(c, 0)?, q))
        })
        .param(table("position", "{x, y, z}"))
        .param(table("rotation", "{alpha, beta, gamma} rad, or a quaternion {x, y, z, w}"))
        .returns(out())
        .text("Returns the pose of a position and a rotation.")
        .example("pose = sim.buildPose({0, 0, 1}, {0, 0, 0})"),
    );
    offer.command(
        modern("sim.multiplyPoses", |c| {
            let product = al::compose(&read_pose(c, 0)?, &read_pose(c, 1)?);
            return_numbers(c, product)
        })
        .param(pose("a"))
        .param(pose("b"))
        .returns(out())
        .text("Returns the product of two poses.")
        .example("pose = sim.multiplyPoses(worldFromBody, bodyFromSensor)"),
    );
    offer.command(
        modern("sim.getPoseInverse", |c| return_numbers(c, al::inverse(&read_pose(c, 0)?)))
            .param(pose("pose"))
            .returns(out())
            .text("Returns the inverse of a pose.")
            .example("pose = sim.getPoseInverse(pose)"),
    );
    offer.command(
        modern("sim.interpolatePoses", |c| {
            let between = al::interpolate(&read_pose(c, 0)?, &read_pose(c, 1)?, c.f64(2)?);
            return_numbers(c, between)
        })
        .param(pose("a"))
        .param(pose("b"))
        .param(Param::float("t").text("0: a, 1: b"))
        .returns(out())
        .text("Interpolates between two poses, along a straight line and the shortest rotation.")
        .example("pose = sim.interpolatePoses(a, b, 0.5)"),
    );
    offer.command(
        modern("sim.matrixToPose", |c| return_numbers(c, al::of_matrix(&numbers(c, 0)?)))
            .param(matrix("matrix"))
            .returns(out())
            .text("Returns the pose of a matrix.")
            .example("pose = sim.matrixToPose(m)"),
    );
    offer.command(
        modern("sim.poseToMatrix", |c| return_numbers(c, al::matrix(&read_pose(c, 0)?)))
            .param(pose("pose"))
            .returns(Param::floats("matrix", 12))
            .text("Returns the matrix of a pose.")
            .example("m = sim.poseToMatrix(pose)"),
    );
}

fn angles(offer: &mut Offer<Vrep>) {
    let three = |command: Cmd, [a, b, g]: [&str; 3], [x, y, z]: [&str; 3]| {
        let angle = |key: &str| Param::float(key).unit("rad");
        command.param(angle(a)).param(angle(b)).param(angle(g)).returns(angle(x)).returns(angle(y)).returns(angle(z))
    };
    let (ypr, abg) = (["yaw", "pitch", "roll"], ["alpha", "beta", "gamma"]);
    offer.command(
        three(
            command(["sim.yawPitchRollToAlphaBetaGamma", "simYawPitchRollToAlphaBetaGamma"], |c| {
                let e = al::to_euler(al::from_yaw_pitch_roll([c.f64(0)?, c.f64(1)?, c.f64(2)?]));
                e.iter().for_each(|x| c.ret(*x));
                Ok(())
            }),
            ypr,
            abg,
        )
        .text("Converts yaw, pitch and roll (about z, then the new y, then the new x) to Euler angles.")
        .example("a, b, g = sim.yawPitchRollToAlphaBetaGamma(yaw, pitch, roll)"),
    );
    offer.command(
        three(
            command(["sim.alphaBetaGammaToYawPitchRoll", "simAlphaBetaGammaToYawPitchRoll"], |c| {
                let e = al::to_yaw_pitch_roll(al::from_euler([c.f64(0)?, c.f64(1)?, c.f64(2)?]));
                e.iter().for_each(|x| c.ret(*x));
                Ok(())
            }),
            abg,
            ypr,
        )
        .text("Converts Euler angles to yaw, pitch and roll (about z, then the new y, then the new x).")
        .example("yaw, pitch, roll = sim.alphaBetaGammaToYawPitchRoll(a, b, g)"),
    );
}
