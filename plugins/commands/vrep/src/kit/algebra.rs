//! Rotations and poses in V-REP's conventions, as plain functions.
//!
//! A quaternion is x y z w; a pose is x y z and a quaternion; a matrix is 12 numbers, three rows of `[X Y Z p]`. Euler
//! angles rotate about the body's x axis, then its y axis, then its z axis: `R = Rx(alpha) Ry(beta) Rz(gamma)`.

pub(crate) type Vector = [f64; 3];
pub(crate) type Quaternion = [f64; 4];
pub(crate) type Pose = [f64; 7];
pub(crate) type Matrix = [f64; 12];

pub(crate) const IDENTITY: Pose = [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0];

pub(crate) fn position([x, y, z, ..]: &Pose) -> Vector {
    [*x, *y, *z]
}
pub(crate) fn rotation([.., x, y, z, w]: &Pose) -> Quaternion {
    [*x, *y, *z, *w]
}
pub(crate) fn pose(p: Vector, q: Quaternion) -> Pose {
    [p[0], p[1], p[2], q[0], q[1], q[2], q[3]]
}

/// Returns the unit quaternion with the same direction, or `None` for zero.
pub(crate) fn normalized(q: Quaternion) -> Option<Quaternion> {
    let n = q.iter().map(|x| x * x).sum::<f64>().sqrt();
    (n > 1e-12).then(|| q.map(|x| x / n))
}

/// Composes two rotations: `a`, followed by `b` about the rotated axes.
pub(crate) fn compose_rotations(a: Quaternion, b: Quaternion) -> Quaternion {
    let ([ax, ay, az, aw], [bx, by, bz, bw]) = (a, b);
    [
        aw * bx + ax * bw + ay * bz - az * by,
        aw * by - ax * bz + ay * bw + az * bx,
        aw * bz + ax * by - ay * bx + az * bw,
        aw * bw - ax * bx - ay * by - az * bz,
    ]
}
pub(crate) fn conjugate([x, y, z, w]: Quaternion) -> Quaternion {
    [-x, -y, -z, w]
}
pub(crate) fn cross(a: Vector, b: Vector) -> Vector {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}
pub(crate) fn add(a: Vector, b: Vector) -> Vector {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}
pub(crate) fn sub(a: Vector, b: Vector) -> Vector {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}
pub(crate) fn length(a: Vector) -> f64 {
    (a[0] * a[0] + a[1] * a[1] + a[2] * a[2]).sqrt()
}

/// Rotates the vector `v` by the unit quaternion `q`.
pub(crate) fn rotate(q: Quaternion, v: Vector) -> Vector {
    let u = [q[0], q[1], q[2]];
    let t = cross(u, v).map(|x| 2.0 * x);
    let s = cross(u, t);
    [v[0] + q[3] * t[0] + s[0], v[1] + q[3] * t[1] + s[1], v[2] + q[3] * t[2] + s[2]]
}

/// Composes two poses. `b` is relative to the frame `a`; the result is relative to the frame to which `a` is relative.
pub(crate) fn compose(a: &Pose, b: &Pose) -> Pose {
    let q = rotation(a);
    pose(add(position(a), rotate(q, position(b))), compose_rotations(q, rotation(b)))
}
pub(crate) fn inverse(a: &Pose) -> Pose {
    let q = conjugate(rotation(a));
    pose(rotate(q, position(a)).map(|x| -x), q)
}

/// Returns the quaternion of a rotation about an axis, or `None` if the axis is zero.
pub(crate) fn about(axis: Vector, angle: f64) -> Option<Quaternion> {
    let n = length(axis);
    let (s, c) = libm::sincos(angle / 2.0);
    (n > 1e-12).then(|| [axis[0] / n * s, axis[1] / n * s, axis[2] / n * s, c])
}
/// Returns the axis of a rotation, and its angle from 0 to pi. The axis of the identity is z.
pub(crate) fn axis_angle(q: Quaternion) -> (Vector, f64) {
    let q = if q[3] < 0.0 { q.map(|x| -x) } else { q };
    let v = [q[0], q[1], q[2]];
    let s = length(v);
    if s < 1e-12 {
        return ([0.0, 0.0, 1.0], 0.0);
    }
    (v.map(|x| x / s), 2.0 * libm::atan2(s, q[3]))
}

