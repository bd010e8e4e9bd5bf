//! Presets of encoders of commercial robots: counts of the motor, and the gear ratio between motor and wheel.

use tatu_plugin_api::safe::Preset;

pub(crate) const ALL: &[Preset] = &[
    Preset {
        id: "pioneer_p3dx",
        text: "Pioneer P3-DX: 500 ticks per motor turn, in quadrature, gear 38.3: 76,600 counts per wheel turn \
               (Pioneer 3 manual, table 20).",
        settings: "counts_per_turn = 2000.0\ngear = 38.3\n",
    },
    Preset {
        id: "pioneer_p3at",
        text: "Pioneer P3-AT: 500 ticks per motor turn, in quadrature, gear 49.8: 99,600 counts per wheel turn \
               (Pioneer 3 manual, table 20).",
        settings: "counts_per_turn = 2000.0\ngear = 49.8\n",
    },
    Preset {
        id: "e_puck",
        text: "e-puck: 20 steps of the motor, gear 50, so 1000 steps per wheel turn (Webots, epuck.md).",
        settings: "counts_per_turn = 20.0\ngear = 50.0\n",
    },
    Preset {
        id: "youbot",
        text: "KUKA youBot: 4000 counts per motor turn, gear 9405 / 364 (youbot_driver, youbot-base.cfg).",
        settings: "counts_per_turn = 4000.0\ngear = 25.837912087912088\n",
    },
];
