//! Draws the surroundings of a proximity sensor: its volume and the detected point, from above and from the side.

use nalgebra::{Isometry3, Point3, Quaternion, Translation3, UnitQuaternion, Vector3};
use tatu_core::{Reading, World};
use tatu_render::{Camera, LineSegment, picture};

use super::canvas::{Canvas, HPos, VPos, title};

const HEADER_HEIGHT: u32 = 76;
const VIEW_SIZE: u32 = 520;
const VIEW_GAP: u32 = 12;
const FOV_RAD: f64 = 0.7;
/// Colours of the volume's edges, and of the line of sight with the detected point.
const EDGE_COLOR: [f64; 3] = [0.95, 0.75, 0.1];
const SIGHT_COLOR: [f64; 3] = [0.9, 0.2, 0.15];

/// Draws the reading of a proximity sensor; returns `None` for readings of other kinds.
pub fn draw(world: &World, reading: &Reading) -> Result<Option<Canvas>, String> {
    let (Some([detected, ..]), Some([distance, ..]), Some([x, y, z])) =
        (ints(reading, "proximity.detected"), reading.floats("proximity.distance"), reading.floats("proximity.point"))
    else {
        return Ok(None);
    };
    let [px, py, pz, qx, qy, qz, qw] = reading.pose;
    let turn = UnitQuaternion::from_quaternion(Quaternion::new(qw, qx, qy, qz));
    let pose = Isometry3::from_parts(Translation3::new(px, py, pz), turn);
    let line = |a: Point3<f64>, b: Point3<f64>, color, width| LineSegment { ends: [pose * a, pose * b], color, width };
    let edges = reading.edges.iter().map(|[a, b]| line(Point3::from(*a), Point3::from(*b), EDGE_COLOR, 1.6));
    let mut lines: Vec<LineSegment> = edges.collect();
    let point = Point3::new(*x, *y, *z);
    if *detected != 0 {
        lines.push(line(Point3::origin(), point, SIGHT_COLOR, 2.5));
        lines.push(line(point, point, SIGHT_COLOR, 11.0));
    }
    // Both pictures must show the whole volume and the ground.
    let reach =
        reading.edges.iter().flatten().chain([&[*x, *y, *z]]).fold(0.1_f64, |m, p| m.max(Vector3::from(*p).norm()));
    let middle = pose * Point3::new(0.0, 0.0, reach * 0.5);
    let ahead = pose.rotation * Vector3::z();
    let flat = Vector3::new(ahead.x, ahead.y, 0.0).try_normalize(1e-6).unwrap_or_else(Vector3::x);
    let away = reach * 0.75 / libm::tan(FOV_RAD / 2.0) + reach * 0.25;
    let beside = flat.cross(&Vector3::z()) * 0.85 - flat * 0.25 + Vector3::z() * 0.45;
    let camera = |from: Vector3<f64>| Camera {
        from: middle + from * away,
        to: middle,
        fov: FOV_RAD,
        columns: VIEW_SIZE,
        rows: VIEW_SIZE,
    };
    let mut canvas = Canvas::new(2 * VIEW_SIZE + VIEW_GAP, VIEW_SIZE + HEADER_HEIGHT);
    canvas.put((0, HEADER_HEIGHT), &picture(world, &camera(Vector3::z()), &lines, true));
    canvas.put((VIEW_SIZE + VIEW_GAP, HEADER_HEIGHT), &picture(world, &camera(beside.normalize()), &lines, true));
    canvas.title(&title(reading))?;
    let caption = match *detected {
        0 => "nothing is detected".to_owned(),
        _ => {
            let what = ints(reading, "proximity.object").and_then(|o| world.path_of(*o.first()?));
            let what = what.map_or(String::new(), |w| format!(", of {w}"));
            format!("the nearest point is {distance:.4} m away{what}")
        }
    };
    canvas.text(
        (20.0, 52.0),
        &format!("{caption}   (left: from above, right: from the side)"),
        15.0,
        (HPos::Left, VPos::Center),
    )?;
    Ok(Some(canvas))
}

fn ints<'a>(reading: &'a Reading, field: &str) -> Option<&'a [i64]> {
    match &reading.field(field)?.value {
        tatu_plugin_api::safe::Value::Ints(all) => Some(all),
        _ => None,
    }
}
