//! Tests of the noise stages, without a world.

use std::sync::{Arc, LazyLock};

use tatu_plugin_api::abi::*;
use tatu_plugins::FieldSpec;

use super::*;

/// Indices of the fields of the sensor kind used in the tests.
pub const FIELD_ONE: usize = 0;
pub const FIELD_MANY: usize = 1;
pub const FIELD_OTHER: usize = 2;
pub const FIELD_SMALL: usize = 3;
pub const FIELD_PLACE: usize = 4;
const FIELD_SEEN: usize = 5;
const FIELD_RAW: usize = 6;
const FIELD_ALTITUDE: usize = 7;
const FIELD_POSITION: usize = 8;
const FIELD_VALID: usize = 9;

fn kind() -> SensorKind {
    let field = |name: &str, elem, dims| FieldSpec { name: name.into(), elem, dims, ..FieldSpec::default() };
    let marked = |name, dims, nothing: &str| {
        let (valid, nothing) = (Some("fix.valid".into()), Some(nothing.into()));
        FieldSpec { valid, nothing, ..field(name, TATU_ELEM_F64, dims) }
    };
    let fields = vec![
        field("test.one", TATU_ELEM_F64, [1, 1, 1]),
        field("test.many", TATU_ELEM_F64, [0, 1, 1]),
        field("test.other", TATU_ELEM_F64, [0, 1, 1]),
        field("test.small", TATU_ELEM_F32, [0, 1, 1]),
        field("test.place", TATU_ELEM_F64, [3, 1, 1]),
        field("test.seen", TATU_ELEM_U8, [0, 1, 1]),
        field("test.raw", TATU_ELEM_U16, [0, 1, 1]),
        // Fields whose validity is marked by a separate field; invalid elements are 0.
        marked("fix.altitude", [1, 1, 1], "0"),
        marked("fix.position", [3, 1, 1], "0 0 0"),
        field("fix.valid", TATU_ELEM_I32, [1, 1, 1]),
        field("test.object", TATU_ELEM_OBJECT, [1, 1, 1]),
        field("else.one", TATU_ELEM_F64, [1, 1, 1]),
    ];
    // SAFETY: both are plain structs of numbers, pointers and optional functions, for which zero bytes are valid.
    let (raw, life) = unsafe { (std::mem::zeroed(), std::mem::zeroed()) };
    SensorKind {
        plugin: 0,
        id: "test".into(),
        text: String::new(),
        schemas: Vec::new(),
        params: Vec::new(),
        field_props: vec![0; fields.len()],
        fields,
        field_tables: Vec::new(),
        presets: Vec::new(),
        raw,
        life,
        of_actuator: false,
    }
}

/// The fields of a measurement, to which tests write.
pub struct TestFields<'a> {
    words: &'a mut [u64],
    spans: &'a [(usize, usize)],
}

impl TestFields<'_> {
    fn typed<T>(&mut self, field: usize) -> &mut [T] {
        let (first, n) = self.spans[field];
        // SAFETY: `words` is borrowed for as long as the slice, and has room for `n` elements of at most 8 bytes from
        // index `first` on.
        unsafe { std::slice::from_raw_parts_mut(self.words[first..].as_mut_ptr().cast(), n) }
    }
    pub fn of(&mut self, field: usize) -> &mut [f64] {
        self.typed(field)
    }
    pub fn of32(&mut self, field: usize) -> &mut [f32] {
        self.typed(field)
    }
}

/// A sensor without a world, with only its fields and their noise.
pub struct TestSensor {
    kind: SensorKind,
    noise: Option<Box<SensorNoise>>,
    spec: Option<Arc<NoiseSpec>>,
    words: Vec<u64>,
    spans: Vec<(usize, usize)>,
    seed: u64,
    drawn: u64,
    pool: Arc<rayon::ThreadPool>,
}

/// A single-threaded pool shared by all sensors, because creating threads takes longer than most of the tests.
static POOL: LazyLock<Arc<rayon::ThreadPool>> = LazyLock::new(|| pool(1));

fn pool(threads: usize) -> Arc<rayon::ThreadPool> {
    Arc::new(rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap())
}

