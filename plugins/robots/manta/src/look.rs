//! The visible parts of the car. They have no collision or mass, and beams ignore them; beams hit the body's boxes and
//! the tyres instead.

use std::f64::consts::{FRAC_PI_2, PI};

use tatu_plugin_api::safe::{Builder, Node, Result, Value, keys};

use crate::numbers::{RADIUS, TRACK, WHEELBASE, WIDTH};

const BLACK: [f64; 3] = [0.08, 0.08, 0.09];
const GLASS: [f64; 3] = [0.22, 0.30, 0.36];
const RIM: [f64; 3] = [0.85, 0.85, 0.83];
const HUB: [f64; 3] = [0.35, 0.36, 0.38];
const LAMP: [f64; 3] = [0.98, 0.96, 0.85];
const TAIL: [f64; 3] = [0.75, 0.05, 0.05];

/// A cross section of the hull: x, half of the width, lower and upper edge. The values are estimates, after the outline
/// of a flat sports car between its wheels.
type Section = [f64; 4];

const BODY: [Section; 9] = [
    [-0.175, 0.105, 0.020, 0.070],
    [-0.150, 0.125, -0.030, 0.088],
    [0.000, 0.135, -0.055, 0.092],
    [0.160, 0.138, -0.060, 0.086],
    [0.360, 0.138, -0.060, 0.072],
    [0.560, 0.132, -0.055, 0.052],
    [0.700, 0.118, -0.045, 0.030],
    [0.780, 0.095, -0.038, 0.006],
    [0.805, 0.060, -0.028, -0.010],
];
const CABIN: [Section; 5] = [
    [-0.060, 0.070, 0.060, 0.090],
    [0.060, 0.088, 0.060, 0.136],
    [0.180, 0.092, 0.060, 0.142],
    [0.270, 0.088, 0.060, 0.122],
    [0.400, 0.074, 0.050, 0.068],
];

/// A mesh: points, and triangles that are counter-clockwise seen from outside.
pub type Mesh = (Vec<[f64; 3]>, Vec<[u32; 3]>);

/// Builds a mesh that joins cross sections from back to front, with rounded upper edges, closed at both ends.
pub fn hull(sections: &[Section]) -> Mesh {
    // One side of a section, from bottom to top: fractions of the half width and of the height.
    const SIDE: [[f64; 2]; 6] = [[0.80, 0.0], [0.96, 0.12], [1.0, 0.45], [0.93, 0.75], [0.75, 0.93], [0.42, 1.0]];
    let n = 2 * SIDE.len() as u32;
    let mut points = Vec::new();
    for &[x, half, low, high] in sections {
        let at = |side: f64, [w, h]: [f64; 2]| [x, side * half * w, low + (high - low) * h];
        points.extend(SIDE.iter().map(|s| at(-1.0, *s)));
        points.extend(SIDE.iter().rev().map(|s| at(1.0, *s)));
    }
    let mut triangles = Vec::new();
    for level in 0..sections.len() as u32 - 1 {
        for i in 0..n {
            let (a, b) = (level * n + i, level * n + (i + 1) % n);
            triangles.extend([[a, a + n, b + n], [a, b + n, b]]);
        }
    }
    let front = points.len() as u32 - n;
    for i in 1..n - 1 {
        triangles.extend([[0, i, i + 1], [front, front + i + 1, front + i]]);
    }
    (points, triangles)
}

fn seen<'a>(builder: &Builder<'a>, parent: Node<'a>, alias: &str) -> Result<Node<'a>> {
    builder
        .object("shape", Some(parent), alias)?
        .set("shape.dynamic", false)?
        .set("shape.respondable", false)?
        .set("shape.detectable", false)
}

fn mesh<'a>(builder: &Builder<'a>, node: Node<'a>, mesh: &Mesh, color: [f64; 3]) -> Result<Node<'a>> {
    node.set("shape.primitive", "mesh")?.set("shape.mesh", builder.mesh(&mesh.0, &mesh.1)?)?.set("shape.color", color)
}

fn part(form: &str, size: [f64; 3], at: [f64; 3], turn: [f64; 3], color: [f64; 3]) -> Value {
    keys([
        ("primitive", Value::text(form)),
        ("size", Value::Floats(size.to_vec())),
        ("position", Value::Floats(at.to_vec())),
        ("orientation", Value::Floats(turn.to_vec())),
        ("color", Value::Floats(color.to_vec())),
    ])
}

