//! Presets of commercial units, and of those in public data sets.
//!
//! Data sheets state white noise as a density, per square root of Hz: 1 deg/s is 0.01745 rad/s, 1 mg is 9.80665e-3
//! m/s^2, 1 deg/sqrt(h) is 2.909e-4 rad/s/sqrt(Hz). An in-run bias is modelled as a Gauss-Markov process. If a source
//! does not state its time constant, 300 s is assumed.

use tatu_plugin_api::safe::Preset;

pub(crate) const ALL: &[Preset] = &[
    Preset {
        id: "mpu_6050",
        text: "InvenSense MPU-6050: gyroscope 0.005 deg/s/sqrt(Hz) and a measured bias instability of 0.0012 deg/s, as \
               quoted on robotics.stackexchange.com 8860; ranges 250 deg/s and 2 g; the accelerometer's 0.4 mg/sqrt(Hz) \
               is an estimate.",
        settings: "noise.angular_velocity = { density = 8.727e-5, walk = { sigma = 2.094e-5, tau_s = 300.0 }, clamp = [-4.363, 4.363] }
noise.acceleration = { density = 3.92e-3, clamp = [-19.61, 19.61] }
",
    },
    Preset {
        id: "adis16448",
        text: "Analog Devices ADIS16448: 0.0135 deg/s/sqrt(Hz) and 0.23 mg/sqrt(Hz) (data sheet as quoted in kalibr's \
               issue 63).",
        settings: "noise.angular_velocity = { density = 2.356e-4 }
noise.acceleration = { density = 2.256e-3 }
",
    },
    Preset {
        id: "euroc",
        text: "The ADIS16448 of the EuRoC data set, as OpenVINS configures it (config/euroc_mav): densities and random \
               walks of the biases; 200 Hz.",
        settings: "rate_hz = 200.0
noise.angular_velocity = { density = 1.6968e-4, random_walk = 1.9393e-5 }
noise.acceleration = { density = 2.0e-3, random_walk = 3.0e-3 }
",
    },
    Preset {
        id: "xsens_mti_1",
        text: "Xsens MTi-1: 0.007 deg/s/sqrt(Hz), 10 deg/h; 0.12 mg/sqrt(Hz), 0.03 mg (data sheet); the time constants \
               are estimates.",
        settings: "noise.angular_velocity = { density = 1.222e-4, walk = { sigma = 4.848e-5, tau_s = 300.0 } }
noise.acceleration = { density = 1.177e-3, walk = { sigma = 2.942e-4, tau_s = 300.0 } }
",
    },
    Preset {
        id: "stim300",
        text: "Sensonor STIM300: 0.15 deg/sqrt(h), 0.5 deg/h; 0.06 m/s/sqrt(h), 0.05 mg, 0.75 mg from start to start \
               (data sheet); the time constants are estimates.",
        settings: "noise.angular_velocity = { density = 4.363e-5, walk = { sigma = 2.424e-6, tau_s = 300.0 } }
noise.acceleration = { density = 1.0e-3, walk = { sigma = 4.903e-4, tau_s = 300.0 }, shift_sigma = 7.355e-3 }
",
    },
    Preset {
        id: "turtlebot3",
        text: "The IMU of TurtleBot3 in Gazebo: 2e-4 rad/s and 0.017 m/s^2 per sample at 200 Hz (turtlebot3_simulations).",
        settings: "rate_hz = 200.0
noise.angular_velocity = { sigma = 2.0e-4 }
noise.acceleration = { sigma = 1.7e-2 }
",
    },
];
