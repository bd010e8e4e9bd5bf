//! `tatu grade`: runs the scripts of students in one scene, and awards points for the goals that each reaches.
//!
//! Each script runs in a process of its own, in a packed copy of the scene, so that neither the criteria nor other
//! scripts are in a folder that it may read. `submissions`: finds the scripts; `runs`: runs and judges them; `slip`: the
//! line that proves a result; `files`: the results as files; `values`: files and points as texts.

mod files;
mod runs;
mod slip;
mod submissions;
mod values;

use std::{collections::BTreeMap, process::ExitCode};

use tatu_core::errors::{Error, Result};
use tatu_terminal::report;

use crate::{child_run, test_args::GradeArgs};
use runs::{Grade, Grading};
use submissions::Submission;
use values::round;

/// Grades scripts. The exit code is 0 if all were graded, however good they are, 1 if a slip does not agree, and 2 if
/// nothing could be graded.
pub fn grade(args: &GradeArgs) -> ExitCode {
    match graded(args) {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => ExitCode::FAILURE,
        Err(e) => {
            report::error(&e);
            ExitCode::from(2)
        }
    }
}

fn graded(args: &GradeArgs) -> Result<bool> {
    let all = submissions::find(&args.submissions)?;
    if args.check.is_some() && all.len() != 1 {
        return Err(Error::new("E105", "a slip is checked with one script").expected("the script of the slip"));
    }
    let place = tempfile::tempdir().map_err(|e| Error::new("E105", format!("cannot create a folder: {e}")))?;
    let films = args.html.as_ref().map(|folder| files::create_folder(folder)).transpose()?;
    let grading = Grading::prepare(args, place.path(), films)?;
    let bar = report::progress(all.len() as u64, "script", true);
    let mut grades = Vec::new();
    child_run::in_order(
        all.len(),
        child_run::threads(args.jobs),
        |i| grading.grade(i, &all[i]),
        |_, grade| {
            bar.inc(1);
            grades.push(grade);
        },
    );
    bar.finish_and_clear();
    let mut grades = grades.into_iter().collect::<Result<Vec<_>>>()?;
    point_out_equal_runs(&all, &mut grades);
    if let Some(given) = &args.check {
        return check_slip(given, &grades[0]);
    }
    print(&all, &grades);
    if args.github {
        files::print_annotations(&all, &grades);
    }
    files::write(args, &all, &grades)?;
    Ok(true)
}

/// Notes which scripts move the robot in exactly the same way as another one, although their texts may differ. Scripts
/// without points are left out, since many of them do nothing at all.
fn point_out_equal_runs(all: &[Submission], grades: &mut [Grade]) {
    let mut by_motion: BTreeMap<String, Vec<usize>> = BTreeMap::new();
    for (i, grade) in grades.iter().enumerate().filter(|(_, g)| g.points > 0.0) {
        by_motion.entry(grade.motion.clone()).or_default().push(i);
    }
    for same in by_motion.values().filter(|same| same.len() > 1) {
        for i in same {
            let others = same.iter().filter(|j| *j != i).map(|j| all[*j].student.as_str());
            let text = format!("moves exactly as {}", others.collect::<Vec<_>>().join(", "));
            grades[*i].notes.push(text);
        }
    }
}

fn check_slip(given: &str, grade: &Grade) -> Result<bool> {
    let differences = grade.slip.differences(given)?;
    match differences.is_empty() {
        true => report::out!("the slip is right: {}", grade.slip),
        false => report::out!("the slip is wrong: {}", differences.join("; ")),
    }
    Ok(differences.is_empty())
}

fn print(all: &[Submission], grades: &[Grade]) {
    let width = all.iter().map(|s| s.student.chars().count()).max().unwrap_or(0);
    for (submission, grade) in all.iter().zip(grades) {
        let notes = if grade.notes.is_empty() { String::new() } else { format!("  {}", grade.notes.join("; ")) };
        report::out!("{:width$}  {} of {}{notes}", submission.student, round(grade.points), round(grade.most));
    }
    for (submission, grade) in all.iter().zip(grades).filter(|(_, g)| g.points > 0.0) {
        report::out!("slip of {}: {}", submission.student, grade.slip);
    }
}
