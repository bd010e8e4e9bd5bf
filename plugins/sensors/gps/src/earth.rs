//! WGS 84: converts coordinates of a plane tangent to the Earth (x east, y north, z up) to latitude, longitude and
//! height, and back.
//!
//! Axes and flattening: NGA.STND.0036, "World Geodetic System 1984", table 3.1. Conversions: EPSG guidance note 7-2,
//! methods 9602 (geographic to geocentric) and 9837 (geographic to topocentric).

/// Semi-major axis, m.
pub const A: f64 = 6_378_137.0;
/// Flattening.
pub const F: f64 = 1.0 / 298.257_223_563;
/// Semi-minor axis, m.
pub const B: f64 = A * (1.0 - F);
/// Square of the first eccentricity.
const E2: f64 = F * (2.0 - F);
/// Square of the second eccentricity.
const E2_SECOND: f64 = E2 / (1.0 - E2);

/// A position on Earth.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GeodeticPosition {
    /// Latitude, rad, north positive.
    pub latitude: f64,
    /// Longitude, rad, east positive, -pi to pi.
    pub longitude: f64,
    /// Height above the ellipsoid, m.
    pub altitude: f64,
}

impl GeodeticPosition {
    /// Returns Earth-centred coordinates: x towards latitude and longitude 0, z towards the north pole; m.
    pub fn to_ecef(self) -> [f64; 3] {
        let ((s, c), (sl, cl)) = (libm::sincos(self.latitude), libm::sincos(self.longitude));
        let n = A / (1.0 - E2 * s * s).sqrt();
        [(n + self.altitude) * c * cl, (n + self.altitude) * c * sl, ((1.0 - E2) * n + self.altitude) * s]
    }

    /// Converts Earth-centred coordinates, by Bowring's iteration over the reduced latitude ("Transformation from
    /// spatial to geographical coordinates", Survey Review 23, 1976): errors are below 1e-9 m after three rounds, from
    /// 10 km below ground up to satellites. Within 45 km of the centre, where latitudes are ambiguous, the result is
    /// only guaranteed to be finite.
    pub fn from_ecef([x, y, z]: [f64; 3]) -> Self {
        let p = libm::hypot(x, y);
        let mut reduced = libm::atan2(z * A, p * B);
        let mut latitude = 0.0;
        for _ in 0..ITERATIONS {
            let (s, c) = libm::sincos(reduced);
            latitude = libm::atan2(z + E2_SECOND * B * s.powi(3), (p - E2 * A * c.powi(3)).max(0.0));
            let (s, c) = libm::sincos(latitude);
            reduced = libm::atan2((1.0 - F) * s, c);
        }
        let (s, c) = libm::sincos(latitude);
        // Unlike p / cos - n, this is also accurate at the poles: Bowring, "The accuracy of geodetic latitude and
        // height equations", 1985.
        let altitude = p * c + z * s - A * (1.0 - E2 * s * s).sqrt();
        GeodeticPosition { latitude, longitude: libm::atan2(y, x), altitude }
    }
}

/// Number of rounds of the iteration; each reduces the error at least a thousandfold.
const ITERATIONS: usize = 5;

/// A plane tangent to the Earth, with the frame x east, y north, z up.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TangentPlane {
    ecef: [f64; 3],
    /// East, north and up, as Earth-centred vectors.
    axes: [[f64; 3]; 3],
}

impl TangentPlane {
    /// Returns the plane that touches the Earth at `origin`.
    pub fn at(origin: GeodeticPosition) -> Self {
        let ((s, c), (sl, cl)) = (libm::sincos(origin.latitude), libm::sincos(origin.longitude));
        TangentPlane { ecef: origin.to_ecef(), axes: [[-sl, cl, 0.0], [-s * cl, -s * sl, c], [c * cl, c * sl, s]] }
    }

    /// Converts a point in the plane's frame (east, north, up; m) to a position on Earth.
    pub fn geodetic_position(&self, local: [f64; 3]) -> GeodeticPosition {
        let along = |i: usize| (0..3).map(|k| local[k] * self.axes[k][i]).sum::<f64>();
        GeodeticPosition::from_ecef([0, 1, 2].map(|i| self.ecef[i] + along(i)))
    }

