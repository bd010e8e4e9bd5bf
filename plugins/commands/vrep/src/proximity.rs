//! Commands on proximity sensors: reading, handling, checking, resetting.

use std::f64::consts::FRAC_PI_2;

use crate::{kit::*, lookup::entities};

pub(crate) fn offer(offer: &mut Offer<Vrep>) {
    let command = |names: CommandNames, run: fn(&mut Ctx<'_>) -> Result| both(names, MINUS_ONE, run);
    let answers = |command: Cmd| {
        command
            .returns(Param::int("result").text(
                "1: detected, 0: nothing detected; for old scripts, the only value if nothing was detected, \
                    and -1 before the first measurement",
            ))
            .returns(Param::float("distance").unit("m").text("from the sensor's origin"))
            .returns(Param::floats("point", 3).unit("m").text("sensor frame"))
            .returns(Param::int("object").text("-1: none"))
            .returns(Param::floats("normal", 3).text("normal of the surface, sensor frame"))
    };
    offer.command(
        answers(both_parallel(["sim.readProximitySensor", "simReadProximitySensor"], MINUS_ONE, |c| {
            let sensor = id(c, 0)?;
            let sight = last_detection(c, sensor)?;
            return_detection(c, sight);
            Ok(())
        }))
        .param(object("sensor"))
        .text("Returns the result of a proximity sensor's last measurement.")
        .example("result, distance = sim.readProximitySensor(sonar)"),
    );
    offer.command(
        answers(command(["sim.handleProximitySensor", "simHandleProximitySensor"], handle_now))
            .param(Param::int("sensor").text("a handle, sim.handle_all or sim.handle_all_except_explicit"))
            .text("Measures a proximity sensor immediately; for several sensors, returns the nearest detection.")
            .example("result, distance = sim.handleProximitySensor(laser)"),
    );
    offer.command(
        answers(command(["sim.checkProximitySensor", "simCheckProximitySensor"], |c| {
            let sensor = id(c, 0)?;
            let sight = nearest_of(c, sensor, 1, |c, only| measure_now(c, sensor, only))?;
            return_detection(c, sight);
            Ok(())
        }))
        .param(object("sensor"))
        .param(Param::int("entity").text("an object, a collection, or sim.handle_all"))
        .text(
            "Checks whether a proximity sensor detects a given object, or any object; the result also becomes the \
             sensor's reading.",
        )
        .example("result, distance = sim.checkProximitySensor(sonar, ball)"),
    );
    offer.command(
        answers(command(["sim.checkProximitySensorEx", "simCheckProximitySensorEx"], |c| {
            let sensor = id(c, 0)?;
            let (mode, threshold, max_angle) = (c.i64(2)?, c.f64(3)?, c.f64(4)?);
            let sight = nearest_of(c, sensor, 1, |c, only| {
                let wanted = search_options(only, mode, threshold, max_angle)?;
                c.world().look_through(sensor, wanted).map_err(|e| explain_proximity_error(c, sensor, e))?;
                last_detection(c, sensor)
            })?;
            return_detection(c, sight);
            Ok(())
        }))
        .param(object("sensor"))
        .param(Param::int("entity").text("an object, a collection, or sim.handle_all"))
        .param(Param::int("mode").text(
            "a sum of: 1 front faces, 2 back faces, 4 any point suffices (the nearest is returned), 8 maxAngle \
             applies, 16 occluded points are ignored",
        ))
        .param(
            Param::float("threshold")
                .unit("m")
                .text("surfaces farther than this are not detected; 0: the sensor's own range"),
        )
        .param(Param::float("maxAngle").unit("rad").text("maximum angle between line of sight and normal, 0 to pi/2"))
        .text(
            "Checks whether a proximity sensor detects a given object, or any object, with the given faces, distance \
             and angle; the result also becomes the sensor's reading.",
        )
        .example("result, distance = sim.checkProximitySensorEx(sonar, ball, 1 + 2, 0.5, 0)"),
    );
    offer.command(
        command(["sim.resetProximitySensor", "simResetProximitySensor"], |c| {
            for sensor in sensors(c)? {
                c.world().reset_reading(sensor).map_err(|e| explain_proximity_error(c, sensor, e))?;
            }
            c.ret(1_i64);
            Ok(())
        })
        .param(Param::int("sensor").text("a handle, sim.handle_all or sim.handle_all_except_explicit"))
        .returns(Param::int("done"))
        .text("Discards the reading of a proximity sensor.")
        .example("sim.resetProximitySensor(sonar)"),
    );
}

/// Converts the arguments of `sim.checkProximitySensorEx` to search options.
fn search_options(only: tatu_object, mode: i64, threshold: f64, max_angle: f64) -> Result<tatu_look> {
    if mode & (FRONT_FACES | BACK_FACES) == 0 {
        return Err(Fail::argument(format!("argument 3: mode {mode} selects neither front (1) nor back faces (2)")));
    }
    let limited = mode & LIMITED_ANGLE != 0;
    if limited && !(max_angle > 0.0 && max_angle <= FRAC_PI_2) {
        return Err(Fail::argument(format!(
            "maxAngle is {max_angle} rad: with mode 8, expected more than 0 and at most pi/2"
        )));
    }
    let flag = |unless: bool, flag: u32| if unless { 0 } else { flag };
    Ok(tatu_look {
        size: 0,
        flags: flag(mode & FRONT_FACES != 0, TATU_BEAMS_NO_FRONT)
            | flag(mode & BACK_FACES != 0, TATU_BEAMS_NO_BACK)
            | flag(mode & OCCLUSION == 0, TATU_BEAMS_OCCLUDE),
        only,
        far_m: if threshold > 0.0 { threshold } else { f64::INFINITY },
        max_incidence: if limited { max_angle } else { FRAC_PI_2 },
    })
}

// Bits of the mode of `sim.checkProximitySensorEx`. The bit 4, which would allow a search to stop at the first point,
// is ignored: the nearest point is always found.
const FRONT_FACES: i64 = 1;
const BACK_FACES: i64 = 2;
const LIMITED_ANGLE: i64 = 8;
const OCCLUSION: i64 = 16;

/// The result of a sensor's last measurement, or `NotMeasured` before the first one.
#[derive(Debug, Clone, Copy, PartialEq)]
enum DetectionResult {
    NotMeasured,
    NotDetected,
    Detected { distance: f64, point: [f64; 3], object: i64, normal: [f64; 3] },
}

/// Distance, point, object and normal.
type DetectionDetails = (f64, [f64; 3], i64, [f64; 3]);

/// Returns the first return value for a result, and the four that follow it. If `short` is true, these four are omitted
/// unless there is a detection.
fn return_values(short: bool, sight: DetectionResult) -> (i64, Option<DetectionDetails>) {
    match sight {
        DetectionResult::Detected { distance, point, object, normal } => (1, Some((distance, point, object, normal))),
        DetectionResult::NotDetected if short => (0, None),
        DetectionResult::NotMeasured if short => (-1, None),
        _ => (0, Some((0.0, [0.0; 3], -1, [0.0; 3]))),
    }
}

fn return_detection(c: &mut SharedCtx<'_>, sight: DetectionResult) {
    let (first, rest) = return_values(old_era(c), sight);
    c.ret(first);
    if let Some((distance, point, object, normal)) = rest {
        c.ret(distance);
        c.ret(&point[..]);
        c.ret(object);
        c.ret(&normal[..]);
    }
}

/// Returns the last reading of a sensor.
fn last_detection(c: &SharedCtx<'_>, sensor: tatu_object) -> Result<DetectionResult> {
    let (w, p) = (c.world(), &c.plugin().p);
    let detected = w.reading(sensor, p.detected).map_err(|e| explain_proximity_error(c, sensor, e))?;
    if detected.sequence() == 0 {
        return Ok(DetectionResult::NotMeasured);
    }
    if detected.i32s().first() != Some(&1) {
        return Ok(DetectionResult::NotDetected);
    }
    let three = |prop| -> Result<[f64; 3]> {
        let reading = w.reading(sensor, prop)?;
        Ok(reading.f64s().first_chunk().copied().unwrap_or_default())
    };
    Ok(DetectionResult::Detected {
        distance: w.reading(sensor, p.distance)?.f64s().first().copied().unwrap_or(0.0),
        point: three(p.point)?,
        object: w.reading(sensor, p.seen_object)?.objects().first().map_or(-1, |o| handle(*o)),
        normal: three(p.normal)?,
    })
}

fn measure_now(c: &Ctx<'_>, sensor: tatu_object, only: tatu_object) -> Result<DetectionResult> {
    c.world().sense_now(sensor, only).map_err(|e| explain_proximity_error(c, sensor, e))?;
    last_detection(c, sensor)
}

/// Measures the entity in argument `i`: everything, an object, or a collection, whose shapes are measured one by one.
/// The sensor's reading is then that of the nearest shape.
fn nearest_of(
    c: &Ctx<'_>,
    sensor: tatu_object,
    i: usize,
    measure: impl Fn(&Ctx<'_>, tatu_object) -> Result<DetectionResult>,
) -> Result<DetectionResult> {
    let which = c.i64(i)?;
    if which == HANDLE_ALL {
        return measure(c, 0);
    }
    if !entities::is_collection(c, which)? {
        return measure(c, existing_object(c, i)?.id);
    }
    let mut nearest: Option<(f64, tatu_object)> = None;
    for only in entities::objects(c, which)? {
        if c.world().look(only)?.kind != TATU_KIND_SHAPE {
            continue;
        }
        if let DetectionResult::Detected { distance, .. } = measure(c, only)?
            && nearest.is_none_or(|(d, _)| distance < d)
        {
            nearest = Some((distance, only));
        }
    }
    // Nothing can be detected of the sensor itself.
    measure(c, nearest.map_or(sensor, |(_, only)| only))
}

fn handle_now(c: &mut Ctx<'_>) -> Result {
    // Fast path for a single sensor, because scripts that rotate a ray call this hundreds of times per callback.
    if c.i64(0)? > 0 {
        let sight = measure_now(c, id(c, 0)?, 0)?;
        return_detection(c, sight);
        return Ok(());
    }
    let far = |s: &DetectionResult| match s {
        DetectionResult::Detected { distance, .. } => *distance,
        _ => f64::INFINITY,
    };
    let mut nearest = DetectionResult::NotDetected;
    // If a main script handles all sensors that are not explicit, run the sensing stage, which measures them together.
    let stage = c.i64(0)? == HANDLE_ALL_EXCEPT_EXPLICIT && is_main(c)?;
    if stage {
        c.world().run_stage(TATU_STAGE_SENSE, 0.0)?;
    }
    for sensor in sensors(c)? {
        let sight = if stage { last_detection(c, sensor)? } else { measure_now(c, sensor, 0)? };
        if far(&sight) < far(&nearest) {
            nearest = sight;
        }
    }
    return_detection(c, nearest);
    Ok(())
}

/// Returns the sensors that argument 0 identifies.
fn sensors(c: &Ctx<'_>) -> Result<Vec<tatu_object>> {
    let which = c.i64(0)?;
    if !matches!(which, HANDLE_ALL | HANDLE_ALL_EXCEPT_EXPLICIT) {
        return Ok(vec![id(c, 0)?]);
    }
    let mut all = c.world().sensors("proximity/1")?;
    if which == HANDLE_ALL_EXCEPT_EXPLICIT {
        all.retain(|s| !bool_of(c, *s, c.plugin().p.sensor_explicit).unwrap_or(false));
    }
    Ok(all)
}

/// Returns the error for a sensor that could not be measured or read.
#[cold]
fn explain_proximity_error(c: &SharedCtx<'_>, sensor: tatu_object, fail: Fail) -> Fail {
    let p = &c.plugin().p;
    c.world().used_as(sensor, "proximity/1");
    match c.world().look(sensor) {
        Ok(o) if o.kind == TATU_KIND_SENSOR && c.world().reading(o.id, p.detected).is_err() => Fail::argument(format!(
            "object {} `{}` is a sensor of kind `{}`, not a proximity sensor",
            o.handle(),
            path(c, o.id),
            text_of(c, o.id, p.sensor_kind).unwrap_or_default()
        )),
        Ok(o) if o.kind == TATU_KIND_SENSOR => fail,
        _ => {
            let e = explain(c, sensor, TATU_KIND_SENSOR, fail);
            Fail::with_code(e.code(), e.text().replace(", not a sensor", ", not a proximity sensor"))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const DETECTED: DetectionResult =
        DetectionResult::Detected { distance: 0.5, point: [0.0, 0.0, 0.5], object: 7, normal: [0.0, 0.0, -1.0] };
    const EMPTY: DetectionDetails = (0.0, [0.0; 3], -1, [0.0; 3]);

    #[test]
    fn mode_bits_select_faces_and_limits() {
        let flags = |mode| search_options(0, mode, 0.0, 0.5).unwrap().flags;
        assert_eq!(flags(3), 0);
        assert_eq!(flags(1), TATU_BEAMS_NO_BACK);
        assert_eq!(flags(2 + 16), TATU_BEAMS_NO_FRONT | TATU_BEAMS_OCCLUDE);
        let (far, all) = (search_options(7, 3, 0.25, 0.5).unwrap(), search_options(7, 3 + 4 + 8, 0.0, 0.5).unwrap());
        assert_eq!((far.only, far.far_m, far.max_incidence), (7, 0.25, FRAC_PI_2));
        assert_eq!((all.far_m, all.max_incidence), (f64::INFINITY, 0.5));
        assert!(
            search_options(0, 4, 0.0, 0.5).is_err()
                && search_options(0, 3 + 8, 0.0, 0.0).is_err()
                && search_options(0, 3 + 8, 0.0, 2.0).is_err()
        );
    }

    #[test]
    fn return_values_depend_on_the_dialect() {
        assert_eq!(return_values(true, DetectionResult::NotMeasured), (-1, None));
        assert_eq!(return_values(true, DetectionResult::NotDetected), (0, None));
        assert_eq!(return_values(false, DetectionResult::NotMeasured), (0, Some(EMPTY)));
        assert_eq!(return_values(false, DetectionResult::NotDetected), (0, Some(EMPTY)));
        for form in [true, false] {
            let (first, rest) = return_values(form, DETECTED);
            assert_eq!(first, 1);
            assert_eq!(rest, Some((0.5, [0.0, 0.0, 0.5], 7, [0.0, 0.0, -1.0])));
        }
    }
}
