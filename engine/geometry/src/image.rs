//! Images: their pixels, and colours between the pixels.

use xxhash_rust::xxh3::xxh3_64_with_seed;

/// Maximum number of pixels in an image, which occupy 64 MiB at 4 bytes per pixel.
pub const MAX_IMAGE_PIXELS: usize = 16 << 20;

/// An RGBA image, with 8 bits per channel.
#[derive(Debug, Clone, PartialEq)]
pub struct Image {
    columns: u32,
    rows: u32,
    rgba: Vec<u8>,
    hash: u64,
    /// 1 divided by the number of columns, and of rows.
    inverse: [f64; 2],
}

impl Image {
    /// Creates an image from pixels of 4 bytes, top row first. Returns `None` if it would have no pixels or more than
    /// [`MAX_IMAGE_PIXELS`], or if the number of bytes does not match.
    pub fn new(columns: u32, rows: u32, rgba: Vec<u8>) -> Option<Self> {
        let pixels = (columns as usize).checked_mul(rows as usize)?;
        let fits = pixels > 0 && pixels <= MAX_IMAGE_PIXELS && rgba.len() == 4 * pixels;
        let hash = xxh3_64_with_seed(&rgba, columns.into());
        let inverse = [1.0 / f64::from(columns), 1.0 / f64::from(rows)];
        fits.then_some(Image { columns, rows, rgba, hash, inverse })
    }
    /// Returns the number of columns.
    pub fn columns(&self) -> u32 {
        self.columns
    }
    /// Returns the number of rows.
    pub fn rows(&self) -> u32 {
        self.rows
    }
    /// Returns a hash of the width and the pixels, by which images are distinguished.
    pub fn hash(&self) -> u64 {
        self.hash
    }
    /// Returns red, green, blue and opacity of all pixels, top row first.
    pub fn rgba(&self) -> &[u8] {
        &self.rgba
    }

    /// Returns red, green, blue and opacity, each 0 to 1, at a position: right and up, each 0 to 1 inside the image.
    /// `smooth` selects whether colours between pixels are interpolated. Outside the image, `repeat` selects per axis
    /// whether the image repeats; otherwise the pixel at the edge is used.
    #[inline]
    pub(crate) fn sample(&self, [right, up]: [f64; 2], repeat: [bool; 2], smooth: bool) -> [f32; 4] {
        let (columns, rows) = (f64::from(self.columns), f64::from(self.rows));
        let (x, y) = (right * columns, (1.0 - up) * rows);
        let column = |x: f64| pixel_at(x, columns, self.inverse[0], repeat[0]);
        let row = |y: f64| pixel_at(y, rows, self.inverse[1], repeat[1]) * self.columns as usize;
        if !smooth {
            return self.pixel(row(floor(y)) + column(floor(x)));
        }
        let (left, top) = (floor(x - 0.5), floor(y - 0.5));
        let (a, b) = ((x - 0.5 - left) as f32, (y - 0.5 - top) as f32);
        let (columns, rows) = ([column(left), column(left + 1.0)], [row(top), row(top + 1.0)]);
        let [p, q] = columns.map(|column| self.pixel(rows[0] + column));
        let [r, s] = columns.map(|column| self.pixel(rows[1] + column));
        [0, 1, 2, 3].map(|i| {
            let (above, below) = (p[i] + (q[i] - p[i]) * a, r[i] + (s[i] - r[i]) * a);
            above + (below - above) * b
        })
    }

    /// Returns red, green, blue and opacity of a pixel, each 0 to 1.
    #[inline]
    fn pixel(&self, index: usize) -> [f32; 4] {
        let (pixels, _) = self.rgba.as_chunks::<4>();
        pixels[index].map(|byte| CHANNEL_VALUES[usize::from(byte)])
    }
}

/// The value, from 0 to 1, of each byte of a channel. Looking it up takes less time than a division.
static CHANNEL_VALUES: [f32; 256] = {
    let mut values = [0.0; 256];
    let mut byte = 0;
    while byte < values.len() {
        values[byte] = byte as f32 / 255.0;
        byte += 1;
    }
    values
};

/// Maximum absolute value up to which products and differences of whole numbers and image sizes are exact.
const MAX_EXACT: f64 = (1_u64 << 31) as f64;

