//! The standard packet of a vision sensor: statistics of its image.

/// Minimum, maximum and mean of intensity, red, green, blue and depth, all from 0 to 1 (tests/facts/script-api.md, 4).
pub(crate) type VisionPacket = [f64; 15];

/// The packet of an empty image: black, with all depths at the far plane.
pub(crate) const EMPTY_PACKET: VisionPacket =
    [0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0];

/// Computes the packet of an image from its bytes (red, green, blue) and its depths from 0 to 1.
pub(crate) fn packet(rgb: &[u8], depth: &[f32]) -> VisionPacket {
    let n = depth.len().min(rgb.len() / 3);
    if n == 0 {
        return EMPTY_PACKET;
    }
    // Sums of bytes are exact; an intensity is a third of such a sum.
    let (mut least, mut most, mut sum) = ([u32::MAX; 4], [0_u32; 4], [0_u64; 4]);
    for pixel in rgb.as_chunks::<3>().0 {
        let [r, g, b] = pixel.map(u32::from);
        for (k, x) in [r + g + b, r, g, b].into_iter().enumerate() {
            least[k] = least[k].min(x);
            most[k] = most[k].max(x);
            sum[k] += u64::from(x);
        }
    }
    let unit = [765.0, 255.0, 255.0, 255.0];
    let mut out = EMPTY_PACKET;
    for k in 0..4 {
        out[k] = f64::from(least[k]) / unit[k];
        out[5 + k] = f64::from(most[k]) / unit[k];
        out[10 + k] = sum[k] as f64 / (n as f64 * unit[k]);
    }
    let depths = || depth.iter().map(|z| f64::from(*z));
    out[4] = depths().fold(f64::INFINITY, f64::min);
    out[9] = depths().fold(f64::NEG_INFINITY, f64::max);
    out[14] = depths().sum::<f64>() / n as f64;
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Computed by hand: pixels (51, 102, 0) and (255, 0, 153) are (0.2, 0.4, 0) and (1, 0, 0.6); intensities 0.2 and
    /// 1.6 / 3.
    #[test]
    fn packet_contains_minimum_maximum_and_mean() {
        let p = packet(&[51, 102, 0, 255, 0, 153], &[0.25, 0.75]);
        let wanted = [
            0.2,
            0.2,
            0.0,
            0.0,
            0.25, //
            1.6 / 3.0,
            1.0,
            0.4,
            0.6,
            0.75, //
            (0.2 + 1.6 / 3.0) / 2.0,
            0.6,
            0.2,
            0.3,
            0.5,
        ];
        for (k, (is, wanted)) in p.iter().zip(wanted).enumerate() {
            assert!((is - wanted).abs() < 1e-12, "{k}: {is}, not {wanted}");
        }
    }

    #[test]
    fn empty_image_is_black_and_far() {
        assert_eq!(packet(&[], &[]), EMPTY_PACKET);
        assert_eq!(packet(&[0; 6], &[1.0; 2]), EMPTY_PACKET);
    }
}
