//! Presets of commercial magnetometers, and of those in other simulators.
//!
//! 1 G is 1e-4 T. A heading error of 1 degree corresponds to a field error of 0.0175 times the horizontal component,
//! which is 20.9 uT by default: 3.6e-7 T.

use tatu_plugin_api::safe::Preset;

pub(crate) const ALL: &[Preset] = &[
    Preset {
        id: "hmc5883l",
        text: "Honeywell HMC5883L: 2 mG, 0.92 mG a digit at its range of 1.3 G, 75 Hz at most (data sheet). An offset \
               of up to 5e-7 T per axis is an estimate that yields the specified accuracy of 1 to 2 degrees.",
        settings: "rate_hz = 75.0
noise.field = { shift = 5.0e-7, sigma = 2.0e-7, clamp = [-1.3e-4, 1.3e-4], step = 9.2e-8 }
",
    },
    Preset {
        id: "hector",
        text: "The magnetometer of hector_quadrotor: 10 Hz, noise 0.013 (hector_quadrotor), taken as a fraction of the \
               field strength (estimate).",
        settings: "rate_hz = 10.0\nnoise.field = { sigma = 6.6e-7 }\n",
    },
    Preset {
        id: "mavsim",
        text: "The compass of mavsim_public, sensor_parameters.py: a bias of 1 degree and white noise of 0.03 degrees \
               of the heading, converted to noise of the default horizontal field (estimate).",
        settings: "noise.field = { shift_sigma = 3.6e-7, sigma = 1.1e-8 }\n",
    },
];
