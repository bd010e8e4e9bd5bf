//! Mass and surface properties of shapes, as passed to the engine.

use std::collections::BTreeSet;

use nalgebra::Point3;
use tatu_physics::{ContactSurface, MassProps, MaterialPair};

use crate::{
    document::FrictionPair,
    mass_properties::{centre_of_mass, inertia, mass},
    object::Shape,
    tree::Scene,
};

/// Returns the materials of the scene's friction pairs, sorted by name. The number of a material in the engine is its
/// position in this order, from 1.
fn material_names(scene: &Scene) -> BTreeSet<&str> {
    scene.friction_pairs.iter().flat_map(|p| p.materials.iter().map(String::as_str)).collect()
}

fn material(scene: &Scene, name: &str) -> u32 {
    material_names(scene).iter().position(|n| *n == name).map_or(0, |i| i as u32 + 1)
}

pub(super) fn materials(scene: &Scene) -> Vec<MaterialPair> {
    let number = |name: &str| material(scene, name);
    let pair = |p: &FrictionPair| MaterialPair {
        materials: (number(&p.materials[0]), number(&p.materials[1])),
        friction: p.friction,
        restitution: p.restitution,
    };
    scene.friction_pairs.iter().map(pair).collect()
}

pub(super) fn surface(scene: &Scene, shape: &Shape) -> ContactSurface {
    ContactSurface { material: material(scene, &shape.material), ..shape.surface }
}

/// Returns the mass properties of a shape, with defaults filled in.
pub fn mass_props(shape: &Shape) -> MassProps {
    MassProps { mass: mass(shape), com: Point3::from(centre_of_mass(shape)), inertia: inertia(shape) }
}
