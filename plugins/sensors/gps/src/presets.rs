//! Presets of commercial receivers, and of V-REP's.
//!
//! A circular error of 2.5 m (CEP, 50 %) is 2.5 / 1.1774 = 2.12 m per axis. Drift is a Gauss-Markov process of 1100 s;
//! that of the height is larger by 0.40 / 0.21. Both are as in the mavsim book's `sensor_parameters.py`.

use tatu_plugin_api::safe::Preset;

pub(crate) const ALL: &[Preset] = &[
    Preset {
        id: "typical",
        text: "A receiver as drones carry it: 5 Hz, 2.5 m circular error that drifts over 1100 s (mavsim_public, \
               sensor_parameters.py), 0.1 m white and 0.05 m/s; an estimate, since the combination is ours.",
        settings: "rate_hz = 5.0
noise = { position = { sigma = 0.1, walk = { sigma = [2.12, 2.12, 4.04], tau_s = 1100.0 } }, velocity = { sigma = 0.05 } }
",
    },
    Preset {
        id: "ublox_m8",
        text: "u-blox M8: 2.5 m circular error, 0.05 m/s, 1 Hz unless set otherwise, up to 18 Hz (MAX-M8Q data sheet). How \
               the error drifts is an estimate: as `typical`.",
        settings: "rate_hz = 1.0
noise = { position = { sigma = 0.1, walk = { sigma = [2.12, 2.12, 4.04], tau_s = 1100.0 } }, velocity = { sigma = 0.05 } }
",
    },
    Preset {
        id: "ublox_6",
        text: "u-blox 6: 2.5 m circular error, 0.1 m/s, 4 Hz (SPK-GS408A data sheet). How the error drifts is an estimate: \
               as `typical`.",
        settings: "rate_hz = 4.0
noise = { position = { sigma = 0.1, walk = { sigma = [2.12, 2.12, 4.04], tau_s = 1100.0 } }, velocity = { sigma = 0.1 } }
",
    },
    Preset {
        id: "vrep_gps",
        text: "V-REP's GPS: in each step, uniform noise of ±0.1 ±0.1 ±0.05 m and a shift of up to ±1 ±1 ±0.5 m that stays \
               for a run (measured on the model in a course scene).",
        settings: "noise = { position = { uniform = [0.1, 0.1, 0.05], shift = [1.0, 1.0, 0.5] } }
",
    },
];
