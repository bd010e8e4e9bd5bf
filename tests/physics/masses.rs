//! Tests of mass, centre of mass and inertia of shapes that do not state them.

use std::f64::consts::PI;

use crate::{kit::*, scenes::*};

/// A cube of 1 m whose origin is a corner; without its last two triangles, its side x = 1 is open.
fn cube(triangles: usize) -> String {
    let corners = ["0 0 0", "0 0 1", "0 1 0", "0 1 1", "1 0 0", "1 0 1", "1 1 0", "1 1 1"];
    let faces = [[1, 3, 4, 2], [1, 2, 6, 5], [3, 7, 8, 4], [1, 5, 7, 3], [2, 4, 8, 6], [5, 6, 8, 7]];
    let mut out: String = corners.iter().map(|c| format!("v {c}\n")).collect();
    let halves = faces.iter().flat_map(|[a, b, c, d]| [[a, b, c], [a, c, d]]);
    out.extend(halves.take(triangles).map(|[a, b, c]| format!("f {a} {b} {c}\n")));
    out
}

fn mesh(more: &str) -> String {
    format!(
        "[[object]]\nkind = \"shape\"\nalias = \"o\"\nprimitive = \"mesh\"\nmesh = \"cube.obj\"\ndynamic = true\n{more}\n"
    )
}

/// A script that prints mass, centre of mass and inertia of the objects with the given paths.
fn weigher(paths: &str, first: &str) -> String {
    watcher(
        "weigher",
        &format!(
            "function sysCall_init()
                {first}
                for _, o in ipairs{{{paths}}} do
                    o = type(o) == 'string' and sim.getObject(o) or o
                    local i, m = sim.getShapeInertia(o)
                    print(string.format('weighs %.9f %.9f %.9f %.9f %.9f %.9f %.9f %.9f', sim.getShapeMass(o), m[4], m[8],
                        m[12], i[1], i[5], i[9], i[2]))
                end
            end"
        ),
    )
}

/// Returns mass, centre of mass, and the inertias xx, yy, zz and xy of each object.
#[track_caller]
fn weighed(place: &TestFolder) -> Vec<[f64; 8]> {
    let said = place.run(&["--steps", "1"]).good().err;
    let lines = said.lines().filter_map(|l| l.split_once("weighs "));
    lines
        .map(|(_, l)| l.split(' ').map(|x| x.trim().parse().unwrap()).collect::<Vec<f64>>().try_into().unwrap())
        .collect()
}

#[track_caller]
fn all_near(what: &str, is: &[f64], wanted: &[f64]) {
    assert_eq!(is.len(), wanted.len(), "{what}");
    is.iter().zip(wanted).for_each(|(is, wanted)| near(what, *is, *wanted, 1e-6 * wanted.abs().max(1.0)));
}

#[test]
fn a_mesh_rests_on_its_bottom_wherever_its_origin_is() {
    // The origin is a corner of the cube that the table does not support; its centre and 81 % of its bottom are.
    let table = "[[object]]\nkind = \"shape\"\nalias = \"table\"\nsize_m = [0.9, 0.9, 0.2]\n\
                 position_m = [0.55, 0.55, 0.1]\nrespondable = true\n";
    let place = scene_of(&(table.to_owned() + &mesh("convex = true\nposition_m = [0, 0, 0.2]\nrespondable = true")));
    place.write("cube.obj", &cube(12));
    let lines = place.trace(&["/o"], &["--seconds", "5"]);
    near("moved", distance(position(&lines[lines.len() - 1], "/o"), [0.0, 0.0, 0.2]), 0.0, 1e-3);
}

