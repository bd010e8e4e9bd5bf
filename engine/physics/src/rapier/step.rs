//! A physics step, phase by phase.
//!
//! ```text
//! arrange    kinematic bodies start to move; trees adopt what they touch, and mechanisms follow changes from outside
//! drive      controllers compute the velocities that drives command; parked mechanisms may sleep
//! push       forces from outside, efforts carried over from the last step, the first half of gyroscopic motion
//! prepare    velocities and momenta are recorded; couplings, separation and friction of this step's contacts
//! solve      rapier finds contacts and moves its bodies, unless only trees move; then trees move theirs
//! finish     loads of joints are measured, the second half of gyroscopic motion, forces are restored
//! ```
//!
//! Scripts and actuators add forces before `push`, when drives are known.

use super::{Rapier, contacts::PairFilter, state::EngineState};
use crate::{BeforeStepHook, BodyWrench};

impl Rapier {
    /// Runs the step with index `step` of the `steps` steps of an advance.
    pub(super) fn run_step(&mut self, step: u32, steps: u32, before: Option<&mut BeforeStepHook<'_>>) {
        self.state.arrange(f64::from(step + 1) / f64::from(steps));
        self.state.drive();
        let mut pushes = Vec::new();
        if let Some(before) = before {
            before(&*self, step, &mut pushes);
        }
        self.state.push(&pushes);
        self.state.prepare();
        self.state.solve();
        self.state.finish();
        if step + 1 == steps {
            self.state.end_advance();
        }
    }
}

impl EngineState {
    /// `done` is the fraction of the advance that is complete after this step.
    fn arrange(&mut self, done: f64) {
        let EngineState { bodies, contacts, joints, forms } = self;
        bodies.move_kinematic(done);
        if !contacts.fresh.is_empty() || bodies.backlog.skipped && bodies.any_free() {
            bodies.place_colliders();
        }
        forms.trees.update_adoptions(bodies, contacts, joints, &mut forms.reduced);
        forms.before_step(bodies, joints);
    }

    fn drive(&mut self) {
        let EngineState { bodies, joints, forms, .. } = self;
        joints.count_turns(bodies);
        joints.update_position_drives(bodies);
        joints.park(bodies);
        joints.weaken_drives(bodies);
        forms.pass_drives(bodies, joints);
    }

    fn push(&mut self, pushes: &[BodyWrench]) {
        let EngineState { bodies, joints, forms, .. } = self;
        bodies.push_for_step(pushes);
        forms.reduced.add_carried_effort(bodies, joints);
        bodies.begin_spin();
    }

    fn prepare(&mut self) {
        let EngineState { bodies, contacts, joints, forms } = self;
        bodies.record_velocities();
        bodies.choose_substeps();
        contacts.find_overlaps(bodies, || joints.mechanism_roots());
        joints.record_momenta(bodies);
        forms.reduced.update_gears(bodies, joints);
        contacts.update_surface_friction(bodies);
    }

    fn solve(&mut self) {
        let EngineState { bodies, contacts, joints, forms } = self;
        bodies.backlog.skipped = forms.trees.detect_alone(bodies, contacts);
        if !bodies.backlog.skipped {
            let filter = PairFilter::new(contacts, bodies);
            bodies.world.step_with_events(&filter, &());
            contacts.update_separations(bodies);
            bodies.collect_frozen();
            bodies.backlog.removed = false;
        }
        forms.after_step(bodies, joints);
    }

    fn finish(&mut self) {
        let EngineState { bodies, joints, forms, .. } = self;
        joints.measure_loads(bodies, &forms.trees.touches);
        bodies.finish_spin();
        bodies.restore_forces();
    }

    /// Ends an advance of several steps: its forces and motions no longer act.
    fn end_advance(&mut self) {
        self.bodies.keep_floating_bodies_awake();
        self.bodies.moving.clear();
        self.bodies.clear_forces();
    }
}
