//! Tests of images against rays, against closed forms and against each other.

mod rays;
mod scenes;
mod translucent;

use fearless_simd::Level;
use nalgebra::{Isometry3, Point3, Translation3, UnitQuaternion, Vector3};
use rays::{compare, render};
use scenes::{any_form, any_grid, ball, cast_of, mesh, scene, target};
use tatu_geometry::Form;

use super::*;
use crate::Faces;
use crate::{BeamScene, BeamTarget, beams_tests::TestRng, simd};

/// Returns a camera that looks roughly at the centre of the scene.
fn looking_inward(dice: &mut TestRng) -> Isometry3<f64> {
    let (eye, at) = (Point3::from(dice.vector(3.5)), Point3::from(dice.vector(1.0)));
    Isometry3::face_towards(&eye, &at, &dice.vector(1.0))
}

#[test]
fn random_images_match_rays() {
    let light = ImageLighting::default();
    let (mut pixels, mut depth, mut name, mut seen) = (0, 0, 0, 0);
    for round in 0..150 {
        let mut dice = TestRng(round);
        let count = dice.between(1.0, 12.0) as u64;
        let mut targets: Vec<BeamTarget> = (1..=count)
            .map(|i| {
                let form = any_form(&mut dice, 1.0);
                target(i, dice.pose(3.0), form)
            })
            .collect();
        if dice.chance(0.4) {
            targets.push(target(99, dice.pose(1.5), Form::Plane));
        }
        let scene = scene(targets);
        let grid = any_grid(&mut dice, round % 3 != 0);
        let mut cast = cast_of(&grid, &light, looking_inward(&mut dice));
        cast.faces = [Faces::BOTH, Faces::BOTH, Faces::FRONT, Faces::BACK][dice.between(0.0, 4.0) as usize];
        cast.skip_group = dice.chance(0.2).then_some(1);
        cast.only_object = dice.chance(0.1).then_some(2);
        let image = render(&scene, &cast);
        let beside = compare(&scene, &cast, &image, &format!("round {round}"));
        depth += beside.depth;
        name += beside.surface;
        pixels += image.depth.len();
        seen += image.depth.iter().filter(|d| d.is_finite()).count();
    }
    assert!(seen * 4 > pixels, "the scenes are empty: {seen} of {pixels}");
    // The triangles of the meshes are tiny in such small images: many pixels contain several edges.
    assert!(depth * 500 < pixels, "{depth} of {pixels} pixels differ in depth");
    assert!(name * 500 < pixels, "{name} of {pixels} pixels differ at edges");
}

#[test]
fn images_from_inside_forms_match_rays() {
    let light = ImageLighting::default();
    for round in 0..80 {
        let mut dice = TestRng(1000 + round);
        let (pose, form) = (dice.pose(2.0), any_form(&mut dice, 1.0));
        let scene = scene([target(1, pose, form)]);
        let grid = Grid { near: dice.between(0.001, 0.3), ..any_grid(&mut dice, round % 4 != 0) };
        let inside = pose * Isometry3::translation(0.02, 0.03, -0.04) * dice.pose(0.2);
        let mut cast = cast_of(&grid, &light, inside);
        cast.faces = [Faces::BOTH, Faces::FRONT, Faces::BACK][round as usize % 3];
        compare(&scene, &cast, &render(&scene, &cast), &format!("round {round}"));
    }
}

/// Returns the instruction set levels to test on this processor.
fn levels() -> Vec<Level> {
    let best = Level::new();
    let mut all = vec![Level::baseline(), best];
    #[cfg(target_arch = "x86_64")]
    all.extend(best.as_avx2().map(Level::Avx2));
    all
}

#[test]
fn images_are_identical_for_all_simd_levels_and_bands() {
    let light = ImageLighting::default();
    for round in 0..30 {
        let mut dice = TestRng(2000 + round);
        let targets: Vec<BeamTarget> = (1..=30)
            .map(|i| {
                let form = any_form(&mut dice, 0.8);
                target(i % 20, dice.pose(3.0), form)
            })
            .collect();
        let scene = scene(targets);
        let mut cast_grid = any_grid(&mut dice, round % 3 != 0);
        cast_grid.columns += 100;
        cast_grid.rows += 80;
        let mut cast = cast_of(&cast_grid, &light, looking_inward(&mut dice));
        if round % 2 == 0 {
            cast.outputs = ImageOutputs::DEPTH;
        }
        let mut first = GridImage::default();
        scene.render_by(&cast, &mut first, Level::baseline(), usize::MAX);
        let mut image = GridImage::default();
        for level in levels() {
            for band in [usize::MAX, 1, 7, 24] {
                scene.render_by(&cast, &mut image, level, band);
                let bits = |image: &GridImage| image.depth.iter().map(|d| d.to_bits()).collect::<Vec<_>>();
                assert!(bits(&image) == bits(&first), "round {round}, {level:?}, bands of {band}: depth");
                assert!(image.object == first.object && image.primitive == first.primitive, "{level:?}, {band}");
                assert!(image.color == first.color && image.cosine == first.cosine, "{level:?}, {band}");
                assert!(image.normal == first.normal, "{level:?}, {band}");
            }
        }
        cast.outputs = ImageOutputs::DEPTH;
        scene.render_by(&cast, &mut image, simd::level(), usize::MAX);
        assert!(image.depth == first.depth, "round {round}: depth alone");
        for threads in [1, 2] {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| scene.render(&cast, &mut image));
            assert!(image.depth == first.depth, "round {round}: {threads} threads");
        }
    }
}