#[test]
fn closed_convex_and_open_meshes_weigh_as_their_solid() {
    // 1000 kg, its centre in the middle, m (a^2 + b^2) / 12; an open mesh is its hull, which is reported once.
    for (triangles, more, told) in [(12, "", 0), (12, "convex = true", 0), (11, "", 1)] {
        let place = scene_of(&(mesh(more) + &weigher("'/o'", "")));
        place.write("cube.obj", &cube(triangles));
        all_near(more, &weighed(&place)[0], &[1000.0, 0.5, 0.5, 0.5, 1000.0 / 6.0, 1000.0 / 6.0, 1000.0 / 6.0, 0.0]);
        for command in ["check", "run"] {
            let err = place.tatu(&[command, "scene.toml"][..]).good().err;
            assert_eq!(err.matches("its mesh is not closed").count(), told, "{command}: {err}");
        }
    }
    // A mesh whose values are all stated is not reported.
    let stated = mesh("mass_kg = 2.0\ncom_m = [0, 0, 0]\ninertia_kg_m2 = [1, 1, 1]");
    let place = scene_of(&(stated + &weigher("'/o'", "")));
    place.write("cube.obj", &cube(11));
    all_near("stated", &weighed(&place)[0], &[2.0, 0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 0.0]);
    assert!(!place.tatu(&["check", "scene.toml"]).good().err.contains("not closed"));
}

#[test]
fn compounds_and_groups_weigh_as_the_sum_of_their_parts() {
    let part = |x: f64, y: f64| format!("{{ primitive = \"box\", size_m = [1, 1, 1], position_m = [{x}, {y}, 0.5] }}");
    let bracket = format!(
        "gravity_m_s2 = [0, 0, 0]\n[[object]]\nkind = \"shape\"\nalias = \"o\"\nprimitive = \"compound\"\ndynamic = true\n\
         initial_angular_velocity_rad_s = [0, 0, 1]\nparts = [{}, {}, {}]\n",
        part(0.5, 0.5),
        part(1.5, 0.5),
        part(0.5, 1.5)
    );
    // Three boxes of 1000 kg: m / 6 each, and m times the squares of the distances from the common centre.
    let (x, across) = (5.0 / 6.0, 500.0 + 2000.0 / 3.0);
    let place = scene_of(&(bracket.clone() + &weigher("'/o'", "")));
    all_near("bracket", &weighed(&place)[0], &[3000.0, x, x, 0.5, across, across, 500.0 + 4000.0 / 3.0, 1000.0 / 3.0]);
    // It turns about its centre of mass: after half a turn, the origin is on the other side.
    let lines = watch_run(&bracket, &["/o"], PI);
    let end = &lines[lines.len() - 1];
    let angle = end.time();
    let wanted = [x - x * (angle.cos() - angle.sin()), x - x * (angle.sin() + angle.cos()), 0.0];
    near("origin", distance(position(end, "/o"), wanted), 0.0, 0.01);

    // Two cubes of 1 kg and 3 kg, 2 m apart: m / 6 each, and 1 kg * 1.5^2 + 3 kg * 0.5^2 across the line between them.
    let make = "local a, b = sim.createPureShape(0, 8, {1, 1, 1}, 1), sim.createPureShape(0, 8, {1, 1, 1}, 3)
                sim.setObjectPosition(b, {2, 0, 0})
                local g = sim.groupShapes({a, b}, false)";
    let group = weighed(&scene_of(&weigher("g", make)))[0];
    let across = 4.0 / 6.0 + 3.0;
    all_near("group", &group, &[4.0, 0.5, 0.0, 0.0, 4.0 / 6.0, across, across, 0.0]);
}

#[test]
fn capsules_and_ellipsoids_weigh_as_their_closed_forms() {
    let shape = |alias: &str, primitive: &str, size: [f64; 3]| {
        format!(
            "[[object]]\nkind = \"shape\"\nalias = \"{alias}\"\nprimitive = \"{primitive}\"\nsize_m = {size:?}\n\
             dynamic = true\n"
        )
    };
    let scene = shape("c", "capsule", [0.2, 0.2, 0.6]) + &shape("e", "sphere", [0.2, 0.4, 0.6]);
    let place = scene_of(&(scene + &weigher("'/c', '/e'", "")));
    let [capsule, ellipsoid] = weighed(&place)[..] else { panic!() };
    let (r, l) = (0.1_f64, 0.4);
    let (rod, ball) = (1000.0 * PI * r * r * l, 1000.0 * 4.0 / 3.0 * PI * r.powi(3));
    let across = rod * (l * l / 12.0 + r * r / 4.0) + ball * (0.4 * r * r + l * l / 4.0 + 0.375 * l * r);
    let about = rod * r * r / 2.0 + ball * 0.4 * r * r;
    all_near("capsule", &capsule, &[rod + ball, 0.0, 0.0, 0.0, across, across, about, 0.0]);
    let m = 1000.0 * 4.0 / 3.0 * PI * 0.1 * 0.2 * 0.3;
    let i = |a: f64, b: f64| m / 5.0 * (a * a + b * b);
    all_near("ellipsoid", &ellipsoid, &[m, 0.0, 0.0, 0.0, i(0.2, 0.3), i(0.1, 0.3), i(0.1, 0.2), 0.0]);
}

