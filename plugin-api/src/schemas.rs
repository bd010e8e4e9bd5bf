//! The schemas of readings that the project defines, from the folder `schemas/`. Sensors and actuators fill their
//! fields, and programs that read sensors rely on them.

/// The contents of the schema files, in TOML.
pub const FILES: &[&str] = &[
    include_str!("../schemas/battery.toml"),
    include_str!("../schemas/buoyancy.toml"),
    include_str!("../schemas/contact.toml"),
    include_str!("../schemas/encoder.toml"),
    include_str!("../schemas/gps.toml"),
    include_str!("../schemas/imu.toml"),
    include_str!("../schemas/magnetic_field.toml"),
    include_str!("../schemas/pressure.toml"),
    include_str!("../schemas/reflectance.toml"),
    include_str!("../schemas/rotor.toml"),
    include_str!("../schemas/wrench.toml"),
    include_str!("../schemas/color_image.toml"),
    include_str!("../schemas/depth_image.toml"),
    include_str!("../schemas/proximity.toml"),
    include_str!("../schemas/range_scan.toml"),
    include_str!("../schemas/thrust.toml"),
];
