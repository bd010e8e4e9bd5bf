//! Commands that create shapes from triangles, read the triangles of a shape, join shapes, and access mass and inertia.

use crate::{
    kit::{algebra as al, *},
    lookup::sets,
};

pub(crate) fn offer(offer: &mut Offer<Vrep>) {
    for (name, old) in [("sim.createMeshShape", Some("simCreateMeshShape")), ("sim.createShape", None)] {
        let run = |c: &mut Ctx<'_>| {
            let points = c.arg(2).numbers().unwrap_or_default();
            let places = c.arg(3).numbers().unwrap_or_default();
            let shape = create_from_triangles(c, points, places)?;
            c.ret(handle(shape));
            Ok(())
        };
        let command = Cmd::new(name, run);
        let command = old.into_iter().fold(command, |command, old| command.old_name(old, MINUS_ONE));
        offer.command(
            command
                .param(Param::any("options").text("ignored: they only affect the appearance"))
                .param(Param::any("shadingAngle").text("ignored"))
                .param(table("vertices", "x, y, z of each point, m"))
                .param(table("indices", "three zero-based point indices per triangle"))
                .param(Param::any("looks").rest().text("ignored: normals and textures"))
                .returns(Param::int("shape"))
                .text("Creates a shape from triangles, with its frame at the centre of its bounding box.")
                .partial("Normals and textures are ignored."),
        );
    }
    offer.command(
        both(["sim.createHeightfieldShape", "simCreateHeightfieldShape"], MINUS_ONE, |c| {
            let (nx, ny, width) = (c.i64(2)?, c.i64(3)?, c.f64(4)?);
            let heights = c.arg(5).numbers().unwrap_or_default();
            let (Ok(nx), Ok(ny)) = (usize::try_from(nx), usize::try_from(ny)) else {
                return Err(Fail::argument("expected numbers of points that are not negative"));
            };
            if nx < 2 || ny < 2 || nx.saturating_mul(ny) != heights.len() {
                let text = format!(
                    "expected at least 2 x 2 points with one height each, found {} heights for {nx} x {ny} points",
                    heights.len()
                );
                return Err(Fail::argument(text));
            }
            let d = width / (nx - 1) as f64;
            let (mut points, mut places) = (Vec::new(), Vec::new());
            for (k, h) in heights.iter().enumerate() {
                let (i, j) = ((k % nx) as f64, (k / nx) as f64);
                points.extend([d * i - width / 2.0, d * j - d * (ny - 1) as f64 / 2.0, *h]);
            }
            for j in 0..ny - 1 {
                for i in 0..nx - 1 {
                    let at = (j * nx + i) as f64;
                    let (right, up) = (at + 1.0, at + nx as f64);
                    places.extend([at, right, up, right, up + 1.0, up]);
                }
            }
            let shape = create_from_triangles(c, points, places)?;
            c.ret(handle(shape));
            Ok(())
        })
        .param(Param::any("options").text("ignored"))
        .param(Param::any("shadingAngle").text("ignored"))
        .param(Param::int("xPoints"))
        .param(Param::int("yPoints"))
        .param(Param::float("xSize").unit("m"))
        .param(table("heights", "row by row along x, m"))
        .returns(Param::int("shape"))
        .text("Creates a heightfield as a shape of triangles."),
    );
    offer.command(
        both(["sim.getShapeMesh", "simGetShapeMesh"], NIL, |c| {
            let shape = of_kind(c, 0, TATU_KIND_SHAPE)?;
            let (points, places) = triangles(c, shape)?;
            let normals = normals(&points, &places);
            c.ret(&points[..]);
            c.ret(&places[..]);
            c.ret(&normals[..]);
            Ok(())
        })
        .param(object("shape"))
        .returns(Param::list("vertices").text("x, y, z of each point, in the shape's frame"))
        .returns(Param::list("indices").text("three zero-based point indices per triangle"))
        .returns(Param::list("normals").text("for each corner of each triangle"))
        .text("Returns the triangles of a shape.")
        .partial("Round shapes are approximated by 32 segments; the parts of compounds are returned as boxes."),
    );
    offer.command(
        both(["sim.getShapeGeomInfo", "simGetShapeGeomInfo"], NIL, |c| {
            let shape = of_kind(c, 0, TATU_KIND_SHAPE)?;
            let p = &c.plugin().p;
            let size = c.world().f64s::<3>(shape, p.size)?;
            let (bits, pure) = match text_of(c, shape, p.primitive)?.as_str() {
                "plane" => (2_i64, 1_i64),
                "box" => (6, 3),
                "sphere" => (6, 4),
                "cylinder" => (6, 5),
                "capsule" => (6, 8),
                "compound" => (1, 0),
                _ => (if bool_of(c, shape, p.convex)? { 4 } else { 0 }, 0),
            };
            c.ret(bits);
            c.ret(pure);
            c.ret(&[size[0], size[1], size[2], 0.0][..]);
            Ok(())
        })
        .param(object("shape"))
        .returns(Param::int("result").text("1: compound, 2: pure, 4: convex, added up"))
        .returns(Param::int("pureType").text("sim.primitiveshape_..."))
        .returns(Param::floats("dimensions", 4))
        .text("Returns information about the geometry of a shape."),
    );
    offer.command(
        both(["sim.groupShapes", "simGroupShapes"], MINUS_ONE, |c| {
            let shapes = sets::list(c, 0)?;
            let group = group(c, &shapes)?;
            c.ret(handle(group));
            Ok(())
        })
        .param(Param::list("shapes"))
        .param(Param::any("merge").optional().text("ignored: the triangles are joined in any case"))
        .returns(Param::int("shape"))
        .text("Joins shapes into one.")
        .partial("The result is a single mesh, which cannot be divided again."),
    );
    offer.command(
        both(["sim.ungroupShape", "simUngroupShape"], NIL, |c| {
            let shape = of_kind(c, 0, TATU_KIND_SHAPE)?;
            c.ret(&[handle(shape)][..]);
            Ok(())
        })
        .param(object("shape"))
        .returns(Param::list("shapes"))
        .text("Divides a shape into its parts.")
        .partial("A shape is not divided: the list contains only itself."),
    );
    mass_commands(offer);
}

