//! The kind as the host uses it: two sensors made, asked for their beams and measured through the C tables.

use std::{
    f64::consts::{FRAC_PI_4, PI},
    ffi::{CStr, c_char, c_void},
    ptr::{null, null_mut},
};

use tatu_plugin_api::{abi::*, safe::Value};

unsafe extern "C" fn no_service(_: *const tatu_host, _: *const c_char) -> *const c_void {
    null()
}

/// Values of all declared parameters: the defaults but for `given`.
///
/// # Safety
/// `kind` is a live table.
unsafe fn values(kind: &tatu_sensor, given: &[(&str, Value)]) -> Vec<tatu_value> {
    let mut out = Vec::new();
    for i in 0.. {
        // SAFETY: a null-terminated list of live tables, as the header says.
        let Some(param) = (unsafe { (*kind.params.add(i)).as_ref() }) else {
            break;
        };
        // SAFETY: NUL-terminated.
        let key = unsafe { CStr::from_ptr(param.key) }.to_str().unwrap();
        let found = given.iter().find(|(k, _)| *k == key);
        // The few bytes of a text are leaked: a test.
        let mut leak = |n: usize| vec![0u64; n.div_ceil(8).max(1)].leak().as_mut_ptr().cast();
        out.push(found.map_or(param.fallback, |(_, v)| v.to_raw(&mut leak).unwrap()));
    }
    out
}

/// Makes one sensor per row of settings, hands over one beam each, and returns the fields by sensor: detected,
/// distance, point, object, normal; and the beams.
fn measured(settings: &[&[(&str, Value)]], distances: &[f64]) -> (Vec<tatu_beams>, Vec<[f64; 9]>) {
    let host =
        tatu_host { size: size_of::<tatu_host>() as u32, abi_minor: 1, ctx: null_mut(), service: Some(no_service) };
    let plugin = &crate::tatu_plugin.0;
    let n = settings.len();
    // SAFETY: the calls follow the header: init, extension, create, beams, measure, destroy, shutdown; everything that
    // is handed over lives until the end of its call.
    unsafe {
        let mut me = null_mut();
        assert_eq!(plugin.init.unwrap()(&host, &mut me, null_mut()), TATU_OK);
        // Starting sends panic messages to the host's log; a test wants to see them.
        drop(std::panic::take_hook());
        let extension = plugin.extension.unwrap()(me, TATU_SENSOR.as_ptr());
        let kind = &**(*extension.cast::<tatu_ext_sensor>()).kinds;
        assert_eq!(CStr::from_ptr(kind.id), c"proximity");
        assert_eq!(CStr::from_ptr(*kind.schemas), c"proximity/1");
        let life = &*kind.life;

        let mut data = Vec::new();
        let mut beams = Vec::new();
        for given in settings {
            let params = values(kind, given);
            let mut info: tatu_instance = std::mem::zeroed();
            info.size = size_of::<tatu_instance>() as u32;
            (info.n_params, info.params) = (params.len() as u32, params.as_ptr());
            let mut one = null_mut();
            assert_eq!(life.create.unwrap()(me, &info, &mut one, null_mut()), TATU_OK);
            let mut beam: tatu_beams = std::mem::zeroed();
            beam.size = size_of::<tatu_beams>() as u32;
            assert_eq!(kind.beams.unwrap()(one, &mut beam, null_mut()), TATU_OK);
            data.push(one);
            beams.push(beam);
        }

        let points: Vec<[f64; 3]> = distances.iter().map(|d| [0.0, 0.1, *d]).collect();
        let normals = vec![[0.0, 0.0, -1.0]; n];
        let objects: Vec<tatu_object> = (0..n as u64).map(|i| 100 + i).collect();
        let first: Vec<u64> = (0..=n as u64).collect();
        let mut detected = vec![0i32; n];
        let mut distance = vec![0.0f64; n];
        let mut point = vec![[0.0f64; 3]; n];
        let mut object = vec![0u64; n];
        let mut normal = vec![[0.0f64; 3]; n];
        let mut fields: Vec<*mut c_void> = Vec::new();
        for i in 0..n {
            fields.push((&raw mut detected[i]).cast());
            fields.push((&raw mut distance[i]).cast());
            fields.push((&raw mut point[i]).cast());
            fields.push((&raw mut object[i]).cast());
            fields.push((&raw mut normal[i]).cast());
        }
        let mut status = vec![TATU_OK; n];
        let mut batch: tatu_sensor_batch = std::mem::zeroed();
        batch.size = size_of::<tatu_sensor_batch>() as u32;
        (batch.n, batch.n_fields) = (n as u32, 5);
        (batch.data, batch.sensor) = (data.as_ptr().cast(), objects.as_ptr());
        (batch.first_beam, batch.distance) = (first.as_ptr(), distances.as_ptr());
        (batch.point, batch.normal) = (points.as_ptr().cast(), normals.as_ptr().cast());
        (batch.object, batch.fields) = (objects.as_ptr(), fields.as_ptr().cast());
        batch.status = status.as_mut_ptr();
        assert_eq!(kind.measure.unwrap()(me, &batch, null_mut()), TATU_OK);
        assert!(status.iter().all(|s| *s == TATU_OK));

        for one in data {
            life.destroy.unwrap()(one);
        }
        plugin.shutdown.unwrap()(me);
        let rows = (0..n).map(|i| {
            let (p, m) = (point[i], normal[i]);
            [detected[i].into(), distance[i], p[0], p[1], p[2], object[i] as f64, m[0], m[1], m[2]]
        });
        (beams, rows.collect())
    }
}

#[test]
fn readings_fill_all_fields_or_none() {
    let sonar: &[(&str, Value)] = &[("volume", "cone".into()), ("min_range", 0.05.into())];
    let (_, rows) = measured(&[sonar, sonar, sonar], &[0.7, 0.04, f64::INFINITY]);
    assert_eq!(rows[0], [1.0, 0.7, 0.0, 0.1, 0.7, 100.0, 0.0, 0.0, -1.0]);
    assert_eq!(rows[1], [0.0; 9], "nearer than the threshold");
    assert_eq!(rows[2], [0.0; 9], "nothing there");
}

#[test]
fn beams_cross_the_border_as_declared() {
    let (beams, _) = measured(
        &[
            &[],
            &[
                ("volume", "cone".into()),
                ("range", 1.005.into()),
                ("near", 0.005.into()),
                ("angle", (PI / 6.0).into()),
                ("max_incidence", FRAC_PI_4.into()),
                ("back_faces", false.into()),
                ("skip_own_model", true.into()),
            ],
        ],
        &[f64::INFINITY; 2],
    );
    let [ray, cone] = beams[..] else { panic!() };
    assert_eq!((ray.form, ray.count[0], ray.flags), (TATU_BEAMS_RAYS, 1, 0));
    assert_eq!((ray.near_m, ray.far_m, ray.max_incidence), (0.0, 1.0, PI / 2.0));
    assert_eq!((cone.form, cone.dims[0]), (TATU_BEAMS_CONE, PI / 12.0));
    assert_eq!((cone.near_m, cone.far_m, cone.max_incidence), (0.005, 1.005, FRAC_PI_4));
    assert_eq!(cone.flags, TATU_BEAMS_NO_BACK | TATU_BEAMS_SKIP_MODEL);
}
