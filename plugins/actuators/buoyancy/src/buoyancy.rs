//! The actuator kind "buoyancy".

use tatu_plugin_api::{
    abi::{TATU_KIND_SHAPE, TATU_LOG_WARNING},
    fields,
    safe::{Actuator, Drive, Fail, Field, Instance, Output, Param, Params, Result, SharedWorld},
};

use crate::hull::{Hull, SubmergedPart};

/// The buoyancy plugin. It has no state.
pub struct BuoyancyPlugin;

/// A hull in water, which exerts buoyancy and drag on the shape that the actuator is mounted on.
#[derive(Debug, Clone, PartialEq)]
pub struct Buoyancy {
    hull: Hull,
    /// Specific weight of the water, N/m^3.
    weight: f64,
    /// Height of the water surface in the world, m.
    surface: f64,
    /// Velocity of the water, world frame, m/s.
    current: [f64; 3],
    /// Linear drag of the fully submerged hull, along and about each axis of the mount, N s/m and N m s.
    linear: [f64; 6],
    /// Quadratic drag of the fully submerged hull, along and about each axis of the mount, N s^2/m^2 and N m s^2.
    quadratic: [f64; 6],
    /// Inertia of the body: its mass for each axis, kg, then its moments of inertia, kg m^2. The inertia limits the
    /// effect of drag in a step.
    inertia: [f64; 6],
}

fields! {
    Report {
        SUBMERGED: f64 = Field::new("buoyancy.submerged").unit("1").text("Fraction of the volume that is under water.");
        FORCE: f64 = Field::new("buoyancy.force").unit("N").text("Upward force of the water, without drag.");
    }
}

/// The fields that the actuator reports.
struct Report;

impl Actuator for Buoyancy {
    type Plugin = BuoyancyPlugin;
    const ID: &'static str = "buoyancy";
    const TEXT: &'static str = "Buoyancy, righting torque and drag of a box hull in water with a flat surface.";
    // The buoyancy of a light body changes considerably within a step of the world.
    const EVERY_SUBSTEP: bool = true;
    const SCHEMAS: &'static [&'static str] = &["buoyancy/1"];

    fn params() -> Vec<Param> {
        let drag = |key: &str, text: &str| Param::floats(key, 6).range(0.0, 1e9).rebuilds().text(text);
        vec![
            Param::floats("size", 3)
                .unit("m")
                .range(0.0, 1e4)
                .default([1.0, 1.0, 1.0])
                .rebuilds()
                .text("Extents of the hull, a box centred on the actuator's origin, along its axes."),
            Param::float("volume")
                .range(0.0, 1e9)
                .default(0.0)
                .rebuilds()
                .text("Volume that the hull displaces when fully submerged, m^3; 0: the volume of the box."),
            Param::float("density").range(0.0, 1e5).default(1000.0).rebuilds().text("Density of the water, kg/m^3."),
            Param::float("surface")
                .unit("m")
                .range(-1e6, 1e6)
                .default(0.0)
                .rebuilds()
                .text("Height of the surface in the world."),
            Param::floats("current", 3)
                .unit("m/s")
                .range(-1e3, 1e3)
                .default([0.0, 0.0, 0.0])
                .rebuilds()
                .text("Velocity of the water, world frame."),
            drag(
                "linear_drag",
                "Drag when submerged, N per m/s along x, y, z and N m per rad/s about them, in the actuator's frame.",
            )
            .default([0.0; 6]),
            drag("quadratic_drag", "Drag per squared velocity, otherwise like `linear_drag`.").default([0.0; 6]),
        ]
    }

    fn fields() -> Vec<Field> {
        Report::declared_fields()
    }

    fn commands() -> Vec<Param> {
        Vec::new()
    }

    fn create(world: &SharedWorld<'_>, instance: Instance, params: &Params<'_>) -> Result<Self> {
        let size = params.array::<3>("size")?;
        let (given, density) = (params.f64("volume")?, params.f64("density")?);
        let [_, _, gravity] = world.f64s(0, world.host().prop("scene.gravity"))?;
        let volume = if given > 0.0 { given } else { size.iter().product() };
        let it = Buoyancy {
            hull: Hull { size, volume },
            weight: density * -gravity,
            surface: params.f64("surface")?,
            current: params.array("current")?,
            linear: params.array("linear_drag")?,
            quadratic: params.array("quadratic_drag")?,
            inertia: inertia(world, instance)?,
        };
        if size.iter().any(|s| *s <= 0.0) {
            return Err(Fail::argument("`size` must be greater than 0 along each axis"));
        }
        let numbers = [it.weight, it.surface, volume];
        let all = numbers.iter().chain(&size).chain(&it.current).chain(&it.linear).chain(&it.quadratic);
        if all.copied().all(f64::is_finite) { Ok(it) } else { Err(Fail::argument("all parameters must be finite")) }
    }

    fn apply(&self, drive: &Drive<'_>, out: &mut Output<'_>) -> Result {
        let axes = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]].map(|axis| drive.to_world(axis));
        let [_, _, height, ..] = drive.pose();
        let [vx, vy, vz, wx, wy, wz] = drive.twist();
        // Use the pose after half a step, because the force acts over the whole step; otherwise, the oscillation of a
        // floating body would grow.
        let half = drive.dt() / 2.0;
        let cross = |a: [f64; 3]| [wy * a[2] - wz * a[1], wz * a[0] - wx * a[2], wx * a[1] - wy * a[0]];
        let ahead = axes.map(|a| std::array::from_fn(|k| a[k] + half * cross(a)[k]));
        let SubmergedPart { share, centre } = self.hull.submerged(ahead, self.surface - height - half * vz);
        let lift = self.weight * self.hull.volume * share;
        let [cx, cy, cz] = self.current;
        let of_mount = |v: [f64; 3]| axes.map(|a| a[0] * v[0] + a[1] * v[1] + a[2] * v[2]);
        let ([u, v, w], [p, q, r]) = (of_mount([vx - cx, vy - cy, vz - cz]), of_mount([wx, wy, wz]));
        let twist = [u, v, w, p, q, r];
        let drag: [f64; 6] = std::array::from_fn(|i| {
            let per_velocity = share * (self.linear[i] + self.quadratic[i] * twist[i].abs());
            -per_velocity * twist[i] * mean_decay(per_velocity * drive.dt() / self.inertia[i])
        });
        let [fx, fy, fz] = drive.to_world([drag[0], drag[1], drag[2]]);
        let [tx, ty, tz] = drive.to_world([drag[3], drag[4], drag[5]]);
        out.force = [fx, fy, fz + lift];
        out.torque = [tx + centre[1] * lift, ty - centre[0] * lift, tz];
        out.report.set(Report::SUBMERGED, share);
        out.report.set(Report::FORCE, lift);
        Ok(())
    }
}

