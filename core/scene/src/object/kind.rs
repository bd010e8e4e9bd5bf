//! The kinds of objects.

/// The kind of an object.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
#[allow(missing_docs, reason = "`Data` describes each kind")]
pub enum Kind {
    Shape,
    Joint,
    Dummy,
    Sensor,
    Actuator,
    ForceSensor,
    Graph,
    Camera,
    Light,
    Path,
    Script,
}

impl Kind {
    /// The kinds of objects that scene files and builders create.
    pub const OF_FILES: [Kind; 10] = [
        Kind::Shape,
        Kind::Joint,
        Kind::Dummy,
        Kind::Sensor,
        Kind::Actuator,
        Kind::ForceSensor,
        Kind::Graph,
        Kind::Camera,
        Kind::Light,
        Kind::Path,
    ];

    /// Returns the name of the kind, as used in scene files and in keys of properties.
    pub const fn name(self) -> &'static str {
        match self {
            Kind::Shape => "shape",
            Kind::Joint => "joint",
            Kind::Dummy => "dummy",
            Kind::Sensor => "sensor",
            Kind::Actuator => "actuator",
            Kind::ForceSensor => "force_sensor",
            Kind::Graph => "graph",
            Kind::Camera => "camera",
            Kind::Light => "light",
            Kind::Path => "path",
            Kind::Script => "script",
        }
    }

    /// Returns the kind with this name, if scene files can contain it.
    pub fn parse(name: &str) -> Option<Kind> {
        Kind::OF_FILES.into_iter().find(|k| k.name() == name)
    }

    /// Returns the names of the kinds that scene files can contain.
    pub fn names() -> [&'static str; 10] {
        Kind::OF_FILES.map(Kind::name)
    }
}
