//! Tests that bodies that overlap at the start separate slowly or remain in place, and are never thrown apart.

use crate::{kit::*, scenes::*};

/// Maximum speed of separating bodies, m/s. Each pair separates at no more than 0.2 m/s, but pushes from two sides add
/// up.
const MAX_SEPARATION_SPEED: f64 = 0.3;

/// The boxes of a body, each with its centre and size, m.
type PartBoxes = Vec<([f64; 3], [f64; 3])>;

/// Returns the boxes of a tray: bottom, back and two sides, and a front and a top if requested.
fn tray([l, w, h]: [f64; 3], wall: f64, front: bool, top: bool) -> PartBoxes {
    let mut out = vec![
        ([0.0, 0.0, (wall - h) / 2.0], [l, w, wall]),
        ([(wall - l) / 2.0, 0.0, 0.0], [wall, w, h]),
        ([0.0, (wall - w) / 2.0, 0.0], [l, wall, h]),
        ([0.0, (w - wall) / 2.0, 0.0], [l, wall, h]),
    ];
    if front {
        out.push(([(l - wall) / 2.0, 0.0, 0.0], [wall, w, h]));
    }
    if top {
        out.push(([0.0, 0.0, (h - wall) / 2.0], [l, w, wall]));
    }
    out
}

fn compound(alias: &str, parent: &str, boxes: &PartBoxes, mass: f64, more: &str) -> String {
    let part = |(at, size): &([f64; 3], [f64; 3])| {
        format!("{{ primitive = \"box\", position_m = {at:?}, size_m = {size:?} }}")
    };
    let parts: Vec<String> = boxes.iter().map(part).collect();
    let parent = if parent.is_empty() { String::new() } else { format!("parent = \"{parent}\"\n") };
    format!(
        "[[object]]\nkind = \"shape\"\nalias = \"{alias}\"\n{parent}primitive = \"compound\"\nparts = [{}]\n\
         respondable = true\ndynamic = true\nmass_kg = {mass:?}\n{more}\n",
        parts.join(", ")
    )
}

/// Returns the maximum speed of any of these objects in any physics step, m/s, and the trace.
#[track_caller]
fn fastest(scene: &str, watch: &[&str], seconds: f64) -> (f64, Vec<TraceLine>) {
    let lines = watch_run(&format!("dt_s = 0.005\n{scene}"), watch, seconds);
    let speeds = lines.iter().flat_map(|l| watch.iter().map(|w| speed(l, w)));
    (speeds.fold(0.0, f64::max), lines)
}

const SIZE: [f64; 3] = [0.5, 0.4, 0.6];
const WALL: f64 = 0.012;

/// Returns a chest with three thin-walled drawers that overlap it, and each other, by `overlap` on all sides.
fn chest(overlap: f64, mass: f64, motor: &str) -> String {
    let height = (SIZE[2] - 2.0 * WALL) / 3.0;
    let mut body = tray(SIZE, WALL, false, true);
    let level = |i: f64| (i - 1.5) * height;
    body.extend([1.0, 2.0].map(|i| ([0.0, 0.0, level(i)], [SIZE[0], SIZE[1], 0.006])));
    let mut out = floor(1.0) + &compound("chest", "", &body, 20.0, "position_m = [0, 0, 0.3]");
    let more = 2.0 * overlap;
    let drawer = tray([SIZE[0] - WALL + more, SIZE[1] - 2.0 * WALL + more, height + more], 0.008, true, false);
    for i in 0..3 {
        let place = format!(
            "type = \"prismatic\"\nlimits_m = [0.0, 0.4]\norientation_deg = [0, 90, 0]\nposition_m = {:?}\n{motor}",
            [WALL / 2.0, 0.0, level(f64::from(i) + 0.5)]
        );
        out += &joint(&format!("j{i}"), "/chest", &place);
        out += &compound(&format!("d{i}"), &format!("/chest/j{i}"), &drawer, mass, "orientation_deg = [0, -90, 0]");
    }
    out
}

const DRAWERS: [&str; 4] = ["/chest", "/chest/j0/d0", "/chest/j1/d1", "/chest/j2/d2"];

/// Drawers held by joints cannot separate from the chest. Light drawers in a heavy chest used to fly off at 300 m/s.
#[test]
fn drawers_stay_in_their_chest() {
    for overlap in [0.001, 0.003, 0.005] {
        for mass in [0.01, 1.0] {
            let (most, _) = fastest(&chest(overlap, mass, ""), &DRAWERS, 2.0);
            assert!(most < MAX_SEPARATION_SPEED, "{mass} kg, {overlap} m: {most} m/s");
        }
    }
}

/// The overlap does not jam the drawers: a motor can open them.
#[test]
fn drawers_open() {
    let motor = "control = \"velocity\"\ntarget_velocity_m_s = 0.1\nmax_force_n = 100.0";
    let (most, lines) = fastest(&chest(0.003, 1.0, motor), &DRAWERS, 2.0);
    assert!(most < MAX_SEPARATION_SPEED, "{most} m/s");
    let way = |l: &TraceLine| position(l, DRAWERS[2])[0];
    assert!(way(&lines[lines.len() - 1]) - way(&lines[0]) > 0.15);
}

#[test]
fn a_lid_rises_out_of_its_box() {
    let skirt = [-0.142, 0.142].map(|y| ([0.0, y, -0.015], [0.38, 0.01, 0.03]));
    let lid: PartBoxes = [([0.0; 3], [0.4, 0.3, 0.01])].into_iter().chain(skirt).collect();
    let scene = floor(1.0)
        + &compound("box", "", &tray([0.4, 0.3, 0.2], 0.01, true, false), 5.0, "position_m = [0, 0, 0.1]")
        + &compound("lid", "", &lid, 0.3, "position_m = [0, 0, 0.2]");
    let (most, _) = fastest(&scene, &["/box", "/lid"], 2.0);
    assert!(most < MAX_SEPARATION_SPEED, "{most} m/s");
}

/// Boxes that start half inside each other separate, and then rest side by side.
#[test]
fn boxes_part_slowly() {
    let cube = |alias: &str, x: f64| {
        body(alias, "", "box", [0.2; 3], 1.0, &format!("respondable = true\nposition_m = [{x}, 0.0, 0.1]"))
    };
    let (most, lines) = fastest(&(floor(0.5) + &cube("a", 0.0) + &cube("b", 0.1)), &["/a", "/b"], 3.0);
    assert!(most < 0.2, "{most} m/s");
    let end = &lines[lines.len() - 1];
    near("apart", position(end, "/b")[0] - position(end, "/a")[0], 0.2, 1e-3);
}
