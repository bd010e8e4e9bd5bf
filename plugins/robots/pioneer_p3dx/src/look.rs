//! The visible parts of the robot, seen by people and sensors. Meshes are extruded outlines, of a few hundred triangles
//! in total.

use std::f64::consts::{FRAC_1_SQRT_2, FRAC_PI_2, PI};

use tatu_plugin_api::safe::{Builder, Node, Result, Value};

use crate::presets::{Caster, Outline, Robot, Wheel};

/// A quarter turn about x that takes z to -y (right), x y z w.
pub const Z_TO_RIGHT: [f64; 4] = [FRAC_1_SQRT_2, 0.0, 0.0, FRAC_1_SQRT_2];

const BLACK: [f64; 3] = [0.06, 0.06, 0.065];
const GRAPHITE: [f64; 3] = [0.16, 0.16, 0.17];
const TYRE: [f64; 3] = [0.09, 0.09, 0.09];
const RIM: [f64; 3] = [0.82, 0.82, 0.8];
const HUB: [f64; 3] = [0.4, 0.41, 0.43];
const GOLD: [f64; 3] = [0.83, 0.65, 0.22];
const STEEL: [f64; 3] = [0.55, 0.56, 0.58];

/// Radius and thickness of a sonar's disc, and distance of its face behind the sensor's origin. Estimates from
/// photographs.
pub const DISC: [f64; 3] = [0.019, 0.006, 0.0005];

/// A corner of an outline seen from above, m.
pub type Corner = [f64; 2];

/// A quarter of an [`Outline`] from its end to its side: fractions of length and of half width.
const CURVE: [Corner; 5] = [[1.0, 0.36], [0.96, 0.57], [0.87, 0.76], [0.73, 0.91], [0.52, 1.0]];

impl Outline {
    /// Returns the outline's corners, counter-clockwise from the front left.
    pub fn corners(&self) -> Vec<Corner> {
        let quarter =
            |length: f64, side: f64| CURVE.map(|[along, across]| [length * along, side * self.half_width * across]);
        let [front_left, back_left] = [self.front, -self.back].map(|l| quarter(l, 1.0));
        let [front_right, back_right] = [self.front, -self.back].map(|l| quarter(l, -1.0));
        front_left
            .into_iter()
            .chain(back_left.into_iter().rev())
            .chain(back_right)
            .chain(front_right.into_iter().rev())
            .collect()
    }
}

/// Returns the convex hull, counter-clockwise: the lower chain, then the upper one.
fn hull(mut points: Vec<Corner>) -> Vec<Corner> {
    points.sort_by(|a, b| a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1])));
    let turn = |a: Corner, b: Corner, c: Corner| (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
    let chain = |points: &mut dyn Iterator<Item = Corner>| {
        let mut out: Vec<Corner> = Vec::new();
        for p in points {
            while out.len() > 1 && turn(out[out.len() - 2], out[out.len() - 1], p) <= 1e-12 {
                out.pop();
            }
            out.push(p);
        }
        out.pop();
        out
    };
    let mut all = chain(&mut points.iter().copied());
    all.extend(chain(&mut points.iter().rev().copied()));
    all
}

/// Returns the corners of the sonar ring, which is flat behind each disc.
pub fn ring_corners(robot: &Robot) -> Vec<Corner> {
    let [radius, thickness, behind] = DISC;
    let places = robot.sonars.iter().flat_map(|&[x, y, heading]| {
        let (s, c) = libm::sincos(heading.to_radians());
        let back = behind + thickness / 2.0;
        [-radius, radius].map(|t| [x - back * c - t * s, y - back * s + t * c])
    });
    hull(places.collect())
}

/// A mesh: points, and triangles that are counter-clockwise seen from outside.
pub type Mesh = (Vec<[f64; 3]>, Vec<[u32; 3]>);

