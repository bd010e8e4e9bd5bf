//! Scans a room with rays in a plane and prints the distances.
//!
//! Run it with `cargo run -p tatu-beams --example scan`.

use nalgebra::{Isometry3, UnitQuaternion, Vector3};
use tatu_beams::{Beam, BeamScene, BeamTarget, Hit};
use tatu_geometry::Form;

fn target(object: u64, place: [f64; 3], form: Form) -> BeamTarget {
    BeamTarget {
        object,
        group: 0,
        world_from_target: Isometry3::translation(place[0], place[1], place[2]),
        form,
        color: [0.7; 3],
        opacity: 1.0,
        texture: None,
    }
}

fn main() {
    let wall = |x: f64, y: f64| Form::Box { half: Vector3::new(x, y, 1.0) };
    let mut scene = BeamScene::default();
    scene.set([
        target(1, [4.0, 0.0, 1.0], wall(0.1, 3.0)),
        target(2, [-4.0, 0.0, 1.0], wall(0.1, 3.0)),
        target(3, [0.0, 3.0, 1.0], wall(4.0, 0.1)),
        target(4, [0.0, -3.0, 1.0], wall(4.0, 0.1)),
        target(5, [1.5, 1.0, 1.0], Form::Cylinder { radius: 0.3, half_length: 1.0 }),
    ]);
    // A beam points along z of its frame, so z is turned to the horizontal first.
    let beams: Vec<Beam> = (0..36)
        .map(|i| {
            let heading = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), f64::from(i * 10).to_radians());
            let forward = UnitQuaternion::from_axis_angle(&Vector3::y_axis(), std::f64::consts::FRAC_PI_2);
            Beam::ray(Isometry3::from_parts(Vector3::new(0.0, 0.0, 0.5).into(), heading * forward), 10.0)
        })
        .collect();
    let mut hits = vec![Hit::NONE; beams.len()];
    scene.cast(&beams, &mut hits);
    for (i, hit) in hits.iter().enumerate() {
        let bar = "#".repeat((hit.distance * 10.0) as usize);
        println!("{:4} deg  {:.3} m  object {}  {bar}", i * 10, hit.distance, hit.object);
    }
}
