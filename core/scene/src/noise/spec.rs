//! Declarations of noise by field name, and their TOML form.

use std::{collections::BTreeMap, fmt::Write, ops::Range};

use serde::{Deserialize, Serialize};
use tatu_errors::{Error, nearest};
use tatu_plugins::SensorKind;
use toml_edit::{Item, TableLike};

use super::{
    error::{NoiseError, noise_error},
    fields::{NamedField, find_field},
};

/// The noise of a sensor.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct NoiseSpec {
    /// Age of the readings that scripts and other clients receive, s; `None` if it is not declared.
    pub latency: Option<f64>,
    /// Noise by full field name. An empty entry removes the noise that a preset declares for the field.
    pub fields: BTreeMap<String, FieldNoise>,
    /// Whether the declaration states that there is no noise.
    pub none: bool,
}

/// The noise of one field, in the field's unit.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct FieldNoise {
    /// Standard deviation of white noise, as coefficients of a polynomial in ascending order: one list for all
    /// components, or one per component.
    pub sigma: Vec<Vec<f64>>,
    /// Spectral density of white noise, per square root of Hz. The standard deviation is the density times the square
    /// root of the measurement rate. Like the lists below, it contains one number for all components, or one for each.
    pub density: Vec<f64>,
    /// The field that is the variable of the polynomial; if `None`, the value itself.
    pub of: Option<String>,
    /// Half width of uniform noise.
    pub uniform: Vec<f64>,
    /// Half width of a uniform offset that is drawn once per run.
    pub shift: Vec<f64>,
    /// Standard deviation of a normal offset that is drawn once per run.
    pub shift_sigma: Vec<f64>,
    /// A slowly varying bias.
    pub walk: Option<GaussMarkovProcess>,
    /// Standard deviation, per square root of a second, of an unbounded random walk that starts at 0.
    pub random_walk: Vec<f64>,
    /// Resolution, to multiples of which values are rounded.
    pub step: Vec<f64>,
    /// Resolution of the inverse value, to multiples of which the inverses of values are rounded.
    pub inverse_step: Vec<f64>,
    /// Probability that an element is lost.
    pub dropout: f64,
    /// The field that is 0 where an element is lost.
    pub valid: Option<String>,
    /// Rare, large errors.
    pub outliers: Option<OutlierNoise>,
    /// Minimum and maximum value; elements outside the range are lost.
    pub limits: Option<[f64; 2]>,
    /// Minimum and maximum value; elements are clamped to the range, as in a device that saturates.
    pub clamp: Option<[f64; 2]>,
}

/// A first-order Gauss-Markov process.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct GaussMarkovProcess {
    /// Long-run standard deviation.
    pub sigma: Vec<f64>,
    /// Time constant, s.
    pub tau: f64,
}

/// Large errors that occur with a given probability.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct OutlierNoise {
    /// Probability of an error, 0 to 1.
    pub probability: f64,
    /// Standard deviation of a normal error.
    pub sigma: Vec<f64>,
    /// Half width of a uniform error.
    pub uniform: Vec<f64>,
}

type NoiseResult<T> = Result<T, NoiseError>;

const KEYS: &[&str] = &[
    "sigma",
    "density",
    "of",
    "uniform",
    "shift",
    "shift_sigma",
    "walk",
    "random_walk",
    "clamp",
    "step",
    "inverse_step",
    "dropout",
    "valid",
    "outliers",
    "limits",
];
const WALK_KEYS: &[&str] = &["sigma", "tau_s"];
const OUTLIER_KEYS: &[&str] = &["probability", "sigma", "uniform"];

/// Maximum latency, s. It is limited because each delayed reading is stored in full.
const MAX_LATENCY_S: f64 = 10.0;

