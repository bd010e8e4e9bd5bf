//! All numbers of the robot, with their sources.
//!
//! Sources: **V** V-REP's library model as measured in `v30200_Pioneer-Sonar` (the same in 13 files of 9 releases),
//! **AR** AriaCoda `params/*.p` (the manufacturer's software), **WD** Webots' guide, **AM** amr-ros-config's URDF,
//! **PM3** Pioneer 3 Operations Manual, **estimate**: chosen here, with the reason. Lengths in m, masses in kg,
//! inertias in kg m^2. Heights are above the floor, x is relative to the base frame's origin.

use tatu_plugin_api::safe::{Fail, Result};

use crate::sonar_poses::{self, Pose};

/// Values of the parameter `preset`.
pub const NAMES: &[&str] = &["as V-REP", "as the data sheet"];

/// Mass properties of a moving part.
pub struct Mass {
    pub mass: f64,
    /// Principal moments about the centre of mass, along the part's axes.
    pub inertia: [f64; 3],
    /// Centre of mass in the part's frame.
    pub com: [f64; 3],
}

/// A wheel, which turns about its own z axis.
pub struct Wheel {
    pub diameter: f64,
    pub width: f64,
    pub mass: Mass,
}

/// The caster: a link that swivels about a vertical axis, and a wheel that trails behind it.
pub struct Caster {
    pub x: f64,
    pub z: f64,
    /// Distance of the wheel behind the swivel.
    pub trail: f64,
    pub link: Mass,
    pub wheel: Wheel,
}

/// A convex outline, seen from above, that is rounded towards its ends.
pub struct Outline {
    pub front: f64,
    pub back: f64,
    pub half_width: f64,
}

/// The whole robot.
pub struct Robot {
    /// Height of the base frame's origin.
    pub height: f64,
    /// Position of the axle ahead of the base frame's origin.
    pub axle_x: f64,
    pub track: f64,
    pub body: Mass,
    pub wheel: Wheel,
    /// Greatest torque of a motor, N m.
    pub max_force: f64,
    pub caster: Caster,
    /// Lower body, up to the sonar ring.
    pub shell: Outline,
    pub shell_z: [f64; 2],
    pub deck: Outline,
    pub deck_z: [f64; 2],
    pub sonars: [Pose; 16],
    pub sonar_z: f64,
    /// Range of the sonars, unless a scene sets a different one.
    pub sonar_range: f64,
    /// Radius of a cone's tip, within which nothing is detected. In V-REP's model the range begins at this radius, so
    /// its far end is 5 mm farther. Here nothing is detected beyond the range itself, as in the readings that V-REP
    /// prints.
    pub sonar_tip: f64,
}

/// Returns the robot of a preset.
pub fn named(name: &str) -> Result<Robot> {
    match name {
        "as V-REP" => Ok(as_vrep()),
        "as the data sheet" => Ok(as_data_sheet()),
        other => Err(Fail::argument(format!("preset `{other}`: expected `as V-REP` or `as the data sheet`"))),
    }
}

fn as_vrep() -> Robot {
    let at_origin = |mass, inertia| Mass { mass, inertia, com: [0.0; 3] };
    Robot {
        height: 0.1388,                                 // V: 0.138793
        axle_x: 0.0445,                                 // V: 0.04451
        track: 0.331,                                   // V: 0.1655 to each side
        body: at_origin(16.0, [1.92, 1.93907, 2.0906]), // V: 3.5 to 7 times a solid box
        wheel: Wheel {
            diameter: 0.195,                          // V
            width: 0.05,                              // V
            mass: at_origin(1.5, [0.03, 0.03, 0.06]), // V: 8 times a solid disc
        },
        max_force: 3.0, // V
        caster: Caster {
            x: -0.149,                                      // V: -0.149027
            z: 0.061,                                       // V: 0.060951
            trail: 0.0222, // V: 0.0212 and 0.0064 across, the link being turned by 17 degrees
            link: at_origin(1.0, [0.016, 0.016, 0.019984]), // V
            wheel: Wheel {
                diameter: 0.0592, // V: 0.059198
                width: 0.0052,    // V: 0.00518; the visible one 0.0207
                // V: 0.0070088 about its axis, which is impossible: a body's moment is at most the sum of the other
                // two.
                mass: at_origin(0.25, [0.0010192, 0.0010192, 0.002]),
            },
        },
        // The file's whole body is 0.519 x 0.415 x 0.196 with its top at 0.237. Its division is an estimate from
        // photographs: the shell between the wheels (whose inner faces are 0.281 apart), the ring, and the deck over
        // everything.
        shell: Outline { front: 0.222, back: 0.222, half_width: 0.1365 },
        shell_z: [0.06, 0.187],
        deck: Outline {
            front: 0.2595,      // V
            back: 0.2595,       // V
            half_width: 0.2075, // V
        },
        deck_z: [0.2293, 0.237], // top V; thickness so that no cone touches it
        sonars: sonar_poses::AS_VREP,
        sonar_z: 0.1388 + 0.0681, // V
        sonar_range: 1.0,         // V
        sonar_tip: 0.005,         // V
    }
}

