//! Goals of actions, and the numbers that represent responses, results and statuses.

use serde::{Deserialize, Serialize};
use serde_json::Value as Json;

/// Name of the event that is published when a script sends a goal to a client.
pub(crate) const GOAL_EVENT: &str = "ros.goal";
/// Name of the event that is published when a script requests that a client cancel a goal.
pub(crate) const CANCEL_EVENT: &str = "ros.cancel";
/// Name of the event that is published when a script reports feedback on a client's goal, or its result.
pub(crate) const PROGRESS_EVENT: &str = "ros.progress";

/// Response to a goal: it is rejected.
pub(crate) const REJECT_GOAL: i64 = 12856;
/// Response to a goal: it is accepted and executed.
pub(crate) const ACCEPT_AND_EXECUTE: i64 = REJECT_GOAL + 1;
/// Response to a goal: it is accepted and will be executed later.
pub(crate) const ACCEPT_AND_DEFER: i64 = REJECT_GOAL + 2;
/// Response to a request to cancel a goal: it is rejected.
pub(crate) const REJECT_CANCEL: i64 = 16099;
/// Response to a request to cancel a goal: it is accepted.
pub(crate) const ACCEPT_CANCEL: i64 = REJECT_CANCEL + 1;
// Result codes of goals, for scripts.
/// The goal has succeeded.
pub(crate) const SUCCEEDED: i64 = 8564;
/// The goal was aborted.
pub(crate) const ABORTED: i64 = SUCCEEDED + 1;
/// The goal was cancelled.
pub(crate) const CANCELED: i64 = SUCCEEDED + 2;
/// The result is not known.
pub(crate) const UNKNOWN: i64 = SUCCEEDED + 3;

/// Converts a result code to a status in `action_msgs/GoalStatus`.
pub(crate) fn status(code: i64) -> i64 {
    match code {
        SUCCEEDED => 4,
        CANCELED => 5,
        ABORTED => 6,
        _ => 0,
    }
}

/// Converts a status in `action_msgs/GoalStatus` to a result code.
pub(crate) fn code(status: i64) -> i64 {
    [SUCCEEDED, ABORTED, CANCELED].into_iter().find(|c| self::status(*c) == status).unwrap_or(UNKNOWN)
}

/// Who has sent a goal, and receives its feedback and result.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(crate) enum GoalSender {
    /// A script, by the handle of its action client.
    Script(i64),
    /// A client of the service, by the id that the service has assigned to the goal.
    Outside(String),
}

/// The stage of a goal without a result.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) enum GoalStage {
    /// The goal is accepted and will be executed later.
    Deferred,
    /// The goal is being executed.
    Executing,
    /// The server has accepted the request of the sender to cancel the goal.
    Canceling,
}

/// A goal that has no result yet.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub(crate) struct PendingGoal {
    /// Number of the goal among all goals of the run, from 1.
    pub(crate) number: u64,
    /// The server: the handle of a script's action server, or `None` for a client of the service.
    pub(crate) server: Option<i64>,
    pub(crate) asker: GoalSender,
    pub(crate) stage: GoalStage,
    /// The goal message.
    pub(crate) json: Json,
}

/// Returns the id of the goal `number`: 32 hexadecimal digits, like a UUID of ROS, that are the same in each run.
pub(crate) fn goal_id(number: u64) -> String {
    let mix = |x: u64| {
        let x = x.wrapping_mul(0x9E37_79B9_7F4A_7C15);
        let x = (x ^ (x >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        (x ^ (x >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB)
    };
    format!("{:016x}{:016x}", mix(2 * number + 1), mix(2 * number + 2))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn goal_ids_have_32_digits_and_result_codes_round_trip() {
        let all: std::collections::BTreeSet<String> = (0..1000).map(goal_id).collect();
        assert_eq!(all.len(), 1000);
        for id in all {
            assert!(id.len() == 32 && id.chars().all(|c| c.is_ascii_digit() || ('a'..='f').contains(&c)), "{id}");
        }
        for c in [SUCCEEDED, ABORTED, CANCELED, UNKNOWN] {
            assert_eq!(code(status(c)), c);
        }
        assert_eq!(code(2), UNKNOWN);
    }
}