/// A sphere with different extents is an ellipsoid for physics and for beams, whatever created it, and this is reported
/// once.
#[test]
fn uneven_spheres_are_ellipsoids() {
    let size = "size_m = [0.2, 0.4, 0.6]";
    let shape = "[[object]]\nkind = \"shape\"\nalias = \"o\"\ndynamic = true\nrespondable = true\nposition_m = [0, 0, 0.1]\n\
                 orientation_deg = [0, 90, 0]\n";
    let own = format!("{shape}primitive = \"sphere\"\n{size}\n");
    let part = format!("{shape}primitive = \"compound\"\nparts = [{{ primitive = \"sphere\", {size} }}]\n");
    let made = watcher(
        "maker",
        "function sysCall_init()
            local o = sim.createPrimitiveShape(sim.primitiveshape_spheroid, {0.2, 0.4, 0.6})
            sim.setObjectAlias(o, 'o')
            sim.setObjectInt32Param(o, sim.shapeintparam_static, 0)
            sim.setObjectInt32Param(o, sim.shapeintparam_respondable, 1)
            sim.setObjectPose(o, {0, 0, 0.1, 0, math.sin(math.pi / 4), 0, math.cos(math.pi / 4)})
        end",
    );
    let teller = watcher(
        "teller",
        "function sysCall_cleanup() print('height ' .. sim.getObjectPosition(sim.getObject('/o'))[3]) end",
    );
    for (what, scene) in [("shape", own), ("part", part), ("command", made)] {
        let err = scene_of(&(floor(1.0) + &scene + &teller)).run(&["--seconds", "2"]).good().err;
        let height = err.lines().find_map(|l| l.split_once("height ")).unwrap_or_else(|| panic!("{err}")).1;
        // It lies on the end of its shortest axis, x, which points down: its centre is half of 0.2 m above the floor.
        near(what, height.trim().parse().unwrap(), 0.1, 0.002);
        assert_eq!(err.matches("is an ellipsoid").count(), 1, "{what}: {err}");
    }
}

/// With the inertia (1, 1, 1) kg m^2, the second moments of mass are 1/2 along each axis; a factor of 2 along x makes
/// the first of them 2.
#[test]
fn stated_matter_is_scaled_with_the_shape() {
    let shape = |stated: &str| {
        format!(
            "[[object]]\nkind = \"shape\"\nalias = \"o\"\nprimitive = \"box\"\nsize_m = [1, 1, 1]\nmass_kg = 6.0\n{stated}\n\
             dynamic = true\n"
        )
    };
    let scale = "sim.scaleObject(sim.getObject('/o'), 2, 1, 1)";
    let scaled = |stated: &str| weighed(&scene_of(&(shape(stated) + &weigher("'/o'", scale))))[0];
    let stated = scaled("com_m = [0.1, 0.2, 0.0]\ninertia_kg_m2 = [1, 1, 1]");
    all_near("stated", &stated, &[6.0, 0.2, 0.2, 0.0, 1.0, 2.5, 2.5, 0.0]);
    // A box of 2 x 1 x 1 m.
    all_near("computed", &scaled(""), &[6.0, 0.0, 0.0, 0.0, 1.0, 2.5, 2.5, 0.0]);
}
