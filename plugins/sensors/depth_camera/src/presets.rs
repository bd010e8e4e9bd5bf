//! Presets of devices. The README lists the sources of the values.

use tatu_plugin_api::safe::Preset;

/// The settings shared by both modes of the first Kinect.
macro_rules! kinect_v1 {
    ($least:literal, $most:literal) => {
        concat!(
            "columns = 640\nrows = 480\nperspective_angle_deg = 58.51\nnear_m = 0.01\nfar_m = 10.0\nempty = \"zero\"\n",
            "projector_m = -0.075\nedges = \"lost\"\nlateral_sigma = 0.8\nmax_incidence_deg = 75.0\n",
            "noise = { depth = { sigma = [0.0, 0.0, 1.425e-3], inverse_step = 2.85e-3, limits = [",
            $least,
            ", ",
            $most,
            "] } }\n",
        )
    };
}

/// The presets of the sensor kind.
pub const ALL: &[Preset] = &[
    Preset {
        id: "vrep_kinect",
        text: "The Kinect of V-REP's models: 640 x 480, 57 degrees, 0.01 to 3.5 m, without noise.",
        settings: "columns = 640\nrows = 480\nperspective_angle_deg = 57.0\nnear_m = 0.01\nfar_m = 3.5\n",
    },
    Preset {
        id: "kinect_v1",
        text: "Microsoft Kinect, structured light: 58.5 degrees, 0.8 to 4 m (Kinect for Windows SDK 1.8); noise and steps \
            that grow with the square of the depth (Khoshelham and Elberink 2012).",
        settings: kinect_v1!("0.8", "4.0"),
    },
    Preset {
        id: "kinect_v1_near",
        text: "Microsoft Kinect in near mode: 0.4 to 3 m (Kinect for Windows SDK 1.8).",
        settings: kinect_v1!("0.4", "3.0"),
    },
    Preset {
        id: "kinect_v2",
        text: "Microsoft Kinect for Xbox One, time of flight: 512 x 424, f 365.456 px, 0.5 to 4.5 m (libfreenect2); noise \
            by depth (Fankhauser and others 2015).",
        settings: "columns = 512\nrows = 424\nperspective_angle_deg = 70.02\nnear_m = 0.01\nfar_m = 18.75\nempty = \"zero\"\n\
            edges = \"mixed\"\nmax_incidence_deg = 80.0\n\
            noise = { depth = { sigma = [1.5e-3, -0.5e-3, 0.3e-3], limits = [0.5, 4.5] } }\n",
    },
    Preset {
        id: "realsense_d435",
        text: "Intel RealSense D435, stereo: 848 x 480, 85.2 degrees (D430 module table), 0.11 to 10 m; noise by the square \
            of the depth over focal length and base of 50 mm, 0.08 pixels (estimate).",
        settings: "columns = 848\nrows = 480\nperspective_angle_deg = 85.2\nnear_m = 0.01\nfar_m = 20.0\nempty = \"zero\"\n\
            projector_m = -0.05\nedges = \"lost\"\nmax_incidence_deg = 80.0\n\
            noise = { depth = { sigma = [0.0, 0.0, 3.47e-3], limits = [0.11, 10.0] } }\n",
    },
];
