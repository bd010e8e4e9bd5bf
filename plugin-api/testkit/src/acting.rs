//! Runs actuators without a host, with parameters, commands and a motion of the mount that the test specifies.

use std::ptr::null;

use tatu_plugin_api::{
    abi::*,
    safe::{Actuator, Drive, Host, Instance, Output, Owned, Param, Params, Readout, Target, Value, World},
};

use crate::{Error, Result, targets::TargetLists};

/// The motion of an actuator's mount, the simulation time, and the duration of the output. By default the mount is at
/// rest at the origin, and the output acts for 10 ms.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Motion {
    /// Pose of the mount in the world: x y z (m), quaternion x y z w.
    pub pose: [f64; 7],
    /// Linear (m/s), then angular velocity (rad/s) of the mount, world frame.
    pub twist: [f64; 6],
    /// Position (rad or m) and velocity of the joint that the actuator acts on.
    pub joint: [f64; 2],
    /// Simulation time, s.
    pub time: f64,
    /// Duration for which the output acts, s.
    pub dt: f64,
}

impl Default for Motion {
    fn default() -> Self {
        Motion { pose: [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0], twist: [0.0; 6], joint: [0.0; 2], time: 0.0, dt: 0.01 }
    }
}

/// What is around an actuator: its targets, and the contacts of its mount. By default there are none.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Surroundings {
    /// The targets; `None` stands for an object that does not exist.
    pub targets: Vec<Option<Target>>,
    /// Contacts of the shape on which the wrench acts, which is the second shape of each contact.
    pub contacts: Vec<tatu_contact>,
    /// Per contact: friction on that shape, N, world frame; if empty, there is no friction.
    pub frictions: Vec<[f64; 3]>,
}

/// The output of an actuator for one call.
#[derive(Debug, Clone, PartialEq)]
pub struct Push {
    /// Force on the mount's origin, N, world frame.
    pub force: [f64; 3],
    /// Torque on the mount, N m, world frame.
    pub torque: [f64; 3],
    /// Torque (N m) or force (N) added to that of the joint that the actuator acts on.
    pub effort: f64,
    /// The state after the call, `Actuator::STATE` values.
    pub state: Vec<f64>,
    /// For each target, the force (N) at its origin and the torque (N m), world frame.
    pub target_wrenches: Vec<[f64; 6]>,
}

/// Creates an actuator with these parameters, and calls it once with these commands. All other parameters and commands
/// have their defaults.
///
/// # Errors
/// Fails if a parameter or a command does not fit its declaration, or the actuator fails.
pub fn act<A: Actuator>(params: &[(&str, Value)], commands: &[(&str, f64)], motion: Motion) -> Result<Push> {
    ActuatorBench::<A>::new(params)?.act(commands, motion)
}

/// An actuator without a host, for a sequence of calls between which its state is retained.
pub struct ActuatorBench<A: Actuator> {
    actuator: A,
    state: Vec<f64>,
}

impl<A: Actuator> ActuatorBench<A> {
    /// Creates an actuator with these parameters; all others have their defaults.
    ///
    /// # Errors
    /// Fails if a parameter does not fit its declaration, or the actuator rejects it.
    pub fn new(params: &[(&str, Value)]) -> Result<Self> {
        let (declared, host) = (A::params(), Host::without_services());
        let values = Param::fill(&declared, params)?;
        let mut owned = Owned::default();
        let instance = Instance { owner: 1, id: 1, seed: 1 };
        let params = owned.values(&values);
        let actuator = A::create(&World::nowhere(&host), instance, &Params::new(&params, &declared))?;
        Ok(ActuatorBench { actuator, state: vec![0.0; A::STATE] })
    }

    /// Returns the actuator.
    pub fn actuator(&self) -> &A {
        &self.actuator
    }

    /// Calls the actuator once with these commands; all others have their defaults.
    ///
    /// # Errors
    /// Fails if a command does not fit its declaration, or the actuator fails.
    pub fn act(&mut self, commands: &[(&str, f64)], motion: Motion) -> Result<Push> {
        self.act_among(commands, motion, Surroundings::default())
    }

    /// Like [`ActuatorBench::act`], with these targets and contacts.
    ///
    /// # Errors
    /// Fails like [`ActuatorBench::act`], or if the kind does not receive these inputs.
    pub fn act_among(&mut self, commands: &[(&str, f64)], motion: Motion, around: Surroundings) -> Result<Push> {
        let Surroundings { targets, contacts, mut frictions } = around;
        let declared = |input: u32| A::INPUTS & input != 0;
        if !declared(TATU_IN_TARGETS) && !targets.is_empty() || !declared(TATU_IN_CONTACTS) && !contacts.is_empty() {
            return Err(Error::new("the actuator receives no targets or contacts, unless its INPUTS declare them"));
        }
        frictions.resize(contacts.len(), [0.0; 3]);
        let lists = TargetLists::of([&targets[..]]);
        let ends = [0, contacts.len() as u64];
        let mut target_wrenches = vec![[0.0; 6]; targets.len()];
        let given: Vec<(&str, Value)> = commands.iter().map(|(key, x)| (*key, Value::Float(*x))).collect();
        let values = Param::fill(&A::commands(), &given)?;
        let number = |v: &Value| if let Value::Float(x) = v { *x } else { 0.0 };
        let commands: Vec<f64> = values.iter().map(number).collect();
        let (ids, command): ([tatu_object; 1], [*const f64; 1]) = ([1], [commands.as_ptr()]);
        let batch = tatu_actuator_batch {
            size: size_of::<tatu_actuator_batch>() as u32,
            n: 1,
            time: motion.time,
            dt: motion.dt,
            data: null(),
            state: null(),
            actuator: ids.as_ptr(),
            pose: motion.pose.as_ptr(),
            twist: motion.twist.as_ptr(),
            joint: motion.joint.as_ptr(),
            command: command.as_ptr(),
            wrench: std::ptr::null_mut(),
            effort: std::ptr::null_mut(),
            status: std::ptr::null_mut(),
            fields: null(),
            lengths: null(),
            n_fields: 0,
            reserved: 0,
            first_target: if declared(TATU_IN_TARGETS) { lists.first.as_ptr() } else { null() },
            target: lists.object.as_ptr(),
            target_pose: lists.pose.as_ptr().cast(),
            target_twist: lists.twist.as_ptr().cast(),
            target_wrench: std::ptr::null_mut(),
            first_contact: if declared(TATU_IN_CONTACTS) { ends.as_ptr() } else { null() },
            contact: contacts.as_ptr(),
            friction: frictions.as_ptr().cast(),
        };
        // SAFETY: the batch has one instance, and its arrays live until the end of this function. Its null pointers for
        // outputs and state are not read by `Drive`.
        let drive = unsafe { Drive::new(&batch, &commands, 0) };
        let mut out = Output {
            force: [0.0; 3],
            torque: [0.0; 3],
            effort: 0.0,
            state: &mut self.state,
            target_wrenches: &mut target_wrenches,
            report: Readout::none(),
        };
        self.actuator.apply(&drive, &mut out)?;
        let (force, torque, effort) = (out.force, out.torque, out.effort);
        Ok(Push { force, torque, effort, state: self.state.clone(), target_wrenches })
    }
}
