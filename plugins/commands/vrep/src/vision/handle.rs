//! Commands that take images with vision sensors, and return the results of filters and scripts.

use super::{
    filters,
    packets::{EMPTY_PACKET, packet},
    parameters,
    results::{VisionResult, stamp},
    sensors::{all, is_vision_sensor},
    view::{VisionView, packed},
};
use crate::{kit::*, state::state};

/// Returns the results for a sensor's current image. If the filters have not processed this image yet, runs them first.
pub(super) fn current_result(c: &Ctx<'_>, view: &VisionView) -> Result<VisionResult> {
    let stored = state(c)?.vision.seen.get(&view.id).filter(|s| s.stamp == stamp(view)).cloned();
    match stored {
        Some(seen) => Ok(seen),
        None if view.sequence == 0 => Ok(VisionResult::of(view)),
        None => {
            let seen = filters::run(c, view, VisionResult::of(view))?;
            store_result(c, view, seen.clone())?;
            Ok(seen)
        }
    }
}

/// Stores the result for a sensor's current image.
pub(super) fn store_result(c: &Ctx<'_>, view: &VisionView, seen: VisionResult) -> Result {
    state(c)?.vision.seen.insert(view.id, VisionResult { stamp: stamp(view), ..seen });
    Ok(())
}

/// Runs the filters and script callbacks of a sensor on an image that was just taken or set.
pub(super) fn process_image(c: &Ctx<'_>, view: &VisionView, seen: VisionResult) -> Result<VisionResult> {
    let seen = filters::run(c, view, seen)?;
    store_result(c, view, seen)?;
    call_scripts(c, view)
}

/// Calls the scripts of a sensor for its current image, and returns their results.
pub(super) fn call_scripts(c: &Ctx<'_>, view: &VisionView) -> Result<VisionResult> {
    let data = parameters::callback_data(c, view)?;
    for answer in call_in_scripts(c, view.id, "sysCall_vision", &data)? {
        let mut seen = current_result(c, view)?;
        seen.trigger = truth(&answer, "trigger").unwrap_or(seen.trigger);
        seen.packets.extend(packets_of(&answer));
        store_result(c, view, seen)?;
    }
    let seen = current_result(c, view)?;
    if !seen.trigger {
        return Ok(seen);
    }
    let packed = |p: &Vec<f64>| {
        let floats: Vec<f32> = p.iter().map(|x| *x as f32).collect();
        Value::Text(packed(&floats))
    };
    let packets = seen.packets.iter().map(packed).collect();
    let data = Value::Map(vec![
        (Value::text("handle"), Value::Int(handle(view.id))),
        (Value::text("packedPackets"), Value::List(packets)),
    ]);
    for answer in call_in_scripts(c, view.id, "sysCall_trigger", &data)? {
        let mut seen = current_result(c, view)?;
        seen.trigger = truth(&answer, "trigger").unwrap_or(seen.trigger);
        store_result(c, view, seen)?;
    }
    current_result(c, view)
}

/// Calls a function in all scripts of an object that define it, and returns the results.
pub(super) fn call_in_scripts(c: &Ctx<'_>, owner: tatu_object, function: &str, data: &Value) -> Result<Vec<Value>> {
    let mut out = Vec::new();
    for script in c.world().scripts(owner)? {
        match c.world().call_function(script, function, std::slice::from_ref(data)) {
            Ok(mut results) if !results.is_empty() => out.push(results.swap_remove(0)),
            Ok(_) => {}
            Err(e) if e.code() == TATU_ERR_MISSING => {}
            Err(e) => return Err(e),
        }
    }
    Ok(out)
}

