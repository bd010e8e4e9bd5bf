//! Joints: the specific part of objects in section `JNT`.

use super::{
    material::EngineBlock,
    section::{ElementTag, tags},
};

/// Kind of a joint that rotates about its axis.
pub const REVOLUTE: i32 = 10;
/// Kind of a joint that slides along its axis.
pub const PRISMATIC: i32 = 11;
/// Kind of a joint that rotates about all axes.
pub const SPHERICAL: i32 = 12;

/// A joint; positions are in rad or m.
#[derive(Debug, Clone)]
pub struct Joint {
    /// Kind of the joint: [`REVOLUTE`], [`PRISMATIC`] or [`SPHERICAL`].
    pub kind: i32,
    /// Position when the file was saved, rad or m.
    pub position: f64,
    /// Minimum position, and the range above it.
    pub limits: [f64; 2],
    /// Whether the joint rotates without limits.
    pub cyclic: bool,
    /// The motor, with its targets and gains.
    pub drive: JointDrive,
    /// Whether limits are enforced even if the joint is not dynamic.
    pub enforced: bool,
    /// Pitch of a screw, m/rad.
    pub pitch: f64,
    /// Rotation of a spherical joint, as a quaternion w x y z.
    pub rotation: [f64; 4],
    /// 0 kinematic, 1 motion, 2 inverse kinematics, 3 and 4 dependent, 5 dynamic.
    pub mode: i32,
    /// Handle of the joint on which this joint depends, and factor and offset of the dependency.
    pub master: (i32, [f64; 2]),
    /// Maximum velocity of position control; before 4.4.
    pub old_max_velocity: Option<f64>,
    /// Maximum velocity, acceleration and jerk; since 4.3.
    pub max_motion: Option<[f64; 3]>,
    /// 0 free, 1 force, 4 velocity, 8 and 9 position, 12 and 13 spring, 16 callback; since 4.3.
    pub control: Option<i32>,
    /// The parameters of the joint for each physics engine.
    pub engines: JointEngines,
}

/// The motor of a joint, with its targets and gains.
#[derive(Debug, Clone)]
pub struct JointDrive {
    /// Flags of the motor. Bit 4: on; bit 5: position control; bit 6: hybrid; bit 7: spring.
    pub motor: u8,
    /// Whether the motor is locked at a target velocity of zero.
    pub locked: bool,
    /// Target velocity, rad/s or m/s.
    pub target_velocity: f64,
    /// Maximum torque or force, N m or N; not negative.
    pub max_force: f64,
    /// Target position, rad or m.
    pub target_position: f64,
    /// Gains of position control: P, I, D.
    pub pid: [f64; 3],
    /// Stiffness and damping of the spring, N m/rad and N m s/rad, or N/m and N s/m.
    pub spring: [f64; 2],
}

/// Parameters of a joint for each engine.
#[derive(Debug, Clone)]
pub struct JointEngines {
    /// Parameters of the Bullet engine.
    pub bullet: EngineBlock,
    /// Parameters of the ODE engine.
    pub ode: EngineBlock,
    /// Parameters of the MuJoCo engine.
    pub mujoco: EngineBlock,
}

impl Default for Joint {
    fn default() -> Self {
        Joint {
            kind: REVOLUTE,
            position: 0.0,
            limits: [0.0; 2],
            cyclic: false,
            drive: JointDrive {
                motor: 0,
                locked: false,
                target_velocity: 0.0,
                max_force: 0.0,
                target_position: 0.0,
                pid: [0.1, 0.0, 0.0],
                spring: [0.0; 2],
            },
            enforced: false,
            pitch: 0.0,
            rotation: [1.0, 0.0, 0.0, 0.0],
            mode: 0,
            master: (-1, [1.0, 0.0]),
            old_max_velocity: None,
            max_motion: None,
            control: None,
            engines: JointEngines {
                bullet: EngineBlock::default(),
                ode: EngineBlock::default(),
                mujoco: EngineBlock::default(),
            },
        }
    }
}

/// Tags of the elements in the part that is specific to joints.
pub const TAGS: &[ElementTag<Joint>] = tags!(Joint {
    "Jtt" => |j, c, _| Ok(j.kind = c.i32()?),
    "Prt" | "_rt" => |j, c, _| Ok(j.position = c.real()?),
    "Pmr" | "_mr" => |j, c, _| Ok(j.limits = c.reals()?),
    "Va9" => |j, c, _| {
        j.drive.motor = c.u8()?;
        Ok(j.cyclic = j.drive.motor & 1 != 0)
    },
    "Vaa" => |j, c, _| {
        let bits = c.u8()?;
        Ok((j.drive.locked, j.enforced) = (bits & 2 != 0, bits & 4 != 0))
    },
    "Jsp" | "_sp" => |j, c, _| Ok(j.pitch = c.real()?),
    "" | "Sld" => |j, c, _| Ok(j.pitch = c.real()? / std::f64::consts::TAU),
    "Jst" | "_st" => |j, c, _| Ok(j.rotation = c.reals()?),
    "Jmd" => |j, c, _| Ok(j.mode = c.i32()?),
    "Jdt" | "_dt" => |j, c, _| Ok(j.master = (c.i32()?, c.reals()?)),
    "Dmp" | "_mp" => |j, c, _| {
        let [velocity, force] = c.reals()?;
        Ok((j.drive.target_velocity, j.drive.max_force) = (velocity, force.abs()))
    },
    "Dtp" | "_tp" => |j, c, _| Ok(j.drive.target_position = c.real()?),
    "Dpc" => |j, c, _| Ok(j.drive.pid = c.reals()?),
    "Dp2" => |j, c, _| Ok(j.drive.pid = c.reals()?),
    "Spp" | "_pp" => |j, c, _| Ok(j.drive.spring = c.reals()?),
    "Ulv" => |j, c, _| Ok(j.old_max_velocity = Some(c.real()?)),
    "Ruc" | "_uc" => |j, c, _| Ok(j.max_motion = Some(c.reals()?)),
    "Dcm" => |j, c, _| Ok(j.control = Some(c.i32()?)),
    "BtN" | "_tN" => |j, c, _| Ok(j.engines.bullet = EngineBlock::read(c)?),
    "OdN" | "_dN" => |j, c, _| Ok(j.engines.ode = EngineBlock::read(c)?),
    "Mj3" | "_j3" => |j, c, _| Ok(j.engines.mujoco = EngineBlock::read(c)?),
});

/// Known elements that are not used: user interface, older engines, and engines that are not supported.
pub const IGNORED: &[&str] = &[
    "Dpm", "Dvm", "V10", "Vo2", "_o2", "Vor", "Nw1", "_w1", "Mj1", "Mj2", "Od1", "Bt1", "Arg", "_rg", "Cl1", "Cl2",
    "Mss", "_ss", "Ikw", "_kw", "Jm2", "Jm3", "_m3", "Cco", "Cv2",
];
