//! Units in scene files, whose keys include the unit. Internally, all values are in SI units and radians.

const DEG: f64 = std::f64::consts::PI / 180.0;

/// Units with the suffixes by which the keys of scene files express them, and the factors of these to SI. The first
/// suffix is suggested in messages. `core.h` has the same list; any other unit has no suffix. Nor had those with an empty
/// suffix in earlier releases, whose files stay valid.
pub const UNITS: &[(&str, &[(&str, f64)])] = &[
    ("m", &[("_m", 1.0)]),
    ("rad", &[("_deg", DEG), ("_rad", 1.0)]),
    ("s", &[("_s", 1.0)]),
    ("kg", &[("_kg", 1.0)]),
    ("Hz", &[("_hz", 1.0)]),
    ("N", &[("_n", 1.0)]),
    ("N m", &[("_nm", 1.0)]),
    ("N s", &[("_ns", 1.0), ("", 1.0)]),
    ("m/s", &[("_m_s", 1.0)]),
    ("rad/s", &[("_deg_s", DEG), ("_rad_s", 1.0)]),
    ("m/s^2", &[("_m_s2", 1.0)]),
    ("rad/s^2", &[("_deg_s2", DEG), ("_rad_s2", 1.0), ("", 1.0)]),
    ("m/s^3", &[("_m_s3", 1.0), ("", 1.0)]),
    ("rad/s^3", &[("_deg_s3", DEG), ("_rad_s3", 1.0), ("", 1.0)]),
    ("m^2", &[("_m2", 1.0), ("", 1.0)]),
    ("m^3", &[("_m3", 1.0), ("", 1.0)]),
    ("kg m^2", &[("_kg_m2", 1.0)]),
    ("kg/m^3", &[("_kg_m3", 1.0), ("", 1.0)]),
    ("N m/rad", &[("_nm_rad", 1.0)]),
    ("N/m", &[("_n_m", 1.0)]),
    ("N m s/rad", &[("_nms_rad", 1.0)]),
    ("N s/m", &[("_ns_m", 1.0)]),
    ("N m/A", &[("_nm_a", 1.0), ("", 1.0)]),
    ("V s/rad", &[("_vs_rad", 1.0), ("", 1.0)]),
    ("J", &[("_j", 1.0)]),
    ("W", &[("_w", 1.0)]),
    ("V", &[("_v", 1.0)]),
    ("A", &[("_a", 1.0)]),
    ("A s", &[("_as", 1.0), ("", 1.0)]),
    ("ohm", &[("_ohm", 1.0), ("", 1.0)]),
    ("F", &[("_f", 1.0), ("", 1.0)]),
    ("H", &[("_h", 1.0), ("", 1.0)]),
    ("K", &[("_k", 1.0)]),
    ("Pa", &[("_pa", 1.0)]),
    ("T", &[("_t", 1.0)]),
    ("lx", &[("_lx", 1.0), ("", 1.0)]),
    ("cd", &[("_cd", 1.0), ("", 1.0)]),
    ("dB", &[("_db", 1.0), ("", 1.0)]),
    ("1", &[("", 1.0)]),
];

/// Units that are taken for others: misspelt, or not SI, in which all values cross the ABI.
const WRONG_UNITS: &[(&str, &[&str])] = &[
    ("m", &["meter", "meters", "metre", "metres", "mm", "cm", "km", "in", "ft"]),
    ("rad", &["radian", "radians", "deg", "degree", "degrees", "rads"]),
    ("s", &["sec", "secs", "second", "seconds", "ms", "us", "min", "h"]),
    ("kg", &["g", "gram", "grams", "kilogram", "kilograms", "Kg", "KG"]),
    ("Hz", &["hz", "HZ", "kHz", "MHz", "hertz"]),
    ("N", &["newton", "newtons", "kN", "n"]),
    ("N m", &["Nm", "N*m", "N.m", "m N"]),
    ("m/s", &["km/h", "cm/s", "mm/s", "m/sec", "mps", "m / s"]),
    ("rad/s", &["deg/s", "rpm", "RPM", "rad/sec", "1/min", "rad / s"]),
    ("m/s^2", &["m/s2", "m/s/s", "m/s**2", "g0"]),
    ("rad/s^2", &["deg/s^2", "rad/s2"]),
    ("kg m^2", &["kgm^2", "kg*m^2", "kg m2", "kg*m2", "kgm2"]),
    ("kg/m^3", &["g/cm^3", "kg/m3"]),
    ("N m/rad", &["Nm/rad", "N*m/rad", "N m/deg"]),
    ("N m s/rad", &["Nms/rad", "Nm s/rad", "Nm*s/rad"]),
    ("N s/m", &["Ns/m", "N*s/m"]),
    ("J", &["Wh", "kWh", "joule", "joules"]),
    ("W", &["watt", "watts", "kW", "mW"]),
    ("V", &["volt", "volts", "mV"]),
    ("A", &["ampere", "amperes", "amp", "amps", "mA"]),
    ("A s", &["Ah", "mAh", "As"]),
    ("ohm", &["Ohm", "ohms"]),
    ("K", &["C", "celsius", "degC", "kelvin"]),
    ("Pa", &["pascal", "bar", "mbar", "hPa", "kPa", "atm"]),
    ("T", &["tesla", "uT", "mT", "gauss"]),
    ("lx", &["lux"]),
];