/// Builds hull, cabin, wing and lights, as children of the base, whose boxes are hidden.
pub fn body<'a>(builder: &Builder<'a>, base: Node<'a>, color: [f64; 3]) -> Result {
    let hull_node = seen(builder, base, "Manta_visible")?;
    mesh(builder, hull_node, &hull(&BODY), color)?;
    let cabin = seen(builder, hull_node, "Manta_cabin_visible")?;
    mesh(builder, cabin, &hull(&CABIN), GLASS)?;
    let still = [0.0; 3];
    let mut parts = vec![
        // The wing on its two posts, and the wheel axles.
        part("box", [0.07, 0.34, 0.010], [-0.135, 0.0, 0.158], [0.0, 0.12, 0.0], BLACK),
        part("box", [0.05, 0.008, 0.08], [-0.135, 0.09, 0.12], still, BLACK),
        part("box", [0.05, 0.008, 0.08], [-0.135, -0.09, 0.12], still, BLACK),
        part("cylinder", [0.022, 0.022, TRACK - WIDTH], [0.0; 3], [FRAC_PI_2, 0.0, 0.0], HUB),
        part("cylinder", [0.022, 0.022, TRACK - WIDTH - 0.05], [WHEELBASE, 0.0, 0.0], [FRAC_PI_2, 0.0, 0.0], HUB),
    ];
    for side in [1.0, -1.0] {
        parts.push(part("sphere", [0.036; 3], [0.752, side * 0.072, 0.0], still, LAMP));
        parts.push(part("box", [0.012, 0.05, 0.016], [-0.172, side * 0.068, 0.052], still, TAIL));
        // A stripe along the side.
        parts.push(part("box", [0.30, 0.004, 0.020], [0.30, side * 0.138, -0.012], still, RIM));
    }
    seen(builder, hull_node, "Manta_details_visible")?
        .set("shape.primitive", "compound")?
        .set("shape.parts", Value::List(parts))?;
    Ok(())
}

/// Builds a rim with five spokes on a tyre whose axis is z, so that its rotation is visible.
pub fn rim<'a>(builder: &Builder<'a>, wheel: Node<'a>, alias: &str) -> Result {
    let d = 2.0 * RADIUS;
    let disc = |share: f64, more: f64, color| {
        part("cylinder", [share * d, share * d, WIDTH + more], [0.0; 3], [0.0; 3], color)
    };
    let mut parts = vec![disc(0.66, 0.001, HUB), disc(0.20, 0.006, RIM)];
    parts.extend((0..5).map(|i| {
        let turn = 2.0 * PI * f64::from(i) / 5.0;
        let (s, c) = libm::sincos(turn);
        let size = [0.30 * d, 0.07 * d, WIDTH + 0.003];
        part("box", size, [0.16 * d * c, 0.16 * d * s, 0.0], [0.0, 0.0, turn], RIM)
    }));
    seen(builder, wheel, &format!("{alias}_visible"))?
        .set("shape.primitive", "compound")?
        .set("shape.parts", Value::List(parts))?;
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn meshes_are_closed_and_face_outwards() {
        for sections in [&BODY[..], &CABIN[..]] {
            let (points, triangles) = hull(sections);
            // Each edge occurs once in each direction.
            let mut edges: Vec<[u32; 2]> =
                triangles.iter().flat_map(|[a, b, c]| [[*a, *b], [*b, *c], [*c, *a]]).collect();
            edges.sort_unstable();
            assert!(edges.windows(2).all(|w| w[0] != w[1]));
            assert!(edges.iter().all(|[a, b]| edges.binary_search(&[*b, *a]).is_ok()));
            // The enclosed volume is positive if the triangles face outwards.
            let volume: f64 = triangles
                .iter()
                .map(|t| {
                    let [a, b, c] = t.map(|i| points[i as usize]);
                    let cross = |i: usize, k: usize| b[i] * c[k] - b[k] * c[i];
                    (a[0] * cross(1, 2) + a[1] * cross(2, 0) + a[2] * cross(0, 1)) / 6.0
                })
                .sum();
            assert!(volume > 1e-3, "{volume}");
        }
    }
}
