//! Callbacks of a sensor's scripts after a measurement: `sysCall_vision` and `sysCall_trigger`.

use super::{
    handle::{call_in_scripts, call_scripts, current_result},
    sensors::is_vision_sensor,
    view::VisionView,
};
use crate::kit::*;

pub(crate) fn offer(offer: &mut Offer<Vrep>) {
    offer.command(
        Cmd::new("sim.handleSensorCallbacks", |c| {
            let o = existing_object(c, 0)?;
            if is_vision_sensor(c, o.id) {
                let view = VisionView::of_object(c, o)?;
                if view.sequence == 0 {
                    // The sensor has no reading that scripts can see yet.
                    return Ok(());
                }
                current_result(c, &view)?;
                call_scripts(c, &view).map(|_| ())
            } else {
                detected(c, o.id)
            }
        })
        .param(object("sensor"))
        .text(
            "Calls sysCall_vision and sysCall_trigger of a sensor's scripts for its last measurement. An addition of \
             Tatu, called automatically after each measurement in the sensing stage, and by sim.handleVisionSensor.",
        ),
    );
}

/// Calls the scripts of a proximity sensor if it has detected something.
pub(crate) fn detected(c: &Ctx<'_>, sensor: tatu_object) -> Result {
    let (w, p) = (c.world(), &c.plugin().p);
    if w.reading(sensor, p.detected)?.i32s().first() != Some(&1) {
        return Ok(());
    }
    let three = |prop| w.reading(sensor, prop).map(|r| Value::Floats(r.f64s().to_vec()));
    let seen = w.reading(sensor, p.seen_object)?.objects().first().map_or(-1, |o| handle(*o));
    let data = Value::Map(
        [
            ("handle", Value::Int(handle(sensor))),
            ("detectedObjectHandle", Value::Int(seen)),
            ("detectedPoint", three(p.point)?),
            ("normalVector", three(p.normal)?),
        ]
        .map(|(k, v)| (Value::text(k), v))
        .into(),
    );
    call_in_scripts(c, sensor, "sysCall_trigger", &data).map(|_| ())
}
