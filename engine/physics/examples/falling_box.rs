//! A box falls on a floor and comes to rest. Prints its height, and at the end the forces with which the floor carries
//! it.
//!
//! Run it with `cargo run -p tatu-physics --example falling_box`.

use nalgebra::{Isometry3, Matrix3, Point3, Vector3};
use tatu_geometry::{Form, SolidPart};
use tatu_physics::{BodyDesc, Engine, EngineSettings, MassProps, Rapier};

fn main() {
    let mut engine = Rapier::new(EngineSettings::default());
    engine.add_body(&BodyDesc::fixed(Isometry3::identity(), vec![SolidPart::from(Form::Plane)]));
    // A cube of 0.2 m and 2 kg, 1 m above the floor and slightly tilted.
    let (mass, size) = (2.0, 0.2);
    let inertia = Matrix3::identity() * (mass * size * size / 6.0);
    let cube = SolidPart::from(Form::Box { half: Vector3::repeat(size / 2.0) });
    let pose = Isometry3::new(Vector3::new(0.0, 0.0, 1.1), Vector3::new(0.1, 0.2, 0.0));
    let mass = MassProps { mass, com: Point3::origin(), inertia };
    let cube = engine.add_body(&BodyDesc { restitution: 0.3, ..BodyDesc::dynamic(pose, mass, vec![cube]) });

    println!("time     height   speed");
    for tenth in 0..=20 {
        let (pose, speed) = (engine.pose(cube), engine.twist(cube).linear.norm());
        println!("{:.1} s  {:7.4} m {speed:6.3} m/s", f64::from(tenth) * 0.1, pose.translation.z);
        // 20 physics steps of 5 ms.
        engine.advance(20);
    }
    let mut contacts = Vec::new();
    engine.contacts(&mut contacts);
    for contact in contacts {
        let [x, y] = [contact.point.x, contact.point.y];
        println!("the floor carries {:.2} N at ({x:.3}, {y:.3}) m", contact.force);
    }
}
