//! Presets of commercial receivers, and of V-REP's.
//!
//! A circular error of 2.5 m (CEP, 50 %) is 2.5 / 1.1774 = 2.12 m per axis. Drift is a Gauss-Markov process with
//! a time constant of 1100 s, and is greater in height by a factor of 0.40 / 0.21 (mavsim book,
//! `sensor_parameters.py`).

use tatu_plugin_api::safe::Preset;

pub(crate) const ALL: &[Preset] = &[
    Preset {
        id: "typical",
        text: "Typical receiver of a drone: 5 Hz, 2.5 m circular error that drifts over 1100 s (mavsim_public, \
               sensor_parameters.py), white noise of 0.1 m and 0.05 m/s; the combination is an estimate.",
        settings: "rate_hz = 5.0
noise = { position = { sigma = 0.1, walk = { sigma = [2.12, 2.12, 4.04], tau_s = 1100.0 } }, velocity = { sigma = 0.05 } }
",
    },
    Preset {
        id: "ublox_m8",
        text: "u-blox M8: 2.5 m circular error, 0.05 m/s, 1 Hz unless set otherwise, up to 18 Hz (MAX-M8Q data sheet). \
               The drift of the error is an estimate, the same as in `typical`.",
        settings: "rate_hz = 1.0
noise = { position = { sigma = 0.1, walk = { sigma = [2.12, 2.12, 4.04], tau_s = 1100.0 } }, velocity = { sigma = 0.05 } }
",
    },
    Preset {
        id: "ublox_6",
        text: "u-blox 6: 2.5 m circular error, 0.1 m/s, 4 Hz (SPK-GS408A data sheet). The drift of the error is an \
               estimate, the same as in `typical`.",
        settings: "rate_hz = 4.0
noise = { position = { sigma = 0.1, walk = { sigma = [2.12, 2.12, 4.04], tau_s = 1100.0 } }, velocity = { sigma = 0.1 } }
",
    },
    Preset {
        id: "vrep_gps",
        text: "V-REP's GPS: in each step, uniform noise of ±0.1 ±0.1 ±0.05 m and a shift of up to ±1 ±1 ±0.5 m that is \
               constant during a run (measured on the model in a course scene).",
        settings: "noise = { position = { uniform = [0.1, 0.1, 0.05], shift = [1.0, 1.0, 0.5] } }
",
    },
];
