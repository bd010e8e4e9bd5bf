//! Runs the scripts and judges the runs.

use std::{
    ffi::OsString,
    fs,
    path::{Path, PathBuf},
    time::Duration,
};

use serde_json::Value;
use tatu_core::errors::{Error, Result};
use tatu_embed::{pack, restart_command};

use super::{
    slip::{self, Slip},
    submissions::Submission,
    values::{read, round},
};
use crate::{
    child_run::{self, FinishedRun},
    test_args::GradeArgs,
};

/// The name of the script's file in the folder of its run.
const SCRIPT_NAME: &str = "script.lua";

/// What all runs of a grading share.
pub struct Grading<'a> {
    args: &'a GradeArgs,
    place: &'a Path,
    /// The packed scene.
    scene: PathBuf,
    criteria: PathBuf,
    object: String,
    /// Seeds of the runs; `None`: the scene's own.
    seeds: Vec<Option<u64>>,
    /// Folder for films.
    films: Option<PathBuf>,
    /// Hashes of the scene and of the criteria.
    hashes: [String; 2],
}

/// A goal, with the points that it has earned.
pub struct GoalGrade {
    pub text: String,
    /// In how many of the runs it was reached, as a share.
    pub share: f64,
    pub points: f64,
    /// Points for reaching it in all runs.
    pub most: f64,
    /// The time at which it was decided in the first run, s; -1 if it was not.
    pub time: f64,
}

/// The result of a submission.
pub struct Grade {
    pub goals: Vec<GoalGrade>,
    pub points: f64,
    pub most: f64,
    /// What the teacher should know.
    pub notes: Vec<String>,
    /// A text that is equal for runs in which everything moved equally.
    pub motion: String,
    pub slip: Slip,
    /// Name of the film in the folder of films.
    pub film: Option<String>,
}

impl<'a> Grading<'a> {
    /// Packs the scene, and runs it with its own script, which shows whether the criteria are right.
    pub fn prepare(args: &'a GradeArgs, place: &'a Path, films: Option<PathBuf>) -> Result<Self> {
        let lost = |e: std::io::Error| Error::new("E105", format!("cannot prepare the scene: {e}"));
        let folder = place.join("scene");
        fs::create_dir(&folder).map_err(lost)?;
        let packed = folder.join("scene.tatu");
        let out = restart_command().map_err(lost)?.arg("pack").args([&args.scene, &packed]).output().map_err(lost)?;
        if !out.status.success() {
            let said = String::from_utf8_lossy(&out.stderr).trim().to_owned();
            return Err(Error::new("E105", format!("cannot pack the scene: {said}")));
        }
        let scene = pack::unpack(&packed, &folder.join("files"))?;
        let criteria_text = read(&args.criteria)?;
        let criteria = place.join("criteria").join(args.criteria.file_name().unwrap_or_default());
        fs::create_dir(place.join("criteria")).map_err(lost)?;
        fs::write(&criteria, &criteria_text).map_err(lost)?;
        let object = match &args.object {
            Some(object) => object.clone(),
            None => only_scripted_object(&scene)?,
        };
        let seeds = match args.seeds.is_empty() {
            true => vec![None],
            false => args.seeds.iter().map(|seed| Some(*seed)).collect(),
        };
        let hashes = [slip::hash([read(&scene)?.as_slice()]), slip::hash([criteria_text.as_slice()])];
        let grading = Grading { args, place, scene, criteria, object, seeds, films, hashes };
        let own = grading.run(&place.join("own"), None, grading.seeds[0], None)?;
        match own.summary.as_ref().is_some_and(|s| s["goals"].as_array().is_some_and(|g| !g.is_empty())) {
            true => Ok(grading),
            false if own.summary.is_some() => {
                Err(Error::new("E105", format!("{} reports no goals", args.criteria.display()))
                    .expected("a script that calls `goals.begin`, `goals.check` and `goals.finish`")
                    .help(own.output))
            }
            false => Err(Error::new("E105", format!("the scene does not run with its own script: {}", own.output))),
        }
    }

    /// Runs a script with all seeds, and grades it.
    pub fn grade(&self, number: usize, submission: &Submission) -> Result<Grade> {
        let script = match &submission.script {
            Ok(script) => script,
            Err(why) => return Ok(self.no_points(&[], vec![why.clone()])),
        };
        let mut runs = Vec::new();
        for (n, seed) in self.seeds.iter().enumerate() {
            let folder = self.place.join(format!("{number}-{n}"));
            let film = self.films.as_ref().filter(|_| n == 0).map(|folder| folder.join(film_name(number, submission)));
            runs.push(self.run(&folder, Some(script), *seed, film.as_deref())?);
        }
        let mut grade = self.judge(script, &runs);
        let film = film_name(number, submission);
        grade.film = self.films.as_ref().is_some_and(|folder| folder.join(&film).is_file()).then_some(film);
        Ok(grade)
    }

