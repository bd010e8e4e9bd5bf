//! Lamp, sky and floor, and the shading of surfaces. Colours are linear unless stated otherwise.

use nalgebra::{Point3, Unit, Vector3};

/// Direction to the lamp, which is infinitely far away; not normalized.
pub const LAMP_DIRECTION: [f64; 3] = [0.3, -0.6, 1.0];

/// A colour in linear red, green and blue, as opposed to gamma-encoded values.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct LinearColor(pub Vector3<f64>);

/// Light of the lamp on a surface that faces it.
const LAMP_LIGHT: [f64; 3] = [0.80, 0.77, 0.71];
/// Ambient light from above and from below on an unoccluded surface.
const AMBIENT_ABOVE: [f64; 3] = [0.40, 0.43, 0.48];
const AMBIENT_BELOW: [f64; 3] = [0.30, 0.29, 0.28];
/// Light from the camera on a surface that faces it, which gives contrast to surfaces in shadow.
const CAMERA_LIGHT: f64 = 0.10;
/// Brightness above which light is compressed, so that white surfaces that face the lamp keep their shading.
const SHOULDER: f64 = 0.6;
/// Colours of the sky at the zenith and at the horizon.
const ZENITH_COLOR: [f64; 3] = [0.30, 0.47, 0.72];
const HORIZON_COLOR: [f64; 3] = [0.80, 0.86, 0.92];
/// Distance over which objects fade into the horizon, in metres, for a camera close to the ground.
const HAZE_DISTANCE_M: f64 = 60.0;

impl LinearColor {
    /// Colour of the floor rendered for a scene without one.
    pub const FLOOR: LinearColor = LinearColor(Vector3::new(0.42, 0.42, 0.42));

    /// Converts a gamma-encoded colour of the scene, with channels from 0 to 1, to a linear colour.
    pub fn of(screen: [f64; 3]) -> Self {
        let linear = |x: f64| libm::pow(x.clamp(0.0, 1.0), 2.2);
        LinearColor(Vector3::from(screen.map(linear)))
    }

    /// Returns the gamma-encoded colour, each channel 0 to 255.
    pub fn bytes(self) -> [u8; 3] {
        let screen = |x: f64| (libm::pow(x.clamp(0.0, 1.0), 1.0 / 2.2) * 255.0).round() as u8;
        [screen(self.0.x), screen(self.0.y), screen(self.0.z)]
    }

    /// Returns the colour with its brightest channel compressed into the range of a picture: below [`SHOULDER`] it is
    /// unchanged, and above, it approaches 1. The hue is preserved.
    fn compressed(self) -> Self {
        let (brightest, room) = (self.0.max(), 1.0 - SHOULDER);
        if brightest <= SHOULDER {
            return self;
        }
        let below_white = room * libm::exp((SHOULDER - brightest) / room);
        LinearColor(self.0 * ((1.0 - below_white) / brightest))
    }

    pub fn mix(self, other: LinearColor, share: f64) -> LinearColor {
        LinearColor(self.0.lerp(&other.0, share.clamp(0.0, 1.0)))
    }
}

/// Returns the unit vector to the lamp.
pub(super) fn lamp_direction() -> Unit<Vector3<f64>> {
    Unit::new_normalize(Vector3::from(LAMP_DIRECTION))
}

/// Returns the colour of the sky in a direction.
pub(super) fn sky(direction: &Vector3<f64>) -> LinearColor {
    let height = direction.z.max(0.0);
    let horizon = LinearColor(Vector3::from(HORIZON_COLOR));
    horizon.mix(LinearColor(Vector3::from(ZENITH_COLOR)), libm::pow((height * 1.4).min(1.0), 0.7))
}

/// A surface point to shade.
pub(super) struct ShadingPoint {
    pub color: LinearColor,
    pub normal: Vector3<f64>,
    /// Unit vector from the surface to the eye.
    pub to_eye: Vector3<f64>,
    /// Whether the lamp illuminates the point.
    pub lamp: bool,
    /// Unoccluded share of the sky, 0 to 1.
    pub sky_share: f64,
    /// Strength of the specular reflection of the lamp.
    pub gloss: f64,
}