fn mass_commands(offer: &mut Offer<Vrep>) {
    let matrix =
        || table("transformation", "a matrix of 12 numbers: the frame of inertia and centre of mass").optional();
    offer.command(
        both(["sim.getShapeMassAndInertia", "simGetShapeMassAndInertia"], NIL, move |c| {
            let (shape, p, w) = (of_kind(c, 0, TATU_KIND_SHAPE)?, &c.plugin().p, c.world());
            let m = w.f64(shape, p.mass)?;
            // V-REP returns the inertia divided by the mass.
            let (inertia, com) = (inertia_of(c, shape)?.map(|x| x / m), w.f64s::<3>(shape, p.com)?);
            let frame = w.pose(shape, 0)?;
            let base = if c.has(1) { al::of_matrix(&numbers::<12>(c, 1)?) } else { al::IDENTITY };
            let to = al::compose(&al::inverse(&base), &frame);
            c.ret(m);
            c.ret(&rotate_inertia(&inertia, al::rotation(&to))[..]);
            c.ret(&al::add(al::position(&to), al::rotate(al::rotation(&to), com))[..]);
            Ok(())
        })
        .param(object("shape"))
        .param(matrix())
        .returns(Param::float("mass").unit("kg"))
        .returns(Param::floats("inertia", 9).text("inertia divided by the mass, m^2"))
        .returns(Param::floats("centreOfMass", 3).unit("m"))
        .text("Returns the mass, inertia and centre of mass of a shape; without a matrix, in the world frame."),
    );
    offer.command(
        both(["sim.setShapeMassAndInertia", "simSetShapeMassAndInertia"], MINUS_ONE, |c| {
            let (shape, p, w) = (of_kind(c, 0, TATU_KIND_SHAPE)?, &c.plugin().p, c.world());
            let m = c.f64(1)?.max(1e-7);
            let (inertia, com): ([f64; 9], [f64; 3]) = (numbers(c, 2)?, numbers(c, 3)?);
            let frame = w.pose(shape, 0)?;
            let base = if c.has(4) { al::of_matrix(&numbers::<12>(c, 4)?) } else { al::IDENTITY };
            let to = al::compose(&al::inverse(&frame), &base);
            let com = al::add(al::position(&to), al::rotate(al::rotation(&to), com));
            w.set_f64s(shape, p.mass, &[m])?;
            w.set(
                shape,
                p.inertia,
                &Value::Floats(rotate_inertia(&inertia, al::rotation(&to)).iter().map(|x| x * m).collect()),
            )?;
            w.set_f64s(shape, p.com, &com)?;
            finish_setter(c)
        })
        .param(object("shape"))
        .param(Param::float("mass").unit("kg"))
        .param(table("inertia", "9 numbers, divided by the mass"))
        .param(table("centreOfMass", "{x, y, z} m"))
        .param(matrix())
        .text("Sets the mass, inertia and centre of mass of a shape."),
    );
    offer.command(
        Cmd::new("sim.getShapeInertia", move |c| {
            let shape = of_kind(c, 0, TATU_KIND_SHAPE)?;
            let (inertia, com) = (inertia_of(c, shape)?, c.world().f64s::<3>(shape, c.plugin().p.com)?);
            c.ret(&inertia[..]);
            c.ret(&al::matrix(&al::pose(com, [0.0, 0.0, 0.0, 1.0]))[..]);
            Ok(())
        })
        .param(object("shape"))
        .returns(Param::floats("inertia", 9).unit("kg m^2"))
        .returns(Param::floats("transformation", 12).text("position of the centre of mass in the shape's frame"))
        .text("Returns the inertia and centre of mass of a shape."),
    );
    offer.command(
        Cmd::new("sim.setShapeInertia", |c| {
            let (shape, p, w) = (of_kind(c, 0, TATU_KIND_SHAPE)?, &c.plugin().p, c.world());
            let (inertia, at): ([f64; 9], [f64; 12]) = (numbers(c, 1)?, numbers(c, 2)?);
            let at = al::of_matrix(&at);
            w.set(shape, p.inertia, &Value::Floats(rotate_inertia(&inertia, al::rotation(&at)).to_vec()))?;
            w.set_f64s(shape, p.com, &al::position(&at))
        })
        .param(object("shape"))
        .param(table("inertia", "9 numbers, kg m^2"))
        .param(table("transformation", "12 numbers"))
        .text("Sets the inertia and centre of mass of a shape."),
    );
    offer.command(
        both(["sim.computeMassAndInertia", "simComputeMassAndInertia"], MINUS_ONE, |c| {
            let (shape, density) = (of_kind(c, 0, TATU_KIND_SHAPE)?, c.f64(1)?);
            let (points, places) = triangles(c, shape)?;
            let corner = |i: i64| {
                let at = 3 * i as usize;
                [points[at], points[at + 1], points[at + 2]]
            };
            let volume: f64 = places
                .chunks_exact(3)
                .map(|t| {
                    let (a, b, d) = (corner(t[0]), corner(t[1]), corner(t[2]));
                    let n = al::cross(b, d);
                    (a[0] * n[0] + a[1] * n[1] + a[2] * n[2]) / 6.0
                })
                .sum();
            c.world().set_f64s(shape, c.plugin().p.mass, &[(volume.abs() * density).max(1e-7)])?;
            c.ret(1_i64);
            Ok(())
        })
        .param(object("shape"))
        .param(Param::float("density").unit("kg/m^3"))
        .returns(Param::int("done"))
        .text("Sets the mass of a shape from its volume.")
        .partial("The inertia is computed from the geometry, unless it was set explicitly."),
    );
}

