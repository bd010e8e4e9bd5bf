//! A host without services, and a builder that records its calls.

use std::{
    cell::RefCell,
    collections::BTreeMap,
    ffi::{CStr, c_char, c_void},
    ptr::null,
};

use tatu_plugin_api::{
    abi::*,
    safe::{Owned, Value},
};

/// A recorded object.
#[derive(Debug, Default)]
pub struct Object {
    pub kind: String,
    pub alias: String,
    /// Number of the parent object, from 1; 0: none.
    pub parent: usize,
    pub device: Option<String>,
    pub properties: BTreeMap<String, Value>,
}

impl Object {
    pub fn numbers(&self, key: &str) -> Vec<f64> {
        match self.properties.get(key) {
            Some(Value::Floats(x)) => x.clone(),
            Some(Value::Float(x)) => vec![*x],
            Some(Value::Int(x)) => vec![*x as f64],
            other => panic!("{}: {key} is {other:?}", self.alias),
        }
    }
    pub fn number(&self, key: &str) -> f64 {
        self.numbers(key)[0]
    }
    pub fn is(&self, key: &str) -> bool {
        self.properties.get(key) == Some(&Value::Bool(true))
    }
    pub fn text(&self, key: &str) -> String {
        match self.properties.get(key) {
            Some(Value::Text(t)) => String::from_utf8_lossy(t).into_owned(),
            other => panic!("{}: {key} is {other:?}", self.alias),
        }
    }
}

/// The record of a build.
#[derive(Debug, Default)]
pub struct Record {
    pub objects: Vec<Object>,
    pub meshes: Vec<crate::look::Mesh>,
}

impl Record {
    pub fn get(&self, alias: &str) -> &Object {
        let found = self.objects.iter().find(|o| o.alias == alias);
        found.unwrap_or_else(|| panic!("no object {alias}"))
    }
    pub fn parent(&self, object: &Object) -> Option<&Object> {
        object.parent.checked_sub(1).map(|i| &self.objects[i])
    }
}

fn record(b: Option<&tatu_builder>) -> &RefCell<Record> {
    // SAFETY: the only builder of these tests is that of `build`, whose `ctx` points to a `RefCell<Record>` that
    // outlives it.
    unsafe { &*b.unwrap().ctx.cast() }
}

extern "C" fn object(b: Option<&tatu_builder>, kind: LentCStr<'_>, parent: u32, alias: Lent<'_>) -> u32 {
    let mut r = record(b).borrow_mut();
    let (kind, alias) = (kind.text().into_owned(), alias.text().into_owned());
    r.objects.push(Object { kind, alias, parent: parent as usize, ..Object::default() });
    r.objects.len() as u32
}

extern "C" fn set(
    b: Option<&tatu_builder>,
    object: u32,
    key: LentCStr<'_>,
    value: Option<&ValueRef<'_>>,
) -> tatu_status {
    let value = value.unwrap().to_value().unwrap();
    record(b).borrow_mut().objects[object as usize - 1].properties.insert(key.text().into_owned(), value);
    TATU_OK
}

unsafe extern "C" fn mesh(b: Option<&tatu_builder>, points: *const f64, n: u64, triangles: *const u32, m: u64) -> u64 {
    // SAFETY: the caller passes `n` points and `m` triangles of 3 numbers each, valid for reads during the call, as the
    // header requires.
    let (points, triangles) = unsafe {
        (
            std::slice::from_raw_parts(points.cast(), n as usize).to_vec(),
            std::slice::from_raw_parts(triangles.cast(), m as usize).to_vec(),
        )
    };
    let mut r = record(b).borrow_mut();
    r.meshes.push((points, triangles));
    r.meshes.len() as u64
}

extern "C" fn device(b: Option<&tatu_builder>, object: u32, kind: LentCStr<'_>) -> tatu_status {
    record(b).borrow_mut().objects[object as usize - 1].device = Some(kind.text().into_owned());
    TATU_OK
}

unsafe extern "C" fn no_service(_: *const tatu_host, _: *const c_char) -> *const c_void {
    null()
}

unsafe extern "C" fn say(e: *mut tatu_error, _: tatu_status, text: tatu_str) {
    // SAFETY: the only error object is that of `build`, whose `ctx` points to a `String` that outlives it; `text` is
    // valid during the call.
    unsafe {
        let bytes = std::slice::from_raw_parts(text.ptr.cast(), text.len as usize);
        *(*e).ctx.cast::<String>() = String::from_utf8_lossy(bytes).into_owned();
    }
}

/// Builds the model through the plugin's C tables, with its defaults except for `given`.
pub fn build(given: &[(&str, Value)]) -> Result<Record, String> {
    let mut said = String::new();
    let empty = tatu_str { ptr: null(), len: 0 };
    let mut error = tatu_error {
        size: size_of::<tatu_error>() as u32,
        code: 0,
        ctx: (&raw mut said).cast(),
        say: Some(say),
        add: None,
        text: empty,
        help: empty,
        file: empty,
        traceback: empty,
        line: 0,
    };
    let host = tatu_host {
        size: size_of::<tatu_host>() as u32,
        abi_minor: TATU_ABI_MINOR.into(),
        ctx: std::ptr::null_mut(),
        service: Some(no_service),
        assets: std::ptr::null(),
    };
    let kept = RefCell::new(Record::default());
    let builder = tatu_builder {
        size: size_of::<tatu_builder>() as u32,
        reserved: 0,
        ctx: (&raw const kept).cast_mut().cast(),
        object: Some(object),
        set: Some(set),
        mesh: Some(mesh),
        image: None,
        script: None,
        device: Some(device),
        report: None,
        file: None,
        describe: None,
        model: std::ptr::null(),
        scene: None,
    };
    let plugin = &crate::tatu_plugin.0;
    let mut me = std::ptr::null_mut();
    let mut owned = Owned::default();
    // SAFETY: the calls follow the order in the header: init, extension, build, shutdown; all tables and `owned` live
    // until the end of this block.
    let status = unsafe {
        assert_eq!(plugin.init.unwrap()(&host, &mut me, &mut error), TATU_OK);
        // `init` redirects panic messages to the host's log; restore the default, so that tests show them.
        drop(std::panic::take_hook());
        let extension: *const tatu_ext_model = plugin.extension.unwrap()(me, TATU_MODEL.as_ptr()).cast();
        let model = &**(*extension).models;
        let mut values = Vec::new();
        for i in 0.. {
            let param = *model.params.add(i);
            if param.is_null() {
                break;
            }
            let key = CStr::from_ptr((*param).key).to_str().unwrap();
            let found = given.iter().find(|(k, _)| *k == key);
            values.push(found.map_or((*param).fallback, |(_, v)| owned.raw(v)));
        }
        let status = model.build.unwrap()(me, &builder, values.as_ptr(), &mut error);
        plugin.shutdown.unwrap()(me);
        status
    };
    if status == TATU_OK { Ok(kept.into_inner()) } else { Err(said) }
}
