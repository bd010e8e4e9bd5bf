//! Times a camera that looks at surfaces with images, and prints a hash of each picture.
//!
//! `cargo run --release -p tatu-beams --example textured_room [seconds per scene] [scene]`. A change of speed alone does not
//! change the hashes.

use std::{sync::Arc, time::Instant};

use nalgebra::{Isometry3, Point3, Translation3, UnitQuaternion, Vector3};
use tatu_beams::{
    BeamScene, BeamTarget, Faces, Grid, GridCast, GridImage, ImageLighting, ImageOutputs, ImageProjection,
};
use tatu_geometry::{Form, Image, Mesh, Texture, TextureBlend, TextureMapping, TextureProjection};

/// Returns an image of coloured noise, which differs from pixel to pixel.
fn noise(columns: u32, rows: u32) -> Arc<Image> {
    let mut state = 7_u32;
    let mut next = || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (state >> 24) as u8
    };
    let rgba = (0..columns * rows * 4).map(|_| next()).collect();
    Arc::new(Image::new(columns, rows, rgba).expect("the image has pixels"))
}

fn target(object: u64, at: [f64; 3], form: Form, texture: Option<(TextureMapping, bool, f64)>) -> BeamTarget {
    let texture = texture.map(|(mapping, smooth, size)| {
        let projection = TextureProjection {
            mapping,
            smooth,
            size: [size, size],
            repeat: [true, object.is_multiple_of(2)],
            blend: [TextureBlend::Modulate, TextureBlend::Decal, TextureBlend::Add][object as usize % 3],
            pose: Isometry3::new(Vector3::new(0.1, 0.2, 0.0), Vector3::z() * 0.3),
        };
        Arc::new(Texture { image: noise(200 + object as u32, 128), projection })
    });
    let turn = UnitQuaternion::from_euler_angles(0.1 * object as f64, 0.0, 0.7 * object as f64);
    BeamTarget {
        object,
        group: 0,
        world_from_target: Isometry3::from_parts(Translation3::from(at), turn),
        form,
        color: [0.7, 0.8, 0.9],
        opacity: 1.0,
        texture,
    }
}

/// Returns a torus with texture coordinates.
fn torus(around: u32, across: u32) -> Form {
    let mut mesh = Mesh::default();
    for i in 0..=around {
        for j in 0..=across {
            let (u, v) = (f64::from(i) / f64::from(around), f64::from(j) / f64::from(across));
            let [(a, b), (c, d)] = [u, v].map(|x| libm::sincos(x * std::f64::consts::TAU));
            mesh.vertices.push(Point3::new((1.0 + 0.4 * d) * b, (1.0 + 0.4 * d) * a, 0.4 * c));
            mesh.coordinates.push([4.0 * u as f32, 2.0 * v as f32]);
            if i < around && j < across {
                let (at, beyond) = (i * (across + 1) + j, (i + 1) * (across + 1) + j);
                mesh.triangles.push([at, beyond, beyond + 1]);
                mesh.triangles.push([at, beyond + 1, at + 1]);
            }
        }
    }
    Form::Mesh { mesh: Arc::new(mesh), convex: false }
}

fn room(floor: Option<(TextureMapping, bool, f64)>, things: Option<(TextureMapping, bool, f64)>) -> Vec<BeamTarget> {
    let mut all = vec![target(0, [0.0, 0.0, -0.1], Form::Box { half: Vector3::new(8.0, 8.0, 0.1) }, floor)];
    all[0].world_from_target.rotation = UnitQuaternion::identity();
    for i in 1..40_u64 {
        let form = match i % 4 {
            0 => Form::Box { half: Vector3::new(0.3, 0.2, 0.4) },
            1 => Form::Sphere { radius: 0.3 },
            2 => Form::Cylinder { radius: 0.2, half_length: 0.4 },
            _ => torus(60, 30),
        };
        let place = [(i % 7) as f64 * 1.2 - 3.6, (i / 7) as f64 * 1.2 - 2.0, 0.4];
        all.push(target(i, place, form, things));
    }
    all
}

/// Returns a floor and boxes, all with images.
fn lab() -> Vec<BeamTarget> {
    let mut all = room(Some((TextureMapping::Plane, true, 0.5)), Some((TextureMapping::Box, true, 0.5)));
    all.retain(|target| matches!(target.form, Form::Box { .. }));
    all
}

fn main() {
    let seconds: f64 = std::env::args().nth(1).and_then(|word| word.parse().ok()).unwrap_or(1.0);
    let only = std::env::args().nth(2);
    let plane = |smooth| Some((TextureMapping::Plane, smooth, 0.5));
    let with = |mapping| Some((mapping, true, 0.5));
    let mesh = Some((TextureMapping::Mesh, true, 1.0));
    let scenes = [
        ("plain", room(None, None)),
        ("smooth floor", room(plane(true), None)),
        ("sharp floor", room(plane(false), plane(false))),
        ("boxes", room(plane(true), with(TextureMapping::Box))),
        ("cylinders", room(plane(true), with(TextureMapping::Cylinder))),
        ("spheres", room(plane(true), with(TextureMapping::Sphere))),
        ("meshes", room(plane(true), mesh)),
        ("floor and boxes", lab()),
        ("fine mesh", vec![target(2, [0.0; 3], torus(600, 200), mesh)]),
    ];
    let grid = Grid {
        columns: 1024,
        rows: 768,
        projection: ImageProjection::Perspective { angle: 1.0 },
        near: 0.05,
        far: 30.0,
    };
    let turn = UnitQuaternion::face_towards(&Vector3::new(0.0, 1.0, -0.6), &Vector3::z());
    let light = ImageLighting::default();
    let cast = GridCast {
        grid: &grid,
        world_from_sensor: Isometry3::from_parts(Translation3::new(0.0, -4.0, 2.6), turn),
        faces: Faces::BOTH,
        skip_group: None,
        only_object: None,
        outputs: ImageOutputs { color: true, ..ImageOutputs::DEPTH },
        light: &light,
    };
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).use_current_thread().build();
    let pool = pool.expect("the thread pool can be created");
    for (name, targets) in scenes.into_iter().filter(|(name, _)| only.as_deref().is_none_or(|only| only == *name)) {
        let mut scene = BeamScene::default();
        scene.set(targets);
        let mut image = GridImage::default();
        let (mut best, start) = (f64::INFINITY, Instant::now());
        while start.elapsed().as_secs_f64() < seconds {
            let at = Instant::now();
            pool.install(|| scene.render(&cast, &mut image));
            best = best.min(at.elapsed().as_secs_f64());
        }
        let bytes = image.color.iter().flatten();
        let hash = bytes.fold(0xcbf2_9ce4_8422_2325_u64, |h, b| (h ^ u64::from(*b)).wrapping_mul(0x100_0000_01b3));
        println!("{name:15} {:6.1} ms  {hash:016x}", 1e3 * best);
    }
}