/// Rotates an inertia tensor, whose elements are listed row by row.
fn rotate_inertia(i: &[f64; 9], q: al::Quaternion) -> [f64; 9] {
    let m = al::matrix(&al::pose([0.0; 3], q));
    let r = |a: usize, b: usize| m[a * 4 + b];
    std::array::from_fn(|k| {
        let (row, column) = (k / 3, k % 3);
        (0..9).map(|n| r(row, n / 3) * i[n] * r(column, n % 3)).sum()
    })
}

/// Creates a shape from triangles, with its frame at the centre of its bounding box.
pub(crate) fn create_from_triangles(c: &Ctx<'_>, mut points: Vec<f64>, places: Vec<f64>) -> Result<tatu_object> {
    if points.len() < 9 || !points.len().is_multiple_of(3) || places.len() < 3 || !places.len().is_multiple_of(3) {
        return Err(Fail::argument("expected at least 9 coordinates and 3 indices, and multiples of 3 of both"));
    }
    let mut middle = [0.0; 3];
    for (k, m) in middle.iter_mut().enumerate() {
        let along = || points.iter().skip(k).step_by(3).copied();
        *m = (along().fold(f64::MAX, f64::min) + along().fold(f64::MIN, f64::max)) / 2.0;
    }
    points.iter_mut().enumerate().for_each(|(i, x)| *x -= middle[i % 3]);
    let (w, p) = (c.world(), &c.plugin().p);
    let shape = w.create("shape", 0, "Shape")?;
    let surface = Value::List(vec![Value::Floats(points), Value::Floats(places)]);
    let set =
        w.set(shape, p.surface, &surface).and_then(|()| w.set_pose(shape, 0, &al::pose(middle, [0.0, 0.0, 0.0, 1.0])));
    if let Err(e) = set {
        w.remove(&[shape])?;
        return Err(e);
    }
    Ok(shape)
}