fn entry<'v>(map: &'v Value, key: &str) -> Option<&'v Value> {
    let Value::Map(entries) = map else { return None };
    entries.iter().find(|(k, _)| *k == Value::text(key)).map(|(_, v)| v)
}
fn truth(map: &Value, key: &str) -> Option<bool> {
    entry(map, key).map(|v| !matches!(v, Value::Nil | Value::Bool(false)))
}
/// Reads `packedPackets`, a list of strings of 32-bit floats.
fn packets_of(map: &Value) -> Vec<Vec<f64>> {
    let floats = |bytes: &[u8]| bytes.as_chunks::<4>().0.iter().map(|b| f64::from(f32::from_le_bytes(*b))).collect();
    match entry(map, "packedPackets") {
        Some(Value::List(all)) => all
            .iter()
            .filter_map(|p| match p {
                Value::Text(b) | Value::Bytes(b) => Some(floats(b)),
                _ => None,
            })
            .collect(),
        _ => Vec::new(),
    }
}

/// Takes an image with a sensor immediately, of one object or of all objects (`only` = 0).
pub(super) fn take_image(c: &Ctx<'_>, id: tatu_object, only: tatu_object) -> Result<(VisionView, VisionResult)> {
    if is_vision_sensor(c, id) {
        c.world().sense_now(id, only)?;
    }
    let view = VisionView::of_object(c, c.world().look(id)?)?;
    let seen = if view.blind { VisionResult::of(&view) } else { process_image(c, &view, VisionResult::of(&view))? };
    Ok((view, seen))
}

/// Returns to the script whether something was detected, the standard packet, and the packets of filters and callbacks.
fn return_result(c: &mut Ctx<'_>, view: &VisionView, seen: &VisionResult) {
    c.ret(i64::from(seen.trigger));
    let first = if view.blind { EMPTY_PACKET } else { packet(&view.rgb(c), &view.depth(c)) };
    c.ret(&first[..]);
    for more in &seen.packets {
        c.ret(&more[..]);
    }
}

/// Returns the sensors that argument 0 identifies.
fn sensors_of_argument(c: &Ctx<'_>) -> Result<Vec<tatu_object>> {
    let which = c.i64(0)?;
    if !matches!(which, HANDLE_ALL | HANDLE_ALL_EXCEPT_EXPLICIT) {
        return Ok(vec![VisionView::of(c, 0)?.id]);
    }
    let mut found = all(c)?;
    if which == HANDLE_ALL_EXCEPT_EXPLICIT {
        found.retain(|s| !bool_of(c, *s, c.plugin().p.sensor_explicit).unwrap_or(false));
    }
    Ok(found)
}

fn handle_now(c: &mut Ctx<'_>) -> Result {
    let which = c.i64(0)?;
    let sensors = sensors_of_argument(c)?;
    if which >= 0 {
        let (view, seen) = take_image(c, sensors[0], 0)?;
        return_result(c, &view, &seen);
        return Ok(());
    }
    let mut count = 0;
    if which == HANDLE_ALL_EXCEPT_EXPLICIT && is_main(c)? {
        // These sensors are measured in the sensing stage. Run this stage unless the main script has already run it for
        // its proximity sensors.
        let now = c.world().f64(0, c.plugin().p.time)?;
        let late =
            |s: &tatu_object| VisionView::of_object(c, c.world().look(*s)?).map(|v| v.sequence == 0 || v.time < now);
        if sensors.iter().map(late).collect::<Result<Vec<bool>>>()?.contains(&true) {
            c.world().run_stage(TATU_STAGE_SENSE, 0.0)?;
        }
        for s in sensors {
            let view = VisionView::of_object(c, c.world().look(s)?)?;
            count += i64::from(current_result(c, &view)?.trigger);
        }
    } else {
        for s in sensors {
            count += i64::from(take_image(c, s, 0)?.1.trigger);
        }
    }
    c.ret(count);
    Ok(())
}

/// Returns the object in argument `i`, or 0 for all objects.
fn entity(c: &Ctx<'_>, i: usize) -> Result<tatu_object> {
    if c.i64(i)? == HANDLE_ALL { Ok(0) } else { Ok(existing_object(c, i)?.id) }
}

const READING_NOTES: &str = "The result also becomes the sensor's reading; collections are not supported.";