/// Extrudes an outline through levels of height and inset, closed at the bottom and the top.
pub fn loft(corners: &[Corner], levels: &[[f64; 2]]) -> Mesh {
    let n = corners.len() as u32;
    let far = corners.iter().fold(0.0_f64, |m, c| m.max(libm::hypot(c[0], c[1])));
    let mut points = Vec::new();
    for [z, inset] in levels {
        // Scaling towards the middle approximates a bevel for a rounded outline.
        let share = 1.0 - inset / far;
        points.extend(corners.iter().map(|c| [c[0] * share, c[1] * share, *z]));
    }
    let mut triangles = Vec::new();
    for level in 0..levels.len() as u32 - 1 {
        for i in 0..n {
            let (a, b) = (level * n + i, level * n + (i + 1) % n);
            triangles.extend([[a, b, b + n], [a, b + n, a + n]]);
        }
    }
    let top = points.len() as u32 - n;
    for i in 1..n - 1 {
        triangles.extend([[0, i + 1, i], [top, top + i, top + i + 1]]);
    }
    (points, triangles)
}

/// Returns boxes that fill an outline between two heights, as parts of a compound for collisions.
pub fn boxes(outline: &Outline, [low, high]: [f64; 2], origin: f64) -> Vec<Value> {
    [CURVE[0], CURVE[2], CURVE[4]]
        .into_iter()
        .map(|[along, across]| {
            let (front, back) = (outline.front * along, -outline.back * along);
            Part {
                form: "box",
                size: [front - back, 2.0 * outline.half_width * across, high - low],
                at: [(front + back) / 2.0, 0.0, (low + high) / 2.0 - origin],
                turn: [0.0; 3],
                color: GRAPHITE,
            }
            .value()
        })
        .collect()
}

/// A part of a compound.
struct Part {
    form: &'static str,
    size: [f64; 3],
    at: [f64; 3],
    /// Euler angles about the part's own x, then y, then z axis.
    turn: [f64; 3],
    color: [f64; 3],
}

impl Part {
    fn value(self) -> Value {
        Value::Map(
            [
                ("primitive", Value::text(self.form)),
                ("size", self.size.into()),
                ("position", self.at.into()),
                ("orientation", self.turn.into()),
                ("color", self.color.into()),
            ]
            .map(|(key, value)| (Value::text(key), value))
            .into(),
        )
    }
}

fn part(form: &'static str, size: [f64; 3], at: [f64; 3], turn: [f64; 3], color: [f64; 3]) -> Value {
    Part { form, size, at, turn, color }.value()
}

/// Builds a shape that is only visible.
fn seen<'a>(builder: &Builder<'a>, parent: Node<'a>, alias: &str) -> Result<Node<'a>> {
    builder
        .object("shape", Some(parent), alias)?
        .set("shape.dynamic", false)?
        .set("shape.respondable", false)?
        .set("shape.detectable", true)
}

fn mesh<'a>(builder: &Builder<'a>, node: Node<'a>, mesh: &Mesh, color: [f64; 3]) -> Result<Node<'a>> {
    node.set("shape.primitive", "mesh")?
        .set("shape.mesh", builder.mesh(&mesh.0, &mesh.1)?)?
        .set("shape.convex", true)?
        .set("shape.color", color)
}

/// Returns the meshes of the body in the base frame: shell, ring, deck.
pub fn body_meshes(robot: &Robot) -> [Mesh; 3] {
    let up = |z: f64| z - robot.height;
    let [floor, ring] = robot.shell_z.map(up);
    let [deck, top] = robot.deck_z.map(up);
    [
        loft(&robot.shell.corners(), &[[floor, 0.018], [floor + 0.022, 0.0], [ring - 0.006, 0.0], [ring, 0.006]]),
        loft(&ring_corners(robot), &[[ring, 0.0], [deck, 0.0]]),
        loft(&robot.deck.corners(), &[[deck, 0.0], [top - 0.002, 0.0], [top, 0.002]]),
    ]
}

