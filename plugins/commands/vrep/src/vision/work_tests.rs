use super::*;

fn grey(columns: usize, rows: usize, values: &[f32]) -> WorkingImage {
    let mut work = WorkingImage::new(columns, rows);
    work.set_depth(values);
    work
}

/// With fx = 2 and two columns about 0, the pixels' rays have x = 0.25 and -0.25 per metre of depth (left is +x), at
/// 1 m and 3 m.
#[test]
fn coordinates_of_pixels_follow_the_projection() {
    let lens = ImageProjection { intrinsics: [2.0, 2.0, 0.5, 0.0], parallel: false, planes: [1.0, 5.0] };
    let out = coordinates(&[0.0, 0.5], 2, 1, &lens, [2, 1], false);
    let d = |x: f64, z: f64| (x * x + z * z).sqrt();
    let wanted = [2.0, 1.0, 0.25, 0.0, 1.0, d(0.25, 1.0), -0.75, 0.0, 3.0, d(0.75, 3.0)];
    assert!(out.iter().zip(wanted).all(|(a, b)| (a - b).abs() < 1e-12) && out.len() == wanted.len(), "{out:?}");
}

/// Four points that are evenly spaced in angle within 90 degrees are at 33.75, 11.25, -11.25 and -33.75 degrees.
#[test]
fn points_are_evenly_spaced_in_angle() {
    let lens = ImageProjection { intrinsics: [8.0, 8.0, 7.5, 0.0], parallel: false, planes: [0.0, 1.0] };
    let out = coordinates(&[1.0; 16], 16, 1, &lens, [4, 1], true);
    for (i, degrees) in [33.75_f64, 11.25, -11.25, -33.75].into_iter().enumerate() {
        assert!((out[2 + 4 * i] - degrees.to_radians().tan()).abs() < 1e-12, "{out:?}");
    }
}

/// An image of 5 x 4 pixels contains a row of three pixels and a separate single pixel.
#[test]
fn blobs_are_counted_and_measured() {
    let mut values = [0.0; 20];
    for i in [6, 7, 8, 19] {
        values[i] = 1.0;
    }
    let (packet, label) = blobs(&grey(5, 4, &values), 0.5, 0.0);
    assert_eq!(packet[..2], [2.0, 6.0]);
    let near = |a: &[f64], b: &[f64]| a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-9);
    // 3 of 20 pixels, horizontal, centre at pixel (2, 1), 3 x 1 pixels.
    assert!(near(&packet[2..8], &[0.15, 0.0, 2.5 / 5.0, 1.5 / 4.0, 3.0 / 5.0, 1.0 / 4.0]), "{packet:?}");
    assert!(near(&packet[8..14], &[0.05, 0.0, 4.5 / 5.0, 3.5 / 4.0, 1.0 / 5.0, 1.0 / 4.0]), "{packet:?}");
    assert_eq!((label[6], label[19], label[0]), (1, 2, 0));
    // The small blob is omitted.
    let (packet, label) = blobs(&grey(5, 4, &values), 0.5, 0.1);
    assert_eq!((packet[0], packet.len(), label[19]), (1.0, 8, 0));
}

#[test]
fn upright_blob_has_the_angle_of_its_long_side() {
    let mut values = [0.0; 25];
    for i in [2, 7, 12, 17] {
        values[i] = 1.0;
    }
    let (packet, _) = blobs(&grey(5, 5, &values), 0.5, 0.0);
    assert!((packet[3].abs() - std::f64::consts::FRAC_PI_2).abs() < 1e-9, "{packet:?}");
    assert!((packet[6] - 0.8).abs() < 1e-9 && (packet[7] - 0.2).abs() < 1e-9, "{packet:?}");
}

#[test]
fn edges_normalization_and_kernels() {
    let mut work = grey(4, 1, &[0.2, 0.2, 0.6, 0.6]);
    work.edges(0.3);
    assert_eq!(work.depth(), [0.0, 1.0, 1.0, 0.0]);
    let mut work = grey(3, 1, &[0.2, 0.4, 0.6]);
    work.normalize();
    assert!(work.depth().iter().zip([0.0, 0.5, 1.0]).all(|(a, b)| (a - b).abs() < 1e-6));
    // The mean of the left, middle and right pixel; outside the image, the nearest pixel is used.
    let mut work = grey(3, 1, &[0.0, 0.3, 0.9]);
    work.kernel(3, &[0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 0.0, 0.0, 0.0], 1.0 / 3.0);
    assert!(work.depth().iter().zip([0.1, 0.4, 0.7]).all(|(a, b)| (a - b).abs() < 1e-6), "{:?}", work.depth());
}