#[test]
fn mesh_images_are_identical_for_all_thread_counts() {
    // Images of 1 to 300 rows, which different numbers of threads divide into different bands, and many frames in the
    // same buffers.
    let light = ImageLighting::default();
    let pools: Vec<_> =
        [1, 2, 3, 5].map(|threads| rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap()).into();
    let mut images = vec![GridImage::default(); pools.len()];
    for round in 0..24 {
        let mut dice = TestRng(3000 + round);
        let (around, up) = (dice.between(5.0, 200.0) as u32, dice.between(5.0, 150.0) as u32);
        let form = ball(&mut dice, 1.0, around, up, 0.05);
        let others = (2..8).map(|i| target(i, dice.pose(2.0), any_form(&mut dice, 0.8))).collect::<Vec<_>>();
        let scene = scene([target(1, dice.pose(0.3), form)].into_iter().chain(others));
        let grid = Grid {
            columns: dice.between(20.0, 200.0) as u32,
            rows: dice.between(1.0, 300.0) as u32,
            near: 0.05,
            far: 12.0,
            ..any_grid(&mut dice, round % 3 != 0)
        };
        let mut cast = cast_of(&grid, &light, looking_inward(&mut dice));
        cast.outputs = if round % 2 == 0 { ImageOutputs::DEPTH } else { ImageOutputs::ALL };
        let mut first = GridImage::default();
        scene.render_by(&cast, &mut first, simd::level(), usize::MAX);
        for (pool, image) in pools.iter().zip(&mut images) {
            let threads = pool.current_num_threads();
            pool.install(|| scene.render(&cast, image));
            assert!(image.depth == first.depth, "round {round}: {threads} threads: depth");
            assert!(image.object == first.object && image.primitive == first.primitive, "{round}, {threads}");
            assert!(image.color == first.color && image.normal == first.normal, "round {round}, {threads}");
        }
    }
}

#[test]
fn wall_depth_equals_its_distance() {
    // The depth of a wall perpendicular to the axis is its distance, regardless of the angle of the ray.
    let light = ImageLighting::default();
    let grid =
        Grid { columns: 640, rows: 480, projection: ImageProjection::Perspective { angle: 1.0 }, near: 0.01, far: 3.5 };
    let wall = mesh(
        [(-9.0, -9.0), (9.0, -9.0), (9.0, 9.0), (-9.0, 9.0)].map(|(x, y)| Point3::new(x, y, 0.0)).to_vec(),
        vec![[0, 2, 1], [0, 3, 2]],
    );
    for distance in [0.011, 0.5, 1.0, 2.0, 3.4999] {
        for form in [Form::Plane, Form::Box { half: Vector3::new(9.0, 9.0, 0.0) }, wall.clone()] {
            let turned = UnitQuaternion::from_axis_angle(&Vector3::x_axis(), std::f64::consts::PI);
            let pose = Isometry3::from_parts(Translation3::new(0.3, 0.2, distance), turned);
            let image = render(&scene([target(1, pose, form)]), &cast_of(&grid, &light, Isometry3::identity()));
            for depth in image.depth {
                assert!((f64::from(depth) / distance - 1.0).abs() < 1e-6, "{depth} instead of {distance}");
            }
        }
    }
}

#[test]
fn columns_run_to_the_right_and_rows_upward() {
    // x points to the left and y up: a ball at +x is in the first columns, one at +y in the last rows.
    let light = ImageLighting::default();
    let grid =
        Grid { columns: 40, rows: 30, projection: ImageProjection::Perspective { angle: 1.0 }, near: 0.1, far: 10.0 };
    let small = Form::Sphere { radius: 0.1 };
    let scene = scene([
        target(1, Isometry3::translation(0.8, 0.0, 2.0), small.clone()),
        target(2, Isometry3::translation(0.0, 0.6, 2.0), small),
    ]);
    for view in [grid.projection, ImageProjection::Orthographic { width: 2.2 }] {
        let grid = Grid { projection: view, ..grid };
        let image = render(&scene, &cast_of(&grid, &light, Isometry3::identity()));
        let places = |object: u64| image.object.iter().enumerate().filter(move |(_, o)| **o == object).map(|(i, _)| i);
        assert!(places(1).count() > 0 && places(1).all(|i| i % 40 < 12 && (10..20).contains(&(i / 40))));
        assert!(places(2).count() > 0 && places(2).all(|i| (15..25).contains(&(i % 40)) && i / 40 > 20));
    }
}

