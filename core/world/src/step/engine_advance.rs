//! Advances the engine together with actuators, and with sensors that measure after each physics step.

use tatu_devices::{
    actuators::{self, ActuatorContext, ApplyFailure},
    sense::{MeasureFailure, MeasureTime, StepContext, StepSensing},
};
use tatu_physics::{BodyWrench, Engine};
use tatu_plugins::thread_grant::ThreadGrant;
use tatu_scene::{Scene, StepHooks};

use crate::cell::WorldCell;

/// The results of an advance.
#[derive(Default)]
pub(super) struct AdvanceResult {
    /// Objects whose bodies the engine lost because their motion became infinite.
    pub lost: Vec<u32>,
    /// Actuators that failed or have no effect.
    pub actuators: Vec<ApplyFailure>,
    /// Sensors that failed.
    pub sensors: Vec<MeasureFailure>,
}

/// The devices that are called between two engine steps.
struct PhysicsStepDevices<'a> {
    actuators: Option<actuators::PhysicsStepActuators<'a>>,
    sensors: Option<StepSensing<'a>>,
}

/// Advances physics by `dt`, or, if `part` is given, only by the engine step with this index among those that make up
/// `dt`.
pub(super) fn advance(world: &WorldCell, dt: f64, part: Option<u32>) -> AdvanceResult {
    let (mut scene, mut dynamics) = (world.state.scene.borrow_mut(), world.state.dynamics.borrow_mut());
    let (mut actuators, mut sensing) = (world.devices.actuators.borrow_mut(), world.devices.sensing.borrow_mut());
    let (scene, dynamics, actuators) = (&mut *scene, &mut *dynamics, &mut *actuators);
    let registry = &world.model.registry;
    sensing.apply_settings(scene, registry);
    let any_acts = actuators.parts().len() < actuators.devices.len();
    if dt <= 0.0 || (!any_acts && !sensing.in_physics(registry)) {
        let lost = match part {
            Some(part) => world.run.install(|| dynamics.advance_part(scene, dt, part, StepHooks::default())),
            None => {
                dynamics.update_bodies(scene);
                world.run.install(|| dynamics.advance(scene, dt, StepHooks::default()))
            }
        };
        return AdvanceResult { lost, ..AdvanceResult::default() };
    }
    if part.is_none() {
        dynamics.prepare(scene);
    }
    let called = actuators.devices.iter().filter(|d| d.part.is_none()).map(|d| registry.actuators[d.kind].plugin);
    let measured = sensing.devices.iter().map(|d| &registry.sensors[d.kind]).filter(|k| k.in_physics());
    world.monitor.note_called(called.chain(measured.map(|k| k.plugin)));
    let (watch, scene_now): (_, &Scene) = (&*world.monitor.watch, scene);
    // The velocity is requested only for devices that are not attached to a body.
    let twist = |slot: u32| world.state.twist_by_motion(scene_now, slot);
    let time = world.state.clock.time.get() + world.state.clock.elapsed_in_step();
    let acts = ActuatorContext { scene: scene_now, registry, twist: &twist, time, watch };
    let mut failed = match part {
        None | Some(0) => actuators::apply_per_advance(actuators, dynamics, &acts, dt),
        Some(_) => Vec::new(),
    };
    let physics_dt = dt / f64::from(dynamics.engine_steps(dt).max(1));
    let gravity = dynamics.settings().gravity.into();
    let moment = MeasureTime { time, step: world.state.clock.step.get(), dt: physics_dt, gravity };
    let around = StepContext { registry, watch, pool: world.run.pool(), moment };
    let mut between = PhysicsStepDevices {
        actuators: actuators::PhysicsStepActuators::new(actuators, (registry, watch), dynamics, &acts, dt),
        sensors: StepSensing::new(&mut sensing, scene_now, dynamics, around, twist),
    };
    // SAFETY: the header declares `apply` and `measure` as `[parallel]`, so they may run on another thread; this thread
    // waits until the pool's thread is done, so nothing is shared.
    let mut granted = unsafe { ThreadGrant::new(&mut between) };
    let lost = world.run.install(|| {
        let PhysicsStepDevices { actuators, sensors } = &mut **granted.get();
        let mut push = actuators.as_mut().map(|a| {
            move |engine: &dyn Engine, step: u32, out: &mut Vec<BodyWrench>| a.apply_before_step(engine, step, out)
        });
        let mut sense =
            sensors.as_mut().map(|s| move |engine: &dyn Engine, step: u32| s.measure_after_step(engine, step));
        let hooks = StepHooks {
            before: push.as_mut().map(|f| f as &mut tatu_physics::BeforeStepHook<'_>),
            after: sense.as_mut().map(|f| f as &mut tatu_scene::AfterStep<'_>),
        };
        match part {
            Some(part) => dynamics.advance_part(scene, dt, part, hooks),
            None => dynamics.advance(scene, dt, hooks),
        }
    });
    failed.extend(between.actuators.into_iter().flat_map(|a| a.failed));
    let sensors = between.sensors.map(|s| s.failed).unwrap_or_default();
    actuators.publish(&mut sensing);
    AdvanceResult { lost, actuators: failed, sensors }
}