/// Returns the greatest whole number that is not greater than `x`. Unlike [`f64::floor`], it compiles to inline code
/// even for the oldest supported processors.
#[inline]
fn floor(x: f64) -> f64 {
    if x.abs() < MAX_EXACT {
        let whole = f64::from(x as i32);
        if whole > x { whole - 1.0 } else { whole }
    } else {
        x.floor()
    }
}

/// Returns the index of the pixel at a whole number of pixels from the edge of an image with `count` pixels along this
/// axis; `inverse` is 1 / `count`.
#[inline]
fn pixel_at(x: f64, count: f64, inverse: f64, repeats: bool) -> usize {
    let inside = if !repeats {
        x.clamp(0.0, count - 1.0)
    } else if x.abs() < MAX_EXACT {
        // The quotient is at most one too small or too large, because it is rounded; the rest is exact.
        let rest = x - floor(x * inverse) * count;
        let rest = if rest < 0.0 { rest + count } else { rest };
        if rest >= count { rest - count } else { rest }
    } else {
        x.rem_euclid(count)
    };
    // A NaN becomes 0.
    inside as i32 as usize
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn images_without_pixels_or_with_missing_bytes_are_refused() {
        assert_eq!(Image::new(2, 2, vec![0; 15]), None);
        assert_eq!(Image::new(0, 2, Vec::new()), None);
    }

    /// The definition of a sample, with divisions and remainders of the standard library.
    fn defined(image: &Image, [right, up]: [f64; 2], repeat: [bool; 2], smooth: bool) -> [f32; 4] {
        let at = |column: f64, row: f64| {
            let place = |x: f64, count: u32, repeats: bool| {
                let x = if repeats { x.rem_euclid(f64::from(count)) } else { x };
                x.clamp(0.0, f64::from(count - 1)) as usize
            };
            let (x, y) = (place(column, image.columns, repeat[0]), place(row, image.rows, repeat[1]));
            let first = 4 * (y * image.columns as usize + x);
            [0, 1, 2, 3].map(|i| f32::from(image.rgba[first + i]) / 255.0)
        };
        let (x, y) = (right * f64::from(image.columns), (1.0 - up) * f64::from(image.rows));
        if !smooth {
            return at(x.floor(), y.floor());
        }
        let (left, top) = ((x - 0.5).floor(), (y - 0.5).floor());
        let (a, b) = ((x - 0.5 - left) as f32, (y - 0.5 - top) as f32);
        let (p, q) = (at(left, top), at(left + 1.0, top));
        let (r, s) = (at(left, top + 1.0), at(left + 1.0, top + 1.0));
        [0, 1, 2, 3].map(|i| {
            let (above, below) = (p[i] + (q[i] - p[i]) * a, r[i] + (s[i] - r[i]) * a);
            above + (below - above) * b
        })
    }

    #[test]
    fn samples_equal_their_definition_bit_by_bit() {
        let mut state = 1_u64;
        let mut next = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 33) as u32
        };
        for (columns, rows) in [(1, 1), (2, 3), (64, 64), (127, 49), (640, 1), (1000, 333)] {
            let rgba = (0..columns * rows * 4).map(|_| next() as u8).collect();
            let image = Image::new(columns, rows, rgba).unwrap();
            let far = [1e-300, -0.0, 1e9, -3e11, 1e17, f64::INFINITY, f64::NAN];
            let mut places: Vec<[f64; 2]> = far.iter().flat_map(|x| far.map(|y| [*x, y])).collect();
            for scale in [1.0, 20.0, 1e5] {
                places.extend((0..2000).map(|_| [0; 2].map(|_| (f64::from(next()) / 2f64.powi(30) - 1.0) * scale)));
            }
            // Exactly on the borders and centres of pixels.
            places.extend((0..2000).map(|_| {
                let half = |n: u32, count: u32| (f64::from(n % 4000) - 2000.0) / (2.0 * f64::from(count));
                [half(next(), columns), half(next(), rows)]
            }));
            for (i, place) in places.into_iter().enumerate() {
                let (repeat, smooth) = ([i % 2 == 0, i % 4 < 2], i % 8 < 4);
                for smooth in [smooth, !smooth] {
                    let found = image.sample(place, repeat, smooth).map(f32::to_bits);
                    let wanted = defined(&image, place, repeat, smooth).map(f32::to_bits);
                    assert_eq!(found, wanted, "{columns} x {rows}, {place:?}, {repeat:?}, {smooth}");
                }
            }
        }
    }
}
