//! Inverse kinematics of arms: the classic methods, and the solver that keeps limits.

#![allow(clippy::disallowed_methods, reason = "expected values in tests do not affect results")]

mod arms;
mod classic;
mod reach;
