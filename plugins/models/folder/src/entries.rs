//! Generates the scene texts from which a model is built, by applying its conditions, repetitions and parameter values.

use std::ops::Range;

use tatu_plugin_api::safe::Params;

use crate::{
    expression::{Names, Room, Value, evaluate},
    fill::filled,
    model::Model,
    sections::{Entry, Section},
    wrong::{Result, Wrong},
};

/// Maximum number of repetitions in a model.
const MOST_REPEATS: usize = 10_000;
/// Maximum total size of the texts of a model, bytes. The text of each repetition is padded with the line breaks of the
/// file above its entry.
const MOST_BYTES: usize = 64 << 20;

/// One text of a plan: the indices of its entries in the model, and the value of `index` if the entry is repeated.
/// Without entries, the text contains the tables `[set]`.
type Run = (Vec<usize>, Option<usize>);

/// The sequence of texts from which a model is built with given parameters.
pub struct Plan<'m> {
    model: &'m Model,
    names: Names,
    runs: std::vec::IntoIter<Run>,
    first: bool,
    /// Total size of the texts so far, bytes.
    bytes: usize,
}

impl<'m> Plan<'m> {
    /// Determines which entries are built and how many times.
    pub fn new(model: &'m Model, params: &Params<'_>) -> Result<Self> {
        let (names, room) = named_values(model, params)?;
        let mut runs: Vec<Run> = vec![(vec![model.base], None)];
        let mut repeated = 0;
        for (i, entry) in model.entries.iter().enumerate() {
            let wanted = condition(entry, &names, &room)?;
            if i == model.base {
                if !wanted || entry.repeat.is_some() {
                    let wrong = Wrong::new("the base of a model can be neither omitted nor repeated");
                    return Err(wrong.at(Some(at(entry))));
                }
                continue;
            }
            if !wanted {
                continue;
            }
            match repeats(entry, &names, &room)? {
                Some(n) => {
                    repeated += n;
                    if repeated > MOST_REPEATS {
                        let text = format!("the model has more than {MOST_REPEATS} repetitions in total");
                        return Err(Wrong::new(text).at(Some(at(entry))));
                    }
                    runs.extend((0..n).map(|index| (vec![i], Some(index))));
                }
                None => match runs.last_mut().filter(|(run, index)| index.is_none() && run[0] != model.base) {
                    Some((run, _)) => run.push(i),
                    None => runs.push((vec![i], None)),
                },
            }
        }
        runs.extend(model.sections.iter().any(|s| s.root == "set").then_some((Vec::new(), None)));
        Ok(Plan { model, names, runs: runs.into_iter(), first: true, bytes: 0 })
    }

    /// Returns the next text in the scene format, or `None` after the last one. The first text contains the base and
    /// the settings, which are all tables except `[set]`, `[model]` and the entries. The other entries follow in the
    /// order of the file, and `[set]` is last.
    pub fn next_text(&mut self) -> Option<Result<String>> {
        let (run, index) = self.runs.next()?;
        let text = self.text(&run, index);
        self.first = false;
        Some(text)
    }

    fn text(&mut self, run: &[usize], index: Option<usize>) -> Result<String> {
        let model = self.model;
        match index {
            Some(index) => self.names.insert("index".to_owned(), Value::Number(index as f64)),
            None => self.names.remove("index"),
        };
        // Settings precede objects, and `[set]` follows them.
        let of_file = |root: &str| match root {
            "set" => run.is_empty(),
            "model" | "object" | "import" => false,
            _ => self.first,
        };
        let kept = |s: &&Section| s.entry.map_or_else(|| of_file(&s.root), |e| run.contains(&e));
        let head = model.sections.first().map_or(model.text.len(), |s| s.span.start);
        let kept: Vec<_> =
            std::iter::once(0..head).chain(model.sections.iter().filter(kept).map(|s| s.span.clone())).collect();
        let own: Vec<_> = run.iter().flat_map(|e| model.entries[*e].own.clone()).collect();
        let text = filled(&model.doc, &kept, &own, &self.names)?;
        self.bytes += text.len();
        if self.bytes > MOST_BYTES {
            let text = format!("the text of the model's repetitions exceeds {} MiB", MOST_BYTES >> 20);
            let wrong = Wrong::new(text).help("reduce the repetitions, or shorten the file above the repeated entry");
            return Err(wrong.at(run.first().map(|e| at(&model.entries[*e]))));
        }
        Ok(text)
    }
}

/// Returns the values of parameters and constants, and the limit on the size of results, reduced by those computed
/// here.
fn named_values(model: &Model, params: &Params<'_>) -> Result<(Names, Room)> {
    let (mut names, room) = (Names::new(), Room::default());
    for (key, computed) in &model.params {
        let given = params.get(key).and_then(|v| v.to_value()).map_err(|e| Wrong::new(e.text()))?;
        let value = match (Value::of_host(&given), computed) {
            (None, Some(computed)) => Some(computed.value(&names, &room)?),
            (value, _) => value,
        };
        names.extend(value.map(|v| (key.clone(), v)));
    }
    for (name, value, span) in &model.numbers {
        let value = value_of(value, &names, &room).map_err(|e| e.at(Some(span.clone())))?;
        names.insert(name.clone(), value);
    }
    Ok((names, room))
}

fn at(entry: &Entry) -> Range<usize> {
    let written = entry.condition.as_ref().or(entry.repeat.as_ref());
    written.map_or(entry.start..entry.start, |(_, span)| span.clone())
}

/// Evaluates the expressions in a value, and returns all other values unchanged.
fn value_of(value: &Value, names: &Names, room: &Room) -> Result<Value> {
    match value {
        Value::Text(t) if t.starts_with('=') => evaluate(&t[1..], names, room),
        Value::List(all) => all.iter().map(|v| value_of(v, names, room)).collect::<Result<_>>().map(Value::List),
        value => Ok(value.clone()),
    }
}

fn condition(entry: &Entry, names: &Names, room: &Room) -> Result<bool> {
    let Some((value, span)) = &entry.condition else { return Ok(true) };
    match value_of(value, names, room).map_err(|e| e.at(Some(span.clone())))? {
        Value::Bool(b) => Ok(b),
        other => Err(Wrong::new(format!("`if`: expected true or false, found {}", other.describe()))
            .help("such as \"=with_arm\" or \"=preset == 'wide'\"")
            .at(Some(span.clone()))),
    }
}

fn repeats(entry: &Entry, names: &Names, room: &Room) -> Result<Option<usize>> {
    let Some((value, span)) = &entry.repeat else { return Ok(None) };
    match value_of(value, names, room).map_err(|e| e.at(Some(span.clone())))? {
        Value::Number(n) if (0.0..=MOST_REPEATS as f64).contains(&n) && n == libm::floor(n) => Ok(Some(n as usize)),
        other => {
            let text =
                format!("`repeat`: expected a whole number from 0 to {MOST_REPEATS}, found {}", other.describe());
            Err(Wrong::new(text).help("`index` counts from 0").at(Some(span.clone())))
        }
    }
}
