//! The colours of pixels that show a translucent surface.

use nalgebra::{Isometry3, Quaternion, UnitQuaternion, Vector3};

use super::{
    light::{brightness, to_byte},
    raster::{NO_SURFACE, Raster},
    shade::Shader,
};
use crate::{Beam, SurfaceLayer, composite};

impl Shader<'_> {
    /// Replaces the colours of the pixels of a band whose nearest surface is translucent. The surfaces behind it, which
    /// the raster does not contain, are found by rays.
    pub fn blend<const ID: bool>(&self, raster: &Raster<'_, ID>, colors: &mut [[u8; 3]]) {
        let mut layers = Vec::new();
        // The surface of the previous pixel: its number, its place, and whether it is translucent.
        let mut last = (NO_SURFACE, 0, false);
        for (row, colors) in (raster.first..raster.end).zip(colors.chunks_exact_mut(raster.columns)) {
            let ids = &raster.id[(row - raster.first) * raster.stride..][..raster.columns];
            for (column, (id, color)) in ids.iter().zip(colors).enumerate() {
                if *id != last.0 {
                    let seen = if *id == NO_SURFACE { None } else { self.find_primitive(*id, last.1) };
                    let at = seen.as_ref().map_or(last.1, |seen| seen.at);
                    last = (*id, at, seen.is_some_and(|seen| seen.target.opacity < 1.0));
                }
                if last.2 {
                    *color = self.blended_color(column, row, &mut layers);
                }
            }
        }
    }

    /// Returns the colour of a pixel; `layers` is a buffer.
    fn blended_color(&self, column: usize, row: usize, layers: &mut Vec<SurfaceLayer>) -> [u8; 3] {
        let ray = self.pixel_ray(column, row);
        self.scene.surfaces_along(&ray, layers);
        let shaded = |layer: &SurfaceLayer| {
            let (light, target) = (self.cast.light, &self.scene.targets()[layer.target]);
            let normal = ray.world_from_beam.rotation * layer.hit.normal;
            let color = target.texture.as_ref().map_or(target.color, |texture| {
                let point = target.world_from_target.inverse_transform_point(&(ray.world_from_beam * layer.hit.point));
                let normal = target.world_from_target.rotation.inverse_transform_vector(&normal);
                texture.color((&target.form, layer.hit.primitive), &point, &normal, target.color)
            });
            let sun = Vector3::from(light.sun_direction).dot(&normal.map(|x| x as f32));
            let sum = brightness(light, -layer.hit.normal.z as f32, sun, 1.0);
            (color.map(|x| (x * sum).min(1.0)), layer.opacity)
        };
        composite(layers.iter().map(shaded), self.cast.light.sky).map(to_byte)
    }

    /// Returns the ray through the centre of a pixel, from the near to the far plane.
    fn pixel_ray(&self, column: usize, row: usize) -> Beam {
        let camera = self.camera;
        let (from, along) = camera.ray(column as f64, row as f64);
        let start = from + along * camera.near;
        let (length, direction) = (along.norm(), along.normalize());
        // The view frame is the sensor's with x to the right. The rotation is from +z to the direction.
        let turn = Quaternion::new(1.0 + direction.z, -direction.y, -direction.x, 0.0);
        let origin = Vector3::new(-start.x, start.y, start.z);
        let sensor_from_ray = Isometry3::from_parts(origin.into(), UnitQuaternion::new_normalize(turn));
        Beam {
            faces: self.cast.faces,
            skip_group: self.cast.skip_group,
            only_object: self.cast.only_object,
            ..Beam::ray(self.cast.world_from_sensor * sensor_from_ray, (camera.far - camera.near) * length)
        }
    }
}
