//! Converts values between the simulator and Python.

use numpy::{PyArray1, PyReadonlyArrayDyn};
use pyo3::{
    IntoPyObjectExt,
    exceptions::PyTypeError,
    prelude::*,
    types::{PyBool, PyByteArray, PyBytes, PyDict, PyFloat, PyInt, PyList, PyMapping, PySequence, PyString},
};
use tatu_plugin_api::safe::Value;

/// Maximum nesting depth of a value. Deeper values are refused, because they may contain themselves.
const MAX_DEPTH: usize = 64;

/// Converts a value for Python: arrays of numbers become NumPy arrays; text becomes `str`, or `bytes` if it is not
/// UTF-8.
pub fn to_python<'py>(py: Python<'py>, value: &Value) -> PyResult<Bound<'py, PyAny>> {
    match value {
        Value::Nil => Ok(py.None().into_bound(py)),
        Value::Bool(b) => b.into_bound_py_any(py),
        Value::Int(i) => i.into_bound_py_any(py),
        Value::Float(x) => x.into_bound_py_any(py),
        Value::Text(t) => match std::str::from_utf8(t) {
            Ok(text) => text.into_bound_py_any(py),
            Err(_) => Ok(PyBytes::new(py, t).into_any()),
        },
        Value::Bytes(b) => Ok(PyBytes::new(py, b).into_any()),
        Value::Floats(v) => Ok(PyArray1::from_slice(py, v).into_any()),
        Value::Ints(v) => Ok(PyArray1::from_slice(py, v).into_any()),
        Value::List(items) => {
            let items = items.iter().map(|v| to_python(py, v)).collect::<PyResult<Vec<_>>>()?;
            Ok(PyList::new(py, items)?.into_any())
        }
        Value::Map(pairs) => {
            let dict = PyDict::new(py);
            for (key, value) in pairs {
                dict.set_item(to_python(py, key)?, to_python(py, value)?)?;
            }
            Ok(dict.into_any())
        }
        Value::Func(f) => f.into_bound_py_any(py),
        Value::Object(o) => o.into_bound_py_any(py),
    }
}

/// Converts a Python value for the simulator.
///
/// # Errors
/// `TypeError` if the simulator has no corresponding type.
pub fn from_python(value: &Bound<'_, PyAny>) -> PyResult<Value> {
    from_python_at(value, 0)
}

fn from_python_at(value: &Bound<'_, PyAny>, depth: usize) -> PyResult<Value> {
    if depth > MAX_DEPTH {
        return Err(PyTypeError::new_err("the value is nested too deeply, or contains itself"));
    }
    if value.is_none() {
        return Ok(Value::Nil);
    }
    if let Ok(b) = value.cast::<PyBool>() {
        return Ok(Value::Bool(b.is_true()));
    }
    if value.is_instance_of::<PyInt>() {
        return value.extract().map(Value::Int);
    }
    if value.is_instance_of::<PyFloat>() {
        return value.extract().map(Value::Float);
    }
    if let Ok(text) = value.cast::<PyString>() {
        return Ok(Value::text(text.to_cow()?.as_ref()));
    }
    if let Ok(bytes) = value.cast::<PyBytes>() {
        return Ok(Value::Bytes(bytes.as_bytes().to_vec()));
    }
    if let Ok(bytes) = value.cast::<PyByteArray>() {
        return Ok(Value::Bytes(bytes.to_vec()));
    }
    if let Some(array) = array(value) {
        return Ok(array);
    }
    if let Ok(mapping) = value.cast::<PyMapping>() {
        let mut pairs = Vec::new();
        for item in mapping.items()?.iter() {
            let (key, value): (Bound<'_, PyAny>, Bound<'_, PyAny>) = item.extract()?;
            pairs.push((from_python_at(&key, depth + 1)?, from_python_at(&value, depth + 1)?));
        }
        return Ok(Value::Map(pairs));
    }
    if let Ok(sequence) = value.cast::<PySequence>() {
        let mut items = Vec::new();
        for item in sequence.try_iter()? {
            items.push(from_python_at(&item?, depth + 1)?);
        }
        return Ok(numbers(&items).unwrap_or(Value::List(items)));
    }
    // NumPy scalars are not instances of `int` and `float`, but can be converted.
    if let Ok(i) = value.extract::<i64>() {
        return Ok(Value::Int(i));
    }
    if let Ok(x) = value.extract::<f64>() {
        return Ok(Value::Float(x));
    }
    let kind = value.get_type().name().map(|n| n.to_string()).unwrap_or_default();
    Err(PyTypeError::new_err(format!(
        "a {kind} cannot be passed to the simulator; expected a number, a string, bytes, an array, a list or a dict"
    )))
}

/// Returns the elements of a NumPy array, row by row, or `None` if the value is not an array of numbers.
fn array(value: &Bound<'_, PyAny>) -> Option<Value> {
    if let Ok(a) = value.extract::<PyReadonlyArrayDyn<'_, f64>>() {
        return Some(Value::Floats(a.as_array().iter().copied().collect()));
    }
    if let Ok(a) = value.extract::<PyReadonlyArrayDyn<'_, f32>>() {
        return Some(Value::Floats(a.as_array().iter().map(|x| f64::from(*x)).collect()));
    }
    if let Ok(a) = value.extract::<PyReadonlyArrayDyn<'_, i64>>() {
        return Some(Value::Ints(a.as_array().iter().copied().collect()));
    }
    if let Ok(a) = value.extract::<PyReadonlyArrayDyn<'_, i32>>() {
        return Some(Value::Ints(a.as_array().iter().map(|x| i64::from(*x)).collect()));
    }
    if let Ok(a) = value.extract::<PyReadonlyArrayDyn<'_, u8>>() {
        return Some(Value::Bytes(a.as_array().iter().copied().collect()));
    }
    None
}

/// Converts a list of numbers to an array of floats. Returns `None` if all elements are integers, or if one of them is
/// not a number.
fn numbers(items: &[Value]) -> Option<Value> {
    if !items.iter().any(|v| matches!(v, Value::Float(_))) {
        return None;
    }
    let number = |v: &Value| match v {
        Value::Float(x) => Some(*x),
        Value::Int(i) => Some(*i as f64),
        _ => None,
    };
    items.iter().map(number).collect::<Option<Vec<_>>>().map(Value::Floats)
}