impl TestSensor {
    /// Creates a sensor with the given noise and number of beams.
    pub fn new(noise: &str, beams: usize, seed: u64) -> Self {
        let kind = kind();
        let full = noise.replace("one.", "\"test.one\".");
        let spec = NoiseSpec::parse(&full, Some(&kind)).unwrap_or_else(|w| panic!("{}", w.error)).merge_over(None);
        let mut spans = Vec::new();
        let mut words = 0;
        for f in &kind.fields {
            let n = if f.dims[0] == 0 { beams } else { f.dims[0] as usize };
            spans.push((words, n));
            words += n;
        }
        let pool = POOL.clone();
        TestSensor { kind, noise: None, spec: spec.map(Arc::new), words: vec![0; words], spans, seed, drawn: 0, pool }
    }

    pub fn measure(&mut self, time: f64, write: impl FnOnce(&mut TestFields<'_>)) {
        self.words.fill(0);
        write(&mut TestFields { words: &mut self.words, spans: &self.spans });
        SensorNoise::update(&mut self.noise, self.spec.as_ref(), &self.kind);
        let TestSensor { kind, words, spans, seed, drawn, .. } = self;
        if let Some(noise) = &mut self.noise {
            let m = RawMeasurement { kind, seed: *seed, drawn: *drawn, time, period: 0.01, fields: words, spans };
            noise.apply(m, &self.pool);
        }
        self.drawn += 1;
    }

    fn set(&mut self, noise: &str) {
        let more = NoiseSpec::parse(noise, Some(&self.kind)).unwrap_or_else(|w| panic!("{}", w.error));
        self.spec = more.merge_over(self.spec.as_deref()).map(Arc::new);
    }

    fn fields(&mut self) -> TestFields<'_> {
        TestFields { words: &mut self.words, spans: &self.spans }
    }
    pub fn read(&mut self, field: usize) -> Vec<f64> {
        self.fields().of(field).to_vec()
    }
    pub fn read32(&mut self, field: usize) -> Vec<f32> {
        self.fields().of32(field).to_vec()
    }
}

/// Returns values of all kinds, including invalid ones.
fn values(i: usize) -> f64 {
    match i % 7 {
        0 => 0.0,
        1 => -0.0,
        2 => f64::MIN_POSITIVE / 3.0,
        3 => -1e300,
        4 => 1.0 / 3.0,
        5 => f64::INFINITY,
        _ => i as f64 * 0.1,
    }
}

#[test]
fn zero_noise_changes_no_bit() {
    let zeros = "many = { sigma = 0, uniform = 0, shift = 0, shift_sigma = 0, walk = { sigma = 0, tau_s = 5 }, step = 0, \
                 inverse_step = 0, dropout = 0, outliers = { probability = 0, sigma = 3 } }\n\
                 small = { sigma = [0, 0, 0], outliers = { probability = 1, sigma = 0 } }";
    let mut s = TestSensor::new(zeros, 1000, 5);
    s.measure(1.0, |f| {
        f.of(FIELD_MANY).iter_mut().enumerate().for_each(|(i, x)| *x = values(i));
        f.of32(FIELD_SMALL).iter_mut().enumerate().for_each(|(i, x)| *x = values(i) as f32);
    });
    for (i, x) in s.read(FIELD_MANY).iter().enumerate() {
        assert_eq!(x.to_bits(), values(i).to_bits(), "{i}");
    }
    for (i, x) in s.read32(FIELD_SMALL).iter().enumerate() {
        assert_eq!(x.to_bits(), (values(i) as f32).to_bits(), "{i}");
    }
}

