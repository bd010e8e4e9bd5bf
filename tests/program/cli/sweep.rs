//! Tests of `tatu sweep`: rows, shards, continuing a sweep, and files that are not overwritten.

use std::{collections::BTreeSet, fs};

use serde_json::Value;

use crate::kit::*;

const SCENE: &str =
    "format = 1\n[[object]]\nkind = \"shape\"\nalias = \"ball\"\nprimitive = \"sphere\"\ndynamic = true\n";
const SWEEP: &str = "scene = \"ball.toml\"\nseconds = 0.1\nseeds = [1, 2]\n[grid]\n\"/ball.position_m\" = [[0, 0, 1], [0, 0, 2]]\n\
                     [metrics]\nheight = { object = \"/ball\", field = \"object.world_pose\", index = 2 }\n";

fn place() -> TestFolder {
    let place = TestFolder::new();
    place.write("ball.toml", SCENE);
    place.write("sweep.toml", SWEEP);
    place
}

fn rows(text: &str) -> Vec<Value> {
    text.lines().map(|line| serde_json::from_str(line).unwrap()).collect()
}

#[test]
fn each_combination_makes_a_row_and_shards_cover_all() {
    let place = place();
    let all = place.tatu(&["sweep", "sweep.toml"]);
    assert_eq!(all.code, 0, "{}", all.err);
    let all = rows(&all.out);
    assert_eq!(all.len(), 4);
    let height = |row: &Value| row["metrics"]["height"].as_f64().unwrap();
    assert!(all.iter().all(|row| height(row) < row["set"]["/ball.position_m"][2].as_f64().unwrap()));
    let keys = |rows: &[Value]| rows.iter().map(|r| r["key"].as_str().unwrap().to_owned()).collect::<BTreeSet<_>>();
    let shards = ["0/2", "1/2"].map(|shard| rows(&place.tatu(&["sweep", "sweep.toml", "--shard", shard]).out));
    assert_eq!(shards.each_ref().map(Vec::len), [2, 2]);
    assert_eq!(keys(&shards.concat()), keys(&all));
}

#[test]
fn a_file_of_rows_is_continued_and_any_other_is_left_alone() {
    let place = place();
    let to = |file: &str| place.tatu(&["sweep", "sweep.toml", "--output", file]);
    assert_eq!(to("rows.jsonl").code, 0);
    let file = place.path().join("rows.jsonl");
    let whole = fs::read_to_string(&file).unwrap();
    // A sweep that was killed while it wrote its last row.
    fs::write(&file, &whole[..whole.len() - 20]).unwrap();
    let again = to("rows.jsonl");
    assert!(again.code == 0 && again.err.contains("3 of 4 jobs are done already"), "{}", again.err);
    assert_eq!(rows(&fs::read_to_string(&file).unwrap()).len(), 4);
    for other in ["my thesis, without an end of line", "my thesis\n", "{\"name\": 1}\n"] {
        place.write("thesis.txt", other);
        let refused = to("thesis.txt");
        assert!(refused.code == 2 && refused.err.contains("not a row of a sweep"), "{}", refused.err);
        assert_eq!(fs::read_to_string(place.path().join("thesis.txt")).unwrap(), other);
    }
    let parquet = to("rows.parquet");
    assert!(parquet.code == 2 && parquet.err.contains("Python package"), "{}", parquet.err);
    assert!(!place.path().join("rows.parquet").exists());
    let held = fs::OpenOptions::new().append(true).open(&file).unwrap();
    held.lock().unwrap();
    let second = to("rows.jsonl");
    assert!(second.code == 2 && second.err.contains("another sweep is writing"), "{}", second.err);
    drop(held);
    assert_eq!(to("rows.jsonl").code, 0);
    assert_eq!(to("sweep.toml").code, 2);
    assert_eq!(fs::read_to_string(place.path().join("sweep.toml")).unwrap(), SWEEP);
}

#[test]
fn a_failed_job_is_reported_and_has_a_row() {
    let place = place();
    place.write("sweep.toml", &SWEEP.replace("/ball\", field", "/bal\", field"));
    let failed = place.tatu(&["sweep", "sweep.toml"]);
    assert_eq!(failed.code, 1);
    assert!(failed.err.contains("no object `/bal`") && failed.err.contains("4 job(s) failed"), "{}", failed.err);
    assert!(rows(&failed.out).iter().all(|row| row["error"].is_string()));
}
