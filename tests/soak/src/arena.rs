//! Generates an arena from a seed, as a scene file.

use std::fmt::Write;

/// Half the side length of the arena, m.
const HALF_SIDE_M: f64 = 5.0;
/// Minimum distance of boxes from each other, from walls and from the robot's start, m.
const MIN_GAP_M: f64 = 1.0;
/// Horizontal distance from the origin of the robot's base to its outermost part, m.
const ROBOT_RADIUS_M: f64 = 0.35;

/// The generator SplitMix64 (Steele, Lea and Flood 2014), which is small and gives the same values on all platforms.
struct SplitMix64(u64);

impl SplitMix64 {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    }
    fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * (self.next() >> 11) as f64 / (1u64 << 53) as f64
    }
}

/// Returns the scene. The robot starts in the middle; its heading is drawn from the seed.
pub fn scene(seed: u64, script: &str, dialect: &str, robot: &str) -> String {
    let mut r = SplitMix64(seed);
    let mut out = format!(
        "format = 1\n[scene]\nseed = {seed}\n{}\n",
        if dialect.is_empty() { String::new() } else { format!("dialect = \"{dialect}\"") }
    );
    shape(&mut out, "floor", "primitive = \"plane\"");
    for (name, size, at) in [
        ("wall_n", [10.4, 0.2, 0.6], [0.0, 5.1, 0.3]),
        ("wall_s", [10.4, 0.2, 0.6], [0.0, -5.1, 0.3]),
        ("wall_e", [0.2, 10.4, 0.6], [5.1, 0.0, 0.3]),
        ("wall_w", [0.2, 10.4, 0.6], [-5.1, 0.0, 0.3]),
    ] {
        shape(&mut out, name, &format!("size_m = {size:?}\nposition_m = {at:?}"));
    }
    // A gap between the bounding circles of two boxes guarantees at least that gap between the boxes.
    let mut placed: Vec<(f64, f64, f64)> = vec![(0.0, 0.0, ROBOT_RADIUS_M)];
    while placed.len() < 9 {
        let (x, y, sx, sy, turn) = (
            r.between(-HALF_SIDE_M, HALF_SIDE_M),
            r.between(-HALF_SIDE_M, HALF_SIDE_M),
            r.between(0.3, 0.8),
            r.between(0.3, 0.8),
            r.between(0.0, 180.0),
        );
        let radius = f64::hypot(sx, sy) / 2.0;
        let in_walls = x.abs().max(y.abs()) + radius + MIN_GAP_M <= HALF_SIDE_M;
        let apart = placed.iter().all(|(a, b, q)| f64::hypot(x - a, y - b) >= radius + q + MIN_GAP_M);
        if in_walls && apart {
            let name = format!("box_{}", placed.len());
            let body = format!(
                "size_m = [{sx}, {sy}, 0.6]\nposition_m = [{x}, {y}, 0.3]\norientation_deg = [0.0, 0.0, {turn}]"
            );
            shape(&mut out, &name, &body);
            placed.push((x, y, radius));
        }
    }
    let heading = r.between(-180.0, 180.0);
    let _ = write!(
        out,
        "[[model]]\nmodel = \"pioneer_p3dx\"\norientation_deg = [0.0, 0.0, {heading}]\nscript = {script:?}\n{robot}\n"
    );
    out
}

fn shape(out: &mut String, alias: &str, body: &str) {
    let _ = write!(out, "[[object]]\nkind = \"shape\"\nalias = \"{alias}\"\nrespondable = true\n{body}\n");
}