#[test]
fn invalid_values_are_not_changed() {
    let mut s = TestSensor::new("many.sigma = 1\naltitude.sigma = 1\nposition.sigma = 1", 100, 5);
    s.measure(0.0, |f| f.of(FIELD_MANY).fill(f64::INFINITY));
    assert!(s.read(FIELD_MANY).iter().all(|x| *x == f64::INFINITY));
    // The schema specifies which field marks validity, so a position of 0 0 0 is valid if there is a fix.
    let mut s = TestSensor::new("altitude.sigma = 1\nposition.sigma = 1", 1, 5);
    for detected in [0, 1] {
        s.measure(0.0, |f| f.typed::<i32>(FIELD_VALID)[0] = detected);
        let stays = (s.read(FIELD_ALTITUDE) == [0.0], s.read(FIELD_POSITION) == [0.0; 3]);
        assert_eq!(stays, (detected == 0, detected == 0));
    }
    // Without such a field, only 0 marks an invalid value.
    let mut s = TestSensor::new("raw.sigma = 100\nmany = { sigma = 1, valid = \"seen\" }", 2, 5);
    s.measure(0.0, |f| {
        f.typed::<u16>(FIELD_RAW).copy_from_slice(&[0, 1000]);
        f.typed::<u8>(FIELD_SEEN).copy_from_slice(&[0, 1]);
    });
    let raw = s.fields().typed::<u16>(FIELD_RAW).to_vec();
    assert!(raw[0] == 0 && raw[1] != 1000, "{raw:?}");
    assert!(s.read(FIELD_MANY)[0] == 0.0 && s.read(FIELD_MANY)[1] != 0.0);
}

#[test]
fn lost_element_is_marked_by_value_and_by_field() {
    let mut s = TestSensor::new("many = { dropout = 0.5, valid = \"seen\" }", 1000, 5);
    s.measure(0.0, |f| {
        f.of(FIELD_MANY).fill(2.0);
        f.typed::<u8>(FIELD_SEEN).fill(1);
    });
    let seen = s.fields().typed::<u8>(FIELD_SEEN).to_vec();
    let lost = s.read(FIELD_MANY).iter().zip(&seen).filter(|(x, s)| (x.is_infinite(), **s) == (true, 0)).count();
    let kept = s.read(FIELD_MANY).iter().zip(&seen).filter(|(x, s)| (**x, **s) == (2.0, 1)).count();
    assert!(lost + kept == 1000 && lost.abs_diff(500) < 70, "{lost} {kept}");
    // The components of a point are lost together. The field that marks a lost point and the point itself are then 0,
    // as the schema requires.
    let mut s = TestSensor::new("position.dropout = 0.5", 1, 5);
    let mut lost = 0;
    for i in 0..1000 {
        s.measure(f64::from(i), |f| {
            f.of(FIELD_POSITION).copy_from_slice(&[0.1, 0.2, 0.3]);
            f.typed::<i32>(FIELD_VALID)[0] = 1;
        });
        match (s.read(FIELD_POSITION).as_slice(), s.fields().typed::<i32>(FIELD_VALID)[0]) {
            ([0.0, 0.0, 0.0], 0) => lost += 1,
            ([0.1, 0.2, 0.3], 1) => {}
            other => panic!("{other:?}"),
        }
    }
    assert!((430..570).contains(&lost), "{lost}");
}

#[test]
fn values_beyond_the_limits_become_invalid() {
    let mut s = TestSensor::new("many.limits = [0.5, 4]\nposition.limits = [-1, 1]", 5, 5);
    s.measure(0.0, |f| {
        f.of(FIELD_MANY).copy_from_slice(&[0.4, 0.5, 2.0, 4.0, 4.1]);
        f.of(FIELD_POSITION).copy_from_slice(&[0.0, 3.0, 0.5]);
        f.typed::<i32>(FIELD_VALID)[0] = 1;
    });
    let inf = f64::INFINITY;
    assert_eq!(s.read(FIELD_MANY), [inf, 0.5, 2.0, 4.0, inf]);
    assert_eq!(s.read(FIELD_POSITION), [0.0; 3], "a point is nothing as a whole");
}

#[test]
fn values_are_rounded_to_their_grid() {
    let mut s = TestSensor::new("many.step = 0.25\nsmall.inverse_step = 0.125\nraw.sigma = 10", 5, 5);
    s.measure(0.0, |f| {
        f.of(FIELD_MANY).copy_from_slice(&[0.1, 0.126, -0.3, 1e17, 7.0]);
        f.of32(FIELD_SMALL).copy_from_slice(&[1.0, 0.9, 4.1, 100.0, f32::INFINITY]);
        f.typed::<u16>(FIELD_RAW).copy_from_slice(&[0, 1, 500, 65535, 30_000]);
    });
    assert_eq!(s.read(FIELD_MANY), [0.0, 0.25, -0.25, 1e17, 7.0]);
    // 1 / 0.9 = 1.11 is closest to 9 / 8; 1 / 100 is closer to 0 than to 1 / 8, so the value 100 cannot be represented.
    let inf = f32::INFINITY;
    assert_eq!(s.read32(FIELD_SMALL), [1.0, 8.0 / 9.0, 4.0, inf, inf]);
    let raw = s.fields().typed::<u16>(FIELD_RAW).to_vec();
    assert_eq!(raw[0], 0, "0 is nothing");
    assert!(raw[3] > 65_000 && raw[4] != 30_000 && raw[4].abs_diff(30_000) < 60, "{raw:?}");
}

