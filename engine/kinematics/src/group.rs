//! Groups of tasks that are solved together.

use serde::{Deserialize, Serialize};

use crate::task::IkTask;

/// The method by which an iteration computes the step of the joints (Buss 2009), for the Jacobian J and the error e.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub enum IkMethod {
    /// The step J⁺ e, with the pseudoinverse J⁺. Singular values below 1e-6 of the greatest one are treated as 0. Near
    /// singular configurations, steps can become very large.
    #[default]
    PseudoInverse,
    /// The step J' (J J' + d² I)⁻¹ e, with the damping d, which limits steps near singular configurations.
    DampedLeastSquares,
    /// The step a J' e, with the factor a that minimises the remaining error of the linearised problem.
    JacobianTranspose,
}

/// A group of tasks that are solved together, with the settings of the solver.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct IkGroup {
    /// The tasks.
    pub tasks: Vec<IkTask>,
    /// The method. Default: [`IkMethod::PseudoInverse`].
    pub method: IkMethod,
    /// Damping of [`IkMethod::DampedLeastSquares`], m or rad; other methods ignore it.
    pub damping: f64,
    /// Maximum number of iterations. Default 3.
    pub max_iterations: u32,
    /// Whether [`Joint::max_step`](crate::Joint::max_step) is ignored. Default `true`.
    pub ignores_max_steps: bool,
    /// Whether joints that reach a limit are held there within an iteration, while the other joints compensate for
    /// them. Otherwise, positions are clamped to their limits after the iteration. Default `false`.
    pub keeps_limits: bool,
    /// Whether the initial positions of the joints are restored if the distance to a target remains too large, and if
    /// the angle does.
    pub restores: [bool; 2],
    /// Whether the iterations end when a joint reaches a limit.
    pub stops_at_limits: bool,
    /// Whether the group is solved; a disabled group is skipped.
    pub enabled: bool,
}

impl Default for IkGroup {
    fn default() -> Self {
        IkGroup {
            tasks: Vec::new(),
            method: IkMethod::PseudoInverse,
            damping: 0.1,
            max_iterations: 3,
            ignores_max_steps: true,
            keeps_limits: false,
            restores: [false, false],
            stops_at_limits: false,
            enabled: true,
        }
    }
}
