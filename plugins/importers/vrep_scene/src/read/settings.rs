//! Settings of the whole scene: the sections `SIM`, `DYN`, `ENV` and `SET`.

use super::{
    cursor::{Cursor, ReadResult},
    material::EngineBlock,
    section::{object, tags},
    unknown::UnknownElements,
};

/// Simulation settings of a scene. Models have no settings.
#[derive(Debug, Clone, Default)]
pub struct SceneSettings {
    /// Whether the file contains any of these sections.
    pub is_present: bool,
    steps: StepSettings,
    /// Whether a run is paced in real time.
    pub real_time: bool,
    /// Whether a run pauses at the first error of a script.
    pub pause_at_error: bool,
    /// 0 Bullet, 1 ODE, 2 Vortex, 3 Newton, 4 MuJoCo, 5 Drake.
    pub engine: Option<i32>,
    /// Version of Bullet: 0, 278 or 283.
    pub engine_version: i32,
    /// Gravitational acceleration in the world frame, m/s^2.
    pub gravity: Option<[f64; 3]>,
    /// Parameters of Bullet; the first one is the physics step.
    pub bullet: EngineBlock,
    /// Parameters of ODE; the first one is the physics step.
    pub ode: EngineBlock,
    /// Parameters of Vortex, Newton and MuJoCo.
    pub others: [EngineBlock; 3],
    /// Whether the physics engine is disabled.
    pub dynamics_off: bool,
    /// Visible layers, one bit per layer.
    pub layers: Option<u16>,
    /// Acknowledgement of the scene's author.
    pub acknowledgement: String,
    /// Names of the disabled stages of a step; only in old files.
    pub disabled_stages: Vec<&'static str>,
}

/// Lengths of steps, in the forms of all versions.
#[derive(Debug, Clone, Default)]
pub struct StepSettings {
    step: [Option<f64>; 3],
    step_index: Option<i32>,
    step_micros: Option<u64>,
    physics_step: Option<f64>,
}

/// Step lengths to which old files refer by index, s.
const STEP_LENGTHS_S: [f64; 5] = [0.2, 0.1, 0.05, 0.025, 0.01];

impl SceneSettings {
    /// Returns the length of a step, s.
    pub fn step(&self) -> Option<f64> {
        let [newest, seconds, oldest] = self.steps.step;
        let by_number = || match self.steps.step_index? {
            5 => self.steps.step_micros.map(|us| us as f64 * 1e-6).or(oldest),
            n => usize::try_from(n).ok().and_then(|n| STEP_LENGTHS_S.get(n).copied()),
        };
        newest.or(seconds).or_else(by_number).filter(|s| s.is_finite() && *s > 0.0)
    }

    /// Returns the length of a physics step, s.
    pub fn physics_step(&self) -> f64 {
        let block = match self.engine {
            Some(1) => &self.ode,
            Some(n @ 2..=4) => &self.others[n as usize - 2],
            _ => &self.bullet,
        };
        let told = self.steps.physics_step.or_else(|| block.real(0));
        told.filter(|s| s.is_finite() && *s > 0.0).unwrap_or(0.005)
    }
}

/// Reads the section `SIM`: step length and pace of runs.
pub fn simulation(s: &mut SceneSettings, c: &mut Cursor<'_>, unknown: &mut UnknownElements) -> ReadResult {
    let tags = tags!(SceneSettings {
        "" | "_t3" => |s, c, _| Ok(s.steps.step[0] = Some(c.real()?)),
        "St3" => |s, c, _| Ok(s.steps.step[1] = Some(short(c.single()?))),
        "Sts" => |s, c, _| Ok(s.steps.step[2] = Some(short(c.single()?))),
        "St2" => |s, c, _| Ok(s.steps.step_micros = Some(c.u64()?)),
        "Spi" => |s, c, _| Ok(s.steps.step_index = Some(c.i32()?)),
        "Ss2" => |s, c, _| {
            let bits = c.u8()?;
            Ok((s.real_time, s.pause_at_error) = (bits & 1 != 0, bits & 8 != 0))
        },
    });
    s.is_present = true;
    const IGNORED: &[&str] = &["Spr", "Rt2", "Rtc", "_a3", "Pa3", "Pa2", "Pat", "Cv2", "Ssi", "_t2", "Rts"];
    object(c, tags, IGNORED, s, unknown).map(drop)
}

/// Converts a number stored in 4 bytes to the value of its shortest decimal form: 0.05, not 0.05000000074505806. Newer
/// files store such numbers in 8 bytes.
fn short(x: f64) -> f64 {
    if f64::from(x as f32) == x { (x as f32).to_string().parse().unwrap_or(x) } else { x }
}