fn group(c: &Ctx<'_>, shapes: &[tatu_object]) -> Result<tatu_object> {
    let (w, p) = (c.world(), &c.plugin().p);
    let Some(first) = shapes.first() else { return Err(Fail::argument("expected at least one shape")) };
    let (mut points, mut places, mut lumps) = (Vec::new(), Vec::new(), Vec::new());
    for s in shapes {
        if w.look(*s)?.kind != TATU_KIND_SHAPE && !w.used_as(*s, "shape") {
            return Err(Fail::argument(format!("object {} is not a shape", handle(*s))));
        }
        let (own, mine) = triangles(c, *s)?;
        let (frame, before) = (w.pose(*s, 0)?, (points.len() / 3) as f64);
        for p in own.chunks_exact(3) {
            points.extend(al::add(al::position(&frame), al::rotate(al::rotation(&frame), [p[0], p[1], p[2]])));
        }
        places.extend(mine.into_iter().map(|i| i as f64 + before));
        lumps.push(mass_of(c, *s)?);
    }
    let group = create_from_triangles(c, points, places)?;
    let (mass, com, inertia) = sum_masses(&lumps);
    let com = al::sub(com, al::position(&w.pose(group, 0)?));
    w.set_f64s(group, p.mass, &[mass])?;
    w.set_f64s(group, p.com, &com)?;
    w.set(group, p.inertia, &Value::Floats(inertia.to_vec()))?;
    for prop in [p.dynamic, p.respondable, p.detectable] {
        w.set(group, prop, &w.get(*first, prop)?.to_value()?)?;
    }
    w.set_f64s(group, p.color, &w.f64s::<3>(*first, p.color)?)?;
    let up = parent(c, *first)?;
    let pose = w.pose(group, 0)?;
    w.set(group, p.parent, &Value::Object(up))?;
    w.set_pose(group, 0, &pose)?;
    let name = text_of(c, *first, p.alias)?;
    w.remove(shapes)?;
    w.set(group, p.alias, &Value::text(&name))?;
    Ok(group)
}

/// The mass of a shape, kg, its centre, m, and its inertia about this centre, kg m^2, row by row, in the world frame.
type MassProperties = (f64, [f64; 3], [f64; 9]);

fn mass_of(c: &Ctx<'_>, shape: tatu_object) -> Result<MassProperties> {
    let (w, p) = (c.world(), &c.plugin().p);
    let frame = w.pose(shape, 0)?;
    let turn = al::rotation(&frame);
    let com = al::add(al::position(&frame), al::rotate(turn, w.f64s::<3>(shape, p.com)?));
    Ok((w.f64(shape, p.mass)?, com, rotate_inertia(&inertia_of(c, shape)?, turn)))
}

/// Returns the mass, centre of mass and inertia of shapes that are joined rigidly (Steiner's theorem).
fn sum_masses(lumps: &[MassProperties]) -> MassProperties {
    let mass: f64 = lumps.iter().map(|l| l.0).sum();
    let com: [f64; 3] = std::array::from_fn(|k| lumps.iter().map(|l| l.0 * l.1[k]).sum::<f64>() / mass);
    let mut inertia = [0.0; 9];
    for (m, centre, own) in lumps {
        let d = al::sub(*centre, com);
        let square: f64 = d.iter().map(|x| x * x).sum();
        for (k, sum) in inertia.iter_mut().enumerate() {
            let diagonal = if k / 3 == k % 3 { square } else { 0.0 };
            *sum += own[k] + m * (diagonal - d[k / 3] * d[k % 3]);
        }
    }
    (mass, com, inertia)
}

/// Returns the inertia of a shape about its centre of mass, kg m^2, row by row in its frame.
fn inertia_of(c: &Ctx<'_>, shape: tatu_object) -> Result<[f64; 9]> {
    let v = c.world().get(shape, c.plugin().p.inertia)?;
    v.array::<9>().ok_or_else(|| Fail::new("the host returned an invalid inertia"))
}