/// The order of stages: white noise and outliers are rounded to the grid, and limits apply to rounded values.
#[test]
fn stages_are_applied_in_order() {
    let noise = "many = { sigma = 0.3, shift = 1, outliers = { probability = 0.5, uniform = 9 }, step = 0.5, limits = [-2, 2] }";
    let mut s = TestSensor::new(noise, 1000, 5);
    s.measure(0.0, |f| f.of(FIELD_MANY).fill(0.3));
    for x in s.read(FIELD_MANY) {
        assert!(x == f64::INFINITY || x.abs() <= 2.0 && (x * 2.0).fract() == 0.0, "{x}");
    }
    // A shift is the same for all elements and is added before rounding.
    let mut s = TestSensor::new("many.shift = 1", 10, 5);
    s.measure(0.0, |f| f.of(FIELD_MANY).fill(0.5));
    let all = s.read(FIELD_MANY);
    assert!(all[0] != 0.5 && all.iter().all(|x| *x == all[0]), "{all:?}");
}

#[test]
fn each_field_has_its_own_random_numbers() {
    let both = "many.sigma = 1\nother.sigma = 1";
    let read = |noise: &str, seed: u64, field: usize| {
        let mut s = TestSensor::new(noise, 100, seed);
        s.measure(0.0, |f| {
            f.of(FIELD_MANY).fill(1.0);
            f.of(FIELD_OTHER).fill(1.0);
        });
        s.read(field)
    };
    assert_eq!(
        read(both, 1, FIELD_MANY),
        read("many.sigma = 1", 1, FIELD_MANY),
        "noise of another field changes nothing"
    );
    assert_ne!(read(both, 1, FIELD_MANY), read(both, 1, FIELD_OTHER));
    assert_ne!(read(both, 1, FIELD_MANY), read(both, 2, FIELD_MANY));
    // An additional stage does not change the random numbers of white noise.
    let with = read("many = { sigma = 1, dropout = 0.5 }", 1, FIELD_MANY);
    let without = read("many.sigma = 1", 1, FIELD_MANY);
    assert!(with.iter().zip(&without).all(|(a, b)| a == b || a.is_infinite()));
}

#[test]
fn noise_does_not_depend_on_the_number_of_threads() {
    let noise =
        "small = { sigma = [0.001, 0, 0.0012], inverse_step = 0.003, dropout = 0.01, shift = 0.01, valid = \"seen\" }";
    let run = |threads: usize| {
        let mut s = TestSensor::new(noise, 307_200, 9);
        s.pool = pool(threads);
        for i in 0..3 {
            s.measure(f64::from(i), |f| {
                f.of32(FIELD_SMALL).iter_mut().enumerate().for_each(|(i, x)| *x = 0.5 + (i % 1000) as f32 * 0.003);
                f.typed::<u8>(FIELD_SEEN).fill(1);
            });
        }
        s.words
    };
    let one = run(1);
    assert!(one == run(2) && one == run(5));
}

#[test]
fn walks_survive_changes_until_they_are_undeclared() {
    let mut s = TestSensor::new("many.walk = { sigma = 1, tau_s = 1e6 }", 1, 5);
    let at = |s: &mut TestSensor, time: f64| {
        s.measure(time, |f| f.of(FIELD_MANY)[0] = 1.0);
        s.read(FIELD_MANY)[0] - 1.0
    };
    let first = at(&mut s, 0.0);
    // In 1 s with tau = 10^6 s, the walk moves by 0.0014 of its sigma.
    assert!((at(&mut s, 1.0) - first).abs() < 0.01);
    s.set("other.sigma = 1");
    assert!((at(&mut s, 2.0) - first).abs() < 0.01, "noise of another field was added");
    s.set("many = { walk = { sigma = 2, tau_s = 1e6 } }");
    assert!((at(&mut s, 3.0) - 2.0 * first).abs() < 0.02);
    // A sensor restored from the saved state continues with the same values.
    let memory = s.noise.as_ref().unwrap().state().clone();
    let on = at(&mut s, 4.0);
    (s.noise, s.drawn) = (Some(Box::new(SensorNoise::from_state(memory))), 4);
    assert_eq!(at(&mut s, 4.0), on);
    s.set("none");
    assert_eq!(at(&mut s, 5.0), 0.0);
    s.set("many.walk = { sigma = 1, tau_s = 1e6 }");
    let anew = at(&mut s, 6.0);
    assert!((anew - first).abs() > 0.01, "it begins anew");
}

