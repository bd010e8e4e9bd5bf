//! The solvers for the joints of a mechanism.

use serde::{Deserialize, Serialize};

use crate::property::words;

/// The solver for the joints of a mechanism, a property of its first shape.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[allow(missing_docs, reason = "the names are self-explanatory")]
pub enum JointSolver {
    #[default]
    Auto,
    Reduced,
    Impulse,
    Tree,
}

words! { JointSolver { Auto "auto", Reduced "reduced", Impulse "impulse", Tree "tree" } }
