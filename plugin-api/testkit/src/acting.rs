//! Actuators without a host: the crate's own type, its parameters and commands, and the motion of what it sits on.

use std::ptr::null;

use tatu_plugin_api::{
    abi::*,
    safe::{Actuator, Drive, Host, Instance, Output, Owned, Param, Params, Readout, Value, World},
};

use crate::Result;

/// The motion of the mount of an actuator, and when it acts. All may be left out, `..Motion::default()`: it rests at the
/// origin, and acts for 10 ms.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Motion {
    /// The mount in the world: x y z (m), quaternion x y z w.
    pub pose: [f64; 7],
    /// Its motion: m/s, then rad/s, world.
    pub twist: [f64; 6],
    /// Position and velocity of the joint that it sits on: rad or m.
    pub joint: [f64; 2],
    /// Simulated time, s.
    pub time: f64,
    /// How long the output acts, s.
    pub dt: f64,
}

impl Default for Motion {
    fn default() -> Self {
        Motion { pose: [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0], twist: [0.0; 6], joint: [0.0; 2], time: 0.0, dt: 0.01 }
    }
}

/// What an actuator did.
#[derive(Debug, Clone, PartialEq)]
pub struct Push {
    /// Force on the mount's origin, N, world.
    pub force: [f64; 3],
    /// Torque on the mount, N m, world.
    pub torque: [f64; 3],
    /// Torque N m or force N of the joint that it sits on.
    pub effort: f64,
    /// What it keeps between calls: `Actuator::STATE` numbers.
    pub state: Vec<f64>,
}

/// Makes an actuator with these parameters and commands (of the others the defaults) and lets it act once.
///
/// # Errors
/// A parameter or a command does not fit, or the actuator fails.
pub fn act<A: Actuator>(params: &[(&str, Value)], commands: &[(&str, f64)], motion: Motion) -> Result<Push> {
    ActuatorBench::<A>::new(params)?.act(commands, motion)
}

/// One actuator without a host, for several calls: what it keeps between them is kept.
pub struct ActuatorBench<A: Actuator> {
    actuator: A,
    state: Vec<f64>,
}

impl<A: Actuator> ActuatorBench<A> {
    /// Makes an actuator with these parameters, of the others the defaults.
    ///
    /// # Errors
    /// A parameter does not fit, or the actuator refuses it.
    pub fn new(params: &[(&str, Value)]) -> Result<Self> {
        let (declared, host) = (A::params(), Host::without_services());
        let values = Param::fill(&declared, params)?;
        let mut owned = Owned::default();
        let instance = Instance { owner: 1, id: 1, seed: 1 };
        let params = owned.values(&values);
        let actuator = A::create(&World::nowhere(&host), instance, &Params::new(&params, &declared))?;
        Ok(ActuatorBench { actuator, state: vec![0.0; A::STATE] })
    }

    /// The actuator itself.
    pub fn actuator(&self) -> &A {
        &self.actuator
    }

    /// Lets it act with these commands, of the others the defaults.
    ///
    /// # Errors
    /// A command does not fit, or the actuator fails.
    pub fn act(&mut self, commands: &[(&str, f64)], motion: Motion) -> Result<Push> {
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
        };
        // SAFETY: a batch of one, whose arrays live until the end of this function; outputs and state do not go through it.
        let drive = unsafe { Drive::new(&batch, &commands, 0) };
        let mut out =
            Output { force: [0.0; 3], torque: [0.0; 3], effort: 0.0, state: &mut self.state, report: Readout::none() };
        self.actuator.apply(&drive, &mut out)?;
        let (force, torque, effort) = (out.force, out.torque, out.effort);
        Ok(Push { force, torque, effort, state: self.state.clone() })
    }
}