#[test]
fn readings_are_delayed_by_the_latency() {
    let mut s = TestSensor::new("latency_s = 0.12", 1, 5);
    s.measure(0.0, |_| {});
    let noise = s.noise.as_mut().unwrap();
    let reading = |time: f64, sequence| HeldReading { time, sequence, fields: ReadingBuffer::default() };
    let seen = |r: Option<HeldReading>| r.map(|r| r.sequence);
    for i in 0..4 {
        noise.hold(reading(f64::from(i) * 0.05, 1 + i as u64));
    }
    assert_eq!(seen(noise.release(0.10)), None);
    assert_eq!(seen(noise.release(0.15)), Some(1));
    assert_eq!(seen(noise.release(0.15)), None);
    // The newest of the readings that are old enough is released.
    assert_eq!(seen(noise.release(0.25)), Some(3));
    // A reading replaces an earlier reading with the same time.
    noise.hold(reading(0.15, 9));
    assert_eq!((noise.newest(), seen(noise.release(0.27)), noise.newest()), (Some(9), Some(9), None));
    // Times are sums of steps, with rounding errors.
    noise.hold(reading(0.3, 10));
    assert_eq!(seen(noise.release(0.42 - 1e-15)), Some(10));
}

#[test]
fn noise_survives_a_round_trip_through_toml() {
    let text = "latency_s = 0.12\n[many]\nsigma = [0.1, 0.2]\nof = \"other\"\nuniform = 1\nshift = 2\nshift_sigma = 3\n\
                walk = { sigma = 2.1, tau_s = 1100 }\nstep = 0.001\ninverse_step = 2.85e-3\ndropout = 0.01\n\
                valid = \"seen\"\noutliers = { probability = 0.001, sigma = 1.0, uniform = 2 }\nlimits = [0, inf]\n\
                [\"fix.position\"]\nsigma = [[1, 2], [3, 4], [5, 6]]\nuniform = [1, 2, 3]";
    let kind = kind();
    let spec = NoiseSpec::parse(text, Some(&kind)).unwrap_or_else(|w| panic!("{}", w.error));
    let written = spec.to_toml();
    assert_eq!(NoiseSpec::parse(&written, None).unwrap_or_else(|w| panic!("{}: {written}", w.error)), spec);
    assert_eq!(NoiseSpec::parse(&written, Some(&kind)).unwrap_or_else(|w| panic!("{}", w.error)), spec);
    assert_eq!(spec.fields.keys().collect::<Vec<_>>(), ["fix.position", "test.many"]);
    assert_eq!(spec.fields["test.many"].of.as_deref(), Some("test.other"));
    // Field names may be written in full, with and without quotes.
    for same in
        ["[test.many]\nsigma = 1", "[\"test.many\"]\nsigma = 1", "test.many.sigma = 1", "many = { sigma = [1] }"]
    {
        let spec = NoiseSpec::parse(same, Some(&kind)).unwrap_or_else(|w| panic!("{same}: {}", w.error));
        assert_eq!(spec.fields["test.many"].sigma, [[1.0]]);
    }
}

