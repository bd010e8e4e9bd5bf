//! Presets of common battery packs.

use tatu_plugin_api::safe::Preset;

pub(crate) const ALL: &[Preset] = &[
    Preset {
        id: "lipo_3s",
        text: "Three lithium polymer cells in series, as in the TurtleBot3: 3.0 V empty, 3.7 V nominal, 4.2 V full per cell \
               (campusrover.org, LiPo background). Estimates: 1.8 A h, 30 mOhm, and the other voltages.",
        settings: "capacity_ah = 1.8
voltages_v = [9.0, 10.8, 11.1, 11.25, 11.7, 12.6]
resistance_ohm = 0.03
",
    },
    Preset {
        id: "lead_acid_12v",
        text: "Sealed lead acid battery of 12 V and 7.2 A h for mobile robots of 10 kg. All values are estimates: six \
               cells of 1.93 V empty and 2.13 V full, 25 mOhm.",
        settings: "capacity_ah = 7.2\nvoltages_v = [11.6, 12.8]\nresistance_ohm = 0.025\n",
    },
    Preset {
        id: "li_ion_cell",
        text: "One lithium ion cell of 1.4 A h for a small desktop robot. All values are estimates: 3.0 V empty, \
               3.7 V nominal, 4.2 V full, 0.1 Ohm.",
        settings: "capacity_ah = 1.4\nvoltages_v = [3.0, 3.6, 3.7, 3.75, 3.9, 4.2]\nresistance_ohm = 0.1\n",
    },
];
