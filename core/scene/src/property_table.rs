//! The table of the core's properties, with one row per property. Scene files, `--set`, builders, scripts and services
//! all use it. Each row is declared beside the struct that stores the property; see `property.rs`.

use std::{fmt, sync::LazyLock};

use tatu_plugin_api::safe::Value;
use tatu_plugins::{ParameterSpec, check_value};

use crate::{
    document::settings::{self, WorldSettings},
    graph::spec,
    object::{any, devices, force_sensor, joint, shape, views},
};
pub use crate::{
    object::ObjectKind,
    property::{ChangeEffect, FileForm, PropertyOwner, PropertySpec},
};

const TABLES: &[&[PropertySpec]] = &[
    &[PropertySpec::NONE],
    any::PROPERTIES,
    shape::PROPERTIES,
    joint::PROPERTIES,
    any::DUMMY,
    force_sensor::PROPERTIES,
    devices::SENSOR,
    devices::ACTUATOR,
    devices::PART,
    spec::PROPERTIES,
    views::CAMERA,
    views::LIGHT,
    views::PATH,
    any::SCRIPT,
    settings::PROPERTIES,
];

const PROPERTY_COUNT: usize = {
    let (mut count, mut table) = (0, 0);
    while table < TABLES.len() {
        count += TABLES[table].len();
        table += 1;
    }
    count
};

/// All properties; the index of each is its interned key. The first entry stands for no property.
pub static PROPERTIES: [PropertySpec; PROPERTY_COUNT] = {
    let mut joined = [PropertySpec::NONE; PROPERTY_COUNT];
    let (mut next, mut table) = (0, 0);
    while table < TABLES.len() {
        let mut row = 0;
        while row < TABLES[table].len() {
            joined[next] = TABLES[table][row];
            next += 1;
            row += 1;
        }
        table += 1;
    }
    joined
};

/// The properties in the form in which plugins declare their parameters.
static DECLARATIONS: LazyLock<Vec<ParameterSpec>> =
    LazyLock::new(|| PROPERTIES.iter().map(PropertySpec::as_parameter).collect());

/// A property of the core: the index of its declaration in [`PROPERTIES`], which is its interned key.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct Property(u32);

impl fmt::Debug for Property {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.key())
    }
}

/// Names the properties that code treats separately.
macro_rules! named {
    ($($name:ident $key:literal),* $(,)?) => {
        impl Property {
            /// No property.
            pub const NONE: Property = Property(0);
            $(
                #[doc = concat!("The property `", $key, "`.")]
                pub const $name: Property = Property::named($key);
            )*
        }
    };
}

named! {
    ALIAS "object.alias", NAME "object.name", PATH "object.path", PARENT "object.parent", POSITION "object.position",
    QUATERNION "object.quaternion", ORIENTATION "object.orientation", POSE "object.pose",
    WORLD_POSE "object.world_pose", TWIST "object.twist", LOCAL_TWIST "object.local_twist",
    MODEL_BASE "object.model_base", VISIBLE "object.visible", LAYER "object.layer", NOTES "object.data",
    PRIMITIVE "shape.primitive", SIZE "shape.size", MESH "shape.mesh", SURFACE "shape.surface", CONVEX "shape.convex",
    PARTS "shape.parts", TEXTURE "shape.texture", COLOR "shape.color", OPACITY "shape.opacity",
    PART_COLORS "shape.part_colors", PART_OPACITIES "shape.part_opacities",
    MASS "shape.mass", INERTIA "shape.inertia",
    COM "shape.com", DYNAMIC "shape.dynamic", RESPONDABLE "shape.respondable",
    RESPONDABLE_MASK "shape.respondable_mask", DETECTABLE_MASK "shape.detectable_mask",
    JOINT_SOLVER_USED "shape.joint_solver_used", BULLET "shape.bullet", ASLEEP "shape.asleep", JOINT_TYPE "joint.type",
    JOINT_MODE "joint.mode", JOINT_POSITION "joint.position", TARGET_VELOCITY "joint.target_velocity",
    TARGET_POSITION "joint.target_position", MAX_FORCE "joint.max_force", CYCLIC "joint.cyclic",
    LIMITS "joint.limits", SENSOR_KIND "sensor.kind", PRESET "sensor.preset", NOISE "sensor.noise",
    SENSOR_RATE "sensor.rate", SENSOR_MEASURED "sensor.measured", SENSOR_BEAMS "sensor.beams", ACTUATOR_KIND "actuator.kind",
    SENSOR_TARGETS "sensor.targets", ACTUATOR_TARGETS "actuator.targets",
    PART_KIND "part.kind", PART_CALLS "part.calls",
    SCRIPT_LANGUAGE "script.language", SCRIPT_DIALECT "script.dialect", SCRIPT_KIND "script.kind",
    SCRIPT_NAME "script.name", SCRIPT_CALLS "script.calls", SCRIPT_INSTRUCTIONS "script.instructions",
    TIME "scene.time", CLOCK_TIME "scene.clock", EPOCH "scene.epoch", DT "scene.dt", STEP "scene.step",
    GRAVITY "scene.gravity", SCENE_FILE "scene.file", SCENE_NOTES "scene.notes", WORLD_NOTES "scene.data",
    RUNNING "scene.running", STOPPING "scene.stopping", PHASE "scene.phase",
}

