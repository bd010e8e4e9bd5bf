//! Tests that stacks of boxes do not fall over, and that they fall asleep.

use crate::{kit::TraceLine, scenes::*};

/// Size (m), mass (kg) and position (m) of a box.
type StackedBox = ([f64; 3], f64, [f64; 3]);

/// Checks that all boxes are asleep (their speed is exactly 0) after 3 s, and have moved by less than `shift` after 10
/// s.
#[track_caller]
fn assert_stack_sleeps(what: &str, boxes: &[StackedBox], friction: f64, shift: f64) {
    let lines = assert_stack_stays("", what, boxes, friction, shift);
    let at = lines.iter().position(|l| l.time() >= 3.0).unwrap();
    let awake = (0..boxes.len()).filter(|i| speed(&lines[at], &format!("/b{i}")) != 0.0).count();
    assert_eq!(awake, 0, "{what}: boxes are awake after 3 s");
}

#[track_caller]
fn assert_stack_stays(settings: &str, what: &str, boxes: &[StackedBox], friction: f64, shift: f64) -> Vec<TraceLine> {
    let mut scene = settings.to_owned() + &floor(1.0);
    for (i, (size, mass, at)) in boxes.iter().enumerate() {
        let more = format!("position_m = {at:?}\nrespondable = true\nfriction = {friction}");
        scene += &body(&format!("b{i}"), "", "box", *size, *mass, &more);
    }
    let paths: Vec<String> = (0..boxes.len()).map(|i| format!("/b{i}")).collect();
    let watch: Vec<&str> = paths.iter().map(String::as_str).collect();
    let lines = watch_run(&scene, &watch, 10.0);
    let last = &lines[lines.len() - 1];
    let moved = |i: usize| {
        let (is, was) = (position(last, &paths[i]), boxes[i].2);
        f64::hypot(is[0] - was[0], is[1] - was[1])
    };
    let most = (0..boxes.len()).map(moved).fold(0.0, f64::max);
    near(what, most, 0.0, shift);
    lines
}

const CUBE: [f64; 3] = [0.1, 0.1, 0.1];

fn tower(n: usize) -> Vec<StackedBox> {
    (0..n).map(|i| (CUBE, 1.0, [0.0, 0.0, 0.05 + 0.1 * i as f64])).collect()
}

/// Returns a wall of bricks, `columns` wide. Every second row is offset by a quarter of a brick.
fn wall(rows: usize, columns: usize) -> Vec<StackedBox> {
    let brick = |row: usize, column: usize| {
        let aside = if row % 2 == 1 { 0.05 } else { 0.0 };
        let x = (column as f64 - (columns as f64 - 1.0) / 2.0) * 0.2 + aside;
        ([0.2, 0.1, 0.1], 1.0, [x, 0.0, 0.05 + 0.1 * row as f64])
    };
    (0..rows).flat_map(|r| (0..columns).map(move |c| brick(r, c))).collect()
}

#[test]
fn ten_boxes() {
    assert_stack_sleeps("ten boxes", &tower(10), 0.5, 1e-3);
}

/// The stack stands with any physics step that a scene can choose; with a coarse one, the boxes may remain awake.
#[test]
fn ten_boxes_at_other_steps() {
    for (dt, substeps) in [(0.01, 4), (0.01, 8), (0.005, 2), (0.02, 4), (0.002, 4), (0.001, 1)] {
        let settings = format!("physics_dt_s = {dt}\nphysics_substeps = {substeps}\n");
        assert_stack_stays(&settings, &format!("ten boxes, {dt} s in {substeps} parts"), &tower(10), 0.5, 5e-3);
    }
}

#[test]
fn pyramid() {
    let row = |i: usize| {
        (0..10 - i).map(move |j| (CUBE, 1.0, [(j as f64 - (9 - i) as f64 / 2.0) * 0.1, 0.0, 0.05 + 0.1 * i as f64]))
    };
    let boxes: Vec<_> = (0..10).flat_map(row).collect();
    assert_stack_sleeps("pyramid of 55", &boxes, 0.5, 1e-3);
}

#[test]
fn wall_of_100() {
    assert_stack_sleeps("wall of 100", &wall(10, 10), 0.5, 2e-3);
}

#[test]
fn wall_of_500() {
    assert_stack_sleeps("wall of 500", &wall(20, 25), 0.7, 5e-3);
}

#[test]
fn heavy_on_light() {
    for (ratio, shift) in [(30.0, 1e-3), (100.0, 1e-3), (1000.0, 5e-3)] {
        let boxes = [(CUBE, 1.0, [0.0, 0.0, 0.05]), (CUBE, ratio, [0.0, 0.0, 0.15])];
        assert_stack_stays("", &format!("{ratio} kg on 1 kg"), &boxes, 0.5, shift);
    }
}