fn engine(s: &mut SceneSettings, c: &mut Cursor<'_>) -> ReadResult {
    s.engine = Some(c.i32()?);
    s.gravity = Some(c.reals()?.map(short));
    Ok(())
}

/// Reads the section `DYN`: parameters of physics engines.
pub fn dynamics(s: &mut SceneSettings, c: &mut Cursor<'_>, unknown: &mut UnknownElements) -> ReadResult {
    let tags = tags!(SceneSettings {
        "Eng" => |s, c, _| engine(s, c),
        "En2" => |s, c, _| engine(s, c),
        "En3" | "_n3" => |s, c, _| engine(s, c),
        "Ver" => |s, c, _| Ok(s.engine_version = c.i32()?),
        "Stp" | "_tp" => |s, c, _| {
            Ok(s.steps.physics_step = Some(short(c.real()?)))
        },
        "Bul" => |s, c, _| Ok(s.bullet.reals = vec![short(c.single()?), c.single()?]),
        "Ode" => |s, c, _| Ok(s.ode.reals = vec![short(c.single()?), c.single()?]),
        "BuN" | "_uN" => |s, c, _| Ok(s.bullet = block(c)?),
        "OdN" | "_dN" => |s, c, _| Ok(s.ode = block(c)?),
        "Vo5" | "_o5" => |s, c, _| Ok(s.others[0] = block(c)?),
        "Nw1" | "_w1" => |s, c, _| Ok(s.others[1] = block(c)?),
        "Mj1" | "_j1" => |s, c, _| Ok(s.others[2] = block(c)?),
        "Var" => |s, c, _| Ok(s.dynamics_off = c.u8()? & 1 == 0),
    });
    s.is_present = true;
    object(c, tags, &["Vo1", "Vo2", "Vo3", "Vo4", "_o4", "Vor", "Nwt", "Cv2", "Dcs", "Mj2", "_j2"], s, unknown)
        .map(drop)
}

fn block(c: &mut Cursor<'_>) -> ReadResult<EngineBlock> {
    let mut block = EngineBlock::read(c)?;
    if let Some(step) = block.reals.first_mut() {
        *step = short(*step);
    }
    Ok(block)
}

/// Reads the section `ENV`: visible layers and acknowledgement.
pub fn environment(s: &mut SceneSettings, c: &mut Cursor<'_>, unknown: &mut UnknownElements) -> ReadResult {
    let tags = tags!(SceneSettings {
        "Vil" => |s, c, _| Ok(s.layers = Some(c.u16()?)),
        "Ack" => |s, c, _| Ok(s.acknowledgement = c.text()?),
    });
    s.is_present = true;
    const IGNORED: &[&str] = &[
        "Clc", "Cld", "Al2", "Alc", "Fbg", "Fd2", "_d2", "Fdn", "_dn", "Var", "Ups", "Uis", "Mt2", "_t2", "Mrs", "_rs",
        "Evc", "Wtc", "Rst", "Job", "Sh2", "Va2", "Va3", "Pof", "Cv2", "Fdt", "Fod",
    ];
    object(c, tags, IGNORED, s, unknown).map(drop)
}

/// Reads the section `SET`: the stages of a step that are disabled.
pub fn main(s: &mut SceneSettings, c: &mut Cursor<'_>, unknown: &mut UnknownElements) -> ReadResult {
    fn note(s: &mut SceneSettings, off: bool, what: &'static str) {
        s.disabled_stages.retain(|w| *w != what);
        if off {
            s.disabled_stages.push(what);
        }
    }
    let tags = tags!(SceneSettings {
        "Va5" => |s, c, _| Ok(note(s, c.u8()? & 1 == 0, "proximity sensors")),
        "Va2" => |s, c, _| Ok(note(s, c.u8()? & 8 == 0, "inverse kinematics")),
        "Va3" => |s, c, _| {
            let bits = c.u8()?;
            note(s, bits & 2 == 0, "collision detection");
            note(s, bits & 4 == 0, "distance calculation");
            note(s, bits & 8 != 0, "joint motion");
            note(s, bits & 16 != 0, "path motion");
            note(s, bits & 32 != 0, "vision sensors");
            Ok(note(s, bits & 64 != 0, "mills"))
        },
    });
    s.is_present = true;
    const IGNORED: &[&str] = &[
        "Al2", "Ss2", "Ddi", "Va4", "Dis", "Dcs", "Gvy", "Od2", "Deu", "Bcm", "Crc", "Iwc", "Cv2", "Var", "Alv", "Fbg",
        "Rst",
    ];
    object(c, tags, IGNORED, s, unknown).map(drop)
}