fn as_data_sheet() -> Robot {
    let axle_x = 0.0445; // the base frame stays where V-REP's model has it, so that scripts and mounts fit both
    let wheel = |diameter, width, mass| Wheel {
        diameter,
        width,
        mass: Mass { mass, inertia: disc(mass, diameter / 2.0, width), com: [0.0; 3] },
    };
    Robot {
        height: 0.1388, // as V-REP, for the same reason
        axle_x,
        // Geometry, V. AR's rotation factor 0.0056 implies 357 mm = 2 / 0.0056: an *effective* track, which includes
        // the slip of two soft tyres. It belongs in odometry, not in physics, where slip is simulated.
        track: 0.331,
        body: Mass {
            mass: 7.4,                                  // WD: 9 in all, less the parts below
            inertia: block(7.4, [0.444, 0.273, 0.169]), // estimate: an even block of the size below
            com: [axle_x - 0.04, 0.0, -0.02],           // estimate: the batteries lie low, behind the axle
        },
        wheel: wheel(0.195, 0.05, 0.6), // diameter PM3; width V; mass estimate: plastic rim, foam-filled tyre
        max_force: 3.0,                 // V; no data sheet has it
        caster: Caster {
            x: axle_x - 0.185, // AM
            z: 0.055,          // AM
            trail: 0.0222,     // estimate: as V-REP
            link: Mass {
                mass: 0.3,                                  // estimate: a bent steel fork
                inertia: block(0.3, [0.051, 0.036, 0.044]), // its size V
                com: [0.0; 3],
            },
            wheel: wheel(0.075, 0.0207, 0.1), // diameter AM; width V; mass estimate
        },
        shell: Outline {
            front: 0.222,       // estimate, as V-REP
            back: 0.222,        // estimate, as V-REP
            half_width: 0.1365, // estimate, as V-REP
        },
        shell_z: [0.06, 0.187], // estimate, as V-REP
        deck: Outline {
            front: axle_x + 0.210, // AR, with bumpers
            back: -axle_x + 0.301, // AR, with bumpers: 0.511 long
            half_width: 0.1905,    // WD: 0.381 wide, the outer faces of the wheels (AR with bumpers: 0.425)
        },
        // Estimate, as V-REP: with WD's height of 0.217 there is no room for sonars at 0.208.
        deck_z: [0.2293, 0.237],
        sonars: sonar_poses::aria(axle_x), // AR
        sonar_z: 0.208,                    // AM
        sonar_range: 5.0,                  // Stage `pioneer.inc`, Webots; PM3: the firmware stops at 4.335
        sonar_tip: 0.0,                    // no data sheet has it
    }
}

/// Returns the inertia of a uniform block with these edges.
fn block(mass: f64, [x, y, z]: [f64; 3]) -> [f64; 3] {
    [y * y + z * z, x * x + z * z, x * x + y * y].map(|sum| mass * sum / 12.0)
}

/// Returns the inertia of a uniform disc perpendicular to z.
fn disc(mass: f64, radius: f64, width: f64) -> [f64; 3] {
    let across = mass * (3.0 * radius * radius + width * width) / 12.0;
    [across, across, mass * radius * radius / 2.0]
}