pub(crate) fn from_euler([a, b, g]: Vector) -> Quaternion {
    let half = |x: f64| libm::sincos(x / 2.0);
    let ((sa, ca), (sb, cb), (sg, cg)) = (half(a), half(b), half(g));
    compose_rotations(compose_rotations([sa, 0.0, 0.0, ca], [0.0, sb, 0.0, cb]), [0.0, 0.0, sg, cg])
}
/// Returns the rows of the rotation matrix.
fn rows([x, y, z, w]: Quaternion) -> [Vector; 3] {
    [
        [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - z * w), 2.0 * (x * z + y * w)],
        [2.0 * (x * y + z * w), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - x * w)],
        [2.0 * (x * z - y * w), 2.0 * (y * z + x * w), 1.0 - 2.0 * (x * x + y * y)],
    ]
}
fn euler_of_rows(r: [Vector; 3]) -> Vector {
    let beta = libm::asin(r[0][2].clamp(-1.0, 1.0));
    if r[0][2].abs() < 0.999_995 {
        [libm::atan2(-r[1][2], r[2][2]), beta, libm::atan2(-r[0][1], r[0][0])]
    } else {
        // Gimbal lock: the first and last axes coincide, so the whole rotation is assigned to gamma.
        [0.0, beta, libm::atan2(r[1][0], r[1][1])]
    }
}
pub(crate) fn to_euler(q: Quaternion) -> Vector {
    euler_of_rows(rows(q)).map(|x| x + 0.0)
}
/// Returns the rotation by yaw about z, then pitch about the new y, then roll about the new x.
pub(crate) fn from_yaw_pitch_roll([yaw, pitch, roll]: Vector) -> Quaternion {
    let (z, y, x) = (from_euler([0.0, 0.0, yaw]), from_euler([0.0, pitch, 0.0]), from_euler([roll, 0.0, 0.0]));
    compose_rotations(compose_rotations(z, y), x)
}
pub(crate) fn to_yaw_pitch_roll(q: Quaternion) -> Vector {
    let r = rows(q);
    let pitch = libm::asin((-r[2][0]).clamp(-1.0, 1.0));
    if r[2][0].abs() < 0.999_995 {
        [libm::atan2(r[1][0], r[0][0]), pitch, libm::atan2(r[2][1], r[2][2])]
    } else {
        // Gimbal lock: the yaw and roll axes coincide, so the whole rotation is assigned to yaw.
        [libm::atan2(-r[0][1], r[1][1]), pitch, 0.0]
    }
}
pub(crate) fn matrix(p: &Pose) -> Matrix {
    let ([x, y, z], t) = (rows(rotation(p)), position(p));
    [x[0], x[1], x[2], t[0], y[0], y[1], y[2], t[1], z[0], z[1], z[2], t[2]]
}
pub(crate) fn of_matrix(m: &Matrix) -> Pose {
    let q = quaternion_of_rows([[m[0], m[1], m[2]], [m[4], m[5], m[6]], [m[8], m[9], m[10]]]);
    pose([m[3], m[7], m[11]], q)
}
fn quaternion_of_rows(r: [Vector; 3]) -> Quaternion {
    let trace = r[0][0] + r[1][1] + r[2][2];
    let q = if trace > 0.0 {
        let s = 2.0 * (trace + 1.0).sqrt();
        [(r[2][1] - r[1][2]) / s, (r[0][2] - r[2][0]) / s, (r[1][0] - r[0][1]) / s, s / 4.0]
    } else {
        // Starting from the largest diagonal element avoids a division by a small number.
        let i = if r[0][0] >= r[1][1] && r[0][0] >= r[2][2] {
            0
        } else if r[1][1] >= r[2][2] {
            1
        } else {
            2
        };
        let (j, k) = ((i + 1) % 3, (i + 2) % 3);
        let s = 2.0 * (1.0 + r[i][i] - r[j][j] - r[k][k]).max(0.0).sqrt();
        let mut q = [0.0; 4];
        q[i] = s / 4.0;
        q[j] = (r[j][i] + r[i][j]) / s;
        q[k] = (r[k][i] + r[i][k]) / s;
        q[3] = (r[k][j] - r[j][k]) / s;
        q
    };
    normalized(q).unwrap_or([0.0, 0.0, 0.0, 1.0])
}

