//! Prints the mass, centre of mass and inertia of a wedge, as a solid of aluminium and as a shell of sheet metal.
//!
//! Run it with `cargo run -p tatu-geometry --example moments`.

use nalgebra::Point3;
use tatu_geometry::{Mesh, Moments};

/// Returns a wedge: a box of 0.3 x 0.2 x 0.1 m, cut along a diagonal of its sides.
fn wedge() -> Mesh {
    let corners =
        [[0.0, 0.0, 0.0], [0.3, 0.0, 0.0], [0.0, 0.0, 0.1], [0.0, 0.2, 0.0], [0.3, 0.2, 0.0], [0.0, 0.2, 0.1]];
    Mesh {
        vertices: corners.map(Point3::from).to_vec(),
        triangles: vec![[0, 1, 2], [3, 5, 4], [0, 3, 4], [0, 4, 1], [0, 2, 5], [0, 5, 3], [1, 4, 5], [1, 5, 2]],
        ..Mesh::default()
    }
}

fn print(name: &str, moments: Option<Moments>, density: f64) {
    let Some(Moments { measure, centre, inertia }) = moments else { return println!("{name}: no volume") };
    let about = (inertia * density).diagonal();
    println!("{name:6} {:.3} kg, centre {:.3} {:.3} {:.3} m,", measure * density, centre.x, centre.y, centre.z);
    println!("       inertia about x, y and z {:.2e} {:.2e} {:.2e} kg m^2", about.x, about.y, about.z);
}

fn main() {
    let wedge = wedge();
    println!("open edges: {}", wedge.open_edges());
    print("solid", wedge.moments(), 2700.0);
    // Sheet metal of 1 mm has 2.7 kg per square metre.
    print("shell", wedge.surface_moments(), 2.7);
}