#[test]
fn equal_depths_go_to_the_lowest_tag() {
    let light = ImageLighting::default();
    let grid =
        Grid { columns: 33, rows: 21, projection: ImageProjection::Perspective { angle: 1.0 }, near: 0.1, far: 10.0 };
    for form in [Form::Box { half: Vector3::new(0.3, 0.2, 0.2) }, Form::Sphere { radius: 0.3 }, Form::Plane] {
        let turned = UnitQuaternion::from_axis_angle(&Vector3::x_axis(), 2.7);
        let place = Isometry3::from_parts(Translation3::new(0.0, 0.0, 1.0), turned);
        let scene = scene([9, 4, 6].map(|object| target(object, place, form.clone())));
        let image = render(&scene, &cast_of(&grid, &light, Isometry3::identity()));
        assert!(image.object.contains(&4), "{form:?}");
        assert!(image.object.iter().all(|o| [0, 4].contains(o)), "{form:?}");
    }
}

#[test]
fn a_closed_mesh_has_no_holes() {
    // Seen from afar, up close and from inside: each ray from outside a closed surface meets a front face first.
    let light = ImageLighting::default();
    let mut dice = TestRng(77);
    for round in 0..40 {
        let (around, up) = (dice.between(20.0, 300.0) as u32, dice.between(10.0, 200.0) as u32);
        let form = ball(&mut dice, 1.0, around, up, 0.002);
        let mut scene = scene([target(1, dice.pose(0.1), form)]);
        let grid = Grid {
            columns: 200,
            rows: 200,
            projection: ImageProjection::Perspective { angle: dice.between(0.3, 1.5) },
            near: 0.01,
            far: 100.0,
        };
        // From inside, every pixel shows the surface.
        let image = render(&scene, &cast_of(&grid, &light, dice.pose(0.3)));
        assert!(image.depth.iter().all(|d| d.is_finite()), "round {round}: a hole from within");
        // From outside, the image of both sides is the same as that of the fronts alone; a back face visible through a
        // gap would cause a difference.
        scene.update_poses(&[(0, Isometry3::translation(0.0, 0.0, dice.between(1.2, 9.0)) * dice.pose(0.05))]);
        let mut cast = cast_of(&grid, &light, Isometry3::identity());
        let both = render(&scene, &cast);
        cast.faces = Faces::FRONT;
        assert!(render(&scene, &cast).depth == both.depth, "round {round}: both sides");
        cast.faces = Faces::BACK;
        let back = render(&scene, &cast);
        let gaps = both.depth.iter().zip(&back.depth).filter(|(both, back)| both.is_finite() != back.is_finite());
        assert_eq!(gaps.count(), 0, "round {round}: silhouettes of fronts and backs");
    }
}

