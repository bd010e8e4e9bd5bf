//! Lamps and the shading of matt surfaces.

use nalgebra::Vector3;

/// Lamps, and the colour of the background. A surface that receives a total of 1 from all lamps shows its own colour.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ImageLighting {
    /// Ambient light, 0 to 1.
    pub ambient: f32,
    /// Contribution of a lamp at the camera to a surface that faces the camera, 0 to 1.
    pub headlight: f32,
    /// Contribution of a distant lamp to a surface that faces it, 0 to 1.
    pub sun: f32,
    /// Unit vector towards the distant lamp, in the world frame.
    pub sun_direction: [f32; 3],
    /// Red, green and blue of pixels without a visible surface, each 0 to 1.
    pub sky: [f32; 3],
}

impl Default for ImageLighting {
    /// Returns lamps with enough ambient light to distinguish colours in the shade, and a sun from above and to one
    /// side.
    fn default() -> Self {
        Self {
            ambient: 0.35,
            headlight: 0.25,
            sun: 0.4,
            sun_direction: [0.267_261_24, 0.534_522_5, 0.801_783_74],
            sky: [0.55, 0.68, 0.82],
        }
    }
}

impl ImageLighting {
    /// Returns the colour of the sky, each channel 0 to 255.
    pub(super) fn sky_bytes(&self) -> [u8; 3] {
        self.sky.map(to_byte)
    }
}

pub(super) fn to_byte(x: f32) -> u8 {
    // A NaN becomes 0.
    (x * 255.0 + 0.5) as u8
}

/// Returns the colour of a matt surface, each channel 0 to 255.
///
/// `normal` (on the side of the camera) and `to_camera` are unit vectors in the world frame. `sunlit` is 0 in shadow
/// and 1 in sunlight.
pub fn shaded_color(
    light: &ImageLighting,
    surface: [f32; 3],
    normal: &Vector3<f32>,
    to_camera: &Vector3<f32>,
    sunlit: f32,
) -> [u8; 3] {
    let facing = |way: &Vector3<f32>| normal.x * way.x + normal.y * way.y + normal.z * way.z;
    let sum = brightness(light, facing(to_camera), facing(&Vector3::from(light.sun_direction)), sunlit);
    surface.map(|x| to_byte(x * sum))
}

/// Returns the total contribution of the lamps; the arguments are the cosines of the angles from the normal to camera
/// and sun.
#[inline(always)]
pub(super) fn brightness(light: &ImageLighting, to_camera: f32, to_sun: f32, sunlit: f32) -> f32 {
    let lit = |cosine: f32| if cosine > 0.0 { cosine } else { 0.0 };
    light.ambient + light.headlight * lit(to_camera) + light.sun * sunlit * lit(to_sun)
}
