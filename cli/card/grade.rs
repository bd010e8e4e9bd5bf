//! How far a model can be relied on.

use tatu_core::plugins::ModelNumber;

use super::{Card, Measure};

/// The grade of a model, from its numbers and its card.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Grade {
    /// All numbers have sources, and all measures are within 2 % of the sheet.
    A,
    /// Some numbers are estimates, which say so, or some measures are farther off.
    B,
    /// Geometry: nothing of what it does was measured.
    C,
}

/// Relative difference up to which a measure is that of the sheet.
const CLOSE: f64 = 0.02;

impl Grade {
    /// Grades a model by its numbers and the card beside it.
    pub fn of(numbers: &[ModelNumber], card: Option<&Card>) -> Self {
        let Some(card) = card.filter(|c| !c.measures.is_empty()) else { return Grade::C };
        if card.measures.iter().all(is_close) && estimates(numbers) == 0 { Grade::A } else { Grade::B }
    }

    /// Returns the letter.
    pub fn letter(self) -> &'static str {
        match self {
            Grade::A => "A",
            Grade::B => "B",
            Grade::C => "C",
        }
    }

    /// Returns what the grade means for a model with these numbers.
    pub fn text(self, numbers: &[ModelNumber], card: Option<&Card>) -> String {
        let off = card.map_or(0, |c| c.measures.iter().filter(|m| !is_close(m)).count());
        let off = match off {
            0 => String::new(),
            1 => "; one measure is more than 2 % off".into(),
            n => format!("; {n} measures are more than 2 % off"),
        };
        match (self, estimates(numbers)) {
            (Grade::A, _) => "all numbers have sources, and what it does is within 2 % of them".into(),
            (Grade::B, 0) => format!("all numbers have sources{off}"),
            (Grade::B, 1) => format!("one number is an estimate, which its source names{off}"),
            (Grade::B, n) => format!("{n} numbers are estimates, which their sources name{off}"),
            (Grade::C, _) => "geometry: nothing of what it does was measured".into(),
        }
    }
}

/// Returns whether a measure is that of the sheet.
fn is_close(m: &Measure) -> bool {
    // What should be nothing has no relative difference: it is close if it holds.
    let allowed = if m.expected == 0.0 { m.allowed } else { CLOSE * m.expected.abs() };
    m.measured.is_some_and(|x| (x - m.expected).abs() <= allowed)
}

/// Returns how many numbers are estimates.
fn estimates(numbers: &[ModelNumber]) -> usize {
    numbers.iter().filter(|n| n.source.contains("estimate")).count()
}
