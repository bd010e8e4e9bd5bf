//! Physics with actuators.

use tatu_devices::actuators;
use tatu_plugins::thread_grant::ThreadGrant;
use tatu_scene::{Dynamics, Scene};

use crate::cell::WorldCell;

/// Advances physics by `dt`. Returns objects whose bodies were lost, and actuators that failed.
pub(super) fn advance(
    world: &WorldCell,
    scene: &mut Scene,
    dynamics: &mut Dynamics,
    actuators: &mut actuators::Actuators,
    dt: f64,
) -> (Vec<u32>, Vec<actuators::ApplyFailure>) {
    dynamics.prepare(scene);
    world.border.note_called(actuators.devices.iter().map(|d| world.model.registry.actuators[d.kind].plugin));
    // This is called only for actuators that no body carries.
    let scene_now: &Scene = scene;
    let twist = |slot: u32| world.state.twist_by_motion(scene_now, slot);
    let time = world.state.clock.time.get() + world.state.clock.so_far();
    let around = actuators::Acts {
        scene: scene_now,
        registry: &world.model.registry,
        twist: &twist,
        time,
        watch: &world.border.watch,
    };
    let mut failed = actuators::per_step(actuators, dynamics, &around, dt);
    let lost = match actuators::SubSteps::new(
        actuators,
        (&world.model.registry, &world.border.watch),
        dynamics,
        &around,
        dt,
    ) {
        None => world.run.install(|| dynamics.advance(scene, dt, None)),
        Some(mut substeps) => {
            // SAFETY: the header declares `apply` as `[parallel]`, so it may run on another thread; this thread waits
            // until the pool's thread is done, so nothing is shared.
            let mut granted = unsafe { ThreadGrant::new(&mut substeps) };
            let lost = world.run.install(|| {
                let substeps = granted.get();
                dynamics.advance(scene, dt, Some(&mut |engine, step, out| substeps.before(engine, step, out)))
            });
            failed.append(&mut substeps.failed);
            lost
        }
    };
    (lost, failed)
}

/// Like `advance`, but for one step of the engine: the `part`-th, from 0.
pub(super) fn advance_part(world: &WorldCell, dt: f64, part: u32) -> (Vec<u32>, Vec<actuators::ApplyFailure>) {
    let (mut scene, mut dynamics, mut actuators) =
        (world.state.scene.borrow_mut(), world.state.dynamics.borrow_mut(), world.devices.actuators.borrow_mut());
    let (scene, dynamics, actuators) = (&mut *scene, &mut *dynamics, &mut *actuators);
    if actuators.devices.is_empty() {
        return (world.run.install(|| dynamics.advance_part(scene, dt, part, None)), Vec::new());
    }
    world.border.note_called(actuators.devices.iter().map(|d| world.model.registry.actuators[d.kind].plugin));
    let scene_now: &Scene = scene;
    let twist = |slot: u32| world.state.twist_by_motion(scene_now, slot);
    let time = world.state.clock.time.get() + world.state.clock.so_far();
    let around = actuators::Acts {
        scene: scene_now,
        registry: &world.model.registry,
        twist: &twist,
        time,
        watch: &world.border.watch,
    };
    let mut failed = if part == 0 { actuators::per_step(actuators, dynamics, &around, dt) } else { Vec::new() };
    let lost = match actuators::SubSteps::new(
        actuators,
        (&world.model.registry, &world.border.watch),
        dynamics,
        &around,
        dt,
    ) {
        None => world.run.install(|| dynamics.advance_part(scene, dt, part, None)),
        Some(mut substeps) => {
            // SAFETY: the header declares `apply` as `[parallel]`, so it may run on another thread; this thread waits
            // until the pool's thread is done, so nothing is shared.
            let mut granted = unsafe { ThreadGrant::new(&mut substeps) };
            let lost = world.run.install(|| {
                let substeps = granted.get();
                let ask = &mut |engine: &dyn tatu_physics::Engine, step, out: &mut Vec<_>| {
                    substeps.before(engine, step, out);
                };
                dynamics.advance_part(scene, dt, part, Some(ask))
            });
            failed.append(&mut substeps.failed);
            lost
        }
    };
    (lost, failed)
}
