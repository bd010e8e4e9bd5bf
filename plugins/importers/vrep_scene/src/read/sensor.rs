//! Proximity, vision and force sensors: the specific parts of objects in `SNR`, `RSN` and `FSE`.

use super::{
    section::{ElementTag, object, tags},
    volume::{self, DetectionVolume},
};

/// The specific part of a proximity sensor.
#[derive(Debug, Clone)]
pub struct ProximityPart {
    /// 30 pyramid, 31 cylinder, 32 disc, 33 cone, 34 ray.
    pub kind: i32,
    /// The detection volume, in the frame of the sensor.
    pub volume: DetectionVolume,
    /// Handle of the object or collection that the sensor detects; -1: all objects.
    pub entity: i32,
    /// Bits of the sensor's technology: 0x10 ultrasonic to 0x100 capacitive.
    pub waves: i32,
    /// Maximum angle to the surface normal, rad.
    pub angle: f64,
    /// Whether `angle` applies regardless of the bits; since 4.10.
    pub angle_alone: bool,
    /// Flags. Bit 1: nearest point; bit 2: angle limit; bit 4: no front faces; bit 5: no back faces; bit 7: measures
    /// only on request.
    pub bits: u8,
    /// For randomized rays, the number of rays, and the number of hits required.
    pub random: Option<[i32; 2]>,
}

impl Default for ProximityPart {
    fn default() -> Self {
        ProximityPart {
            kind: 33,
            volume: DetectionVolume::default(),
            entity: -1,
            waves: 0x10,
            angle: 0.0,
            angle_alone: false,
            bits: 2,
            random: None,
        }
    }
}

/// Tags of the elements of proximity sensors.
pub const PROXIMITY: &[ElementTag<ProximityPart>] = tags!(ProximityPart {
    "Snt" => |s, c, _| Ok(s.kind = c.i32()?),
    "Vod" => |s, c, u| Ok(s.volume = volume::read(c, u)?),
    "Sox" => |s, c, _| Ok(s.entity = c.i32()?),
    "Sst" => |s, c, _| Ok(s.waves = c.i32()?),
    "Al2" | "_l2" => |s, c, _| Ok(s.angle = c.real()?),
    "" | "al3" => |s, c, _| Ok((s.angle, s.angle_alone) = (c.real()?, true)),
    "Pr4" => |s, c, _| Ok(s.bits = c.u8()?),
    "Rad" => |s, c, _| Ok(s.random = Some([c.i32()?, c.i32()?])),
});

/// Known elements, for the user interface only.
pub const PROXIMITY_IGNORED: &[&str] =
    &["Sns", "_ns", "Pr5", "Pr3", "Pr2", "Pra", "Cl1", "Cl2", "Cl3", "Cl4", "Cv2", "Shk", "Var"];

/// The specific part of a vision sensor.
#[derive(Debug, Clone)]
pub struct VisionPart {
    /// Orthographic size, m; perspective angle, rad; near and far plane, m.
    pub clip: [f64; 4],
    /// Resolution of the image: columns and rows of pixels.
    pub resolution: [i32; 2],
    /// Handle of the object or collection that the sensor renders; -1: all objects.
    pub entity: i32,
    /// Background color: red, green, blue.
    pub background: [f64; 3],
    /// Render mode: 0 OpenGL, 2 a color per object, 3 POV-Ray, ...
    pub mode: i32,
    /// Flags. Bit 0: perspective projection; bit 1: measures only on request.
    pub bits: u8,
    /// Flags. Bit 0: the image is provided from outside; bit 1: no colors; bit 2: no depth.
    pub more_bits: u8,
    /// Ids of the enabled filters of the old image processing.
    pub filters: Vec<i32>,
}

impl Default for VisionPart {
    fn default() -> Self {
        VisionPart {
            clip: [0.01, std::f64::consts::FRAC_PI_3, 0.01, 10.0],
            resolution: [32, 32],
            entity: -1,
            background: [0.0; 3],
            mode: 0,
            bits: 1,
            more_bits: 0,
            filters: Vec::new(),
        }
    }
}

/// A filter of the old image processing: its id, and whether it is enabled.
#[derive(Default)]
struct ImageFilter {
    kind: i32,
    on: bool,
}

const FILTER: &[ElementTag<ImageFilter>] = tags!(ImageFilter {
    "Sft" => |f, c, _| Ok(f.kind = c.i32()?),
    "Sfe" => |f, c, _| Ok(f.on = c.u8()? & 1 != 0),
});

/// Tags of the elements of vision sensors.
pub const VISION: &[ElementTag<VisionPart>] = tags!(VisionPart {
    "Ccp" | "_cp" => |s, c, _| Ok(s.clip = c.reals()?),
    "Res" => |s, c, _| Ok(s.resolution = [c.i32()?, c.i32()?]),
    "Dox" => |s, c, _| Ok(s.entity = c.i32()?),
    "Db2" => |s, c, _| Ok(s.background = c.reals()?),
    "Rmd" => |s, c, _| Ok(s.mode = c.i32()?),
    "Var" => |s, c, _| Ok(s.bits = c.u8()?),
    "Va3" => |s, c, _| Ok(s.bits = c.u8()?),
    "Va2" => |s, c, _| Ok(s.more_bits = c.u8()?),
    "Cfr" => |s, c, u| {
        let tags = tags!(VisionPart {
            "Sfr" => |s, c, u| {
                let mut filter = ImageFilter::default();
                object(c, FILTER, &["Sfv", "Cfn", "Pab", "Pai", "Paf", "Cfp", "_af"], &mut filter, u)?;
                if filter.on {
                    s.filters.push(filter.kind);
                }
                Ok(())
            },
        });
        object(c, tags, &[], s, u).map(drop)
    },
});

/// Known elements, for the user interface only.
pub const VISION_IGNORED: &[&str] = &[
    "Siz", "Si2", "_i2", "Afr", "Pv1", "Cl1", "Cl2", "Cl3", "Cl4", "Cv2", "Dbv", "_b2", "_iz", "Dot", "Rm2", "Fow",
    "_f2",
];

/// The specific part of a force sensor.
#[derive(Debug, Clone, Default)]
pub struct ForcePart {
    /// Flags of the enabled thresholds. Bit 0: force; bit 1: torque.
    pub bits: u8,
    /// Thresholds above which the sensor breaks, N and N m, and the number of consecutive measurements required.
    pub threshold: ([f64; 2], i32),
    /// Number of measurements that the filter combines.
    pub samples: i32,
    /// Filter: 0 mean, 1 median.
    pub filter: i32,
}

/// Tags of the elements of force sensors.
pub const FORCE: &[ElementTag<ForcePart>] = tags!(ForcePart {
    "Vab" => |s, c, _| Ok(s.bits = c.u8()?),
    "Tre" => |s, c, _| Ok(s.threshold = (c.reals()?, c.i32()?)),
    "Tri" | "_ri" => |s, c, _| Ok(s.threshold = (c.reals()?, c.i32()?)),
    "Fil" => |s, c, _| Ok((s.samples, s.filter) = (c.i32()?, c.i32()?)),
});

/// Known elements, for the user interface only.
pub const FORCE_IGNORED: &[&str] = &["Siz", "_iz", "Cl1", "Cl2", "Cv2", "Var"];
