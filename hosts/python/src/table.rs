//! Converts TOML tables to dictionaries.

use pyo3::{
    IntoPyObjectExt,
    prelude::*,
    types::{PyDict, PyList},
};
use toml_edit::{Item, TableLike, Value};

/// Returns the table `[env]` of a scene as a dictionary; `text` is a document that contains only this table.
pub fn env<'py>(py: Python<'py>, text: Option<&str>) -> PyResult<Option<Bound<'py, PyDict>>> {
    let parsed: Option<toml_edit::DocumentMut> = text.and_then(|t| t.parse().ok());
    let table = parsed.as_ref().and_then(|t| t.get("env")).and_then(Item::as_table_like);
    table.map(|t| dict(py, t)).transpose()
}

/// Converts a table to a dictionary.
pub fn dict<'py>(py: Python<'py>, table: &dyn TableLike) -> PyResult<Bound<'py, PyDict>> {
    let out = PyDict::new(py);
    for (key, item) in table.iter() {
        out.set_item(key, item_of(py, item)?)?;
    }
    Ok(out)
}

fn item_of<'py>(py: Python<'py>, item: &Item) -> PyResult<Bound<'py, PyAny>> {
    match item {
        Item::None => Ok(py.None().into_bound(py)),
        Item::Value(value) => value_of(py, value),
        Item::Table(table) => Ok(dict(py, table)?.into_any()),
        Item::ArrayOfTables(tables) => {
            let all = tables.iter().map(|t| dict(py, t)).collect::<PyResult<Vec<_>>>()?;
            Ok(PyList::new(py, all)?.into_any())
        }
    }
}

fn value_of<'py>(py: Python<'py>, value: &Value) -> PyResult<Bound<'py, PyAny>> {
    match value {
        Value::String(s) => s.value().into_bound_py_any(py),
        Value::Integer(i) => i.value().into_bound_py_any(py),
        Value::Float(x) => x.value().into_bound_py_any(py),
        Value::Boolean(b) => b.value().into_bound_py_any(py),
        Value::Datetime(d) => d.value().to_string().into_bound_py_any(py),
        Value::Array(all) => {
            let all = all.iter().map(|v| value_of(py, v)).collect::<PyResult<Vec<_>>>()?;
            Ok(PyList::new(py, all)?.into_any())
        }
        Value::InlineTable(table) => Ok(dict(py, table)?.into_any()),
    }
}