    /// Converts a position on Earth to a point in the plane's frame (east, north, up; m).
    pub fn local_point(&self, place: GeodeticPosition) -> [f64; 3] {
        let ecef = place.to_ecef();
        self.axes.map(|axis| (0..3).map(|i| axis[i] * (ecef[i] - self.ecef[i])).sum())
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::{FRAC_PI_2, PI};

    use super::*;

    fn degrees(latitude: f64, longitude: f64, altitude: f64) -> GeodeticPosition {
        GeodeticPosition { latitude: latitude.to_radians(), longitude: longitude.to_radians(), altitude }
    }

    fn distance(a: [f64; 3], b: [f64; 3]) -> f64 {
        (0..3).map(|i| (a[i] - b[i]).powi(2)).sum::<f64>().sqrt()
    }

    /// The example of EPSG guidance note 7-2 for method 9602: 53°48'33.820"N 2°07'46.380"E 73.0 m.
    const EXAMPLE_ECEF: [f64; 3] = [3_771_793.968, 140_253.342, 5_124_304.349];
    fn example() -> GeodeticPosition {
        degrees(53.0 + 48.0 / 60.0 + 33.820 / 3600.0, 2.0 + 7.0 / 60.0 + 46.380 / 3600.0, 73.0)
    }

    #[test]
    fn the_example_of_epsg_for_geocentric_coordinates() {
        assert!(distance(example().to_ecef(), EXAMPLE_ECEF) < 1e-3);
        let back = GeodeticPosition::from_ecef(EXAMPLE_ECEF);
        // 0.001" is 31 mm of latitude, the precision of the example.
        assert!((back.latitude - example().latitude).abs() < 1e-9, "{back:?}");
        assert!((back.longitude - example().longitude).abs() < 1e-9);
        assert!((back.altitude - 73.0).abs() < 1e-3);
    }

    #[test]
    fn the_example_of_epsg_for_a_plane() {
        // Method 9837: the plane at 55°N 5°E, 200 m. In it, the example's point has the coordinates U V W.
        let plane = TangentPlane::at(degrees(55.0, 5.0, 200.0));
        let wanted = [-189_013.869, -128_642.040, -4_220.171];
        assert!(distance(plane.local_point(example()), wanted) < 2e-3, "{:?}", plane.local_point(example()));
        let back = plane.geodetic_position(wanted);
        assert!(distance(back.to_ecef(), EXAMPLE_ECEF) < 2e-3);
    }

    #[test]
    fn poles_and_equator_match_the_axes_of_the_ellipsoid() {
        // NGA.STND.0036 states the derived semi-minor axis as 6 356 752.3142 m.
        assert!((B - 6_356_752.314_2).abs() < 1e-4);
        assert!(distance(degrees(0.0, 0.0, 0.0).to_ecef(), [A, 0.0, 0.0]) < 1e-9);
        assert!(distance(degrees(90.0, 0.0, 10.0).to_ecef(), [0.0, 0.0, B + 10.0]) < 1e-8);
        let pole = GeodeticPosition::from_ecef([0.0, 0.0, -B - 7.0]);
        assert!((pole.latitude + FRAC_PI_2).abs() < 1e-12 && (pole.altitude - 7.0).abs() < 1e-8, "{pole:?}");
    }

    #[test]
    fn ecef_round_trip_is_exact_to_a_nanometre() {
        // 1e-9 m is about the resolution of coordinates of 6e6 m (9.3e-10): two units are allowed.
        for lat in (-90..=90).step_by(5) {
            for lon in (-175..=180).step_by(35) {
                for alt in [-10_000.0, -1.0, 0.0, 519.0, 9000.0, 400e3, 20e6] {
                    let place = degrees(f64::from(lat), f64::from(lon), alt);
                    let ecef = place.to_ecef();
                    let back = GeodeticPosition::from_ecef(ecef);
                    let error = distance(back.to_ecef(), ecef);
                    assert!(error < 4e-9 * (1.0 + alt.abs() / A), "{place:?}: {error}");
                    assert!((back.altitude - alt).abs() < 4e-9 * (1.0 + alt.abs() / A), "{place:?}: {back:?}");
                }
            }
        }
    }

    #[test]
    fn tangent_plane_conversions_are_inverse() {
        for origin in [degrees(48.1372, 11.5756, 519.0), degrees(-89.9999, 170.0, 2800.0), degrees(0.0, 180.0, 0.0)] {
            let plane = TangentPlane::at(origin);
            for local in [[0.0; 3], [1.0, 2.0, 3.0], [-5e3, 7e3, 120.0], [1e5, -2e5, 1e4]] {
                let back = plane.local_point(plane.geodetic_position(local));
                assert!(distance(back, local) < 1e-8, "{origin:?} {local:?} {back:?}");
            }
        }
    }

    #[test]
    fn conversion_from_ecef_is_always_finite() {
        for ecef in [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 0.0, 1e-300], [-3e4, 1e3, 2e4], [1e30, -1e30, 1e30]] {
            let place = GeodeticPosition::from_ecef(ecef);
            assert!(place.latitude.abs() <= FRAC_PI_2 && place.longitude.abs() <= PI && place.altitude.is_finite());
        }
    }
}
