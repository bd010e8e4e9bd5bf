use super::*;

/// A source of random numbers that always returns the same number.
struct ConstantSource(f64);
impl RandomSource for ConstantSource {
    fn uniform(&self, _: u64, out: &mut [f64]) {
        out.fill(self.0);
    }
    fn normal(&self, _: u64, out: &mut [f64]) {
        out.fill(self.0);
    }
}

const COLUMNS: usize = 40;
const FOCAL: f64 = 100.0;

/// Measures an image of identical rows.
fn measure_row(optics: Optics, row: &[f32], cosine: &[f32], random: f64) -> Vec<f32> {
    let repeat = |v: &[f32]| v.repeat(8);
    let (depth, cosine) = (repeat(row), repeat(cosine));
    let frame = IdealImage { columns: row.len(), focal: FOCAL, depth: &depth, cosine: &cosine };
    let mut out = vec![-1.0; depth.len()];
    optics.measure(&frame, &ConstantSource(random), &mut out);
    out[4 * row.len()..5 * row.len()].to_vec()
}

/// Returns a row with a wall at 2 m, and a post at 1 m in front of columns 20 to 24.
fn post_row() -> Vec<f32> {
    (0..COLUMNS).map(|c| if (20..25).contains(&c) { 1.0 } else { 2.0 }).collect()
}

#[test]
fn slanted_surfaces_have_no_depth() {
    let optics = Optics { least_cosine: 0.5, ..Optics::NONE };
    let out = measure_row(optics, &[0.7, 1.0, f32::INFINITY], &[0.6, 0.4, 0.0], 0.0);
    assert_eq!(out, [0.7, 0.0, f32::INFINITY]);
}

/// With a projector 0.1 m to the right, the post's shadow covers focal * offset * (1/1 - 1/2) = 5 columns to its left;
/// with one to the left, 5 columns to its right.
#[test]
fn the_shadow_lies_opposite_to_the_projector() {
    let lost = |projector: f64| -> Vec<usize> {
        let out = measure_row(Optics { projector, ..Optics::NONE }, &post_row(), &[1.0; COLUMNS], 0.0);
        (0..COLUMNS).filter(|c| out[*c] == 0.0).collect()
    };
    assert_eq!(lost(-0.1), [15, 16, 17, 18, 19]);
    assert_eq!(lost(0.1), [25, 26, 27, 28, 29]);
    // At twice the offset, the shadow is as wide, but moves away from the post: 10 columns away, 5 wide.
    assert_eq!(lost(-0.2), [10, 11, 12, 13, 14]);
}

#[test]
fn a_slanted_wall_has_no_shadow() {
    let row: Vec<f32> = (0..COLUMNS).map(|c| 1.0 / (1.0 - 0.012 * c as f32)).collect();
    for projector in [-0.2, 0.2] {
        let out = measure_row(Optics { projector, ..Optics::NONE }, &row, &[1.0; COLUMNS], 0.0);
        assert_eq!(out, row);
    }
}

#[test]
fn edges_are_lost_or_mixed() {
    let out = measure_row(Optics { edges: EdgeMode::Lost, ..Optics::NONE }, &post_row(), &[1.0; COLUMNS], 0.0);
    let lost: Vec<usize> = (0..COLUMNS).filter(|c| out[*c] == 0.0).collect();
    assert_eq!(lost, [19, 20, 24, 25]);
    let out = measure_row(Optics { edges: EdgeMode::Mixed, ..Optics::NONE }, &post_row(), &[1.0; COLUMNS], 0.25);
    assert_eq!(out[18..27], [2.0, 1.75, 1.25, 1.0, 1.0, 1.0, 1.25, 1.75, 2.0]);
}

/// The fixed noise is one standard deviation, two pixels to the right: the edges of the post move, but the wall does
/// not.
#[test]
fn edges_move_by_the_lateral_noise() {
    let out = measure_row(Optics { lateral_sigma: 2.0, ..Optics::NONE }, &post_row(), &[1.0; COLUMNS], 1.0);
    let near: Vec<usize> = (0..COLUMNS).filter(|c| out[*c] == 1.0).collect();
    assert_eq!(near, [18, 19, 20, 21, 22]);
}

#[test]
fn a_pixel_alone_has_no_neighbours() {
    let optics = Optics { edges: EdgeMode::Lost, lateral_sigma: 1.0, projector: 0.1, ..Optics::NONE };
    let frame = IdealImage { columns: 1, focal: FOCAL, depth: &[1.5], cosine: &[1.0] };
    let mut out = [-1.0];
    optics.measure(&frame, &ConstantSource(0.5), &mut out);
    assert_eq!(out, [1.5]);
}
