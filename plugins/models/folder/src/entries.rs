//! The texts from which a model is built: which entries, how often, and with which values.

use std::ops::Range;

use tatu_plugin_api::safe::Params;

use crate::{
    expression::{Names, Value, evaluate},
    fill::filled,
    model::Model,
    sections::{Entry, Section},
    wrong::{Result, Wrong},
};

/// Most repetitions of an entry.
const MOST_REPEATS: f64 = 10_000.0;

/// Returns the texts in the scene format of a model with these parameters: first that of its base alone, then those of
/// everything below it, in the order of the file.
pub fn texts(model: &Model, params: &Params<'_>) -> Result<Vec<String>> {
    let mut names = Names::new();
    for (key, computed) in &model.params {
        let given = params.get(key).and_then(|v| v.to_value()).map_err(|e| Wrong::new(e.text()))?;
        let value = match (Value::of_host(&given), computed) {
            (None, Some(computed)) => Some(computed.value(&names)?),
            (value, _) => value,
        };
        names.extend(value.map(|v| (key.clone(), v)));
    }
    for (name, value, span) in &model.numbers {
        let value = value_of(value, &names).map_err(|e| e.at(Some(span.clone())))?;
        names.insert(name.clone(), value);
    }
    let mut runs: Vec<(Vec<usize>, Option<f64>)> = vec![(vec![model.base], None)];
    for (i, entry) in model.entries.iter().enumerate() {
        let wanted = condition(entry, &names)?;
        if i == model.base {
            if !wanted || entry.repeat.is_some() {
                return Err(Wrong::new("the base of a model can be neither left out nor repeated").at(Some(at(entry))));
            }
            continue;
        }
        if !wanted {
            continue;
        }
        match repeats(entry, &names)? {
            Some(n) => runs.extend((0..n).map(|index| (vec![i], Some(index as f64)))),
            None => match runs.last_mut().filter(|(run, index)| index.is_none() && run[0] != model.base) {
                Some((run, _)) => run.push(i),
                None => runs.push((vec![i], None)),
            },
        }
    }
    let last = model.sections.iter().any(|s| s.root == "set").then_some((Vec::new(), None));
    runs.extend(last);
    let text = |(i, (run, index)): (usize, &(Vec<usize>, Option<f64>))| {
        let mut names = names.clone();
        names.extend(index.map(|x| ("index".to_owned(), Value::Number(x))));
        // Settings come before objects, and what `[set]` changes after them.
        let of_file = |root: &str| match root {
            "set" => run.is_empty(),
            "model" | "object" | "import" => false,
            _ => i == 0,
        };
        let kept = |s: &&Section| s.entry.map_or_else(|| of_file(&s.root), |e| run.contains(&e));
        let head = model.sections.first().map_or(model.text.len(), |s| s.span.start);
        let kept: Vec<_> =
            std::iter::once(0..head).chain(model.sections.iter().filter(kept).map(|s| s.span.clone())).collect();
        let own: Vec<_> = run.iter().flat_map(|e| model.entries[*e].own.clone()).collect();
        filled(&model.doc, &kept, &own, &names)
    };
    runs.iter().enumerate().map(text).collect()
}

fn at(entry: &Entry) -> Range<usize> {
    let written = entry.condition.as_ref().or(entry.repeat.as_ref());
    written.map_or(entry.start..entry.start, |(_, span)| span.clone())
}

/// Returns a value, or what its expression yields.
fn value_of(value: &Value, names: &Names) -> Result<Value> {
    match value {
        Value::Text(t) if t.starts_with('=') => evaluate(&t[1..], names),
        Value::List(all) => all.iter().map(|v| value_of(v, names)).collect::<Result<_>>().map(Value::List),
        value => Ok(value.clone()),
    }
}

fn condition(entry: &Entry, names: &Names) -> Result<bool> {
    let Some((value, span)) = &entry.condition else { return Ok(true) };
    match value_of(value, names).map_err(|e| e.at(Some(span.clone())))? {
        Value::Bool(b) => Ok(b),
        other => Err(Wrong::new(format!("`if`: expected true or false, found {}", other.describe()))
            .help("such as \"=with_arm\" or \"=preset == 'wide'\"")
            .at(Some(span.clone()))),
    }
}

fn repeats(entry: &Entry, names: &Names) -> Result<Option<usize>> {
    let Some((value, span)) = &entry.repeat else { return Ok(None) };
    match value_of(value, names).map_err(|e| e.at(Some(span.clone())))? {
        Value::Number(n) if (0.0..=MOST_REPEATS).contains(&n) && n == libm::floor(n) => Ok(Some(n as usize)),
        other => {
            let text =
                format!("`repeat`: expected a whole number from 0 to {MOST_REPEATS}, found {}", other.describe());
            Err(Wrong::new(text).help("`index` counts from 0").at(Some(span.clone())))
        }
    }
}