    /// Runs a script, or the scene's own, in a folder of its own, which is the only one in which it may open files.
    fn run(&self, folder: &Path, script: Option<&[u8]>, seed: Option<u64>, film: Option<&Path>) -> Result<FinishedRun> {
        let lost = |e: std::io::Error| Error::new("E105", format!("cannot write the script: {e}"));
        let mut words: Vec<OsString> = vec![self.scene.clone().into(), "--no-addons".into()];
        words.extend(["--criteria".into(), self.criteria.clone().into()]);
        if let Some(text) = script {
            let own = folder.join("script");
            fs::create_dir_all(&own).map_err(lost)?;
            let file = own.join(SCRIPT_NAME);
            fs::write(&file, text).map_err(lost)?;
            let mut given = OsString::from(format!("{}=", self.object));
            given.push(&file);
            words.extend(["--script".into(), given]);
        }
        if let Some(seconds) = self.args.seconds {
            words.extend(["--seconds".into(), seconds.to_string().into()]);
        }
        if let Some(seed) = seed {
            words.extend(["--seed".into(), seed.to_string().into()]);
        }
        if let Some(film) = film {
            words.extend(["--html".into(), film.into()]);
        }
        let timeout = Duration::from_secs_f64(self.args.timeout);
        child_run::run(&words, &folder.join("work"), timeout, Some(self.args.memory << 20))
    }

    fn judge(&self, script: &[u8], runs: &[FinishedRun]) -> Grade {
        let mut notes = Vec::new();
        let mut hashes = Vec::new();
        let mut motion = String::new();
        let mut goals: Vec<GoalGrade> = Vec::new();
        let share = 1.0 / runs.len() as f64;
        for run in runs {
            let Some(summary) = &run.summary else {
                hashes.push("none".to_owned());
                notes.push(match run.timed_out {
                    true => format!("ended after {} s, before the run was complete", self.args.timeout),
                    false => format!("the run crashed: {}", run.output.lines().next_back().unwrap_or_default()),
                });
                continue;
            };
            hashes.push(summary["hash"].as_str().unwrap_or_default().to_owned());
            motion += &summary["objects"].to_string();
            notes.extend(first_error(summary));
            for (i, goal) in summary["goals"].as_array().into_iter().flatten().enumerate() {
                let most = goal["points"].as_f64().unwrap_or(1.0);
                if goals.len() == i {
                    let text = goal["text"].as_str().unwrap_or_default().to_owned();
                    let time = goal["time"].as_f64().unwrap_or(-1.0);
                    goals.push(GoalGrade { text, share: 0.0, points: 0.0, most, time });
                }
                if goal["state"] == "reached" {
                    goals[i].share += share;
                    goals[i].points += share * most;
                }
            }
        }
        notes.dedup();
        let (points, most) = (goals.iter().map(|g| g.points).sum(), goals.iter().map(|g| g.most).sum());
        let slip = self.slip(script, &hashes.join(","), points, most);
        Grade { goals, points, most, notes, motion, slip, film: None }
    }

    fn no_points(&self, script: &[u8], notes: Vec<String>) -> Grade {
        let slip = self.slip(script, "none", 0.0, 0.0);
        Grade { goals: Vec::new(), points: 0.0, most: 0.0, notes, motion: String::new(), slip, film: None }
    }

    fn slip(&self, script: &[u8], hash: &str, points: f64, most: f64) -> Slip {
        let [scene, criteria] = self.hashes.clone();
        let seeds: Vec<String> = self.args.seeds.iter().map(u64::to_string).collect();
        Slip(vec![
            ("scene", scene),
            ("criteria", criteria),
            ("script", slip::hash([script])),
            ("seeds", if seeds.is_empty() { "scene".to_owned() } else { seeds.join(",") }),
            ("hash", hash.to_owned()),
            ("points", format!("{}/{}", round(points), round(most))),
        ])
    }
}

fn film_name(number: usize, submission: &Submission) -> String {
    let name: String = submission.student.chars().map(|c| if c.is_alphanumeric() { c } else { '_' }).collect();
    format!("{:03}_{name}.html", number + 1)
}

/// Returns the first error of a run, as its own note.
fn first_error(summary: &Value) -> Option<String> {
    let error = summary["errors"].as_array()?.first()?["message"].as_str()?;
    Some(error.lines().next().unwrap_or_default().to_owned())
}

/// Returns the path of the only object at the top of a packed scene with a script that is not a referee. Scripts below it
/// are those of its sensors.
fn only_scripted_object(scene: &Path) -> Result<String> {
    let out = restart_command()
        .map_err(|e| Error::new("E105", e.to_string()))?
        .args(["run"])
        .arg(scene)
        .args(["--steps", "0", "--json", "--no-addons"])
        .output()
        .map_err(|e| Error::new("E105", format!("cannot run the scene: {e}")))?;
    let summary: Value = serde_json::from_slice(&out.stdout).unwrap_or_default();
    let scripts = summary["scripts"].as_array().into_iter().flatten().filter(|s| s["kind"] != "referee");
    let objects = scripts.filter_map(|s| s["object"].as_str()).filter(|path| path.matches('/').count() == 1);
    let objects: Vec<&str> = objects.collect();
    match objects.as_slice() {
        [one] => Ok((*one).to_owned()),
        [] => Err(Error::new("E105", "the scene has no script that could be replaced")
            .help("name the object whose script is graded: `--object /Robot`")),
        all => Err(Error::new("E105", format!("the scene has several scripts: {}", all.join(", ")))
            .help("name the object whose script is graded: `--object /Robot`")),
    }
}
