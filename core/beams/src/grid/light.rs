//! Lamps, and what they make of a surface.

use nalgebra::Vector3;

/// Lamps, and the colour where nothing is. A surface that gets 1 in sum has its own colour.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Light {
    /// Light from everywhere, 0 to 1.
    pub ambient: f32,
    /// A lamp beside the camera: its part of a surface that faces the camera, 0 to 1.
    pub headlight: f32,
    /// A lamp far away: its part of a surface that faces it, 0 to 1.
    pub sun: f32,
    /// Toward that lamp, in the world; of length 1.
    pub sun_direction: [f32; 3],
    /// Red, green and blue of pixels that see nothing, 0 to 1.
    pub sky: [f32; 3],
}

impl Default for Light {
    /// Enough from everywhere to distinguish colours in the shade, a sun from above and beside.
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

impl Light {
    /// The sky, 0 to 255.
    pub(super) fn sky_bytes(&self) -> [u8; 3] {
        self.sky.map(byte)
    }
}

pub(super) fn byte(x: f32) -> u8 {
    // What is no number becomes 0.
    (x * 255.0 + 0.5) as u8
}

/// The colour of a matt surface, 0 to 255.
///
/// `normal` (on the side of the camera) and `to_camera` are of length 1, in the world. `sunlit` is 0 in a shadow, 1 in
/// the light.
pub fn color_of(
    light: &Light,
    surface: [f32; 3],
    normal: &Vector3<f32>,
    to_camera: &Vector3<f32>,
    sunlit: f32,
) -> [u8; 3] {
    let facing = |way: &Vector3<f32>| normal.x * way.x + normal.y * way.y + normal.z * way.z;
    let sum = brightness(light, facing(to_camera), facing(&Vector3::from(light.sun_direction)), sunlit);
    surface.map(|x| byte(x * sum))
}

/// The sum of the lamps, from the cosines of the angles between the normal and the ways to camera and sun.
#[inline(always)]
pub(super) fn brightness(light: &Light, to_camera: f32, to_sun: f32, sunlit: f32) -> f32 {
    let lit = |cosine: f32| if cosine > 0.0 { cosine } else { 0.0 };
    light.ambient + light.headlight * lit(to_camera) + light.sun * sunlit * lit(to_sun)
}