impl NoiseSpec {
    /// Parses a TOML table, or the string `none`. If the sensor kind is given, the declaration is checked against it,
    /// and names of fields can omit the schema.
    pub fn parse(text: &str, kind: Option<&SensorKind>) -> NoiseResult<Self> {
        if matches!(text.trim(), "" | "none") {
            return Ok(NoiseSpec { none: true, ..Default::default() });
        }
        let doc = toml_edit::Document::parse(text).map_err(|e| NoiseError {
            error: Error::new("E102", format!("`noise` is not valid TOML: {}", e.message())),
            span: e.span(),
        })?;
        Self::read(doc.as_table(), kind)
    }

    /// Reads a noise declaration from a scene file: a table, or a string in the form that [`parse`](Self::parse)
    /// accepts.
    pub fn of_item(item: &Item, kind: Option<&SensorKind>) -> NoiseResult<Self> {
        match (item.as_table_like(), item.as_str()) {
            (Some(table), _) => Self::read(table, kind),
            (None, Some(text)) => Self::parse(text, kind).map_err(|w| match text.contains('\n') {
                true => NoiseError { error: w.with_line(text), span: item.span() },
                false => NoiseError { span: item.span(), ..w },
            }),
            _ => Err(NoiseError {
                error: Error::new("E102", "`noise`: expected a table, or \"none\"")
                    .expected("[object.noise.<field>], or noise = { <field> = { sigma = 0.01 } }"),
                span: item.span(),
            }),
        }
    }

    /// Reads a table. An empty table declares that there is no noise.
    pub fn read(table: &dyn TableLike, kind: Option<&SensorKind>) -> NoiseResult<Self> {
        let mut spec = NoiseSpec { none: table.is_empty(), ..Default::default() };
        for (key, item) in table.iter() {
            let at = span(table, key);
            if key == "latency_s" {
                spec.latency = Some(number(key, item, 0.0, MAX_LATENCY_S).map_err(|e| e.at_span(&at))?);
                continue;
            }
            let Some(inner) = item.as_table_like() else {
                let known = ["latency_s", "<field> = { ... }"].join(", ");
                let error = Error::new("E101", format!("unknown key `{key}` of `noise`")).expected(known);
                return Err(NoiseError { error: error.nearest(key, ["latency_s"]), span: at });
            };
            // In `[noise.range_scan.distance]`, without quotes, the key `range_scan` is a schema, and its table
            // contains fields.
            let schema = format!("{key}.");
            // A field can have the same name as its schema, such as `pressure.pressure`.
            let is_field = |k: &SensorKind| {
                let is_of_schema = |short: &str| k.fields.iter().any(|f| f.name == format!("{schema}{short}"));
                find_field(k, key).is_ok() && !inner.iter().all(|(short, _)| is_of_schema(short))
            };
            if kind.is_some_and(|k| k.fields.iter().any(|f| f.name.starts_with(&schema)) && !is_field(k)) {
                for (short, item) in inner.iter() {
                    let at = span(inner, short);
                    let Some(inner) = item.as_table_like() else {
                        let error = Error::new("E102", format!("`{key}.{short}` of `noise`: expected a table"));
                        return Err(NoiseError { error, span: at });
                    };
                    spec.add(&format!("{schema}{short}"), inner, kind, &at)?;
                }
                continue;
            }
            spec.add(key, inner, kind, &at)?;
        }
        Ok(spec)
    }

    fn add(
        &mut self,
        name: &str,
        table: &dyn TableLike,
        kind: Option<&SensorKind>,
        at: &Option<Range<usize>>,
    ) -> NoiseResult<()> {
        let field = kind.map(|k| find_field(k, name)).transpose().map_err(|e| e.at_span(at))?;
        let full = field.as_ref().map_or(name, |f| &f.info.name).to_owned();
        let noise = FieldNoise::read(table, kind.zip(field))?;
        if self.fields.insert(full.clone(), noise).is_some() {
            return Err(NoiseError {
                error: Error::new("E102", format!("`noise` configures `{full}` twice")),
                span: at.clone(),
            });
        }
        Ok(())
    }

