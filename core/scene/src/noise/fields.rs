//! Lookup of the fields of a sensor kind by name, with their shapes and the values that mean "nothing".

use tatu_errors::Error;
use tatu_plugin_api::abi::*;
use tatu_plugins::{FieldSpec, SensorKind, schemas};

use super::error::{NoiseError, noise_error};

/// The field that a name refers to.
pub struct NamedField<'k> {
    /// Index of the field among those of its sensor kind.
    pub index: usize,
    /// The kind's declaration of the field.
    pub info: &'k FieldSpec,
    /// Number of components of an element: the size of the innermost dimension if it is fixed and at most
    /// `MAX_COMPONENTS`, otherwise 1.
    pub components: usize,
    /// The value that means "nothing", one number or one per component; `None` if there is no such value.
    pub nothing: Option<Vec<f64>>,
    /// Index of the field that is 0 where this field has no value, if there is such a field.
    pub valid: Option<usize>,
}

/// Maximum number of components of an element. The values of a larger dimension are treated as separate elements.
pub const MAX_COMPONENTS: usize = 64;

/// Returns the field of a kind with this name. The schema can be omitted from the name if the rest is unambiguous.
pub fn find_field<'k>(kind: &'k SensorKind, name: &str) -> Result<NamedField<'k>, NoiseError> {
    let short = |f: &FieldSpec| f.name.rsplit('.').next() == Some(name);
    let fields = || kind.fields.iter().enumerate();
    let found: Vec<usize> = match fields().find(|(_, f)| f.name == name) {
        Some((i, _)) => vec![i],
        None => fields().filter(|(_, f)| short(f)).map(|(i, _)| i).collect(),
    };
    match found.as_slice() {
        [i] => field_at(kind, *i),
        [] => {
            let known: Vec<&str> = kind.fields.iter().map(|f| f.name.as_str()).collect();
            let shorts = known.iter().filter_map(|n| n.rsplit('.').next());
            let error = Error::new("E101", format!("a sensor of kind `{}` has no field `{name}`", kind.id));
            let error = error.expected(known.join(", ")).nearest(name, known.iter().copied().chain(shorts));
            Err(NoiseError { error, span: None })
        }
        several => {
            let all: Vec<&str> = several.iter().map(|i| kind.fields[*i].name.as_str()).collect();
            Err(noise_error(format!("`{name}` is ambiguous: write the full name in quotes, {}", all.join(" or "))))
        }
    }
}

/// Returns the field of a kind with the given index. Fails for a field that contains objects.
pub fn field_at(kind: &SensorKind, index: usize) -> Result<NamedField<'_>, NoiseError> {
    let info = &kind.fields[index];
    if info.elem == TATU_ELEM_OBJECT {
        return Err(noise_error(format!("`{}` contains objects, but noise applies only to numbers", info.name)));
    }
    let shape = shape(info);
    let components = match shape.last() {
        Some(n) if (1..=MAX_COMPONENTS as u32).contains(n) => *n as usize,
        _ => 1,
    };
    let declared = schemas::all_schemas().iter().flat_map(|s| &s.fields).find(|f| f.name == info.name);
    let valid = info.valid.as_ref().or_else(|| declared?.valid.as_ref());
    let valid = valid.and_then(|v| kind.fields.iter().position(|f| f.name == *v && f.elem != TATU_ELEM_OBJECT));
    let valid = valid.filter(|i| shape.starts_with(self::shape(&kind.fields[*i])));
    Ok(NamedField { index, info, components, nothing: nothing(info, declared, components), valid })
}

/// Returns the declared shape without trailing dimensions of 1.
fn shape(info: &FieldSpec) -> &[u32] {
    let n = info.dims.iter().rposition(|d| *d != 1).map_or(0, |i| i + 1);
    &info.dims[..n]
}

fn nothing(info: &FieldSpec, declared: Option<&schemas::SchemaField>, components: usize) -> Option<Vec<f64>> {
    let Some(words) = info.nothing.as_ref().or_else(|| Some(&declared?.nothing)) else {
        // If neither the field nor a standard schema declares the value, it is infinity for floats, which cannot be a
        // measured value, and 0 for integers.
        return Some(vec![if matches!(info.elem, TATU_ELEM_F64 | TATU_ELEM_F32) { f64::INFINITY } else { 0.0 }]);
    };
    let number = |word: &str| if matches!(word, "infinity" | "inf") { Some(f64::INFINITY) } else { word.parse().ok() };
    let all: Option<Vec<f64>> = words.split_whitespace().map(number).collect();
    all.filter(|v| v.len() == 1 || v.len() == components)
}

impl NamedField<'_> {
    /// Checks that another field has one element for each element of this one.
    pub fn check_same_shape(&self, other: &NamedField<'_>) -> Result<(), NoiseError> {
        if shape(self.info) == shape(other.info) {
            return Ok(());
        }
        Err(noise_error(format!("`{}` must have the same shape as `{}`", other.info.name, self.info.name)))
    }

    /// Checks that another field can mark the valid elements of this one, with one mark for each element or for each
    /// index in the leading dimensions, or with a single mark.
    pub fn check_valid_field(&self, other: &NamedField<'_>) -> Result<(), NoiseError> {
        if other.info.name == self.info.name {
            return Err(noise_error("`valid` refers to the field itself, but must be the name of another field"));
        }
        if shape(self.info).starts_with(shape(other.info)) {
            return Ok(());
        }
        let (this, other) = (&self.info.name, &other.info.name);
        Err(noise_error(format!(
            "`{other}` cannot mark valid elements of `{this}`: its shape must be the same, or leading dimensions of it"
        )))
    }
}
