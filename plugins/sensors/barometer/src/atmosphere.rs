//! The standard atmosphere: pressure as a function of altitude, and its inverse.
//!
//! Constants of ICAO Doc 7488/2 and the U.S. Standard Atmosphere 1976, as crnslab.org/util/atmo.php lists them: the
//! temperature decreases by 6.5 K per km from 288.15 K at sea level to 216.65 K at 11 km, and is constant up to 20 km.
//! In these layers
//!
//! p = p0 (1 - L h / T0)^(g0 / (R L))    and    p = p1 exp(-g0 (h - h1) / (R T1)),
//!
//! where h = r z / (r + z) is the geopotential altitude at the geometric altitude z, and r is the radius of the Earth.

/// Pressure at sea level, Pa.
pub const SEA_LEVEL_PRESSURE: f64 = 101_325.0;
/// Temperature at sea level, K.
const T0: f64 = 288.15;
/// Decrease of temperature in the lower layer, K/m.
const LAPSE_RATE: f64 = 0.0065;
/// Standard gravity, m/s^2.
const G0: f64 = 9.806_65;
/// Specific gas constant of air, J/(kg K): 8.31432 J/(mol K) over 0.0289644 kg/mol.
const R: f64 = 8.314_32 / 0.028_964_4;
/// Radius of the Earth in the definition of geopotential altitude, m.
const EARTH_RADIUS: f64 = 6_356_766.0;
/// Geopotential altitude of the tropopause, m.
const TROPOPAUSE: f64 = 11_000.0;
/// Temperature at the tropopause, K.
const T1: f64 = T0 - LAPSE_RATE * TROPOPAUSE;
const EXPONENT: f64 = G0 / (R * LAPSE_RATE);
/// Minimum supported altitude, m. It is below any mine and any point on land.
const MIN_ALTITUDE_M: f64 = -10_000.0;
/// Maximum supported altitude, m.
const MAX_ALTITUDE_M: f64 = 100_000.0;

/// Returns the ratio of the pressure at the tropopause to that at sea level.
fn tropopause_ratio() -> f64 {
    libm::pow(T1 / T0, EXPONENT)
}

/// Returns the ratio of the pressure at an altitude, m, to that at sea level. The altitude is clamped to
/// `MIN_ALTITUDE_M` and `MAX_ALTITUDE_M`; above 20 km, the formula of the layer below is used.
pub fn pressure_ratio(altitude: f64) -> f64 {
    let z = altitude.clamp(MIN_ALTITUDE_M, MAX_ALTITUDE_M);
    let h = EARTH_RADIUS * z / (EARTH_RADIUS + z);
    if h < TROPOPAUSE {
        libm::pow(1.0 - LAPSE_RATE * h / T0, EXPONENT)
    } else {
        tropopause_ratio() * libm::exp(-G0 * (h - TROPOPAUSE) / (R * T1))
    }
}

/// Returns the altitude, m, at which the ratio of the pressure to that at sea level is `share`.
pub fn altitude(share: f64) -> f64 {
    let share = share.max(1e-12);
    let tropopause = tropopause_ratio();
    let h = if share > tropopause {
        T0 / LAPSE_RATE * (1.0 - libm::pow(share, 1.0 / EXPONENT))
    } else {
        TROPOPAUSE - R * T1 / G0 * libm::log(share / tropopause)
    };
    EARTH_RADIUS * h / (EARTH_RADIUS - h)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pressures_are_those_of_the_published_table() {
        // Wikipedia, "Barometric formula": 22632.10 Pa at a geopotential altitude of 11 km, 5474.89 Pa at 20 km.
        let of = |h: f64| SEA_LEVEL_PRESSURE * pressure_ratio(EARTH_RADIUS * h / (EARTH_RADIUS - h));
        assert!((of(11_000.0) - 22_632.10).abs() < 0.1, "{}", of(11_000.0));
        assert!((of(20_000.0) - 5_474.89).abs() < 0.1, "{}", of(20_000.0));
        assert_eq!(of(0.0), SEA_LEVEL_PRESSURE);
        assert!((EXPONENT - 5.255_88).abs() < 1e-5);
    }

    #[test]
    fn altitude_and_pressure_are_inverse() {
        for z in [-400.0, 0.0, 0.01, 519.0, 8848.0, 11_019.0, 11_020.0, 19_000.0] {
            assert!((altitude(pressure_ratio(z)) - z).abs() < 1e-6, "{z}: {}", altitude(pressure_ratio(z)));
        }
    }

    #[test]
    fn pressure_and_altitude_are_always_finite() {
        for z in [f64::NEG_INFINITY, -1e9, 1e9, f64::INFINITY] {
            assert!(pressure_ratio(z).is_finite() && pressure_ratio(z) > 0.0);
        }
        for p in [-1.0, 0.0, f64::MIN_POSITIVE, 3.0] {
            assert!(altitude(p).is_finite(), "{p}");
        }
    }
}
