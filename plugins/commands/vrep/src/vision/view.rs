//! The last reading of a vision sensor, converted to its clipping planes and units.

use super::{
    sensors::{DEFAULT_PLANES, angle, is_vision_sensor, planes},
    work::ImageProjection,
};
use crate::kit::*;

/// Number of columns and rows of a blind sensor's image.
const BLIND_SIDE: usize = 32;
/// Maximum number of columns or rows of a part of its image.
const MAX_BLIND_SIDE: usize = 4096;

/// The state of a vision sensor at a point in time.
#[derive(Debug, Clone, Copy)]
pub(crate) struct VisionView {
    pub id: tatu_object,
    pub columns: usize,
    pub rows: usize,
    /// Number of images taken since the start or the last reset.
    pub sequence: u64,
    /// Time of the last image, s.
    pub time: f64,
    /// Distances of the near and the far plane, m.
    pub planes: [f64; 2],
    /// Whether the object is a dummy or camera that represents a sensor, and therefore measures nothing.
    pub blind: bool,
}

/// A part of an image, in pixels.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct ImageRegion {
    pub x: usize,
    pub y: usize,
    pub columns: usize,
    pub rows: usize,
}

impl VisionView {
    /// Creates the view of the sensor in argument `i`.
    pub fn of(c: &Ctx<'_>, i: usize) -> Result<Self> {
        let o = existing_object(c, i)?;
        Self::of_object(c, o)
    }

    pub fn of_object(c: &Ctx<'_>, o: Object) -> Result<Self> {
        let id = o.id;
        if is_vision_sensor(c, id) {
            let p = &c.plugin().p;
            let reading = c.world().reading(id, p.depth).or_else(|_| c.world().reading(id, p.rgb))?;
            let [rows, columns, _] = reading.dims();
            return Ok(VisionView {
                id,
                columns: columns as usize,
                rows: rows as usize,
                sequence: reading.sequence(),
                time: reading.time(),
                planes: planes(c, id),
                blind: false,
            });
        }
        // In a run without a scene, a dummy or camera can replace a sensor. Shapes, joints and other sensors are
        // rejected, as in V-REP.
        let stands_in = matches!(o.kind, TATU_KIND_DUMMY | TATU_KIND_CAMERA) && c.world().makes_stand_ins();
        if !stands_in {
            return Err(Fail::argument(format!("object {} `{}` is not a vision sensor", o.handle(), path(c, id))));
        }
        Ok(VisionView {
            id,
            columns: BLIND_SIDE,
            rows: BLIND_SIDE,
            sequence: 0,
            time: 0.0,
            planes: DEFAULT_PLANES,
            blind: true,
        })
    }

    /// Returns the projection of the sensor's image.
    pub fn lens(&self, c: &Ctx<'_>) -> ImageProjection {
        let (w, p) = (c.world(), &c.plugin().p);
        let told = w.reading(self.id, p.intrinsics).ok().and_then(|r| r.f64s().first_chunk::<4>().copied());
        let parallel = w.reading(self.id, p.parallel).ok().and_then(|r| r.i32s().first().copied());
        let intrinsics = told.filter(|k| k[0] > 0.0 && k[1] > 0.0).unwrap_or_else(|| {
            // Before its first image, the sensor has no intrinsics, so derive them from its angle.
            let (columns, rows) = (self.columns as f64, self.rows as f64);
            let f = columns.max(rows) / 2.0 / libm::tan(angle(c, self.id) / 2.0);
            [f, f, (columns - 1.0) / 2.0, (rows - 1.0) / 2.0]
        });
        ImageProjection { intrinsics, parallel: parallel == Some(1), planes: self.planes }
    }

    pub fn pixels(&self) -> usize {
        self.columns * self.rows
    }

    /// Returns the requested part, or the whole image if a side is 0. A blind sensor has as many pixels as requested.
    pub fn region(&mut self, [x, y]: [i64; 2], [columns, rows]: [i64; 2]) -> Result<ImageRegion> {
        if columns == 0 || rows == 0 {
            return Ok(ImageRegion { x: 0, y: 0, columns: self.columns, rows: self.rows });
        }
        let count = |n: i64| usize::try_from(n).ok();
        if let (Some(x), Some(y), Some(columns), Some(rows)) = (count(x), count(y), count(columns), count(rows)) {
            if self.blind && x.max(y).max(columns).max(rows) <= MAX_BLIND_SIDE {
                (self.columns, self.rows) = (self.columns.max(x + columns), self.rows.max(y + rows));
            }
            if x.saturating_add(columns) <= self.columns && y.saturating_add(rows) <= self.rows {
                return Ok(ImageRegion { x, y, columns, rows });
            }
        }
        Err(Fail::argument(format!(
            "a part of {columns} x {rows} pixels at ({x}, {y}) exceeds the image of {} x {} pixels",
            self.columns, self.rows
        )))
    }