impl ShadingPoint {
    pub fn shade(&self) -> LinearColor {
        let lamp = lamp_direction();
        let up = 0.5 + 0.5 * self.normal.z;
        let soft = Vector3::from(AMBIENT_BELOW).lerp(&Vector3::from(AMBIENT_ABOVE), up) * self.sky_share;
        let mut light = soft + Vector3::repeat(CAMERA_LIGHT * self.normal.dot(&self.to_eye).max(0.0));
        let mut mirrored = 0.0;
        if self.lamp {
            light += Vector3::from(LAMP_LIGHT) * self.normal.dot(&lamp).max(0.0);
            let half = (lamp.into_inner() + self.to_eye).normalize();
            mirrored = self.gloss * self.normal.dot(&half).max(0.0).powi(40);
        }
        // Surfaces seen at a grazing angle are slightly brighter, which sets dark objects apart.
        let rim = (1.0 - self.normal.dot(&self.to_eye).clamp(0.0, 1.0)).powi(4) * self.gloss * 0.5 * self.sky_share;
        let color = self.color.0.component_mul(&light) + Vector3::repeat(mirrored) + Vector3::from(AMBIENT_ABOVE) * rim;
        LinearColor(color).compressed()
    }
}

/// Returns a colour faded into the horizon according to its distance; a higher camera sees farther.
pub(super) fn fade_to_horizon(color: LinearColor, distance: f64, eye_height: f64) -> LinearColor {
    let share = 1.0 - libm::exp(-(distance / (HAZE_DISTANCE_M + 8.0 * eye_height.abs())).powi(2));
    color.mix(LinearColor(Vector3::from(HORIZON_COLOR)), share)
}

/// Lines of the floor's grid: spacing and width, in metres, and the share by which they darken the floor, 0 to 1.
const GRID_LINES: [(f64, f64, f64); 2] = [(1.0, 0.012, 0.34), (0.1, 0.004, 0.14)];

/// Returns the share by which the grid darkens a point of the floor, 0 to 1. `reach` is the extent of the pixel on the
/// floor along x and y, in metres; lines fade where it is a large part of their spacing.
pub(super) fn grid_darkening(point: &Point3<f64>, reach: [f64; 2]) -> f64 {
    let mut darker: f64 = 0.0;
    for (step, width, strength) in GRID_LINES {
        for (x, reach) in [(point.x, reach[0]), (point.y, reach[1])] {
            let off = x - (x / step).round() * step;
            // The share of the pixel that the line covers.
            let reach = reach.max(1e-6);
            let covered = (off + reach / 2.0).min(width / 2.0) - (off - reach / 2.0).max(-width / 2.0);
            let share = (covered / reach).max(0.0);
            // Lines narrower than a pixel are rendered wider and fainter to keep them continuous, and they fade out
            // where they get too close together.
            let seen =
                if width < reach { (1.0 - (off.abs() / reach)).max(0.0) * (width / reach).sqrt() } else { share };
            let fade = (1.0 - 5.0 * reach / step).clamp(0.0, 1.0);
            darker = darker.max(seen.min(1.0) * strength * fade);
        }
    }
    darker
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lit(color: f64, normal: Vector3<f64>) -> Vector3<f64> {
        let to_eye = Vector3::new(0.0, -0.6, 0.8);
        let color = LinearColor(Vector3::repeat(color));
        ShadingPoint { color, normal, to_eye, lamp: true, sky_share: 1.0, gloss: 0.0 }.shade().0
    }

    #[test]
    fn white_surfaces_are_shaded_in_full_light() {
        let lamp = lamp_direction().into_inner();
        let [facing, top, side] =
            [lamp, Vector3::z(), -Vector3::y()].map(|normal| LinearColor(lit(1.0, normal)).bytes());
        assert!(facing[0] < 255 && facing[0] > top[0] && top[0] > side[0], "{facing:?}, {top:?}, {side:?}");
    }

    #[test]
    fn dark_surfaces_are_lit_in_proportion_to_their_colour() {
        assert!((lit(0.2, Vector3::z()) - 2.0 * lit(0.1, Vector3::z())).norm() < 1e-12);
    }
}
