//! Times planning for a Panda among tables and shelves: `bench-planning [problems|spheres]`.
//!
//! Without a word, solves 100 problems with one seed and prints, as JSON, the times in ms, the tests and the lengths, and
//! whether one and two threads find the same paths. `problems` prints the problems, and `spheres` the model of the arm,
//! for other planners.

mod panda;
mod problems;

use std::time::Instant;

use problems::{Task, checker, tasks};
use serde_json::{Value, json};
use tatu_planning::{
    Goal, Path, Problem, Seeds, Settings, Solution, plan, plan_with_seeds, shorten,
    spheres::{SphereCache, cover},
};

/// Number of problems, and the seed from which they follow.
const COUNT: usize = 100;
const SEED: u64 = 20_260;
/// Each problem is solved this often; the fastest counts, as the others wait for the system.
const REPEATS: usize = 5;
/// The largest motion between two tests: about 0.04 rad in all joints together.
const SETTINGS: fn() -> Settings = || Settings { resolution: 0.003, max_checks: 2_000_000, ..Settings::default() };

fn problems() -> Value {
    let all = tasks(COUNT, SEED);
    let block = |b: &problems::Block| json!({"center": b.center, "half": b.half, "yaw": b.yaw});
    let task = |t: &Task| json!({"name": t.name, "blocks": t.blocks.iter().map(block).collect::<Vec<_>>(), "start": t.start, "goal": t.goal});
    json!({"limits": panda::LIMITS, "ready": panda::READY, "problems": all.iter().map(task).collect::<Vec<_>>()})
}

/// The spheres of each link, in its frame.
fn spheres() -> Value {
    let bodies = panda::bodies();
    let of_body = |body: &tatu_planning::spheres::Body| {
        let forms = body.forms.iter().flat_map(|(pose, form)| {
            cover(form, 24).into_iter().map(move |s| {
                let c = pose * s.center;
                [c.x, c.y, c.z, s.radius]
            })
        });
        json!({"frame": body.frame, "spheres": forms.collect::<Vec<_>>()})
    };
    json!({"links": bodies.iter().map(of_body).collect::<Vec<_>>(), "pairs": panda::SELF_PAIRS})
}

/// Returns the solution, the tests for the first path, and the times of preparing, planning and shortening, ms.
fn solve(task: &Task, cache: &mut SphereCache) -> (Option<Solution>, u64, [f64; 3]) {
    let (space, settings) = (panda::space(), SETTINGS());
    let begun = Instant::now();
    let mut test = checker(&task.blocks, 0.0, cache);
    let ready = begun.elapsed().as_secs_f64();
    let problem = Problem { space: &space, start: &task.start, goal: Goal::States(vec![task.goal.clone()]) };
    let found = plan(problem, &settings, &mut test, &mut |_| true);
    let planned = begun.elapsed().as_secs_f64();
    let checks = found.as_ref().map_or(0, |solution| solution.checks);
    let found = found.ok().map(|mut solution| {
        solution.checks += shorten(&mut solution.path, &space, &settings, &mut test, &mut |_| true).unwrap_or(0);
        solution
    });
    (found, checks, [ready, planned - ready, begun.elapsed().as_secs_f64() - planned].map(|s| 1e3 * s))
}

/// Returns whether one and two threads find the same path among several seeds.
fn threads_agree(task: &Task) -> bool {
    let space = panda::space();
    let goals = [task.goal.clone()];
    let run = |threads| -> Option<Path> {
        let test = || checker(&task.blocks, 0.0, &mut SphereCache::default());
        let found =
            plan_with_seeds(&space, &task.start, &goals, &SETTINGS(), Seeds { count: 3, threads }, &test, &|| false);
        found.ok().map(|s| s.path)
    };
    run(1) == run(2)
}

fn run() -> Value {
    let mut cache = SphereCache::default();
    let mut rows = Vec::new();
    for task in tasks(COUNT, SEED) {
        let runs: Vec<_> = (0..REPEATS).map(|_| solve(&task, &mut cache)).collect();
        let least = |i: usize| runs.iter().map(|r| r.2[i]).fold(f64::INFINITY, f64::min);
        let found = runs.first().and_then(|r| r.0.as_ref());
        let same = runs.iter().all(|r| r.0.as_ref() == found) && threads_agree(&task);
        rows.push(json!({
            "name": task.name, "solved": found.is_some(), "same": same,
            "setup_ms": least(0), "plan_ms": least(1), "shorten_ms": least(2),
            "plan_checks": runs.first().map(|r| r.1), "checks": found.map(|s| s.checks), "length": found.map(|s| s.path.length(&panda::space())),
            "path": found.map(|s| &s.path.states),
        }));
    }
    Value::Array(rows)
}

fn main() {
    let word = std::env::args().nth(1);
    let value = match word.as_deref() {
        Some("problems") => problems(),
        Some("spheres") => spheres(),
        _ => run(),
    };
    println!("{value}");
}
