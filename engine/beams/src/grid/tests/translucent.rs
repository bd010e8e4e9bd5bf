//! Colours of translucent surfaces.

use super::*;
use crate::MAX_TRANSLUCENT_LAYERS;

const RED: [f32; 3] = [1.0, 0.0, 0.0];
const BLUE: [f32; 3] = [0.0, 0.0, 1.0];
const WHITE: [f32; 3] = [1.0; 3];

/// Light in which surfaces show their own colours, before a black sky.
const FLAT: ImageLighting =
    ImageLighting { ambient: 1.0, headlight: 0.0, sun: 0.0, sun_direction: [0.0, 0.0, 1.0], sky: [0.0; 3] };

const GRID: Grid = Grid {
    columns: 24,
    rows: 16,
    projection: ImageProjection::Perspective { angle: 0.8 },
    near: 0.1,
    far: f64::INFINITY,
};

/// Returns a pane across the view whose front is `distance` metres away.
fn pane(object: u64, distance: f64, color: [f32; 3], opacity: f32) -> BeamTarget {
    let form = Form::Box { half: Vector3::new(9.0, 9.0, 0.05) };
    BeamTarget { color, opacity, ..target(object, Isometry3::translation(0.0, 0.0, distance + 0.05), form) }
}

/// Returns the colour that all pixels have.
fn color_of(targets: impl IntoIterator<Item = BeamTarget>) -> [u8; 3] {
    let image = render(&scene(targets), &cast_of(&GRID, &FLAT, Isometry3::identity()));
    assert!(image.color.iter().all(|c| *c == image.color[0]), "{:?}", image.color);
    image.color[0]
}

#[test]
fn translucent_red_over_white_is_mixed_by_opacity() {
    // 1/4 of red and 3/4 of white: 255, 0.75 * 255 = 191.25.
    assert_eq!(color_of([pane(1, 1.0, RED, 0.25), pane(2, 2.0, WHITE, 1.0)]), [255, 191, 191]);
    // Before the black sky only the quarter remains: 63.75.
    assert_eq!(color_of([pane(1, 1.0, RED, 0.25)]), [64, 0, 0]);
    assert_eq!(color_of([pane(1, 1.0, RED, 0.0), pane(2, 2.0, WHITE, 1.0)]), [255; 3]);
}

#[test]
fn two_translucent_layers_are_mixed_from_near_to_far() {
    // blue/2 + (red/4 + 3/4 white)/2 = 0.5, 0.375, 0.875.
    let all = [pane(3, 1.0, BLUE, 0.5), pane(2, 1.5, RED, 0.25), pane(1, 2.0, WHITE, 1.0)];
    assert_eq!(color_of(all.clone()), [128, 96, 223]);
    let [a, b, c] = all;
    assert_eq!(color_of([c, b, a]), [128, 96, 223], "the order of targets has no effect");
}

#[test]
fn closed_form_has_its_opacity_once() {
    // Rays pass the front and the back of the ball, which have the opacity together.
    let ball = BeamTarget {
        color: RED,
        opacity: 0.25,
        ..target(1, Isometry3::translation(0.0, 0.0, 4.0), Form::Sphere { radius: 3.5 })
    };
    assert_eq!(color_of([ball, pane(2, 9.0, WHITE, 1.0)]), [255, 191, 191]);
}

#[test]
fn nearest_translucent_layers_and_the_opaque_one_count() {
    let panes = (0..12).map(|i| pane(i + 1, 1.0 + 0.2 * i as f64, WHITE, 0.5));
    // Each of 8 layers lets half of the light through: 255 / 256 of white.
    let white = 255.0 * (1.0 - 0.5_f32.powi(MAX_TRANSLUCENT_LAYERS as i32));
    assert_eq!(color_of(panes.clone()), [(white + 0.5) as u8; 3]);
    let dim = panes.map(|p| BeamTarget { color: [0.0; 3], opacity: 0.1, ..p });
    let rest = 255.0 * 0.9_f32.powi(MAX_TRANSLUCENT_LAYERS as i32);
    assert_eq!(color_of(dim.chain([pane(99, 9.0, WHITE, 1.0)])), [(rest + 0.5) as u8; 3]);
}

#[test]
fn opacity_changes_colours_of_its_pixels_only() {
    let light = ImageLighting::default();
    for round in 0..40 {
        let mut dice = TestRng(7000 + round);
        let targets: Vec<BeamTarget> = (1..=8)
            .map(|i| {
                let form = any_form(&mut dice, 1.0);
                BeamTarget { color: [0.2, 0.5, 0.9], ..target(i, dice.pose(3.0), form) }
            })
            .collect();
        let grid = any_grid(&mut dice, round % 3 != 0);
        let cast = cast_of(&grid, &light, looking_inward(&mut dice));
        let opaque = render(&scene(targets.clone()), &cast);
        let clear =
            |t: &BeamTarget| BeamTarget { opacity: if t.object.is_multiple_of(2) { 0.4 } else { 1.0 }, ..t.clone() };
        let mixed: Vec<BeamTarget> = targets.iter().map(clear).collect();
        let seen = render(&scene(mixed.clone()), &cast);
        assert_eq!(seen.depth, opaque.depth);
        assert_eq!((&seen.object, &seen.primitive, &seen.cosine), (&opaque.object, &opaque.primitive, &opaque.cosine));
        for (i, object) in seen.object.iter().enumerate().filter(|(_, object)| **object % 2 == 1 || **object == 0) {
            assert_eq!(seen.color[i], opaque.color[i], "round {round}, object {object}");
        }
        let turned = render(&scene(mixed.into_iter().rev()), &cast);
        assert_eq!(turned.color, seen.color, "round {round}: the order of targets has no effect");
    }
}

#[test]
fn shading_of_a_translucent_surface_is_that_of_an_opaque_one() {
    // With an opacity of nearly 1, the colour from rays differs from that of the raster by rounding only.
    let light = ImageLighting::default();
    let (mut differ, mut all) = (0, 0);
    for round in 0..40 {
        let mut dice = TestRng(9000 + round);
        let form = any_form(&mut dice, 1.0);
        let one = BeamTarget { color: [0.9, 0.4, 0.2], ..target(2, dice.pose(1.0), form) };
        let grid = any_grid(&mut dice, round % 3 != 0);
        let cast = cast_of(&grid, &light, looking_inward(&mut dice));
        let opaque = render(&scene([one.clone()]), &cast);
        let nearly = render(&scene([BeamTarget { opacity: 0.999_99, ..one }]), &cast);
        let near = |(a, b): (&[u8; 3], &[u8; 3])| a.iter().zip(b).all(|(a, b)| a.abs_diff(*b) <= 1);
        differ += opaque.color.iter().zip(&nearly.color).filter(|(a, b)| !near((a, b))).count();
        all += opaque.object.iter().filter(|o| **o > 0).count();
    }
    assert!(all > 1000 && differ * 50 < all, "{differ} of {all} pixels differ");
}

#[test]
fn set_opacity_counts_translucent_targets() {
    let mut scene = scene([pane(1, 1.0, RED, 1.0), pane(2, 2.0, WHITE, 0.5)]);
    assert!(scene.has_translucent_targets());
    scene.set_color(1, WHITE, 1.0);
    assert!(!scene.has_translucent_targets());
    scene.set_color(0, RED, 0.25);
    scene.set_color(0, RED, 0.25);
    let image = render(&scene, &cast_of(&GRID, &FLAT, Isometry3::identity()));
    assert_eq!(image.color[0], [255, 191, 191]);
}