/// Builds the visible body as children of the base: the shell, which has ring, deck and discs as children.
pub fn body<'a>(builder: &Builder<'a>, base: Node<'a>, robot: &Robot, color: [f64; 3]) -> Result<Node<'a>> {
    let [shell, ring, deck] = body_meshes(robot);
    let body = seen(builder, base, "Pioneer_p3dx_visible")?;
    mesh(builder, body, &shell, color)?;
    let node = seen(builder, body, "Pioneer_p3dx_ring_visible")?;
    mesh(builder, node, &ring, GRAPHITE)?;
    let node = seen(builder, body, "Pioneer_p3dx_deck_visible")?;
    mesh(builder, node, &deck, BLACK)?;

    // Beams ignore the discs, which are flat against the ring.
    let [radius, thickness, behind] = DISC;
    let discs = robot.sonars.iter().map(|&[x, y, heading]| {
        let (s, c) = libm::sincos(heading.to_radians());
        let back = behind + thickness / 2.0;
        part(
            "cylinder",
            [2.0 * radius, 2.0 * radius, thickness],
            [x - back * c, y - back * s, robot.sonar_z - robot.height],
            lying(heading.to_radians()),
            GOLD,
        )
    });
    seen(builder, body, "Pioneer_p3dx_discs_visible")?
        .set("shape.detectable", false)?
        .set("shape.primitive", "compound")?
        .set("shape.parts", Value::List(discs.collect()))?;
    Ok(body)
}

/// Returns Euler angles that lay a cylinder's axis horizontally along a heading: a quarter turn about x takes z to -y,
/// then a turn about the new y, which is vertical, takes -y to the heading.
fn lying(heading: f64) -> [f64; 3] {
    [FRAC_PI_2, heading + FRAC_PI_2, 0.0]
}

/// Builds a tyre with a light rim and a hub with three spokes, so that its rotation is visible. It is a child of the
/// wheel, but turned upright again.
pub fn wheel<'a>(builder: &Builder<'a>, parent: Node<'a>, wheel: &Wheel, alias: &str) -> Result {
    let (d, w) = (wheel.diameter, wheel.width);
    let across = |diameter: f64, width: f64, color| {
        part("cylinder", [diameter, diameter, width], [0.0; 3], [FRAC_PI_2, 0.0, 0.0], color)
    };
    let mut parts = vec![across(d, w - 0.004, TYRE), across(0.68 * d, w - 0.001, RIM), across(0.22 * d, w, HUB)];
    parts.extend((0..3).map(|i| {
        let size = [0.62 * d, w - 0.0004, 0.07 * d];
        part("box", size, [0.0; 3], [0.0, PI * f64::from(i) / 3.0, 0.0], HUB)
    }));
    seen(builder, parent, alias)?
        .set("object.quaternion", Z_TO_RIGHT)?
        .set("shape.primitive", "compound")?
        .set("shape.parts", Value::List(parts))?;
    Ok(())
}

/// Builds the caster's fork: a plate below the body, and two cheeks down to the axle.
pub fn fork<'a>(builder: &Builder<'a>, link: Node<'a>, caster: &Caster) -> Result {
    let drop = caster.z - caster.wheel.diameter / 2.0;
    let cheek = |side: f64| {
        let size = [0.022, 0.003, drop + 0.012];
        part("box", size, [0.004, side * 0.0145, 0.0198 - size[2] / 2.0], [0.0; 3], STEEL)
    };
    let plate = part("box", [0.051, 0.032, 0.004], [0.0, 0.0, 0.0198], [0.0; 3], STEEL);
    seen(builder, link, "Pioneer_p3dx_caster_link_visible")?
        .set("object.position", [0.0078, 0.0, -0.0203])?
        .set("shape.primitive", "compound")?
        .set("shape.parts", Value::List(vec![plate, cheek(1.0), cheek(-1.0)]))?;
    Ok(())
}

/// Builds the visible caster wheel, 20.7 mm wide (V-REP's); the colliding one is thin.
pub fn caster_wheel<'a>(builder: &Builder<'a>, parent: Node<'a>, caster: &Caster) -> Result {
    let d = caster.wheel.diameter;
    seen(builder, parent, "Pioneer_p3dx_caster_wheel_visible")?.set("shape.primitive", "compound")?.set(
        "shape.parts",
        Value::List(vec![
            part("cylinder", [d, d, 0.0207], [0.0; 3], [0.0; 3], TYRE),
            part("cylinder", [0.5 * d, 0.5 * d, 0.0215], [0.0; 3], [0.0; 3], HUB),
        ]),
    )?;
    Ok(())
}