#[test]
fn later_declaration_replaces_that_of_its_field() {
    let kind = kind();
    let parse = |text: &str| NoiseSpec::parse(text, Some(&kind)).unwrap_or_else(|w| panic!("{}", w.error));
    let preset = parse("latency_s = 1\nmany = { sigma = 1, step = 2 }\nsmall.sigma = 3").merge_over(None).unwrap();
    let set = |text: &str| parse(text).merge_over(Some(&preset));
    // A new declaration replaces all settings of its field, and does not affect other fields.
    let changed = set("many.uniform = 4").unwrap();
    assert_eq!(changed.fields["test.many"], FieldNoise { uniform: vec![4.0], ..Default::default() });
    assert_eq!(
        (changed.fields["test.small"].clone(), changed.latency),
        (preset.fields["test.small"].clone(), Some(1.0))
    );
    let without = set("many = {}").unwrap();
    assert_eq!(without.fields.keys().collect::<Vec<_>>(), ["test.small"]);
    assert_eq!(set("latency_s = 0").unwrap().latency, None);
    assert!(["", "none"].iter().all(|t| set(t).is_none()));
    assert_eq!(parse("many = {}").merge_over(None), None);
}

#[test]
fn invalid_noise_is_refused_with_its_key() {
    let kind = kind();
    for (text, words) in [
        ("many.sgima = 1", "E101 unknown key `sgima` did you mean `sigma`"),
        ("latency = 1", "E101 unknown key `latency` did you mean `latency_s`"),
        ("latency_s = 100", "`latency_s`: expected a number from 0 to 10"),
        ("latency_s = -1", "`latency_s`: expected a number"),
        ("mani.sigma = 1", "E101 no field `mani` did you mean `many`"),
        ("one.sigma = 1", "`one` is ambiguous test.one or else.one full name in quotes"),
        ("object.sigma = 1", "`test.object` contains objects"),
        ("many = 1", "E101 unknown key `many` of `noise`"),
        ("many.sigma = -1", "`sigma`: expected a number, at least 0"),
        ("many.sigma = [1, \"x\"]", "`sigma`: expected a number, or [c0, c1, ...]"),
        ("many.sigma = []", "`sigma`: expected a number, or [c0, c1, ...]"),
        ("many.sigma = [[1], [2]]", "`sigma`: expected one number, found 2"),
        ("many.sigma = nan", "`sigma`: expected a number"),
        ("many.uniform = [1, 2]", "`uniform`: expected one number, found 2"),
        ("place.uniform = [1, 2]", "expected one number, or 3"),
        ("place.uniform = [1, 2, -3]", "each at least 0"),
        ("many.walk = 1", "`walk`: expected a table of sigma, tau_s"),
        ("many.walk = { sigma = 1 }", "E104 `walk` has no `tau_s`"),
        ("many.walk = { sigma = 1, tau = 1 }", "unknown key `tau` of `walk` did you mean `tau_s`"),
        ("many.walk = { sigma = 1, tau_s = 0 }", "`tau_s`: expected a number greater than 0"),
        ("many.dropout = 1.5", "`dropout`: expected a number from 0 to 1"),
        ("many = { dropout = 0.1, valid = 3 }", "`valid`: expected the name of a field"),
        ("many = { dropout = 0.1, valid = \"position\" }", "`fix.position` cannot mark valid elements of `test.many`"),
        ("many = { dropout = 0.1, valid = \"many\" }", "refers to the field itself"),
        ("many = { sigma = 1, of = \"place\" }", "`test.place` must have the same shape as `test.many`"),
        ("many.of = \"other\"", "`of` requires `sigma`"),
        ("many.outliers = { sigma = 1 }", "`outliers` has no `probability`"),
        ("many.outliers = { probability = 0.1 }", "must contain `sigma` or `uniform`"),
        ("many.limits = [2, 1]", "`limits`: expected [lowest, highest]"),
        ("many.sigma = 1\n\"test.many\".sigma = 1", "`noise` configures `test.many` twice"),
        ("many.sigma = ", "not valid TOML"),
    ] {
        let wrong = NoiseSpec::parse(text, Some(&kind)).err().unwrap_or_else(|| panic!("{text} passed"));
        let told = wrong.with_line(text).to_string();
        for word in words.split(' ') {
            assert!(told.contains(word), "{text}: `{told}` lacks {word}");
        }
    }
    // The error message contains the line number.
    let text = "many.sigma = 1\nsmall.sigma = 1\nsmall.step = true";
    let wrong = NoiseSpec::parse(text, Some(&kind)).unwrap_err().with_line(text);
    assert!(wrong.text.starts_with("line 3 of `noise`"), "{}", wrong.text);
}