    /// Returns the measured colours, 3 bytes per pixel; black before the first image.
    pub fn rgb(&self, c: &Ctx<'_>) -> Vec<u8> {
        let taken = (!self.blind && self.sequence > 0).then(|| c.world().reading(self.id, c.plugin().p.rgb).ok());
        match taken.flatten().filter(|r| r.u8s().len() == 3 * self.pixels()) {
            Some(rgb) => rgb.u8s().to_vec(),
            None => vec![0; 3 * self.pixels()],
        }
    }

    /// Returns the measured depths, m, or `None` before the first image, or if the sensor does not measure depths.
    pub fn metres(&self, c: &Ctx<'_>) -> Option<Vec<f32>> {
        let taken = (!self.blind && self.sequence > 0).then(|| c.world().reading(self.id, c.plugin().p.depth).ok());
        taken.flatten().map(|r| r.f32s().to_vec()).filter(|z| z.len() == self.pixels())
    }

    /// Returns the depths, from 0 at the near plane to 1 at the far plane; pixels without a surface have the depth 1.
    pub fn depth(&self, c: &Ctx<'_>) -> Vec<f32> {
        match self.metres(c) {
            Some(metres) => metres.iter().map(|z| self.linear(*z)).collect(),
            None => vec![1.0; self.pixels()],
        }
    }

    /// Converts a depth in m to the range 0..1 between the planes.
    pub fn linear(&self, metres: f32) -> f32 {
        let [near, far] = self.planes;
        if far <= near {
            return 1.0;
        }
        ((f64::from(metres) - near) / (far - near)).clamp(0.0, 1.0) as f32
    }
    /// Converts a depth from 0..1 back to m.
    pub fn metres_of(&self, linear: f32) -> f32 {
        let [near, far] = self.planes;
        (near + f64::from(linear) * (far - near)) as f32
    }
}

impl ImageRegion {
    /// Returns the pixels of this part of an image with `columns` columns and `each` values per pixel.
    pub fn of<T: Copy>(&self, all: &[T], columns: usize, each: usize) -> Vec<T> {
        let mut out = Vec::with_capacity(self.columns * self.rows * each);
        for y in self.y..self.y + self.rows {
            let first = (y * columns + self.x) * each;
            out.extend_from_slice(all.get(first..first + self.columns * each).unwrap_or_default());
        }
        out
    }
}

/// Returns the first two numbers of the table in argument `i`; missing numbers are 0.
pub(super) fn pair(c: &Ctx<'_>, i: usize) -> [i64; 2] {
    [0, 1].map(|k| c.arg(i).number(k).map_or(0, |x| x as i64))
}

/// Packs floats into little-endian bytes.
pub(super) fn packed(floats: &[f32]) -> Vec<u8> {
    floats.iter().flat_map(|x| x.to_le_bytes()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    pub(crate) fn view(columns: usize, rows: usize) -> VisionView {
        VisionView { id: 1, columns, rows, sequence: 1, time: 0.0, planes: [0.5, 2.5], blind: false }
    }

    /// metres = near + d (far - near): tests/facts/script-api.md, 4.
    #[test]
    fn depths_are_linear_between_the_planes() {
        let v = view(1, 1);
        assert_eq!([0.5, 1.0, 2.5].map(|z| v.linear(z)), [0.0, 0.25, 1.0]);
        assert_eq!([0.0, f32::INFINITY].map(|z| v.linear(z)), [0.0, 1.0]);
        assert_eq!(v.metres_of(0.25), 1.0);
    }

    #[test]
    fn regions_are_checked_against_the_image() {
        let mut v = view(4, 3);
        let all: Vec<u8> = (0..12).collect();
        let part = v.region([1, 1], [2, 2]).unwrap();
        assert_eq!(part.of(&all, 4, 1), [5, 6, 9, 10]);
        assert_eq!(v.region([3, 3], [0, 2]).unwrap(), ImageRegion { x: 0, y: 0, columns: 4, rows: 3 });
        for (at, size) in [([3, 0], [2, 1]), ([-1, 0], [1, 1]), ([0, 2], [1, 2]), ([0, 0], [i64::MAX, 1])] {
            assert!(v.region(at, size).is_err(), "{at:?} {size:?}");
        }
    }
}
