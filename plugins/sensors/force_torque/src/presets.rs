//! Presets of commercial transducers: saturation and noise.
//!
//! `clamp` limits all axes equally. If a data sheet states a greater range along z than along x and y, the preset uses
//! the range along z.

use tatu_plugin_api::safe::Preset;

pub(crate) const ALL: &[Preset] = &[
    Preset {
        id: "ati_axia80_m20",
        text: "ATI Axia80-M20, calibration SI-500-20: 500 N across, 900 N along z, 20 N m (manual 9610-05-Ethernet Axia, \
               table 4.8). Noise of 0.1 N and 0.005 N m is an estimate: the order of the resolution of such sensors.",
        settings: "noise.force = { sigma = 0.1, clamp = [-900.0, 900.0] }
noise.torque = { sigma = 0.005, clamp = [-20.0, 20.0] }
",
    },
    Preset {
        id: "robotiq_ft300",
        text: "Robotiq FT 300: 300 N and 30 N m, 100 Hz, 0.1 N (roboticscenter.ai, guide to force and torque sensors); noise \
               of the torque, 0.005 N m, is an estimate.",
        settings: "rate_hz = 100.0
noise.force = { sigma = 0.1, clamp = [-300.0, 300.0] }
noise.torque = { sigma = 0.005, clamp = [-30.0, 30.0] }
",
    },
];
