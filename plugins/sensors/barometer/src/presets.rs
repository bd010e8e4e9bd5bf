//! Presets of commercial barometers. Near sea level, a difference of 12 Pa corresponds to 1 m.

use tatu_plugin_api::safe::Preset;

pub(crate) const ALL: &[Preset] = &[
    Preset {
        id: "bmp280",
        text: "Bosch BMP280: 300 to 1100 hPa, absolute accuracy 1 hPa, relative 0.12 hPa, steps of 0.16 Pa at ultra high \
               resolution (data sheet BST-BMP280-DS001). Estimates: white noise of 1.3 Pa, a drift of 12 Pa over \
               600 s, and 25 Hz.",
        settings: "rate_hz = 25.0
noise.\"pressure.pressure\" = { shift = 100.0, walk = { sigma = 6.0, tau_s = 600.0 }, sigma = 1.3, clamp = [30000.0, 110000.0], step = 0.16 }
",
    },
    Preset {
        id: "bmp180",
        text: "Bosch BMP180: 300 to 1100 hPa (data sheet BST-BMP180-DS000). Estimates: white noise of 3 Pa (a quarter \
               of a metre), an offset of up to 1 hPa, steps of 1 Pa, and 25 Hz.",
        settings: "rate_hz = 25.0
noise.\"pressure.pressure\" = { shift = 100.0, sigma = 3.0, clamp = [30000.0, 110000.0], step = 1.0 }
",
    },
    Preset {
        id: "ms5611",
        text: "MEAS MS5611-01BA03: 10 to 1200 mbar, altitude resolved to 10 cm, here as noise of 1.2 Pa (data sheet). \
               Estimates: an offset of up to 1.5 hPa, and 50 Hz.",
        settings: "rate_hz = 50.0
noise.\"pressure.pressure\" = { shift = 150.0, sigma = 1.2, clamp = [1000.0, 120000.0] }
",
    },
];
