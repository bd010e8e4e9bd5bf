//! Tests of starting, stopping and restarting a world, through the Rust interface and with the built plugins.

use std::{path::Path, sync::Arc};

use tatu_core::{
    World, document,
    plugins::{Registry, SearchPath},
};

use crate::kit::*;

/// Loads the plugins that these tests need, whose libraries are next to the built program.
pub fn registry() -> Arc<Registry> {
    let names = [
        "tatu_commands_vrep",
        "tatu_commands_simui",
        "tatu_scripts_lua",
        "tatu_sensors_proximity",
        "tatu_models_folder",
        "tatu_importers_mesh",
    ];
    load_registry(SearchPath::standard(Some(program()), None, &names))
}

pub fn world(scene: &Path, registry: &Arc<Registry>) -> World {
    let document = document::load(scene, registry, &document::LoadOptions::default()).unwrap();
    World::new(Arc::new(document), registry.clone()).unwrap()
}

#[test]
fn a_second_run_repeats_the_first() {
    let registry = registry();
    let world = world(&root().join("scenes/first/pioneer_avoids_walls.toml"), &registry);
    let before = world.observe("/Pioneer_p3dx").unwrap();
    let mut hashes = Vec::new();
    for _ in 0..3 {
        world.start();
        for _ in 0..100 {
            world.step();
        }
        hashes.push(world.hash());
        assert_ne!(world.observe("/Pioneer_p3dx").unwrap().pose, before.pose);
        world.stop();
        assert_eq!(world.observe("/Pioneer_p3dx").unwrap(), before, "stopping must restore the initial state");
    }
    assert_eq!(hashes[0], hashes[1]);
    assert_eq!(hashes[0], hashes[2]);
    assert!(world.faults().is_empty(), "{:?}", world.faults());
}

#[test]
fn two_worlds_do_not_disturb_each_other() {
    let registry = registry();
    let scene = root().join("scenes/first/pioneer_avoids_walls.toml");
    let alone = world(&scene, &registry);
    alone.start();
    for _ in 0..60 {
        alone.step();
    }
    let (a, b) = (world(&scene, &registry), world(&scene, &registry));
    a.start();
    b.start();
    for i in 0..60 {
        a.step();
        if i % 2 == 0 {
            b.step();
        }
    }
    assert_eq!(a.hash(), alone.hash());
    for _ in 0..30 {
        b.step();
    }
    assert_eq!(b.hash(), alone.hash());
}

#[test]
fn a_hash_names_the_object_that_differs() {
    let registry = registry();
    let scene = root().join("scenes/first/pioneer_avoids_walls.toml");
    let (a, b) = (world(&scene, &registry), world(&scene, &registry));
    b.start();
    b.step();
    let (a, b) = (a.hash(), b.hash());
    assert_ne!(a.total, b.total);
    let differing: Vec<_> =
        a.objects.iter().zip(&b.objects).filter(|(x, y)| x != y).map(|(x, _)| x.0.as_str()).collect();
    assert!(differing.iter().all(|p| p.starts_with("/Pioneer_p3dx")), "{differing:?}");
    assert!(differing.contains(&"/Pioneer_p3dx/Pioneer_p3dx_leftMotor"), "{differing:?}");
}
