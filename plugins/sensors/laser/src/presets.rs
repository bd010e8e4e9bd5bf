//! Presets of commercial devices, and of the scanners in V-REP's models.
//!
//! The number of beams includes both ends of the field of view: field / step + 1.

use tatu_plugin_api::safe::Preset;

pub(crate) const ALL: &[Preset] = &[
    Preset {
        id: "hokuyo_urg_04lx",
        text: "Hokuyo URG-04LX: 682 beams, steps 44 to 725 of 1024 per turn with step 384 ahead, 10 Hz, whole mm (SCIP \
               2.0 parameters; Webots, lidar-sensors). Noise, an estimate: the usual ±10 mm below 1 m and 1 % beyond, \
               taken as three standard deviations, to which the polynomial is fitted.",
        settings: "start_angle_deg = -119.53125
end_angle_deg = 119.8828125
rays = 682
min_range_m = 0.06
range_m = 4.095
rate_hz = 10.0
noise = { distance = { sigma = [0.0025, 0.0012, 0.0004], step = 0.001 } }
",
    },
    Preset {
        id: "hokuyo_utm_30lx",
        text: "Hokuyo UTM-30LX: 1081 beams, steps 0 to 1080 of 1440 per turn with step 540 ahead, 40 Hz, 0.1 to 30 m, \
               whole mm (SCIP 2.0; Webots, lidar-sensors). Noise: 10 mm, as in simulators; the data sheet states ±30 mm \
               up to 10 m and ±50 mm beyond.",
        settings: "start_angle_deg = -135.0
end_angle_deg = 135.0
rays = 1081
min_range_m = 0.1
range_m = 30.0
rate_hz = 40.0
noise = { distance = { sigma = 0.01, step = 0.001 } }
",
    },
    Preset {
        id: "sick_lms200",
        text: "SICK LMS200 in steps of 1 degree: 181 beams over 180 degrees, 75 Hz, 8.192 m in its mm mode (Player, \
               sicklms200). Noise, an estimate: the usual 5 mm, and a constant error of up to ±15 mm.",
        settings: "start_angle_deg = -90.0
end_angle_deg = 90.0
rays = 181
range_m = 8.192
rate_hz = 75.0
noise = { distance = { sigma = 0.005, shift = 0.015, step = 0.001 } }
",
    },
    Preset {
        id: "sick_lms200_half_degree",
        text: "SICK LMS200 in steps of half a degree: 361 beams, half the rate of `sick_lms200`, because a scan \
               requires two turns of the mirror (Player, sicklms200; sicktoolbox); otherwise the same.",
        settings: "start_angle_deg = -90.0
end_angle_deg = 90.0
rays = 361
range_m = 8.192
rate_hz = 37.5
noise = { distance = { sigma = 0.005, shift = 0.015, step = 0.001 } }
",
    },
    Preset {
        id: "sick_s300",
        text: "SICK S300: 541 beams over 270 degrees, a scan every 40 ms, 30 m (Webots, SickS300.proto; Care-O-bot \
               driver). No noise, because the sources do not specify it.",
        settings: "start_angle_deg = -135.0
end_angle_deg = 135.0
rays = 541
range_m = 30.0
rate_hz = 25.0
",
    },
    Preset {
        id: "velodyne_vlp16",
        text: "Velodyne VLP-16 at 600 turns/min: 16 layers 2 degrees apart from -15 to 15, lowest first, 1808 beams \
               around in each, 0.9 to 100 m (velodyne driver, VLP16db.yaml; a firing every 55.296 µs). Noise: 8 mm, as \
               in its simulator. The vertical offsets of the layers, up to 11 mm, are not modelled, and all layers fire \
               at the same time.",
        settings: "start_angle_deg = -180.0
end_angle_deg = 179.80088495575222
rays = 1808
layers = 16
vertical_field_deg = 30.0
min_range_m = 0.9
range_m = 100.0
rate_hz = 10.0
noise = { distance = { sigma = 0.008 } }
",
    },
    Preset {
        id: "vrep_laser_scanner_2d",
        text: "V-REP's LaserScanner_2D, a SICK: 361 beams over 180 degrees, each from 0.055 m to 20 m, one scan per \
               step, no noise (measured on the model in a course scene).",
        settings: "start_angle_deg = -90.0
end_angle_deg = 90.0
rays = 361
near_m = 0.055
range_m = 20.0
",
    },
    Preset {
        id: "vrep_hokuyo_urg_04lx_ug01",
        text: "V-REP's Hokuyo_URG_04LX_UG01: 684 beams over 240 degrees, each from 0.022 m to 5.6 m, 10 Hz, uniform noise \
               of ±10 mm (measured on the model in two course scenes).",
        settings: "start_angle_deg = -120.0
end_angle_deg = 120.0
rays = 684
near_m = 0.022
range_m = 5.6
rate_hz = 10.0
noise = { distance = { uniform = 0.01 } }
",
    },
];
