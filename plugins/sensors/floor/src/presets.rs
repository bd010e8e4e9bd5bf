//! Presets of commercial line sensors, and of V-REP's.

use tatu_plugin_api::safe::Preset;

pub(crate) const ALL: &[Preset] = &[
    Preset {
        id: "qtr_8",
        text: "Pololu QTR-8: 8 spots, 9.525 mm apart, best at 3 mm, up to 9.5 mm (product page). Estimates: the \
               decrease beyond 3 mm, spots of 2 mm, and noise of 1 %.",
        settings: "count = 8
pitch_m = 0.009525
range_m = 0.0095
diameter_m = 0.002
rays = 7
response = [0.0, 0.6, 0.003, 1.0, 0.0095, 0.3]
noise.value = { sigma = 0.01 }
",
    },
    Preset {
        id: "e_puck",
        text: "e-puck, ground sensors: 3 spots, 10 mm apart; white yields 1000 at 0 and 300 at 16 mm, noise 10 % \
               (Webots, E-puckGroundSensors.proto); 1000 corresponds to 1 here.",
        settings: "count = 3
pitch_m = 0.01
range_m = 0.016
response = [0.0, 1.0, 0.016, 0.3]
noise.value = { sigma = [0.0, 0.1] }
",
    },
    Preset {
        id: "thymio_2",
        text: "Thymio II, ground sensors: 2 spots at y of 12 and -12 mm; white yields 1000 at 0, decreasing linearly \
               to 0 at 50 mm, noise 1 % (Webots, Thymio2.proto); 1000 corresponds to 1 here.",
        settings: "count = 2
pitch_m = 0.024
range_m = 0.05
response = [0.0, 1.0, 0.05, 0.0]
noise.value = { sigma = [0.0, 0.01] }
",
    },
    Preset {
        id: "vrep_line_tracer",
        text: "V-REP's LineTracer: 3 spots, 22.5 mm apart, each 10 mm wide, up to 60 mm, without noise (measured on the model \
               in a course scene).",
        settings: "count = 3\npitch_m = 0.0225\nrange_m = 0.06\ndiameter_m = 0.01\nrays = 64\n",
    },
];
