//! Presets of bumpers and feet.

use tatu_plugin_api::safe::Preset;

pub(crate) const ALL: &[Preset] = &[
    Preset {
        id: "bumper_switch",
        text: "Bumper of a small mobile robot with micro switches: 1.5 N (estimate: the levers of such switches \
               require about 0.5 to 1.5 N, and the bumper adds friction).",
        settings: "threshold_n = 1.5\n",
    },
    Preset {
        id: "nao_bumper",
        text: "NAO: switch at the tip of a foot (doc.aldebaran.com, contact sensors: x 0.0876 m, z -0.0353 m in the ankle's \
               frame, which is the sensor's); the box around it and 2 N are estimates.",
        settings: "threshold_n = 2.0\nregion_m = [0.08, -0.04, -0.05, 0.11, 0.045, -0.02]\n",
    },
    Preset {
        id: "nao_foot",
        text: "NAO: the four force sensors of a sole together, in the ankle's frame; sole of 0.15 x 0.075 m at z -0.045 m \
               (nao_description, BHuman). 0.5 N of noise, the threshold, and the range of 4 x 25 N are estimates.",
        settings: "threshold_n = 2.0
rate_hz = 100.0
region_m = [-0.065, -0.045, -0.055, 0.105, 0.051, -0.035]
noise.normal_force = { sigma = 0.5, clamp = [0.0, 100.0] }
",
    },
];
