//! Generates the scene texts from which a model is built, by applying its conditions, repetitions and parameter values.

use std::ops::Range;

use tatu_plugin_api::safe::Params;

use crate::{
    error::{ModelError, Result},
    expression::{ExpressionValue, NamedValues, SizeBudget, value_of},
    fill::fill_expressions,
    model::ParsedModel,
    sections::{ModelEntry, TextSection},
};

/// Maximum number of repetitions in a model.
const MAX_REPEATS: usize = 10_000;
/// Maximum total size of the texts of a model, bytes. The text of each repetition is padded with the line breaks of the
/// file above its entry.
const MAX_TEXT_BYTES: usize = 64 << 20;

/// One text of a plan: the indices of its entries in the model, and the value of `index` if the entry is repeated.
/// Without entries, the text contains the tables `[set]`.
type EntryRun = (Vec<usize>, Option<usize>);

/// The sequence of texts from which a model is built with given parameters.
pub struct BuildPlan<'m> {
    model: &'m ParsedModel,
    names: NamedValues,
    runs: std::vec::IntoIter<EntryRun>,
    first: bool,
    /// Total size of the texts so far, bytes.
    bytes: usize,
}

impl<'m> BuildPlan<'m> {
    /// Determines which entries are built and how many times.
    pub fn new(model: &'m ParsedModel, params: &Params<'_>) -> Result<Self> {
        let (names, room) = named_values(model, params)?;
        let mut runs: Vec<EntryRun> = vec![(vec![model.base], None)];
        let mut repeated = 0;
        for (i, entry) in model.entries.iter().enumerate() {
            let wanted = evaluate_condition(entry, &names, &room)?;
            if i == model.base {
                if !wanted || entry.repeat.is_some() {
                    let wrong = ModelError::new("the base of a model can be neither omitted nor repeated");
                    return Err(wrong.at(Some(entry_range(entry))));
                }
                continue;
            }
            if !wanted {
                continue;
            }
            match repeat_count(entry, &names, &room)? {
                Some(n) => {
                    repeated += n;
                    if repeated > MAX_REPEATS {
                        let text = format!("the model has more than {MAX_REPEATS} repetitions in total");
                        return Err(ModelError::new(text).at(Some(entry_range(entry))));
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
        Ok(BuildPlan { model, names, runs: runs.into_iter(), first: true, bytes: 0 })
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
            Some(index) => self.names.insert("index".to_owned(), ExpressionValue::Number(index as f64)),
            None => self.names.remove("index"),
        };
        // Settings precede objects, and `[set]` follows them.
        let of_file = |root: &str| match root {
            "set" => run.is_empty(),
            "model" | "object" | "import" => false,
            _ => self.first,
        };
        let kept = |s: &&TextSection| s.entry.map_or_else(|| of_file(&s.root), |e| run.contains(&e));
        let head = model.sections.first().map_or(model.text.len(), |s| s.span.start);
        let kept: Vec<_> =
            std::iter::once(0..head).chain(model.sections.iter().filter(kept).map(|s| s.span.clone())).collect();
        let own: Vec<_> = run.iter().flat_map(|e| model.entries[*e].own_keys.clone()).collect();
        let text = fill_expressions(&model.doc, &kept, &own, &self.names)?;
        self.bytes += text.len();
        if self.bytes > MAX_TEXT_BYTES {
            let text = format!("the text of the model's repetitions exceeds {} MiB", MAX_TEXT_BYTES >> 20);
            let wrong =
                ModelError::new(text).help("reduce the repetitions, or shorten the file above the repeated entry");
            return Err(wrong.at(run.first().map(|e| entry_range(&model.entries[*e]))));
        }
        Ok(text)
    }
}

/// Returns the values of parameters and constants, and the limit on the size of results, reduced by those computed
/// here.
fn named_values(model: &ParsedModel, params: &Params<'_>) -> Result<(NamedValues, SizeBudget)> {
    let (mut names, room) = (NamedValues::new(), SizeBudget::default());
    for (key, computed) in &model.params {
        let given = params.get(key).and_then(|v| v.to_value()).map_err(|e| ModelError::new(e.text()))?;
        let value = match (ExpressionValue::from_host(&given), computed) {
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

fn entry_range(entry: &ModelEntry) -> Range<usize> {
    let written = entry.condition.as_ref().or(entry.repeat.as_ref());
    written.map_or(entry.start..entry.start, |(_, span)| span.clone())
}

fn evaluate_condition(entry: &ModelEntry, names: &NamedValues, room: &SizeBudget) -> Result<bool> {
    let Some((value, span)) = &entry.condition else { return Ok(true) };
    match value_of(value, names, room).map_err(|e| e.at(Some(span.clone())))? {
        ExpressionValue::Bool(b) => Ok(b),
        other => Err(ModelError::new(format!("`if`: expected true or false, found {}", other.describe()))
            .help("such as \"=with_arm\" or \"=preset == 'wide'\"")
            .at(Some(span.clone()))),
    }
}

fn repeat_count(entry: &ModelEntry, names: &NamedValues, room: &SizeBudget) -> Result<Option<usize>> {
    let Some((value, span)) = &entry.repeat else { return Ok(None) };
    match value_of(value, names, room).map_err(|e| e.at(Some(span.clone())))? {
        ExpressionValue::Number(n) if (0.0..=MAX_REPEATS as f64).contains(&n) && n == libm::floor(n) => {
            Ok(Some(n as usize))
        }
        other => {
            let text = format!("`repeat`: expected a whole number from 0 to {MAX_REPEATS}, found {}", other.describe());
            Err(ModelError::new(text).help("`index` counts from 0").at(Some(span.clone())))
        }
    }
}
