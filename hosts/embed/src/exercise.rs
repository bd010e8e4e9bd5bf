//! Exercises and tests: the goals that a scene's referee decides. A referee is a script that the examined scripts can
//! neither see nor affect; it reports its goals by the event [`GOALS_EVENT`].

use serde::Serialize;
use tatu_core::{
    World,
    document::{Document, ObjectSpec, REFEREE_KIND},
};
use tatu_plugin_api::safe::Value;

/// The event by which a referee reports its goals.
pub const GOALS_EVENT: &str = "exercise.goals";
/// The tag of the custom data that contains the goals of an exercise.
const GOALS_TAG: &[u8] = b"exercise.goals";
/// The property with the custom data of an object.
const DATA_PROPERTY: &str = "object.data";

/// A goal at the end of a run.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Goal {
    /// What people are shown.
    pub text: String,
    /// "reached", "failed" or, if the run was interrupted, "open".
    pub state: String,
    /// Simulation time at which it was decided, s; -1 if it is open.
    pub time: f64,
    /// Points for reaching it.
    pub points: f64,
}

impl Goal {
    /// Returns whether the goal is reached.
    pub fn is_reached(&self) -> bool {
        self.state == "reached"
    }

    fn parse(value: &Value) -> Option<Self> {
        let text = |key| match entry(value, key)? {
            Value::Text(t) => Some(String::from_utf8_lossy(t).into_owned()),
            _ => None,
        };
        Some(Goal {
            text: text("text")?,
            state: text("state")?,
            time: number(entry(value, "time")).unwrap_or(-1.0),
            points: number(entry(value, "points")).unwrap_or(1.0),
        })
    }
}

/// Makes the scripts of exercises referees: those of objects with goals in their custom data, which were saved as child
/// scripts before there were referees, or by the page, which adds them to a running program.
pub fn appoint_referees(document: &mut Document) {
    for object in document.objects.iter_mut().filter(|o| has_goals(o)) {
        for script in object.scripts.iter_mut().filter(|s| s.kind == "child") {
            REFEREE_KIND.clone_into(&mut script.kind);
        }
    }
}

fn has_goals(object: &ObjectSpec) -> bool {
    object.properties.iter().any(|(row, value)| {
        matches!(value, Value::Map(all) if row.key() == DATA_PROPERTY
            && all.iter().any(|(tag, _)| matches!(tag, Value::Text(t) if t == GOALS_TAG)))
    })
}

/// Returns whether a scene has a referee.
pub fn has_referee(document: &Document) -> bool {
    document.objects.iter().flat_map(|o| &o.scripts).any(|s| s.kind == REFEREE_KIND)
}

/// Returns the goals that the referee of a world has reported last.
pub fn goals(world: &World) -> Vec<Goal> {
    let payload = world.verdict(GOALS_EVENT);
    match payload.as_ref().and_then(|p| entry(p, "goals")) {
        Some(Value::List(all)) => all.iter().filter_map(Goal::parse).collect(),
        _ => Vec::new(),
    }
}

fn entry<'a>(map: &'a Value, key: &str) -> Option<&'a Value> {
    let Value::Map(all) = map else { return None };
    all.iter().find(|(k, _)| matches!(k, Value::Text(t) if t == key.as_bytes())).map(|(_, v)| v)
}

fn number(value: Option<&Value>) -> Option<f64> {
    match value? {
        Value::Float(x) => Some(*x),
        Value::Int(i) => Some(*i as f64),
        _ => None,
    }
}
