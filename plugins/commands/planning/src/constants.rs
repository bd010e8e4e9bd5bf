//! Constants of scripts, with the numbers of CoppeliaSim.

use tatu_planning::Algorithm;
use tatu_plugin_api::safe::{Constant, Offer, Value};

use crate::state::Planning;

const FIRST_ALGORITHM: i64 = 30_001;
const FIRST_SPACE_TYPE: i64 = 50_001;

/// The algorithms in the order of their numbers, and the planner that stands for each.
const ALGORITHMS: [(&str, Option<Algorithm>); 25] = [
    ("BiTRRT", Some(Algorithm::RrtConnect)),
    ("BITstar", Some(Algorithm::RrtStar)),
    ("BKPIECE1", Some(Algorithm::RrtConnect)),
    ("CForest", Some(Algorithm::RrtStar)),
    ("EST", Some(Algorithm::Rrt)),
    ("FMT", Some(Algorithm::RrtStar)),
    ("KPIECE1", Some(Algorithm::RrtConnect)),
    ("LazyPRM", Some(Algorithm::Prm)),
    ("LazyPRMstar", Some(Algorithm::PrmStar)),
    ("LazyRRT", Some(Algorithm::Rrt)),
    ("LBKPIECE1", Some(Algorithm::RrtConnect)),
    ("LBTRRT", Some(Algorithm::RrtStar)),
    ("PDST", Some(Algorithm::Rrt)),
    ("PRM", Some(Algorithm::Prm)),
    ("PRMstar", Some(Algorithm::PrmStar)),
    ("pRRT", None),
    ("pSBL", None),
    ("RRT", Some(Algorithm::Rrt)),
    ("RRTConnect", Some(Algorithm::RrtConnect)),
    ("RRTstar", Some(Algorithm::RrtStar)),
    ("SBL", Some(Algorithm::RrtConnect)),
    ("SPARS", Some(Algorithm::Prm)),
    ("SPARStwo", Some(Algorithm::Prm)),
    ("STRIDE", Some(Algorithm::Rrt)),
    ("TRRT", Some(Algorithm::Rrt)),
];
/// The number of `KPIECE1`, the default.
pub const DEFAULT_ALGORITHM: i64 = FIRST_ALGORITHM + 6;

const SPACE_TYPES: [&str; 7] =
    ["position2d", "pose2d", "position3d", "pose3d", "joint_position", "dubins", "cyclic_joint_position"];

/// Returns the planner for the number of an algorithm, or its name if there is none; `None` for other numbers.
pub fn algorithm(number: i64) -> Option<Result<Algorithm, &'static str>> {
    let (name, planner) = ALGORITHMS.get(usize::try_from(number.checked_sub(FIRST_ALGORITHM)?).ok()?)?;
    Some(planner.ok_or(name))
}

/// Returns the index of the type of a space by its number.
pub fn space_type(number: i64) -> Option<usize> {
    usize::try_from(number.checked_sub(FIRST_SPACE_TYPE)?).ok().filter(|i| *i < SPACE_TYPES.len())
}

pub fn offer(offer: &mut Offer<Planning>) {
    let algorithms: Vec<(&str, i64)> = ALGORITHMS.iter().zip(FIRST_ALGORITHM..).map(|((n, _), i)| (*n, i)).collect();
    let types: Vec<(&str, i64)> = SPACE_TYPES.iter().zip(FIRST_SPACE_TYPE..).map(|(n, i)| (*n, i)).collect();
    for (group, flat, entries) in [("Algorithm", "algorithm", algorithms), ("StateSpaceType", "statespacetype", types)]
    {
        for (name, number) in &entries {
            offer.constant(Constant::new(format!("sim_ompl_{flat}_{name}"), Value::Int(*number)));
        }
        let map = entries.iter().map(|(name, number)| (Value::text(name), Value::Int(*number))).collect();
        offer.constant(Constant::new(format!("simOMPL.{group}"), Value::Map(map)));
    }
}
