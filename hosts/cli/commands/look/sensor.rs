//! Draws a sensor's reading. The picture depends on the schemas of the reading, never on the kind of sensor.

use tatu_core::{Reading, World, errors::Error};
use tatu_render::Picture;

use super::{canvas::Canvas, frame, numbers, proximity, scan};

/// Returns the last reading of the sensor at a path, or an error that lists the sensors of the scene.
pub fn find(world: &World, path: &str) -> Result<Reading, Error> {
    if let Some(reading) = world.reading(path) {
        return Ok(reading);
    }
    let all = world.sensors();
    let text = match world.observe(path) {
        Some(seen) => format!("--sensor: `{}` is not a sensor", seen.path),
        None => format!("--sensor: there is no object `{path}`"),
    };
    let error = Error::new("E110", text);
    if all.is_empty() {
        return Err(error.help("there is no sensor in this scene"));
    }
    let list = match all.len() {
        0..=MAX_LISTED_SENSORS => all.join("\n  "),
        n => format!("{}\n  and {} more", all[..MAX_LISTED_SENSORS].join("\n  "), n - MAX_LISTED_SENSORS),
    };
    let list = format!("the scene has these sensors:\n  {list}");
    Err(match world.nearest(path).filter(|near| all.contains(near) || world.reading(near).is_some()) {
        Some(near) => error.help(format!("did you mean `{near}`? {list}")),
        None => error.help(list),
    })
}

/// Maximum number of sensors that an error lists.
const MAX_LISTED_SENSORS: usize = 24;

/// Draws the last reading of a sensor.
pub fn picture(world: &World, path: &str) -> Result<Picture, Error> {
    let reading = find(world, path)?;
    if reading.sequence == 0 {
        let error = Error::new("E105", format!("`{}` has not measured anything by {} s", reading.path, world.time()));
        return Err(error.help(
            "give a later time with --at; a sensor with explicit handling measures only when a script requests it",
        ));
    }
    let draw = || -> Result<Canvas, String> {
        if let Some(canvas) = scan::draw(&reading)? {
            return Ok(canvas);
        }
        if let Some(canvas) = frame::draw(&reading)? {
            return Ok(canvas);
        }
        if let Some(canvas) = proximity::draw(world, &reading)? {
            return Ok(canvas);
        }
        numbers::draw(&reading)
    };
    let canvas = draw().map_err(|e| Error::new("E105", format!("the picture cannot be drawn: {e}")))?;
    Ok(canvas.picture())
}
