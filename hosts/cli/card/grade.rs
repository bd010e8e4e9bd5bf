//! Grades how well a model is validated against its data sheet.

use tatu_core::plugins::ModelNumber;

use super::{Card, CardMeasure};

/// The grade of a model, derived from the sources of its parameters and from its card.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Grade {
    /// No parameter is an estimate, and all measures have recorded values within 2 % of the data sheet.
    A,
    /// Some parameters are estimates, according to their sources, or some measures deviate by more than 2 % or have no
    /// recorded value.
    B,
    /// Geometry only: the model has no card, or its card contains no measures.
    C,
}

/// Maximum relative deviation from the data sheet for grade A.
const MAX_GRADE_A_DEVIATION: f64 = 0.02;

impl Grade {
    /// Grades a model by its parameters and the card beside it.
    pub fn of(numbers: &[ModelNumber], card: Option<&Card>) -> Self {
        let Some(card) = card.filter(|c| !c.measures.is_empty()) else { return Grade::C };
        if card.measures.iter().all(is_close) && estimates(numbers) == 0 { Grade::A } else { Grade::B }
    }

    /// Returns the letter of the grade.
    pub fn letter(self) -> &'static str {
        match self {
            Grade::A => "A",
            Grade::B => "B",
            Grade::C => "C",
        }
    }

    /// Explains the grade of a model with these parameters.
    pub fn text(self, numbers: &[ModelNumber], card: Option<&Card>) -> String {
        let off = card.map_or(0, |c| c.measures.iter().filter(|m| !is_close(m)).count());
        let off = match off {
            0 => String::new(),
            1 => "; one measure is more than 2 % off".into(),
            n => format!("; {n} measures are more than 2 % off"),
        };
        match (self, estimates(numbers)) {
            (Grade::A, _) => "all values have sources, and all measures are within 2 % of the data sheet".into(),
            (Grade::B, 0) => format!("all values have sources{off}"),
            (Grade::B, 1) => format!("one value is an estimate, as its source states{off}"),
            (Grade::B, n) => format!("{n} values are estimates, as their sources state{off}"),
            (Grade::C, _) => "geometry only: the behaviour was not measured".into(),
        }
    }
}

/// Returns whether the recorded value of a measure agrees with the data sheet.
fn is_close(m: &CardMeasure) -> bool {
    // A relative deviation from 0 is undefined, so the measure's absolute tolerance applies.
    let allowed = if m.expected == 0.0 { m.allowed } else { MAX_GRADE_A_DEVIATION * m.expected.abs() };
    m.measured.is_some_and(|x| (x - m.expected).abs() <= allowed)
}

/// Returns the number of parameters that are estimates, according to their sources.
fn estimates(numbers: &[ModelNumber]) -> usize {
    numbers.iter().filter(|n| n.source.contains("estimate")).count()
}
