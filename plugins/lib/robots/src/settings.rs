//! How a robot is built.

/// The settings that the parameters of an importer specify.
#[derive(Debug, Clone, PartialEq)]
pub struct BuildSettings {
    /// Whether the first root is fixed.
    pub fixed_base: bool,
    /// Folder of the packages, or empty.
    pub package_root: String,
    /// Initial mode of motors: `auto`, `velocity`, `position` or `free`.
    pub motors: String,
    /// Effort of joints whose file states none; `None`: a computed one.
    pub default_effort: Option<f64>,
    /// Friction of links whose file states none.
    pub friction: f64,
    /// Whether cylinders that can roll collide as spheres.
    pub wheels_as_balls: bool,
    /// Whether meshes collide as they are.
    pub concave: bool,
    /// Greatest number of convex parts of a mesh; 0: its hull.
    pub decompose: u32,
    /// Whether links of the robot collide with each other.
    pub self_collision: bool,
    /// Whether the robot is moved so that its lowest point is at a height of 0.
    pub on_floor: bool,
}