pub(crate) fn offer(offer: &mut Offer<Vrep>) {
    let packets = |command: Cmd| {
        command
            .returns(Param::floats("packet", 15).text(
                "three groups of five, 0 to 1: minimum, maximum and mean of intensity, red, green, blue and depth of \
                the image",
            ))
            .returns(Param::floats("more", 0).text("results of filters and sysCall_vision, packet by packet"))
    };
    offer.command(
        packets(
            both(["sim.readVisionSensor", "simReadVisionSensor"], MINUS_ONE, |c| {
                let view = VisionView::of(c, 0)?;
                if view.sequence == 0 {
                    c.ret(-1_i64);
                    return Ok(());
                }
                let seen = current_result(c, &view)?;
                return_result(c, &view, &seen);
                Ok(())
            })
            .param(flagged("sensor"))
            .returns(Param::int("result").text("1: detection, 0: none; -1 alone: never handled")),
        )
        .text("Returns the results of a vision sensor's last image."),
    );
    offer.command(
        packets(
            both(["sim.handleVisionSensor", "simHandleVisionSensor"], MINUS_ONE, handle_now)
                .param(flagged("sensor").text("a handle, sim.handle_all or sim.handle_all_except_explicit"))
                .returns(Param::int("count").text("number of sensors that detected something")),
        )
        .text(
            "Takes images with vision sensors immediately, then calls sysCall_vision and sysCall_trigger of their \
             scripts. For a single sensor, also returns the packets.",
        ),
    );
    offer.command(
        both(["sim.resetVisionSensor", "simResetVisionSensor"], MINUS_ONE, |c| {
            for sensor in sensors_of_argument(c)? {
                if is_vision_sensor(c, sensor) {
                    c.world().reset_reading(sensor)?;
                }
                state(c)?.vision.seen.remove(&sensor);
            }
            c.ret(0_i64);
            Ok(())
        })
        .param(flagged("sensor").text("a handle, sim.handle_all or sim.handle_all_except_explicit"))
        .returns(Param::int("result").text("0"))
        .text("Discards the readings of vision sensors."),
    );
    offer.command(
        packets(
            both(["sim.checkVisionSensor", "simCheckVisionSensor"], MINUS_ONE, |c| {
                let (sensor, only) = (VisionView::of(c, 0)?.id, entity(c, 1)?);
                let (view, seen) = take_image(c, sensor, only)?;
                return_result(c, &view, &seen);
                Ok(())
            })
            .param(flagged("sensor"))
            .param(Param::int("entity").text("an object, or sim.handle_all"))
            .returns(Param::int("result").text("1: something was detected, 0: nothing")),
        )
        .text("Checks whether a vision sensor detects an object.")
        .partial(READING_NOTES),
    );
    offer.command(
        both(["sim.checkVisionSensorEx", "simCheckVisionSensorEx"], NIL, |c| {
            let (sensor, only) = (VisionView::of(c, 0)?.id, entity(c, 1)?);
            let (view, seen) = take_image(c, sensor, only)?;
            let out: Vec<f64> = if c.arg(2).truthy() {
                seen.rgb(c, &view).iter().map(|x| f64::from(*x) / 255.0).collect()
            } else {
                seen.depth(c, &view).iter().map(|x| f64::from(*x)).collect()
            };
            c.ret(out);
            Ok(())
        })
        .param(flagged("sensor"))
        .param(Param::int("entity").text("an object, or sim.handle_all"))
        .param(Param::any("image").optional().text("true: colours, otherwise depths"))
        .returns(Param::floats("buffer", 0).text("0 to 1"))
        .text("Takes an image of a single object with a vision sensor, and returns the image or the depths.")
        .partial(READING_NOTES),
    );
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn results_of_script_callbacks_are_read() {
        let bytes: Vec<u8> = [1.5_f32, -2.0].iter().flat_map(|x| x.to_le_bytes()).collect();
        let map = Value::Map(vec![
            (Value::text("trigger"), Value::Bool(true)),
            (Value::text("packedPackets"), Value::List(vec![Value::Text(bytes), Value::Text(Vec::new())])),
        ]);
        assert_eq!(truth(&map, "trigger"), Some(true));
        assert_eq!(truth(&map, "other"), None);
        assert_eq!(packets_of(&map), [vec![1.5, -2.0], vec![]]);
        assert!(packets_of(&Value::Nil).is_empty());
    }
}
