//! Metrics: values that are computed from a run.

use serde::{Deserialize, Serialize};
use tatu_core::{
    Channel, World,
    errors::{Error, Result},
};

/// The definition of a value that is computed from a run.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Metric {
    /// Path of the object, or an empty string for the world.
    pub object: String,
    /// Name of a property, or of a field of the object's readings.
    pub field: String,
    /// Index of the element to use, from 0. If it is `None`, all elements are reduced to one number.
    #[serde(default)]
    pub index: Option<usize>,
    /// How the elements are reduced to one number; required if there are several and `index` is `None`.
    #[serde(default)]
    pub reduce: Option<Reduction>,
    /// How the values of all steps are combined.
    #[serde(default)]
    pub over: StepAggregation,
}

/// How several elements are reduced to one number.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Reduction {
    /// The first element.
    First,
    /// The least element.
    Min,
    /// The greatest element.
    Max,
    /// The sum of the elements.
    Sum,
    /// The mean of the elements.
    Mean,
    /// The Euclidean norm of the elements.
    Norm,
}

/// How the values after each step are combined into one number.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum StepAggregation {
    /// The value after the last step, or the initial value if no step is run.
    #[default]
    End,
    /// The least value.
    Min,
    /// The greatest value.
    Max,
    /// The sum over all steps.
    Sum,
    /// The mean over all steps.
    Mean,
    /// The path length of the value: the sum of the magnitudes of its changes.
    Way,
}

/// The evaluation of a metric during a run.
pub(super) struct MetricEvaluation<'a> {
    name: &'a str,
    metric: &'a Metric,
    channel: Channel,
    numbers: Vec<f64>,
    /// Value after the previous step.
    last: Option<f64>,
    /// Value accumulated so far; `None` before the first step.
    accumulated: Option<f64>,
    count: u64,
}

impl<'a> MetricEvaluation<'a> {
    pub fn new(name: &'a str, metric: &'a Metric, world: &World) -> Result<Self> {
        let channel = world.channel(&metric.object, &metric.field);
        let channel = channel.map_err(|r| metric_error(name, &r.1))?;
        let count = channel.shape.iter().product();
        if let Some(index) = metric.index.filter(|i| *i >= count) {
            let text = format!(
                "`{}` of {} has {count} elements, so the index {index} is out of range",
                metric.field, metric.object
            );
            return Err(metric_error(name, &text).expected(format!("an index from 0 to {}", count.saturating_sub(1))));
        }
        if count != 1 && metric.index.is_none() && metric.reduce.is_none() {
            let text =
                format!("`{}` of `{}` has {count} elements, but a metric is one number", metric.field, metric.object);
            return Err(metric_error(name, &text).help("select an element by `index`, or combine all by `reduce`"));
        }
        let mut taken = MetricEvaluation {
            name,
            metric,
            channel,
            numbers: vec![0.0; count],
            last: None,
            accumulated: None,
            count: 0,
        };
        // `StepAggregation::Way` starts at the initial value; all others use the values after steps.
        taken.last = Some(taken.read(world)?);
        Ok(taken)
    }

    fn read(&mut self, world: &World) -> Result<f64> {
        world.read_channel(&self.channel, &mut self.numbers).map_err(|r| metric_error(self.name, &r.1))?;
        Ok(match self.metric.index {
            Some(index) => self.numbers[index],
            None => self.metric.reduce.unwrap_or(Reduction::First).reduce(&self.numbers),
        })
    }

    pub fn after_step(&mut self, world: &World) -> Result {
        let number = self.read(world)?;
        let before = self.last.replace(number).unwrap_or(number);
        self.count += 1;
        let old = self.accumulated;
        self.accumulated = match self.metric.over {
            StepAggregation::End => Some(number),
            StepAggregation::Min => Some(old.map_or(number, |x| x.min(number))),
            StepAggregation::Max => Some(old.map_or(number, |x| x.max(number))),
            StepAggregation::Sum | StepAggregation::Mean => Some(old.unwrap_or(0.0) + number),
            StepAggregation::Way => Some(old.unwrap_or(0.0) + (number - before).abs()),
        };
        Ok(())
    }

    /// Returns the value of the metric, or `None` if it has no finite value, such as a mean over no steps.
    pub fn value(&self) -> Option<f64> {
        let number = match self.metric.over {
            StepAggregation::End => self.accumulated.or(self.last),
            StepAggregation::Mean => self.accumulated.map(|sum| sum / self.count as f64),
            _ => self.accumulated,
        };
        number.filter(|x| x.is_finite())
    }
}

impl Reduction {
    fn reduce(self, numbers: &[f64]) -> f64 {
        let n = numbers.len() as f64;
        let sum = || numbers.iter().sum::<f64>();
        match self {
            Reduction::First => numbers.first().copied().unwrap_or(f64::NAN),
            Reduction::Min => numbers.iter().copied().reduce(f64::min).unwrap_or(f64::NAN),
            Reduction::Max => numbers.iter().copied().reduce(f64::max).unwrap_or(f64::NAN),
            Reduction::Sum => sum(),
            Reduction::Mean => sum() / n,
            Reduction::Norm => numbers.iter().map(|x| x * x).sum::<f64>().sqrt(),
        }
    }
}

fn metric_error(name: &str, text: &str) -> Error {
    Error::new("E102", format!("metric `{name}`: {text}"))
}