/// Returns the triangles of a shape: vertices in the shape's frame, and zero-based indices. Round shapes are
/// approximated by 32 segments, and compounds by their bounding box.
pub(crate) fn triangles(c: &Ctx<'_>, shape: tatu_object) -> Result<(Vec<f64>, Vec<i64>)> {
    let (w, p) = (c.world(), &c.plugin().p);
    let form = text_of(c, shape, p.primitive)?;
    let [x, y, z] = w.f64s::<3>(shape, p.size)?.map(|s| s / 2.0);
    Ok(match form.as_str() {
        "mesh" => {
            let v = w.get(shape, p.surface)?;
            let lists = v.list().unwrap_or_default();
            let numbers = |i: usize| lists.get(i).and_then(|v| v.numbers()).unwrap_or_default();
            (numbers(0), numbers(1).into_iter().map(|i| i as i64).collect())
        }
        "sphere" => {
            let ring = |a: f64| (libm::sin(a), -libm::cos(a) * z);
            let (mut points, places) = rings(x, &(0..=16).map(|k| ring(half_turn(k, 16))).collect::<Vec<_>>());
            points.iter_mut().skip(1).step_by(3).for_each(|along_y| *along_y *= y / x);
            (points, places)
        }
        "cylinder" => rings(x, &[(0.0, -z), (1.0, -z), (1.0, z), (0.0, z)]),
        "capsule" => {
            let straight = (z - x).max(0.0);
            let low = (0..=8).map(|k| half_turn(k, 16)).map(|a| (libm::sin(a), -libm::cos(a) * x - straight));
            let high = (8..=16).map(|k| half_turn(k, 16)).map(|a| (libm::sin(a), -libm::cos(a) * x + straight));
            rings(x, &low.chain(high).collect::<Vec<_>>())
        }
        "plane" => (vec![-x, -y, 0.0, x, -y, 0.0, x, y, 0.0, -x, y, 0.0], vec![0, 1, 2, 0, 2, 3]),
        _ => {
            let points = (0..8).flat_map(|k| {
                let side = |bit: i32, h: f64| if k & bit != 0 { h } else { -h };
                [side(1, x), side(2, y), side(4, z)]
            });
            let places = vec![
                0, 2, 3, 0, 3, 1, 4, 5, 7, 4, 7, 6, 0, 1, 5, 0, 5, 4, 2, 6, 7, 2, 7, 3, 0, 4, 6, 0, 6, 2, 1, 3, 7, 1,
                7, 5,
            ];
            (points.collect(), places)
        }
    })
}

fn half_turn(k: i32, n: i32) -> f64 {
    std::f64::consts::PI * f64::from(k) / f64::from(n)
}

/// Builds a solid of revolution about z from rings of 32 segments. `profile` contains the radius of each ring, as a
/// fraction of `radius`, and its height, from bottom to top.
fn rings(radius: f64, profile: &[(f64, f64)]) -> (Vec<f64>, Vec<i64>) {
    const SEGMENTS: i64 = 32;
    let (mut points, mut places) = (Vec::new(), Vec::new());
    for (r, z) in profile {
        for k in 0..SEGMENTS {
            let a = half_turn(k as i32 * 2, SEGMENTS as i32);
            points.extend([radius * r * libm::cos(a), radius * r * libm::sin(a), *z]);
        }
    }
    for ring in 0..profile.len() as i64 - 1 {
        for k in 0..SEGMENTS {
            let (a, b) = (ring * SEGMENTS + k, ring * SEGMENTS + (k + 1) % SEGMENTS);
            if profile[ring as usize].0 > 1e-9 {
                places.extend([a, b, b + SEGMENTS]);
            }
            if profile[ring as usize + 1].0 > 1e-9 {
                places.extend([a, b + SEGMENTS, a + SEGMENTS]);
            }
        }
    }
    (points, places)
}

fn normals(points: &[f64], places: &[i64]) -> Vec<f64> {
    let corner = |i: i64| {
        let at = 3 * i as usize;
        [points[at], points[at + 1], points[at + 2]]
    };
    places
        .chunks_exact(3)
        .flat_map(|t| {
            let a = corner(t[0]);
            let n = al::cross(al::sub(corner(t[1]), a), al::sub(corner(t[2]), a));
            let l = al::length(n).max(1e-300);
            let n = n.map(|x| x / l);
            [n, n, n].concat()
        })
        .collect()
}