/// Multiplies two affine matrices, whose 3 x 3 parts need not be rotations.
pub(crate) fn multiply(a: &Matrix, b: &Matrix) -> Matrix {
    let mut out = [0.0; 12];
    for row in 0..3 {
        for column in 0..4 {
            let mut sum = if column == 3 { a[4 * row + 3] } else { 0.0 };
            for k in 0..3 {
                sum += a[4 * row + k] * b[4 * k + column];
            }
            out[4 * row + column] = sum;
        }
    }
    out
}
pub(crate) fn multiply_vector(m: &Matrix, v: Vector) -> Vector {
    [0, 4, 8].map(|i| m[i] * v[0] + m[i + 1] * v[1] + m[i + 2] * v[2] + m[i + 3])
}
/// Inverts a matrix whose 3 x 3 part is a rotation.
pub(crate) fn invert(m: &Matrix) -> Matrix {
    let t = |i: usize| -(m[i] * m[3] + m[i + 4] * m[7] + m[i + 8] * m[11]);
    [m[0], m[4], m[8], t(0), m[1], m[5], m[9], t(1), m[2], m[6], m[10], t(2)]
}
/// Interpolates between two poses: positions linearly, orientations along the shortest rotation.
pub(crate) fn interpolate(a: &Pose, b: &Pose, t: f64) -> Pose {
    let (p, q) = (position(a), position(b));
    let at = [0, 1, 2].map(|i| p[i] + (q[i] - p[i]) * t);
    let (from, to) = (rotation(a), rotation(b));
    let (axis, angle) = axis_angle(compose_rotations(conjugate(from), to));
    let part = about(axis, angle * t).unwrap_or([0.0, 0.0, 0.0, 1.0]);
    pose(at, compose_rotations(from, part))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn near(a: &[f64], b: &[f64]) -> bool {
        a.len() == b.len() && a.iter().zip(b).all(|(x, y)| (x - y).abs() < 1e-12)
    }

    /// Expected elements: tests/facts/script-api.md, section 7.
    #[test]
    fn matrix_of_euler_angles() {
        let (a, b, g) = (0.3_f64, -0.7_f64, 1.9_f64);
        let ((sa, ca), (sb, cb), (sg, cg)) = (libm::sincos(a), libm::sincos(b), libm::sincos(g));
        let expected = [
            cb * cg,
            -cb * sg,
            sb,
            1.0,
            sa * sb * cg + ca * sg,
            -sa * sb * sg + ca * cg,
            -sa * cb,
            2.0,
            -ca * sb * cg + sa * sg,
            ca * sb * sg + sa * cg,
            ca * cb,
            3.0,
        ];
        let p = pose([1.0, 2.0, 3.0], from_euler([a, b, g]));
        assert!(near(&matrix(&p), &expected));
        assert!(near(&to_euler(rotation(&p)), &[a, b, g]));
        assert!(near(&of_matrix(&expected), &p));
    }

    #[test]
    fn gimbal_lock_is_resolved_into_gamma() {
        let q = from_euler([0.4, std::f64::consts::FRAC_PI_2, 0.3]);
        let e = to_euler(q);
        assert_eq!(e[0], 0.0);
        assert!(near(&[e[2]], &[0.7]));
    }

    #[test]
    fn heading_is_gamma() {
        let e = to_euler([0.0, 0.0, libm::sin(0.6_f64), libm::cos(0.6_f64)]);
        assert!(near(&e, &[0.0, 0.0, 1.2]));
    }

    #[test]
    fn poses_and_matrices_agree() {
        let a = pose([1.0, -2.0, 0.5], from_euler([0.2, 0.4, -2.8]));
        let b = pose([-0.3, 0.1, 4.0], from_euler([-1.2, 0.9, 0.1]));
        let product = multiply(&matrix(&a), &matrix(&b));
        assert!(near(&product, &matrix(&compose(&a, &b))));
        assert!(near(&matrix(&compose(&a, &inverse(&a))), &matrix(&IDENTITY)));
        assert!(near(&invert(&matrix(&a)), &matrix(&inverse(&a))));
        let v = [0.7, 0.8, 0.9];
        assert!(near(&multiply_vector(&matrix(&a), v), &position(&compose(&a, &pose(v, rotation(&IDENTITY))))));
    }

    #[test]
    fn yaw_pitch_roll_angles_are_inverted() {
        let angles = [0.5, -0.4, 2.0];
        let q = from_yaw_pitch_roll(angles);
        assert!(near(&to_yaw_pitch_roll(q), &angles));
        assert!(near(&from_yaw_pitch_roll([0.3, 0.0, 0.0]), &from_euler([0.0, 0.0, 0.3])));
    }

    #[test]
    fn poses_are_interpolated_halfway() {
        let a = IDENTITY;
        let b = pose([2.0, 0.0, 0.0], from_euler([0.0, 0.0, 1.0]));
        let half = interpolate(&a, &b, 0.5);
        assert!(near(&position(&half), &[1.0, 0.0, 0.0]));
        assert!(near(&to_euler(rotation(&half)), &[0.0, 0.0, 0.5]));
    }

    #[test]
    fn half_turns_survive_the_matrix_form() {
        for axis in [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]] {
            let q = about(axis, std::f64::consts::PI).unwrap();
            let back = rotation(&of_matrix(&matrix(&pose([0.0; 3], q))));
            assert!(near(&axis_angle(back).0.map(f64::abs), &axis));
        }
    }
}
