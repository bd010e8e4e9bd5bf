//! Tasks that are solved together.

use serde::{Deserialize, Serialize};

use crate::task::IkTask;

/// How an iteration moves the joints (Buss 2009).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub enum IkMethod {
    /// J⁺ e. Singular values below 1e-6 of the greatest one count as 0. Steps grow without bound near singular positions.
    #[default]
    PseudoInverse,
    /// J' (J J' + d² I)⁻¹ e with the damping d.
    DampedLeastSquares,
    /// a J' e, with the factor a for which the error becomes smallest.
    JacobianTranspose,
}

/// Tasks that are solved together, and how.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct IkGroup {
    /// The tasks.
    pub tasks: Vec<IkTask>,
    /// The method. Default: [`IkMethod::PseudoInverse`].
    pub method: IkMethod,
    /// Damping of damped least squares, m or rad.
    pub damping: f64,
    /// Maximum number of iterations. Default 3.
    pub max_iterations: u32,
    /// Whether [`Joint::max_step`](crate::Joint::max_step) is ignored. Default `true`.
    pub ignores_max_steps: bool,
    /// Whether joints keep their limits within each iteration, in which the others make up for them; otherwise, positions
    /// are clamped after it. Default `false`.
    pub keeps_limits: bool,
    /// Whether the joints return to their positions if the distance remains too large, and if the angle does.
    pub restores: [bool; 2],
    /// Whether the iterations end when a joint reaches a limit.
    pub stops_at_limits: bool,
    /// Whether the group is solved.
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