/// Returns the suffixes of the keys of a parameter with a unit, with factors to SI. The first one is suggested in
/// messages.
pub fn suffixes(unit: &str) -> &'static [(&'static str, f64)] {
    UNITS.iter().find(|(name, _)| *name == unit).map_or(&[("", 1.0)], |(_, suffixes)| suffixes)
}

/// Returns the SI unit that is meant by a unit which is misspelt or not an SI unit.
pub fn meant(unit: &str) -> Option<&'static str> {
    WRONG_UNITS.iter().find(|(_, wrong)| wrong.contains(&unit)).map(|(right, _)| *right)
}

/// Returns the key of a parameter with the suffix of its unit, as messages suggest it.
pub fn key_with_unit(key: &str, unit: Option<&str>) -> String {
    format!("{key}{}", suffixes(unit.unwrap_or("")).first().map_or("", |s| s.0))
}

/// Returns the factor to SI units if a key in a file refers to the parameter `key`.
pub fn factor(written: &str, key: &str, unit: Option<&str>) -> Option<f64> {
    let rest = written.strip_prefix(key)?;
    suffixes(unit.unwrap_or("")).iter().find(|(s, _)| *s == rest).map(|(_, f)| *f)
}

/// Returns whether a key in a file is that of the parameter with a wrong unit, such as `range_cm`, or without the
/// required unit.
pub fn wrong_unit(written: &str, key: &str, unit: Option<&str>) -> bool {
    const KNOWN_SUFFIXES: &[&str] = &[
        "", "_m", "_cm", "_mm", "_km", "_in", "_ft", "_deg", "_rad", "_s", "_ms", "_us", "_kg", "_g", "_hz", "_khz",
        "_n", "_kn", "_nm", "_m_s", "_cm_s", "_km_h", "_deg_s", "_rad_s", "_rpm", "_m_s2", "_g0", "_kg_m2", "_nm_rad",
        "_n_m", "_nms_rad", "_ns_m",
    ];
    factor(written, key, unit).is_none()
        && written.strip_prefix(key).is_some_and(|rest| KNOWN_SUFFIXES.contains(&rest.to_lowercase().as_str()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_header_lists_the_same_units() {
        let header = include_str!("../../../plugin-api/include/tatu/core.h");
        let quoted = |text: &str| text.split('"').skip(1).step_by(2).map(str::to_owned).collect::<Vec<_>>();
        let list = header.split_once("Units with a suffix:").unwrap().1.split_once("*/").unwrap().0;
        let ours: Vec<String> = UNITS
            .iter()
            .flat_map(|(unit, of)| [*unit].into_iter().chain(of.iter().map(|s| s.0)))
            .map(str::to_owned)
            .collect();
        assert_eq!(quoted(list), ours.into_iter().filter(|s| !s.is_empty()).collect::<Vec<_>>());
    }

    #[test]
    fn suffixes_follow_the_rule_of_the_header() {
        for (unit, of) in UNITS.iter().filter(|(unit, _)| !["1", "kg m^2"].contains(unit)) {
            let rule = format!("_{}", unit.to_lowercase().replace('/', "_").replace(['^', ' '], ""));
            assert!(of.iter().any(|(suffix, _)| *suffix == rule), "{unit}: {rule}");
        }
    }

    #[test]
    fn no_unit_is_both_right_and_wrong() {
        for (right, wrong) in WRONG_UNITS {
            assert!(UNITS.iter().any(|(unit, _)| unit == right), "{right}");
            assert!(wrong.iter().all(|w| UNITS.iter().all(|(unit, _)| unit != w)), "{wrong:?}");
        }
    }

    #[test]
    fn unit_is_read_from_key_suffix() {
        assert_eq!(factor("range_m", "range", Some("m")), Some(1.0));
        assert_eq!(factor("angle_deg", "angle", Some("rad")), Some(std::f64::consts::PI / 180.0));
        assert_eq!(factor("angle", "angle", Some("rad")), None);
        assert_eq!(factor("preset", "preset", None), Some(1.0));
        assert!(wrong_unit("range_cm", "range", Some("m")));
        assert!(wrong_unit("range", "range", Some("m")));
        assert!(!wrong_unit("range_max", "range", Some("m")));
    }
}
