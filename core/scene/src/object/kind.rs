//! The kinds of objects.

/// The kind of an object.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
#[allow(missing_docs, reason = "`ObjectVariant` describes each kind")]
pub enum ObjectKind {
    Shape,
    Joint,
    Dummy,
    Sensor,
    Actuator,
    Part,
    ForceSensor,
    Graph,
    Camera,
    Light,
    Path,
    Script,
}

impl ObjectKind {
    /// The kinds of objects that scene files and builders create.
    pub const FILE_KINDS: [ObjectKind; 11] = [
        ObjectKind::Shape,
        ObjectKind::Joint,
        ObjectKind::Dummy,
        ObjectKind::Sensor,
        ObjectKind::Actuator,
        ObjectKind::Part,
        ObjectKind::ForceSensor,
        ObjectKind::Graph,
        ObjectKind::Camera,
        ObjectKind::Light,
        ObjectKind::Path,
    ];

    /// Returns the name of the kind, as used in scene files and in keys of properties.
    pub const fn name(self) -> &'static str {
        match self {
            ObjectKind::Shape => "shape",
            ObjectKind::Joint => "joint",
            ObjectKind::Dummy => "dummy",
            ObjectKind::Sensor => "sensor",
            ObjectKind::Actuator => "actuator",
            ObjectKind::Part => "part",
            ObjectKind::ForceSensor => "force_sensor",
            ObjectKind::Graph => "graph",
            ObjectKind::Camera => "camera",
            ObjectKind::Light => "light",
            ObjectKind::Path => "path",
            ObjectKind::Script => "script",
        }
    }

    /// Returns the kind with this name, if scene files can contain it.
    pub fn parse(name: &str) -> Option<ObjectKind> {
        ObjectKind::FILE_KINDS.into_iter().find(|k| k.name() == name)
    }

    /// Returns the names of the kinds that scene files can contain.
    pub fn names() -> [&'static str; 11] {
        ObjectKind::FILE_KINDS.map(ObjectKind::name)
    }
}
