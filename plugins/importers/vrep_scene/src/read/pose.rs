//! Poses, which files store in two orders.

use nalgebra::{Isometry3, Quaternion, Translation3, UnitQuaternion};

use super::cursor::{Cursor, ReadResult};

/// A pose as stored: quaternion w x y z, then position x y z, m.
pub type StoredPose = [f64; 7];

/// The default pose: no rotation, no translation.
pub const IDENTITY: StoredPose = [1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0];

/// Reads a quaternion, then a position: used for objects and textures.
pub fn quaternion_first(c: &mut Cursor<'_>) -> ReadResult<StoredPose> {
    c.reals()
}

/// Reads a position, then a quaternion: used inside meshes and for path points.
pub fn position_first(c: &mut Cursor<'_>) -> ReadResult<StoredPose> {
    let [x, y, z, a, b, d, e] = c.reals()?;
    Ok([a, b, d, e, x, y, z])
}

/// Converts a stored pose to an isometry with a unit quaternion. Non-finite numbers are replaced by 0.
pub fn isometry(stored: &StoredPose) -> Isometry3<f64> {
    let [w, i, j, k, x, y, z] = stored.map(|x| if x.is_finite() { x } else { 0.0 });
    let q = UnitQuaternion::try_new(Quaternion::new(w, i, j, k), 1e-9).unwrap_or_else(UnitQuaternion::identity);
    Isometry3::from_parts(Translation3::new(x, y, z), q)
}
