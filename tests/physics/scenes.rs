//! Helpers that build parts of scenes and evaluate traces.

use std::f64::consts::FRAC_PI_2;

use crate::kit::*;

pub const G: f64 = 9.81;

/// Runs a scene, whose text begins within the table `[scene]`, and returns a trace with the watched objects.
#[track_caller]
pub fn watch_run(scene: &str, watch: &[&str], seconds: f64) -> Vec<TraceLine> {
    scene_of(scene).trace(watch, &["--seconds", &seconds.to_string()])
}

/// Returns a folder with a scene, whose text begins within the table `[scene]`.
pub fn scene_of(text: &str) -> TestFolder {
    TestFolder::scene(&format!("{}{text}", crate::SETTINGS))
}

pub fn floor(friction: f64) -> String {
    format!(
        "[[object]]\nkind = \"shape\"\nalias = \"floor\"\nprimitive = \"plane\"\nrespondable = true\nfriction = {friction}\n"
    )
}

/// Returns the scene entry of a dynamic shape; `more` contains further keys.
pub fn body(alias: &str, parent: &str, primitive: &str, size: [f64; 3], mass: f64, more: &str) -> String {
    let parent = if parent.is_empty() { String::new() } else { format!("parent = \"{parent}\"\n") };
    format!(
        "[[object]]\nkind = \"shape\"\nalias = \"{alias}\"\n{parent}primitive = \"{primitive}\"\nsize_m = {size:?}\n\
         mass_kg = {mass:?}\ndynamic = true\n{more}\n"
    )
}

/// Returns the scene entry of a static shape with the alias `base`.
pub fn base(at: [f64; 3]) -> String {
    format!("[[object]]\nkind = \"shape\"\nalias = \"base\"\nsize_m = [0.05, 0.05, 0.05]\nposition_m = {at:?}\n")
}

pub fn joint(alias: &str, parent: &str, more: &str) -> String {
    format!("[[object]]\nkind = \"joint\"\nalias = \"{alias}\"\nparent = \"{parent}\"\n{more}\n")
}

/// Returns the keys of a pose in the world, rotated by `angle` about `axis`.
pub fn placed(at: [f64; 3], axis: [f64; 3], angle: f64) -> String {
    let (s, c) = (angle / 2.0).sin_cos();
    let [x, y, z] = at;
    format!("world_pose = {:?}", [x, y, z, axis[0] * s, axis[1] * s, axis[2] * s, c])
}

/// Returns the keys of a pose whose z axis is the world's y axis.
pub fn about_y(at: [f64; 3]) -> String {
    placed(at, [1.0, 0.0, 0.0], -FRAC_PI_2)
}

/// Returns the key `gravity` that turns a horizontal floor into a slope that descends towards +x.
pub fn slope(degrees: f64) -> String {
    let a = degrees.to_radians();
    format!("gravity_m_s2 = {:?}\n", [G * a.sin(), 0.0, -G * a.cos()])
}

/// Returns the "position", "velocity" or "effort" of a joint.
#[track_caller]
pub fn of_joint(line: &TraceLine, path: &str, what: &str) -> f64 {
    line.0["objects"][path]["joint"][what].as_f64().unwrap_or_else(|| panic!("`{path}` {what}: {}", line.0["objects"]))
}

#[track_caller]
pub fn position(line: &TraceLine, path: &str) -> [f64; 3] {
    line.object(path, "position")
}

#[track_caller]
pub fn speed(line: &TraceLine, path: &str) -> f64 {
    norm(line.object::<3>(path, "linear_velocity"))
}

pub fn norm(v: [f64; 3]) -> f64 {
    v.iter().map(|x| x * x).sum::<f64>().sqrt()
}

pub fn distance(a: [f64; 3], b: [f64; 3]) -> f64 {
    norm([a[0] - b[0], a[1] - b[1], a[2] - b[2]])
}

/// Checks that `is` differs from `wanted` by at most `within`, and prints both.
#[track_caller]
pub fn near(what: &str, is: f64, wanted: f64, within: f64) {
    println!("{what}: {is:.6}, {wanted:.6} within {within}");
    assert!((is - wanted).abs() <= within, "{what}: {is} instead of {wanted}; the difference is {}", is - wanted);
}

/// Returns times and heights of the peaks of an evenly sampled curve, each interpolated by a parabola.
pub fn peaks(t: &[f64], x: &[f64]) -> Vec<(f64, f64)> {
    (1..x.len() - 1)
        .filter(|&k| x[k] > x[k - 1] && x[k] >= x[k + 1])
        .map(|k| {
            let (a, b) = ((x[k + 1] + x[k - 1]) / 2.0 - x[k], (x[k + 1] - x[k - 1]) / 2.0);
            (t[k] - b / (2.0 * a) * (t[k + 1] - t[k]), x[k] - b * b / (4.0 * a))
        })
        .collect()
}

/// Rotates a vector from the world frame to the frame of a body with the orientation (x, y, z, w).
pub fn into_body([x, y, z, w]: [f64; 4], v: [f64; 3]) -> [f64; 3] {
    let u = [-x, -y, -z];
    let cross =
        |a: [f64; 3], b: [f64; 3]| [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
    let t = cross(u, v).map(|c| 2.0 * c);
    let s = cross(u, t);
    [v[0] + w * t[0] + s[0], v[1] + w * t[1] + s[1], v[2] + w * t[2] + s[2]]
}

/// Returns the keys of a shape's initial velocity.
pub fn starts(linear: [f64; 3], angular: [f64; 3]) -> String {
    format!("initial_velocity_m_s = {linear:?}\ninitial_angular_velocity_rad_s = {angular:?}")
}
