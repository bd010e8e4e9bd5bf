//! The sensor kind "proximity".

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use tatu_plugin_api::{
    abi::{TATU_IN_DISTANCE, TATU_IN_NORMAL, TATU_IN_OBJECT, TATU_IN_POINT, tatu_object},
    safe::{Beams, Fail, Field, Form, Host, Instance, Param, Params, Readout, Result, Sample, Sensor},
};

use crate::Proximities;

/// The parameters of one sensor, checked.
#[derive(Debug, Clone, PartialEq)]
pub struct Proximity {
    beams: Beams,
    min_range: f64,
}

/// What scenes write, before it is checked.
#[derive(Debug, Clone)]
struct Settings {
    volume: String,
    range: f64,
    near: f64,
    min_range: f64,
    angle: f64,
    max_incidence: f64,
    front_faces: bool,
    back_faces: bool,
    skip_own_model: bool,
}

impl Settings {
    fn read(p: &Params<'_>) -> Result<Self> {
        Ok(Settings {
            volume: p.string("volume")?,
            range: p.f64("range")?,
            near: p.f64("near")?,
            min_range: p.f64("min_range")?,
            angle: p.f64("angle")?,
            max_incidence: p.f64("max_incidence")?,
            front_faces: p.bool("front_faces")?,
            back_faces: p.bool("back_faces")?,
            skip_own_model: p.bool("skip_own_model")?,
        })
    }

    fn check(self) -> Result<Proximity> {
        let refuse = |text: String| Err(Fail::argument(text));
        let numbers = [self.range, self.near, self.min_range, self.angle, self.max_incidence];
        if numbers.iter().any(|x| !x.is_finite()) {
            return refuse("a proximity sensor's parameters must be finite numbers".into());
        }
        if self.near < 0.0 || self.range <= self.near {
            return refuse(format!(
                "`range` ({} m) must be greater than `near` ({} m), which must not be negative",
                self.range, self.near
            ));
        }
        if self.min_range < 0.0 {
            return refuse(format!("`min_range` ({} m) is negative", self.min_range));
        }
        if self.max_incidence <= 0.0 {
            return refuse("`max_incidence` must be greater than 0; a quarter turn is no limit".into());
        }
        if !self.front_faces && !self.back_faces {
            return refuse("with neither `front_faces` nor `back_faces` the sensor sees nothing".into());
        }
        let form = match self.volume.as_str() {
            "ray" => Form::Rays(vec![[0.0, 0.0, 1.0]]),
            "cone" if self.angle > 0.0 && self.angle <= TAU + 1e-9 => {
                Form::Cone { half_angle: (self.angle / 2.0).min(PI) }
            }
            "cone" => {
                return refuse(format!(
                    "`angle` is {} rad; a cone opens by more than 0 and at most a full turn",
                    self.angle
                ));
            }
            other => return refuse(format!("`volume` is `{other}`; it may be `ray` or `cone`")),
        };
        Ok(Proximity {
            beams: Beams {
                form,
                near: self.near,
                far: self.range,
                max_incidence: self.max_incidence.min(FRAC_PI_2),
                skip_own_model: self.skip_own_model,
                faces: (self.front_faces, self.back_faces),
                ..Beams::default()
            },
            min_range: self.min_range,
        })
    }
}

/// The nearest surface point that the beam met.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Echo {
    distance: f64,
    point: [f64; 3],
    normal: [f64; 3],
    object: tatu_object,
}

/// What is reported of it: nothing at all when the *nearest* point is nearer than `min_range`, as in V-REP, where
/// a thing too near hides the things behind it.
fn reported(echo: Option<Echo>, min_range: f64) -> Option<Echo> {
    echo.filter(|e| e.distance.is_finite() && e.distance >= min_range)
}

fn echo(sample: &Sample<'_>) -> Option<Echo> {
    Some(Echo {
        distance: *sample.distances().first()?,
        point: *sample.points().first()?,
        normal: *sample.normals().first()?,
        object: *sample.objects().first()?,
    })
}

impl Sensor for Proximity {
    type Plugin = Proximities;
    const ID: &'static str = "proximity";
    const TEXT: &'static str = "Finds the nearest surface along a ray or in a cone, as V-REP's proximity sensors do.";
    const SCHEMAS: &'static [&'static str] = &["proximity/1"];
    const INPUTS: u32 = TATU_IN_DISTANCE | TATU_IN_POINT | TATU_IN_NORMAL | TATU_IN_OBJECT;

    fn params() -> Vec<Param> {
        [
            Param::string("volume")
                .choices(&["ray", "cone"])
                .default("ray")
                .text("Where it looks: along its +z axis, or in a cone around it with a round far end."),
            Param::float("range")
                .unit("m")
                .range(0.0, f64::INFINITY)
                .default(1.0)
                .text("Distance from the sensor's origin to the far end of the beam."),
            Param::float("near")
                .unit("m")
                .range(0.0, f64::INFINITY)
                .default(0.0)
                .text("Blind zone: surfaces nearer to the origin are looked through."),
            Param::float("min_range").unit("m").range(0.0, f64::INFINITY).default(0.0).text(
                "Threshold: when the nearest surface is nearer than this, nothing at all is reported \
                     (unlike `near`, which looks through it).",
            ),
            Param::float("angle")
                .unit("rad")
                .range(0.0, TAU)
                .default(PI / 6.0)
                .text("Full opening angle of the cone, up to a full turn; a ray has none."),
            Param::float("max_incidence").unit("rad").range(0.0, FRAC_PI_2).default(FRAC_PI_2).text(
                "Greatest angle between line of sight and surface normal; slanted surfaces send no echo. \
                     A quarter turn is no limit.",
            ),
            Param::bool("front_faces").default(true).text("Whether the outer sides of things are seen."),
            Param::bool("back_faces")
                .default(true)
                .text("Whether the inner sides of things are seen, as from within a box."),
            Param::bool("skip_own_model")
                .default(false)
                .text("Whether objects of the sensor's own model are looked through."),
        ]
        .map(Param::rebuilds)
        .into()
    }

    fn fields() -> Vec<Field> {
        vec![
            Field::i32("proximity.detected").text("1: something is seen; 0: nothing."),
            Field::f64("proximity.distance")
                .unit("m")
                .text("From the sensor's origin to the nearest point; 0: nothing is seen."),
            Field::f64("proximity.point")
                .dims([3, 1, 1])
                .unit("m")
                .text("That point in the sensor's frame; 0 0 0: nothing is seen."),
            Field::object("proximity.object").text("The object seen; 0: nothing is seen."),
            Field::f64("proximity.normal")
                .dims([3, 1, 1])
                .unit("1")
                .text("Unit normal there, towards the sensor, in its frame; 0 0 0: nothing is seen."),
        ]
    }

    fn create(_: &Host, _: Instance, params: &Params<'_>) -> Result<Self> {
        Settings::read(params)?.check()
    }

    fn beams(&self) -> Result<Beams> {
        Ok(self.beams.clone())
    }

    fn measure(&self, sample: &Sample<'_>, out: &mut Readout<'_>) -> Result {
        // The host zeroes the fields: nothing seen needs no writing.
        if let Some(echo) = reported(echo(sample), self.min_range) {
            out.i32(0).copy_from_slice(&[1]);
            out.f64(1).copy_from_slice(&[echo.distance]);
            out.f64(2).copy_from_slice(&echo.point);
            out.object(3).copy_from_slice(&[echo.object]);
            out.f64(4).copy_from_slice(&echo.normal);
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests;
