//! Poses, which stand in files in two orders.

use nalgebra::{Isometry3, Quaternion, Translation3, UnitQuaternion};

use super::cursor::{Cursor, Read};

/// As a file stores it: quaternion w x y z, then position x y z, m.
pub type Stored = [f64; 7];

/// The default: no rotation, no translation.
pub const IDENTITY: Stored = [1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0];

/// Quaternion first, then position: objects, textures.
pub fn quaternion_first(c: &mut Cursor<'_>) -> Read<Stored> {
    c.reals()
}

/// Position first, then quaternion: all that is inside of meshes, points of paths.
pub fn position_first(c: &mut Cursor<'_>) -> Read<Stored> {
    let [x, y, z, a, b, d, e] = c.reals()?;
    Ok([a, b, d, e, x, y, z])
}

/// As an isometry: quaternions get length 1. Numbers that are none give no turn and no way.
pub fn isometry(stored: &Stored) -> Isometry3<f64> {
    let [w, i, j, k, x, y, z] = stored.map(|x| if x.is_finite() { x } else { 0.0 });
    let q = UnitQuaternion::try_new(Quaternion::new(w, i, j, k), 1e-9).unwrap_or_else(UnitQuaternion::identity);
    Isometry3::from_parts(Translation3::new(x, y, z), q)
}
