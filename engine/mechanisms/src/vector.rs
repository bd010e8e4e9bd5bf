//! Vectors, rotations and quaternions as plain arrays, with every operation in a fixed order.
//!
//! The crate uses these types internally instead of those of nalgebra, whose matrix kernels may change the order of
//! additions, and thus the exact results, between versions.

/// A vector of three components.
pub(crate) type Vec3 = [f64; 3];
/// A 3 x 3 matrix in row-major order.
pub(crate) type Mat3 = [f64; 9];
/// A unit quaternion: w, x, y, z.
pub(crate) type Quat = [f64; 4];

pub(crate) const ZERO: Vec3 = [0.0; 3];
pub(crate) const IDENTITY: Mat3 = [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0];

#[inline(always)]
pub(crate) fn add(a: Vec3, b: Vec3) -> Vec3 {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

#[inline(always)]
pub(crate) fn sub(a: Vec3, b: Vec3) -> Vec3 {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

#[inline(always)]
pub(crate) fn scale(a: Vec3, s: f64) -> Vec3 {
    [a[0] * s, a[1] * s, a[2] * s]
}

#[inline(always)]
pub(crate) fn dot(a: Vec3, b: Vec3) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

#[inline(always)]
pub(crate) fn cross(a: Vec3, b: Vec3) -> Vec3 {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// Returns the dot product of two sequences; excess elements of the longer one are ignored. The sum is computed in four
/// interleaved parts, which processors can add in parallel.
#[inline]
pub(crate) fn dot_slices(a: &[f64], b: &[f64]) -> f64 {
    let (a, b) = (&a[..a.len().min(b.len())], &b[..a.len().min(b.len())]);
    let (a, b) = (a.chunks_exact(4), b.chunks_exact(4));
    let rest: f64 = a.remainder().iter().zip(b.remainder()).map(|(a, b)| a * b).sum();
    let mut sums = [0.0; 4];
    for (a, b) in a.zip(b) {
        for (sum, (a, b)) in sums.iter_mut().zip(a.iter().zip(b)) {
            *sum += a * b;
        }
    }
    (sums[0] + sums[1]) + (sums[2] + sums[3]) + rest
}

/// Returns the product of a matrix and a vector.
#[inline(always)]
pub(crate) fn turn(m: &Mat3, v: Vec3) -> Vec3 {
    [
        m[0] * v[0] + m[1] * v[1] + m[2] * v[2],
        m[3] * v[0] + m[4] * v[1] + m[5] * v[2],
        m[6] * v[0] + m[7] * v[1] + m[8] * v[2],
    ]
}

/// Returns the product of two matrices.
#[inline(always)]
pub(crate) fn product(a: &Mat3, b: &Mat3) -> Mat3 {
    let mut out = [0.0; 9];
    for i in 0..3 {
        for j in 0..3 {
            out[3 * i + j] = a[3 * i] * b[j] + a[3 * i + 1] * b[3 + j] + a[3 * i + 2] * b[6 + j];
        }
    }
    out
}

/// Returns column `k` of a matrix.
#[inline(always)]
pub(crate) fn column(m: &Mat3, k: usize) -> Vec3 {
    [m[k], m[3 + k], m[6 + k]]
}

/// Returns the rotation about a unit axis by the angle with the given sine and cosine.
#[inline(always)]
pub(crate) fn rotation(axis: Vec3, sine: f64, cosine: f64) -> Mat3 {
    let t = 1.0 - cosine;
    let [x, y, z] = axis;
    [
        t * x * x + cosine,
        t * x * y - sine * z,
        t * x * z + sine * y,
        t * x * y + sine * z,
        t * y * y + cosine,
        t * y * z - sine * x,
        t * x * z - sine * y,
        t * y * z + sine * x,
        t * z * z + cosine,
    ]
}

/// Returns the product of a matrix and a rotation about coordinate axis `axis`, which changes only the other two
/// columns.
#[inline(always)]
pub(crate) fn turned_about(m: &Mat3, axis: usize, sine: f64, cosine: f64) -> Mat3 {
    let mut out = *m;
    let mut mix = |a: usize, b: usize| {
        for row in [0, 3, 6] {
            let (x, y) = (m[row + a], m[row + b]);
            out[row + a] = cosine * x + sine * y;
            out[row + b] = cosine * y - sine * x;
        }
    };
    match axis {
        0 => mix(1, 2),
        1 => mix(2, 0),
        _ => mix(0, 1),
    }
    out
}

/// Returns the rotation matrix of a unit quaternion.
#[inline(always)]
pub(crate) fn rotation_of(q: Quat) -> Mat3 {
    let [w, x, y, z] = q;
    [
        1.0 - 2.0 * (y * y + z * z),
        2.0 * (x * y - w * z),
        2.0 * (x * z + w * y),
        2.0 * (x * y + w * z),
        1.0 - 2.0 * (x * x + z * z),
        2.0 * (y * z - w * x),
        2.0 * (x * z - w * y),
        2.0 * (y * z + w * x),
        1.0 - 2.0 * (x * x + y * y),
    ]
}

/// Returns a unit quaternion advanced by a time `h` at the constant angular velocity `w` in the body's own axes.
///
/// Source: the exponential map of the rotation group; the result is normalised, so that errors do not accumulate.
pub(crate) fn turned(q: Quat, w: Vec3, h: f64) -> Quat {
    let rate = dot(w, w).sqrt();
    let half = 0.5 * h * rate;
    let (sine, cosine) = libm::sincos(half);
    // Below 1e-8, sin(x) / x rounds to 1.
    let factor = if half > 1e-8 { sine / rate } else { 0.5 * h };
    let e = [cosine, w[0] * factor, w[1] * factor, w[2] * factor];
    normalized([
        q[0] * e[0] - q[1] * e[1] - q[2] * e[2] - q[3] * e[3],
        q[0] * e[1] + q[1] * e[0] + q[2] * e[3] - q[3] * e[2],
        q[0] * e[2] - q[1] * e[3] + q[2] * e[0] + q[3] * e[1],
        q[0] * e[3] + q[1] * e[2] - q[2] * e[1] + q[3] * e[0],
    ])
}

/// Normalises a quaternion; returns the identity if the square of its norm is 0 or not finite.
pub(crate) fn normalized(q: Quat) -> Quat {
    let square = q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3];
    if square > 0.0 && square.is_finite() {
        let s = 1.0 / square.sqrt();
        [q[0] * s, q[1] * s, q[2] * s, q[3] * s]
    } else {
        [1.0, 0.0, 0.0, 0.0]
    }
}

/// Returns the unit quaternion of a rotation matrix, w first; w is not negative.
///
/// Source: Shepperd's method, which selects one of four formulas by the diagonal so that precision is not lost.
pub(crate) fn quaternion_of(m: &Mat3) -> Quat {
    let [xx, yy, zz] = [m[0], m[4], m[8]];
    let trace = xx + yy + zz;
    let q = if trace > 0.0 {
        [1.0 + trace, m[7] - m[5], m[2] - m[6], m[3] - m[1]]
    } else if xx >= yy && xx >= zz {
        [m[7] - m[5], 1.0 + xx - yy - zz, m[1] + m[3], m[2] + m[6]]
    } else if yy >= zz {
        [m[2] - m[6], m[1] + m[3], 1.0 + yy - xx - zz, m[5] + m[7]]
    } else {
        [m[3] - m[1], m[2] + m[6], m[5] + m[7], 1.0 + zz - xx - yy]
    };
    let q = normalized(q);
    if q[0] < 0.0 { q.map(|x| -x) } else { q }
}
