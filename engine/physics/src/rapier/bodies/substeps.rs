//! The number and the length of the sub-steps of a physics step.

use super::table::Bodies;
use crate::rapier::tuning::{HALVED_SUBSTEPS_TIME_S, MAX_SUBSTEP_MOTION, REST_SPEED_SHARE, REST_TIME_S};

impl Bodies {
    /// Returns the length of rapier's sub-steps, s, over which the impulses that it reports act.
    pub fn substep(&self) -> f64 {
        let numbers = &self.world.integration_parameters;
        numbers.dt / numbers.num_solver_iterations as f64
    }

    /// Returns the length of a sub-step of an ordinary step, s, which is also that of trees.
    pub fn usual_substep(&self) -> f64 {
        self.world.integration_parameters.dt / self.substeps.usual as f64
    }

    /// Doubles the number of sub-steps while a mechanism swings so fast that it would gain or lose energy: the energy
    /// of a double pendulum that falls from horizontal then changes by 2 % instead of 10 %. The number remains doubled
    /// for a while or until the mechanism has come to rest, because each change of the sub-step also costs energy: a
    /// pendulum with changes in each swing would lose 10 % in 100 s.
    pub fn choose_substeps(&mut self) {
        let (usual, dt) = (self.substeps.usual, self.world.integration_parameters.dt);
        let fastest = MAX_SUBSTEP_MOTION * usual as f64 / dt;
        self.substeps.fast_s = (self.substeps.fast_s - dt).max(0.0);
        let speeds = self.world.multibody_joints.multibodies().map(|m| m.generalized_velocity().amax());
        let most = speeds.fold(0.0, f64::max);
        if most > fastest {
            self.substeps.fast_s = HALVED_SUBSTEPS_TIME_S;
        }
        self.substeps.calm_s = if most < REST_SPEED_SHARE * fastest { self.substeps.calm_s + dt } else { 0.0 };
        if self.substeps.calm_s > REST_TIME_S {
            self.substeps.fast_s = 0.0;
        }
        let fast = self.substeps.fast_s > 0.0;
        self.world.integration_parameters.num_solver_iterations = if fast { 2 * usual } else { usual };
    }
}