/// Returns the mass, once per axis, and the moments of inertia of the nearest shape above an actuator. Without a shape,
/// logs a warning and returns infinite values.
fn inertia(world: &SharedWorld<'_>, instance: Instance) -> Result<[f64; 6]> {
    let host = world.host();
    let [parent, mass, inertia] = ["object.parent", "shape.mass", "shape.inertia"].map(|key| host.prop(key));
    let mut mount = instance.owner;
    loop {
        mount = match world.get(mount, parent)?.as_object() {
            Some(above) if above != 0 => above,
            _ => {
                world.log(TATU_LOG_WARNING, b"buoyancy has no effect without a shape above it; parent it to a shape");
                return Ok([f64::INFINITY; 6]);
            }
        };
        if world.look(mount)?.kind == TATU_KIND_SHAPE {
            break;
        }
    }
    let m = world.f64(mount, mass)?;
    let [xx, _, _, _, yy, _, _, _, zz] = world.f64s(mount, inertia)?;
    Ok([m, m, m, xx, yy, zz].map(|x| x.max(f64::MIN_POSITIVE)))
}

/// Returns the mean of exp(-t) for t from 0 to x: the mean drag during a step as a fraction of its initial value,
/// because drag decreases as the body slows down. Without this factor, a light body would oscillate.
fn mean_decay(x: f64) -> f64 {
    if x < 1e-9 { 1.0 } else { -libm::expm1(-x) / x }
}

#[cfg(test)]
mod tests {
    use super::mean_decay;

    #[test]
    fn drag_never_reverses_the_velocity() {
        for x in [0.0, 1e-12, 1e-3, 1.0, 100.0, 1e9] {
            let slower = 1.0 - x * mean_decay(x);
            assert!((slower - libm::exp(-x)).abs() < 1e-12 && (0.0..=1.0).contains(&slower), "{x}: {slower}");
        }
    }
}
