//! The results of a grading as files: for spreadsheets, as a page, for Gradescope and for GitHub.

use std::{
    fs,
    path::{Path, PathBuf},
};

use maud::{DOCTYPE, PreEscaped, html};
use serde_json::{Value, json};
use tatu_core::errors::{Error, Result};
use tatu_terminal::report;

use super::{runs::Grade, submissions::Submission, values::round};
use crate::test_args::GradeArgs;

const STYLE: &str = "body { font: 15px/1.5 system-ui, sans-serif; margin: 2rem auto; max-width: 70rem; padding: 0 1rem; \
    color: #1c2733; background: #fff } table { border-collapse: collapse; width: 100% } th, td { text-align: left; \
    padding: .4rem .7rem; border-bottom: 1px solid #d7dee5; vertical-align: top } td.points { font-variant-numeric: \
    tabular-nums; white-space: nowrap } .reached { color: #12703a } .failed { color: #b3261e } .note { color: #5b6875 } \
    @media (prefers-color-scheme: dark) { body { color: #dbe3ea; background: #14191f } th, td { border-color: #2c3640 } \
    .reached { color: #6fcf97 } .failed { color: #ff8a80 } .note { color: #9aa8b5 } a { color: #8ab4f8 } }";

/// Creates a folder and returns its absolute path.
pub fn create_folder(folder: &Path) -> Result<PathBuf> {
    let lost = |e: std::io::Error| Error::new("E105", format!("cannot create the folder {}: {e}", folder.display()));
    fs::create_dir_all(folder).map_err(lost)?;
    fs::canonicalize(folder).map_err(lost)
}

/// Writes the files that were asked for.
pub fn write(args: &GradeArgs, all: &[Submission], grades: &[Grade]) -> Result {
    if let Some(file) = &args.csv {
        write_csv(file, all, grades).map_err(|e| unwritable(file, &e))?;
    }
    if let Some(folder) = &args.html {
        let file = folder.join("index.html");
        fs::write(&file, page(args, all, grades)).map_err(|e| unwritable(&file, &e))?;
    }
    if let Some(folder) = &args.gradescope {
        let folder = create_folder(folder)?;
        for (submission, grade) in all.iter().zip(grades) {
            let file = folder.join(format!("{}.json", submission.student));
            let text = serde_json::to_string_pretty(&gradescope(grade)).unwrap_or_default();
            fs::write(&file, text).map_err(|e| unwritable(&file, &e))?;
        }
    }
    Ok(())
}

fn unwritable(file: &Path, e: &dyn std::fmt::Display) -> Error {
    Error::new("E105", format!("cannot write {}: {e}", file.display()))
}

/// Returns the texts of the goals, from the first submission that was run.
fn goal_texts(grades: &[Grade]) -> Vec<&str> {
    let first = grades.iter().find(|g| !g.goals.is_empty());
    first.map(|g| g.goals.iter().map(|goal| goal.text.as_str()).collect()).unwrap_or_default()
}

fn write_csv(file: &Path, all: &[Submission], grades: &[Grade]) -> csv::Result<()> {
    let mut out = csv::Writer::from_path(file)?;
    let texts = goal_texts(grades);
    let columns = ["student", "points", "of"].into_iter().chain(texts.iter().copied()).chain(["notes", "slip"]);
    out.write_record(columns.map(cell))?;
    for (submission, grade) in all.iter().zip(grades) {
        let mut row = vec![cell(&submission.student), round(grade.points), round(grade.most)];
        row.extend((0..texts.len()).map(|i| grade.goals.get(i).map_or(String::new(), |goal| round(goal.points))));
        row.extend([cell(&grade.notes.join("; ")), grade.slip.to_string()]);
        out.write_record(row)?;
    }
    out.flush()?;
    Ok(())
}

/// Returns the text of a cell that no spreadsheet takes for a formula.
fn cell(text: &str) -> String {
    match text.starts_with(['=', '+', '-', '@', '\t', '\r']) {
        true => format!("'{text}"),
        false => text.to_owned(),
    }
}

fn page(args: &GradeArgs, all: &[Submission], grades: &[Grade]) -> String {
    let scene = args.scene.file_stem().map(|s| s.to_string_lossy().into_owned()).unwrap_or_default();
    let texts = goal_texts(grades);
    html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                meta name="viewport" content="width=device-width";
                title { "Results: " (scene) }
                style { (PreEscaped(STYLE)) }
            }
            body {
                h1 { "Results: " (scene) }
                table {
                    thead { tr {
                        th scope="col" { "Student" }
                        th scope="col" { "Points" }
                        @for text in &texts { th scope="col" { (text) } }
                        th scope="col" { "Notes" }
                    } }
                    tbody {
                        @for (submission, grade) in all.iter().zip(grades) { tr {
                            th scope="row" {
                                @match &grade.film {
                                    Some(film) => a href=(film) { (submission.student) },
                                    None => (submission.student),
                                }
                            }
                            td.points { (round(grade.points)) " of " (round(grade.most)) }
                            @for i in 0..texts.len() { td {
                                @if let Some(goal) = grade.goals.get(i) {
                                    @if goal.share > 0.999 { span.reached { "reached" } }
                                    @else if goal.share > 0.0 { (format!("reached in {:.0} % of the runs", 100.0 * goal.share)) }
                                    @else { span.failed { "not reached" } }
                                    @if goal.time >= 0.0 { " " span.note { (format!("{:.2} s", goal.time)) } }
                                }
                            } }
                            td.note { (grade.notes.join("; ")) }
                        } }
                    }
                }
            }
        }
    }
    .into_string()
}

/// Returns the results in the format that Gradescope's autograder reads.
fn gradescope(grade: &Grade) -> Value {
    let test = |goal: &super::runs::GoalGrade| {
        let status = if goal.share > 0.999 { "passed" } else { "failed" };
        json!({ "name": goal.text, "score": goal.points, "max_score": goal.most, "status": status })
    };
    let output = [grade.notes.join("\n"), grade.slip.to_string()].join("\n");
    json!({
        "score": grade.points, "output": output.trim(), "tests": grade.goals.iter().map(test).collect::<Vec<_>>(),
    })
}

/// Prints annotations for GitHub Actions.
pub fn print_annotations(all: &[Submission], grades: &[Grade]) {
    // In properties, these characters separate or end.
    let escape = |text: &str| text.replace('%', "%25").replace('\r', "%0D").replace('\n', "%0A");
    let property = |text: &str| escape(text).replace(':', "%3A").replace(',', "%2C");
    for (submission, grade) in all.iter().zip(grades) {
        let file = property(&submission.path.display().to_string());
        for goal in grade.goals.iter().filter(|g| g.share < 0.999) {
            report::out!("::error file={file}::{}", escape(&format!("not reached: {}", goal.text)));
        }
        for note in &grade.notes {
            report::out!("::warning file={file}::{}", escape(note));
        }
    }
}
