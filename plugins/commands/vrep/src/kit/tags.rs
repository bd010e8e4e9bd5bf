//! Custom data of objects and of the scene, by tag; the core stores it (`object.data`, `scene.data`).
//!
//! Attributes of V-REP's objects that the core does not have are stored in the same way, under tags that start with
//! [`PRIVATE_PREFIX`], so that they are copied, saved and removed with the object. Scripts cannot access these tags.

use tatu_plugin_api::{
    abi::tatu_object,
    safe::{Result, Value, ValueRef},
};

use super::{
    arguments::explain_any,
    plugin::{Ctx, SharedCtx},
};

/// First byte of this plugin's private tags.
pub(crate) const PRIVATE_PREFIX: u8 = 1;

/// Returns all custom data of an object, or of the scene if `id` is 0.
pub(crate) fn all(c: &SharedCtx<'_>, id: tatu_object) -> Result<Vec<(Vec<u8>, Vec<u8>)>> {
    let p = &c.plugin().p;
    let v = c.world().get(id, if id == 0 { p.scene_data } else { p.object_data }).map_err(|e| explain_any(c, id, e))?;
    let bytes = |v: &ValueRef<'_>| v.as_bytes().unwrap_or_default().to_vec();
    Ok(v.map().unwrap_or_default().iter().map(|[key, value]| (bytes(key), bytes(value))).collect())
}

/// Returns the data stored under a tag, or `None` if there is none.
pub(crate) fn get(c: &SharedCtx<'_>, id: tatu_object, tag: &[u8]) -> Result<Option<Vec<u8>>> {
    Ok(all(c, id)?.into_iter().find(|(k, _)| k == tag).map(|(_, v)| v))
}

/// Stores data under a tag, or removes the data if `value` is `None`.
pub(crate) fn set(c: &Ctx<'_>, id: tatu_object, tag: &[u8], value: Option<&[u8]>) -> Result {
    let mut all = all(c, id)?;
    all.retain(|(k, _)| k != tag);
    if let Some(v) = value {
        all.push((tag.to_vec(), v.to_vec()));
    }
    replace_all(c, id, all)
}

/// Replaces all data of an object.
pub(crate) fn replace_all(c: &Ctx<'_>, id: tatu_object, all: Vec<(Vec<u8>, Vec<u8>)>) -> Result {
    let p = &c.plugin().p;
    let map = all.into_iter().map(|(k, v)| (Value::Text(k), Value::Bytes(v))).collect();
    c.world().set(id, if id == 0 { p.scene_data } else { p.object_data }, &Value::Map(map))
}

fn private_tag(name: &str) -> Vec<u8> {
    [&[PRIVATE_PREFIX], name.as_bytes()].concat()
}

/// Returns a number that this plugin has stored with an object under a private tag.
pub(crate) fn number(c: &Ctx<'_>, id: tatu_object, name: &str) -> Result<Option<f64>> {
    let text = get(c, id, &private_tag(name))?;
    Ok(text.and_then(|t| String::from_utf8(t).ok()).and_then(|t| t.parse().ok()))
}

/// Stores a number with an object under a private tag of this plugin.
pub(crate) fn set_number(c: &Ctx<'_>, id: tatu_object, name: &str, x: f64) -> Result {
    set(c, id, &private_tag(name), Some(x.to_string().as_bytes()))
}

/// Returns data that this plugin has stored with an object under a private tag.
pub(crate) fn private(c: &SharedCtx<'_>, id: tatu_object, name: &str) -> Result<Option<Vec<u8>>> {
    get(c, id, &private_tag(name))
}

/// Stores data with an object under a private tag of this plugin, or removes the data if `value` is `None`.
pub(crate) fn set_private(c: &Ctx<'_>, id: tatu_object, name: &str, value: Option<&[u8]>) -> Result {
    set(c, id, &private_tag(name), value)
}