#[test]
fn invalid_targets_and_cameras_render_empty_images() {
    let light = ImageLighting::default();
    let nan = f64::NAN;
    let grid =
        Grid { columns: 31, rows: 17, projection: ImageProjection::Perspective { angle: 1.0 }, near: 0.1, far: 10.0 };
    let ahead = Isometry3::translation(0.0, 0.0, 2.0);
    let lost = Isometry3::translation(nan, 0.0, 2.0);
    let p = |x: f64, y: f64, z: f64| Point3::new(x, y, z);
    let bad = mesh(
        vec![p(0.0, 0.0, 0.0), p(1.0, 0.0, 0.0), p(2.0, 0.0, 0.0), p(nan, 1.0, 0.0), p(1e300, 1e300, 0.0)],
        vec![[0, 1, 2], [0, 1, 1], [0, 1, 3], [0, 1, 77], [4, 4, 4]],
    );
    let nothing = [
        target(1, lost, Form::Sphere { radius: 1.0 }),
        target(2, lost, Form::Plane),
        target(3, lost, Form::Box { half: Vector3::repeat(1.0) }),
        target(4, ahead, Form::Sphere { radius: nan }),
        target(5, ahead, Form::Box { half: Vector3::new(1.0, nan, 1.0) }),
        target(6, ahead, Form::Box { half: Vector3::zeros() }),
        target(7, ahead, Form::Sphere { radius: 0.0 }),
        target(8, ahead, Form::Cylinder { radius: 0.0, half_length: 0.0 }),
        target(9, ahead, Form::Capsule { radius: -1.0, half_length: 1.0 }),
        target(10, ahead, bad),
        target(11, ahead, mesh(Vec::new(), Vec::new())),
        target(12, Isometry3::translation(0.0, 0.0, -3.0), Form::Box { half: Vector3::repeat(1.0) }),
    ];
    for one in nothing {
        let image = render(&scene([one.clone()]), &cast_of(&grid, &light, Isometry3::identity()));
        assert!(image.depth.iter().all(|d| *d == f32::INFINITY), "{one:?}");
    }
    let full = scene([target(1, ahead, Form::Sphere { radius: 1.9 })]);
    let grids = [
        Grid { columns: 0, ..grid },
        Grid { rows: 0, ..grid },
        Grid { near: 5.0, far: 4.0, ..grid },
        Grid { near: nan, far: nan, ..grid },
        Grid { projection: ImageProjection::Perspective { angle: 0.0 }, ..grid },
        Grid { projection: ImageProjection::Perspective { angle: 3.2 }, ..grid },
        Grid { projection: ImageProjection::Orthographic { width: nan }, ..grid },
    ];
    for grid in &grids {
        let image = render(&full, &cast_of(grid, &light, Isometry3::identity()));
        assert!(image.depth.iter().all(|d| *d == f32::INFINITY), "{grid:?}");
    }
    let image = render(&full, &cast_of(&grid, &light, lost));
    assert!(image.depth.iter().all(|d| *d == f32::INFINITY));
    let endless = Grid { far: f64::INFINITY, near: 0.0, ..grid };
    let image = render(&full, &cast_of(&endless, &light, Isometry3::identity()));
    assert!(image.depth.iter().any(|d| d.is_finite()));
}

#[test]
fn image_of_ten_thousand_objects_matches_rays() {
    let light = ImageLighting::default();
    let mut dice = TestRng(5);
    let targets: Vec<BeamTarget> = (0..10_000)
        .map(|i| {
            let form = any_form(&mut dice, 0.1);
            target(i, dice.pose(20.0), form)
        })
        .collect();
    let scene = scene(targets);
    let grid = Grid {
        columns: 160,
        rows: 120,
        projection: ImageProjection::Perspective { angle: 1.0 },
        near: 0.1,
        far: 100.0,
    };
    let cast = cast_of(&grid, &light, Isometry3::identity());
    let image = render(&scene, &cast);
    let beside = compare(&scene, &cast, &image, "ten thousand");
    assert!((beside.depth + beside.surface) * 100 < image.depth.len(), "{beside:?}");
}

#[test]
fn colours_are_the_sum_of_the_lamps() {
    // A red wall, perpendicular to the axis and 2 m away: at the axis the cosine to the camera is 1, to the sun -sun.z.
    let grid =
        Grid { columns: 41, rows: 31, projection: ImageProjection::Perspective { angle: 1.0 }, near: 0.1, far: 10.0 };
    let turned = UnitQuaternion::from_axis_angle(&Vector3::x_axis(), std::f64::consts::PI);
    let pose = Isometry3::from_parts(Translation3::new(0.0, 0.0, 2.0), turned);
    let wall = Form::Box { half: Vector3::new(0.5, 0.5, 0.1) };
    let scene = scene([BeamTarget { color: [0.8, 0.1, 0.0], ..target(1, pose, wall) }]);
    let (ambient, headlight, sun) = (0.2, 0.3, 0.5);
    for (direction, facing) in [([0.6, 0.0, -0.8], 0.8), ([0.0, 0.6, 0.8], 0.0)] {
        let light = ImageLighting { ambient, headlight, sun, sun_direction: direction, sky: [0.0, 0.5, 1.0] };
        let image = render(&scene, &cast_of(&grid, &light, Isometry3::identity()));
        let sum = ambient + headlight + sun * facing;
        let wanted = [0.8 * sum, 0.1 * sum, 0.0].map(|x: f32| (x * 255.0 + 0.5) as u8);
        let middle = image.color[15 * 41 + 20];
        assert!(middle.iter().zip(wanted).all(|(a, b)| a.abs_diff(b) <= 1), "{middle:?} for {wanted:?}");
        let ours = shaded_color(&light, [0.8, 0.1, 0.0], &-Vector3::z(), &-Vector3::z(), 1.0);
        assert!(ours.iter().zip(wanted).all(|(a, b)| a.abs_diff(b) <= 1), "{ours:?} for {wanted:?}");
        assert_eq!(image.color[0], [0, 128, 255]);
        assert!(image.cosine[15 * 41 + 20] > 0.999_99 && image.cosine[0] == 0.0);
    }
}
