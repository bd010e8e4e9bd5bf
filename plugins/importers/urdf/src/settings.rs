//! The parameters of the importer.

use tatu_importers_robots::{BodyTree, BuildSettings, Robot};
use tatu_plugin_api::safe::{Param, Params, Result};

/// Declares the parameters.
pub fn params() -> Vec<Param> {
    vec![
        Param::bool("fixed_base")
            .optional()
            .text("Whether the root link is fixed; default: true if it is named `world`."),
        Param::bool("on_floor").default(false).text(
            "Whether the robot is raised or lowered so that the lowest point of its collision shapes is at the \
             height where it is placed.",
        ),
        Param::string("package_root").default("").text(
            "Folder that contains the packages, or the single package, to which `package://` names refer, relative \
             to the folder of the file; empty: packages are searched upward from the file, then in the folders \
             given by `--package-path`, TATU_PACKAGE_PATH, ROS_PACKAGE_PATH and AMENT_PREFIX_PATH.",
        ),
        Param::string("arguments")
            .default("")
            .text("Arguments of a xacro file, which replace its defaults: `name:=value name:=value`."),
        Param::string("motors").choices(&["auto", "velocity", "position", "free"]).default("auto").text(
            "Initial mode of motors: velocity 0; the position at the start; or off. auto: continuous joints have a \
                 velocity, as wheels need, others a position, as arms need.",
        ),
        Param::float("default_effort").range(0.0, 1e9).optional().text(
            "Effort of the motors of joints whose file states none, 0 or a negative one, N m or N; 0: such joints \
             have no motor. Default: revolute and prismatic joints can lift the whole robot with what they move, \
             and continuous ones can hold what they move and push the robot with its weight.",
        ),
        Param::float("link_friction")
            .range(0.0, 100.0)
            .default(1.0)
            .text("Friction of links for which the file states none."),
        Param::bool("wheels_as_balls").default(true).text(
            "Whether cylinders on continuous joints about their own horizontal axis collide as spheres, which roll \
             more accurately.",
        ),
        Param::bool("concave").default(false).text(
            "Whether meshes collide with their hollows, as trays and rooms need, instead of as convex hulls, which \
             are faster and more robust.",
        ),
        Param::int("decompose").range(0.0, 64.0).default(0).text(
            "Greatest number of convex parts into which a colliding mesh is divided, so that hollows stay open; 0: \
             one hull. Takes up to seconds for each mesh.",
        ),
        Param::bool("self_collision")
            .default(false)
            .text("Whether links of the robot collide with each other, except those that a joint connects."),
    ]
}

/// Reads the parameters; if `fixed_base` is missing, it is true if the root link is named `world` and has not been
/// left out.
pub fn read(params: &Params<'_>, robot: &Robot, tree: &BodyTree) -> Result<BuildSettings> {
    let root = &robot.links[tree.bodies[0].links[0].0];
    Ok(BuildSettings {
        fixed_base: params.get("fixed_base")?.as_bool().unwrap_or(root.name == "world"),
        package_root: params.string("package_root")?,
        motors: params.string("motors")?,
        default_effort: params.get("default_effort")?.as_f64(),
        friction: params.f64("link_friction")?,
        wheels_as_balls: params.bool("wheels_as_balls")?,
        concave: params.bool("concave")?,
        decompose: params.get("decompose")?.as_i64().and_then(|n| u32::try_from(n).ok()).unwrap_or(0),
        self_collision: params.bool("self_collision")?,
        on_floor: params.bool("on_floor")?,
    })
}
