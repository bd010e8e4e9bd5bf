//! Detection volumes of proximity sensors and mills, along the z axis of their object.

use super::{
    cursor::{Cursor, ReadResult},
    section::{object, tags},
    unknown::UnknownElements,
};

/// A detection volume. Fields that `kind` does not use can have any value.
#[derive(Debug, Clone, Default)]
pub struct DetectionVolume {
    /// 0 pyramid, 1 cylinder, 2 disc, 3 cone, 4 ray, 5 random rays.
    pub kind: i32,
    /// Distance from the object to the near end, m.
    pub offset: f64,
    /// Distance from the near end to the far end, m.
    pub range: f64,
    /// Sides of a pyramid's near end along x and y, m.
    pub near: [f64; 2],
    /// Sides of a pyramid's far end along x and y, m.
    pub far: [f64; 2],
    /// Radius of a cylinder, or of the near end of a cone or disc, m.
    pub radius: f64,
    /// Radius of the far end, m.
    pub radius_far: f64,
    /// Full opening angle of a cone or disc, rad.
    pub angle: f64,
    /// Fraction of the opening angle that is excluded, 0 to 1.
    pub inside: f64,
    /// Minimum distance that is detected, m, if enabled.
    pub smallest: Option<f64>,
    threshold: f64,
}

/// Reads the element `Vod`, which contains a detection volume.
pub fn read(c: &mut Cursor<'_>, unknown: &mut UnknownElements) -> ReadResult<DetectionVolume> {
    let mut volume = DetectionVolume::default();
    let tags = tags!(DetectionVolume {
        "Snt" => |v, c, _| Ok(v.kind = c.i32()?),
        "Ss3" | "_s3" => |v, c, _| {
            let [offset, range, nx, ny, fx, fy, near, far, angle] = c.reals()?;
            (v.offset, v.range, v.near, v.far) = (offset, range, [nx, ny], [fx, fy]);
            Ok((v.radius, v.radius_far, v.angle) = (near, far, angle))
        },
        "Sia" | "_ia" => |v, c, _| Ok(v.inside = c.real()?),
        "Wtf" | "_tf" => |v, c, _| Ok(v.threshold = c.real()?),
        "" | "at2" => |v, c, _| Ok(v.threshold = c.real()?),
        "Par" => |v, c, _| Ok(v.smallest = (c.u8()? & 1 != 0).then_some(0.0)),
    });
    const IGNORED: &[&str] = &[
        "Ssi", "Nc0", "Nc1", "Nc2", "Nc3", "Nc4", "Nc5", "Nc6", "_c0", "_c1", "_c2", "_c3", "_c4", "_c5", "Cv2", "Wtd",
    ];
    object(c, tags, IGNORED, &mut volume, unknown)?;
    let told = volume.threshold;
    volume.smallest = volume.smallest.map(|_| told).filter(|t| *t > 0.0);
    Ok(volume)
}