    /// Returns the combination of this declaration with an earlier one, which it overrides field by field, or `None` if
    /// no noise remains.
    pub fn merge_over(self, before: Option<&NoiseSpec>) -> Option<NoiseSpec> {
        if self.none {
            return None;
        }
        let mut out = before.cloned().unwrap_or_default();
        out.latency = self.latency.or(out.latency).filter(|s| *s > 0.0);
        out.fields.extend(self.fields);
        out.fields.retain(|_, f| *f != FieldNoise::default());
        (out.latency.is_some() || !out.fields.is_empty()).then_some(out)
    }

    /// Formats the declaration as TOML, for [`parse`](Self::parse).
    pub fn to_toml(&self) -> String {
        let mut out = String::new();
        if let Some(s) = self.latency {
            let _ = writeln!(out, "latency_s = {s:?}");
        }
        for (name, f) in &self.fields {
            let _ = writeln!(out, "[\"{name}\"]");
            f.write(&mut out);
        }
        out
    }
}

impl FieldNoise {
    fn read(table: &dyn TableLike, of: Option<(&SensorKind, NamedField<'_>)>) -> NoiseResult<Self> {
        let mut n = FieldNoise::default();
        let components = of.as_ref().map(|(_, m)| m.components);
        let other = |key: &str, item: &Item| -> NoiseResult<String> {
            let name = item.as_str().ok_or_else(|| noise_error(format!("`{key}`: expected the name of a field")))?;
            let Some((kind, this)) = &of else { return Ok(name.to_owned()) };
            let other = find_field(kind, name)?;
            match key {
                "of" => this.check_same_shape(&other)?,
                _ => this.check_valid_field(&other)?,
            }
            Ok(other.info.name.clone())
        };
        for (key, item) in table.iter() {
            let at = span(table, key);
            let mut read = || -> NoiseResult<()> {
                let each = |least: f64| each(key, item, components, least);
                match key {
                    "sigma" => n.sigma = sigma(key, item, components)?,
                    "density" => n.density = each(0.0)?,
                    "of" => n.of = Some(other(key, item)?),
                    "uniform" => n.uniform = each(0.0)?,
                    "shift" => n.shift = each(0.0)?,
                    "shift_sigma" => n.shift_sigma = each(0.0)?,
                    "walk" => {
                        let t = sub_table(key, item, WALK_KEYS)?;
                        let tau = required(t, key, "tau_s")?;
                        let sigma = required(t, key, "sigma")?;
                        n.walk = Some(GaussMarkovProcess {
                            sigma: self::each("sigma", sigma, components, 0.0)
                                .map_err(|e| e.at_span(&span(t, "sigma")))?,
                            tau: number("tau_s", tau, f64::MIN_POSITIVE, f64::MAX)
                                .map_err(|e| e.at_span(&span(t, "tau_s")))?,
                        });
                    }
                    "random_walk" => n.random_walk = each(0.0)?,
                    "step" => n.step = each(0.0)?,
                    "inverse_step" => n.inverse_step = each(0.0)?,
                    "dropout" => n.dropout = number(key, item, 0.0, 1.0)?,
                    "valid" => n.valid = Some(other(key, item)?),
                    "outliers" => {
                        let t = sub_table(key, item, OUTLIER_KEYS)?;
                        let size = |key: &str| match t.get(key) {
                            Some(item) => self::each(key, item, components, 0.0).map_err(|e| e.at_span(&span(t, key))),
                            None => Ok(Vec::new()),
                        };
                        let (sigma, uniform) = (size("sigma")?, size("uniform")?);
                        let probability = number("probability", required(t, key, "probability")?, 0.0, 1.0)
                            .map_err(|e| e.at_span(&span(t, "probability")))?;
                        if sigma.is_empty() && uniform.is_empty() {
                            return Err(noise_error(
                                "`outliers` must contain `sigma` or `uniform`, the size of the errors",
                            ));
                        }
                        n.outliers = Some(OutlierNoise { probability, sigma, uniform });
                    }
                    "limits" => n.limits = Some(limits(key, item)?),
                    "clamp" => n.clamp = Some(limits(key, item)?),
                    _ => {
                        let error = Error::new("E101", format!("unknown key `{key}` in the noise of a field"));
                        let error = error.expected(KEYS.join(", ")).nearest(key, KEYS.iter().copied());
                        return Err(NoiseError { error, span: at.clone() });
                    }
                }
                Ok(())
            };
            read().map_err(|w| w.at_span(&item.span().or_else(|| at.clone())))?;
        }
        if n.of.is_some() && n.sigma.is_empty() {
            return Err(noise_error("`of` requires `sigma`, the polynomial in that field").at_span(&span(table, "of")));
        }
        if let Some((_, this)) = &of
            && n.can_lose_elements()
            && n.valid.is_none()
            && this.valid.is_none()
            && this.nothing.is_none()
        {
            let name = &this.info.name;
            let text = format!(
                "`{name}` has no value that means \"nothing\": set `valid` to the field that marks valid elements"
            );
            let key = ["dropout", "limits", "inverse_step"].into_iter().find(|k| table.contains_key(k));
            return Err(noise_error(text).at_span(&span(table, key.unwrap_or_default())));
        }
        Ok(n)
    }

    fn can_lose_elements(&self) -> bool {
        self.dropout > 0.0 || self.limits.is_some() || self.inverse_step.iter().any(|s| *s > 0.0)
    }

    fn write(&self, out: &mut String) {
        // A single number is written without brackets.
        let list = |v: &[f64]| match v {
            [x] => format!("{x:?}"),
            v => format!("{v:?}"),
        };
        let sigma = match self.sigma.as_slice() {
            [one] => list(one),
            all => format!("{all:?}"),
        };
        let mut put = |key: &str, there: bool, value: String| {
            if there {
                let _ = writeln!(out, "{key} = {value}");
            }
        };
        let quoted = |t: &Option<String>| t.as_ref().map_or(String::new(), |t| format!("{t:?}"));
        put("sigma", !self.sigma.is_empty(), sigma);
        put("density", !self.density.is_empty(), list(&self.density));
        put("of", self.of.is_some(), quoted(&self.of));
        put("uniform", !self.uniform.is_empty(), list(&self.uniform));
        put("shift", !self.shift.is_empty(), list(&self.shift));
        put("shift_sigma", !self.shift_sigma.is_empty(), list(&self.shift_sigma));
        if let Some(w) = &self.walk {
            put("walk", true, format!("{{ sigma = {}, tau_s = {:?} }}", list(&w.sigma), w.tau));
        }
        put("random_walk", !self.random_walk.is_empty(), list(&self.random_walk));
        put("step", !self.step.is_empty(), list(&self.step));
        put("inverse_step", !self.inverse_step.is_empty(), list(&self.inverse_step));
        put("dropout", self.dropout != 0.0, format!("{:?}", self.dropout));
        put("valid", self.valid.is_some(), quoted(&self.valid));
        if let Some(o) = &self.outliers {
            let part =
                |key: &str, v: &[f64]| if v.is_empty() { String::new() } else { format!(", {key} = {}", list(v)) };
            let (sigma, uniform) = (part("sigma", &o.sigma), part("uniform", &o.uniform));
            put("outliers", true, format!("{{ probability = {:?}{sigma}{uniform} }}", o.probability));
        }
        for (key, range) in [("limits", self.limits), ("clamp", self.clamp)] {
            put(key, range.is_some(), range.map_or(String::new(), |[low, high]| format!("[{low:?}, {high:?}]")));
        }
    }
}

fn span(table: &dyn TableLike, key: &str) -> Option<Range<usize>> {
    table.key(key).and_then(|k| k.span())
}

fn float(item: &toml_edit::Value) -> Option<f64> {
    item.as_float().or_else(|| item.as_integer().map(|i| i as f64)).filter(|x| !x.is_nan())
}

fn number(key: &str, item: &Item, least: f64, greatest: f64) -> NoiseResult<f64> {
    let found = item.as_value().and_then(float);
    let expected = match (least, greatest) {
        (0.0, f64::MAX) => "a number, at least 0".to_owned(),
        (_, f64::MAX) => "a number greater than 0".to_owned(),
        _ => format!("a number from {least} to {greatest}"),
    };
    found.filter(|x| (least..=greatest).contains(x)).ok_or_else(|| noise_error(format!("`{key}`: expected {expected}")))
}

/// Reads one number for all components, or a list with one number per component.
fn each(key: &str, item: &Item, components: Option<usize>, least: f64) -> NoiseResult<Vec<f64>> {
    let Some(array) = item.as_array() else { return Ok(vec![number(key, item, least, f64::MAX)?]) };
    let numbers: Option<Vec<f64>> = array.iter().map(|v| float(v).filter(|x| x.is_finite() && *x >= least)).collect();
    let numbers = numbers.ok_or_else(|| noise_error(format!("`{key}`: expected numbers, each at least {least}")))?;
    count(key, numbers.len(), components)?;
    Ok(numbers)
}

fn count(key: &str, n: usize, components: Option<usize>) -> NoiseResult<()> {
    match components {
        Some(c) if n != c && n != 1 && c == 1 => Err(noise_error(format!("`{key}`: expected one number, found {n}"))),
        Some(c) if n != c && n != 1 => {
            Err(noise_error(format!("`{key}`: expected one number, or {c} numbers, one for each component; found {n}")))
        }
        None if n == 0 => Err(noise_error(format!("`{key}`: expected at least one number, found an empty list"))),
        _ => Ok(()),
    }
}

/// Reads a number, a polynomial, or a polynomial per component.
fn sigma(key: &str, item: &Item, components: Option<usize>) -> NoiseResult<Vec<Vec<f64>>> {
    let expected = || noise_error(format!("`{key}`: expected a number, or [c0, c1, ...] for c0 + c1 x + c2 x^2 ..."));
    let polynomial = |a: &toml_edit::Array| -> Option<Vec<f64>> {
        a.iter().map(|v| float(v).filter(|x| x.is_finite())).collect::<Option<Vec<_>>>().filter(|v| !v.is_empty())
    };
    let Some(array) = item.as_array() else { return Ok(vec![vec![number(key, item, 0.0, f64::MAX)?]]) };
    if !array.iter().any(toml_edit::Value::is_array) {
        return Ok(vec![polynomial(array).ok_or_else(expected)?]);
    }
    let all: Option<Vec<_>> = array.iter().map(|v| v.as_array().and_then(polynomial)).collect();
    let all = all.ok_or_else(expected)?;
    count(key, all.len(), components)?;
    Ok(all)
}

fn limits(key: &str, item: &Item) -> NoiseResult<[f64; 2]> {
    let numbers: Option<Vec<f64>> = item.as_array().and_then(|a| a.iter().map(float).collect());
    match numbers.as_deref() {
        Some([low, high]) if low <= high => Ok([*low, *high]),
        _ => Err(noise_error(format!("`{key}`: expected [lowest, highest] in ascending order"))),
    }
}

fn sub_table<'t>(key: &str, item: &'t Item, known: &[&str]) -> NoiseResult<&'t dyn TableLike> {
    let table = item
        .as_table_like()
        .ok_or_else(|| noise_error(format!("`{key}`: expected a table of {}", known.join(", "))))?;
    match table.iter().find(|(k, _)| !known.contains(k)) {
        None => Ok(table),
        Some((other, _)) => {
            let error = Error::new("E101", format!("unknown key `{other}` of `{key}`")).expected(known.join(", "));
            let error = match nearest(other, known.iter().copied()) {
                Some(near) => error.help(format!("did you mean `{near}`?")),
                None => error,
            };
            Err(NoiseError { error, span: span(table, other) })
        }
    }
}

fn required<'t>(table: &'t dyn TableLike, owner: &str, key: &str) -> NoiseResult<&'t Item> {
    table.get(key).ok_or_else(|| NoiseError {
        error: Error::new("E104", format!("`{owner}` has no `{key}`")),
        span: table.iter().next().and_then(|(k, _)| span(table, k)),
    })
}
