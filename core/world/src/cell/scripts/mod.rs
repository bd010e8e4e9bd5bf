//! The scripts of a world.
//!
//! - `list`: the scripts, with their `kinds` and `order`; `counts`: numbers of calls of each script;
//! - `worker_view`, `worker`: a thread's view of the world while it runs scripts in parallel;
//! - `folders`: the folders in which scripts open files;
//! - `stand_ins`, `stand_in_use`: objects created because scripts request them.

pub(in crate::cell) mod counts;
pub(in crate::cell) mod folders;
pub(in crate::cell) mod kinds;
pub(in crate::cell) mod list;
pub(in crate::cell) mod order;
pub(crate) mod stand_in_use;
pub(in crate::cell) mod stand_ins;
pub(in crate::cell) mod worker;
pub(in crate::cell) mod worker_view;