impl Property {
    const fn named(key: &str) -> Property {
        let (key, mut at) = (key.as_bytes(), 1);
        while at < PROPERTY_COUNT {
            let (other, mut byte) = (PROPERTIES[at].key.as_bytes(), 0);
            while byte < key.len() && key.len() == other.len() && key[byte] == other[byte] {
                byte += 1;
            }
            if byte == key.len() && key.len() == other.len() {
                return Property(at as u32);
            }
            at += 1;
        }
        panic!("no property has this key")
    }

    /// Returns the property with an interned key, or `Property::NONE` if the key is not one of the core's.
    pub fn of(prop: u32) -> Property {
        if (prop as usize) < PROPERTY_COUNT { Property(prop) } else { Property::NONE }
    }
    /// Returns the property with a key, such as "joint.position".
    pub fn by_key(key: &str) -> Option<Property> {
        PROPERTIES.iter().position(|r| r.key == key && !key.is_empty()).map(|i| Property(i as u32))
    }
    /// Returns the interned key.
    pub fn number(self) -> u32 {
        self.0
    }
    /// Returns the property's description.
    pub fn spec(self) -> &'static PropertySpec {
        &PROPERTIES[self.0 as usize]
    }
    /// Returns the key, such as "joint.position".
    pub fn key(self) -> &'static str {
        self.spec().key
    }
    /// Returns the property in the form in which plugins declare their parameters; the key is without its prefix.
    pub fn declaration(self) -> &'static ParameterSpec {
        &DECLARATIONS[self.0 as usize]
    }
    /// Converts a value to the declared type, and checks its length, range and choices. The error names the property,
    /// what is expected, and the value.
    pub fn check(self, value: Value) -> Result<Value, String> {
        check_value(self.declaration(), value).map_err(|e| format!("`{}`: {e}", self.key()))
    }
    /// Returns the value of a property of the world that is one of its settings.
    pub fn setting(self, settings: &WorldSettings) -> Option<Value> {
        (self.spec().access.get)(settings)
    }
}

