//! Units in scene files, whose keys include the unit. Internally, all values are in SI units and radians.

/// Returns the suffixes by which the keys of scene files express a unit, with factors to SI. The first one is suggested
/// in messages.
pub fn suffixes(unit: &str) -> &'static [(&'static str, f64)] {
    const DEG: f64 = std::f64::consts::PI / 180.0;
    match unit {
        "m" => &[("_m", 1.0)],
        "rad" => &[("_deg", DEG), ("_rad", 1.0)],
        "s" => &[("_s", 1.0)],
        "kg" => &[("_kg", 1.0)],
        "Hz" => &[("_hz", 1.0)],
        "N" => &[("_n", 1.0)],
        "N m" => &[("_nm", 1.0)],
        "m/s" => &[("_m_s", 1.0)],
        "rad/s" => &[("_deg_s", DEG), ("_rad_s", 1.0)],
        "m/s^2" => &[("_m_s2", 1.0)],
        "kg m^2" => &[("_kg_m2", 1.0)],
        "N m/rad" => &[("_nm_rad", 1.0)],
        "N/m" => &[("_n_m", 1.0)],
        "N m s/rad" => &[("_nms_rad", 1.0)],
        "N s/m" => &[("_ns_m", 1.0)],
        "J" => &[("_j", 1.0)],
        "W" => &[("_w", 1.0)],
        "V" => &[("_v", 1.0)],
        "A" => &[("_a", 1.0)],
        "K" => &[("_k", 1.0)],
        "Pa" => &[("_pa", 1.0)],
        "T" => &[("_t", 1.0)],
        _ => &[("", 1.0)],
    }
}

/// Units that keys can include. Keys without a unit or with the unit "1" have no suffix.
pub const KNOWN_UNITS: &[&str] = &[
    "m",
    "rad",
    "s",
    "kg",
    "Hz",
    "N",
    "N m",
    "m/s",
    "rad/s",
    "m/s^2",
    "kg m^2",
    "N m/rad",
    "N/m",
    "N m s/rad",
    "N s/m",
    "J",
    "W",
    "V",
    "A",
    "K",
    "Pa",
    "T",
    "1",
];

/// Returns whether scene files support a unit.
pub fn is_known(unit: &str) -> bool {
    unit.is_empty() || KNOWN_UNITS.contains(&unit)
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