/// Returns the properties of objects of a kind, or those of the world if `kind` is `None`.
pub fn properties_of(kind: Option<ObjectKind>) -> impl Iterator<Item = Property> {
    (1..PROPERTY_COUNT as u32).map(Property).filter(move |r| r.spec().applies_to(kind))
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use tatu_plugin_api::abi::*;
    use tatu_plugins::units;

    use super::*;
    use crate::{ObjectVariant, Scene, get};

    fn blank(kind: ObjectKind) -> (Scene, u32) {
        let mut scene = Scene::default();
        let slot = scene.add(0, "blank", nalgebra::Isometry3::identity(), ObjectVariant::of_kind(kind, 0)).unwrap();
        (scene, slot)
    }

    const WITHOUT_FIXED_DEFAULT: &[&str] = &[
        "object.alias",
        "object.name",
        "object.parent",
        "object.world_pose",
        "shape.mesh",
        "shape.surface",
        "shape.mass",
        "shape.inertia",
        "shape.com",
        "joint.limits",
    ];

    #[test]
    fn new_objects_have_the_declared_defaults() {
        for kind in ObjectKind::FILE_KINDS {
            let (scene, slot) = blank(kind);
            for row in properties_of(Some(kind)).filter(|r| r.spec().is_settable()) {
                let usual = row.spec().default();
                assert_eq!(usual == Value::Nil, WITHOUT_FIXED_DEFAULT.contains(&row.key()), "{row:?}");
                if let Some(value) = get(&scene, slot, row).ok().filter(|_| usual != Value::Nil) {
                    assert_eq!(value, usual, "{row:?}");
                }
            }
        }
        let settings = WorldSettings::default();
        for row in properties_of(None) {
            let (usual, value) = (row.spec().default(), row.setting(&settings));
            if let Some(value) = value.filter(|_| usual != Value::Nil) {
                assert_eq!(value, usual, "{row:?}");
            }
        }
    }

    #[test]
    fn properties_read_back_and_refuse_values_out_of_range() {
        for kind in ObjectKind::FILE_KINDS {
            let (mut scene, slot) = blank(kind);
            for row in properties_of(Some(kind)).filter(|r| r.spec().is_settable()) {
                let (info, usual) = (row.spec(), row.spec().default());
                if usual != Value::Nil {
                    crate::set(&mut scene, slot, row, &usual).unwrap();
                }
                for out in [info.range.0.next_down(), info.range.1.next_up(), f64::NAN] {
                    let wrong = match info.kind {
                        TATU_F64 => Value::Float(out),
                        TATU_I64 if out.abs() < 1e15 => {
                            Value::Int(if out < info.range.0 { out.floor() } else { out.ceil() } as i64)
                        }
                        TATU_F64S => Value::Floats(vec![out; info.count.max(1) as usize]),
                        _ => continue,
                    };
                    let refusal = crate::set(&mut scene, slot, row, &wrong).unwrap_err();
                    assert_eq!(refusal.0, TATU_ERR_ARGUMENT, "{row:?}");
                    let start = format!("`{}`: expected ", row.key());
                    assert!(refusal.1.starts_with(&start) && refusal.1.contains(", found "), "{}", refusal.1);
                }
            }
        }
    }

    /// Returns the table of a section of `docs/reference/properties.md`.
    fn table(rows: impl Iterator<Item = Property>) -> String {
        let mut out = String::from("| key | in a scene file | type | unit | range | default | change | meaning |\n");
        out += "|---|---|---|---|---|---|---|---|\n";
        for row in rows {
            let (info, declared) = (row.spec(), row.declaration());
            let key = match row {
                Property::JOINT_POSITION => "joint_position",
                _ => info.short_key(),
            };
            let written =
                |unit: &str| units::suffixes(unit).iter().map(|(s, _)| format!("`{key}{s}`")).collect::<Vec<_>>();
            let of_files = match info.owner {
                PropertyOwner::World => settings::written_keys(info.short_key()),
                _ if !info.is_settable() || matches!(row, Property::NAME | Property::SURFACE) => Vec::new(),
                _ => info.unit.unwrap_or("").split('|').flat_map(written).collect(),
            };
            let mut of_files: Vec<String> = of_files;
            of_files.dedup();
            let kind = match info.kind {
                _ if !info.choices.is_empty() => {
                    format!("one of {}", info.choices.iter().map(|c| format!("`{c}`")).collect::<Vec<_>>().join(", "))
                }
                TATU_BOOL => "true or false".into(),
                TATU_I64 => "integer".into(),
                TATU_F64 => "number".into(),
                TATU_F64S if info.count > 0 => format!("{} numbers", info.count),
                TATU_F64S => "numbers".into(),
                TATU_LIST => "list".into(),
                TATU_MAP if info.file_form == FileForm::Data => "table of texts".into(),
                TATU_MAP => "table".into(),
                TATU_OBJECT => "object".into(),
                _ => "text".into(),
            };
            let range = match declared.bounds() {
                [Some(low), None] if low < 1e-300 && low > 0.0 => "above 0".to_owned(),
                [Some(low), Some(high)] if low < 1e-300 && low > 0.0 => format!("above 0, to {high}"),
                [Some(low), Some(high)] => format!("{low} to {high}"),
                [Some(low), None] => format!("from {low}"),
                [None, Some(high)] => format!("to {high}"),
                [None, None] => String::new(),
            };
            let usual = match info.default() {
                Value::Bool(b) => b.to_string(),
                Value::Int(i) => i.to_string(),
                Value::Float(x) => x.to_string(),
                Value::Text(t) if !t.is_empty() => format!("`{}`", String::from_utf8_lossy(&t)),
                Value::Floats(v) if !v.is_empty() => v.iter().map(f64::to_string).collect::<Vec<_>>().join(" "),
                Value::Nil => String::new(),
                _ => "none".into(),
            };
            let change = match (info.is_settable(), info.rebuilds()) {
                (false, _) => "read-only",
                (true, true) => "rebuilds",
                (true, false) => "live",
            };
            let unit = info.unit.unwrap_or("").replace('|', "\\|");
            out += &format!(
                "| `{}` | {} | {kind} | {unit} | {range} | {usual} | {change} | {} |\n",
                info.key,
                of_files.join(", "),
                info.text
            );
        }
        out
    }

    /// Replaces the tables of the page, one after another, by those of the properties; the rest of the page is prose.
    fn page_with_tables(page: &str) -> String {
        let of = |kinds: &'static [ObjectKind]| {
            move || {
                kinds
                    .iter()
                    .flat_map(|k| properties_of(Some(*k)).filter(|r| r.spec().owner != PropertyOwner::Any))
                    .collect::<Vec<_>>()
            }
        };
        let sections: [Box<dyn Fn() -> Vec<Property>>; 12] = [
            Box::new(|| {
                properties_of(Some(ObjectKind::Script)).filter(|r| r.spec().owner == PropertyOwner::Any).collect()
            }),
            Box::new(of(&[ObjectKind::Shape])),
            Box::new(of(&[ObjectKind::Joint])),
            Box::new(of(&[ObjectKind::Dummy])),
            Box::new(of(&[ObjectKind::ForceSensor])),
            Box::new(of(&[ObjectKind::Sensor])),
            Box::new(of(&[ObjectKind::Actuator])),
            Box::new(of(&[ObjectKind::Part])),
            Box::new(of(&[ObjectKind::Graph])),
            Box::new(of(&[ObjectKind::Camera, ObjectKind::Light, ObjectKind::Path])),
            Box::new(of(&[ObjectKind::Script])),
            Box::new(|| properties_of(None).collect()),
        ];
        let (mut out, mut next, mut in_table) = (String::new(), sections.iter(), false);
        for line in page.lines() {
            if !line.starts_with('|') {
                out += line;
                out.push('\n');
            } else if !in_table {
                out += &table(next.next().expect("the page has one table for each section")().into_iter());
            }
            in_table = line.starts_with('|');
        }
        out
    }

    /// `TATU_BLESS=properties cargo test -p tatu-scene reference_page` writes the tables of the page.
    #[test]
    fn reference_page_has_the_property_tables() {
        let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/reference/properties.md");
        let page = std::fs::read_to_string(&file).unwrap();
        let written = page_with_tables(&page);
        if std::env::var_os("TATU_BLESS").is_some_and(|v| v == "properties") {
            std::fs::write(&file, &written).unwrap();
        }
        let page = std::fs::read_to_string(&file).unwrap();
        let bless = "run `TATU_BLESS=properties cargo test -p tatu-scene reference_page`";
        assert!(page == written, "docs/reference/properties.md does not have the tables of the properties: {bless}");
    }
}
