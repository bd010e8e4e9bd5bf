//! Maps the paths under which scripts load models of V-REP's installation to the models that replace them in Tatu.

/// Value of `sim.stringparam_modeldefaultdir`: the folder of models.
pub(crate) const MODEL_FOLDER: &str = "models";
/// Value of `sim.stringparam_scenedefaultdir`: the folder of scenes.
pub(crate) const SCENE_FOLDER: &str = "scenes";

/// File names of V-REP's models, reduced to lower-case letters and digits, and the equivalent models of Tatu.
const SAME: &[(&str, &str)] = &[
    ("pioneerp3dx", "pioneer_p3dx"),
    ("quadcopter", "quadrotor"),
    ("quadricopter", "quadrotor"),
    ("epuck", "e_puck"),
    ("bubblerob", "bubblerob"),
    ("manta", "manta"),
    ("mantawithdifferential", "manta"),
    ("hexapod", "hexapod"),
    ("snake", "snake"),
    ("thymio", "thymio"),
    ("thymioii", "thymio"),
    ("ur5", "ur5"),
    ("frankaemikapanda", "panda"),
    ("frankapanda", "panda"),
    ("robotiq85", "gripper_2f85"),
    ("hokuyourg04lxug01", "hokuyo"),
    ("hokuyourg04lxug01fast", "fast_hokuyo"),
    ("fasthokuyourg04lxug01", "fast_hokuyo"),
    ("fasthokuyo", "fast_hokuyo"),
    ("2dlaserscanner", "laser_scanner_2d"),
    ("laserscanner2d", "laser_scanner_2d"),
    ("kinect", "kinect"),
    ("gps", "gps"),
    ("walkingbill", "person"),
    ("standingbill", "person"),
    ("conveyorbelt", "conveyor"),
    ("genericconveyor", "conveyor"),
    ("customizabletable", "table"),
];

/// Words that occur in paths of V-REP's models, and the models of Tatu that are most similar.
const NEAREST: &[(&str, &str)] = &[
    ("youbot", "omni_platform"),
    ("turtlebot", "turtlebot3"),
    ("omni", "omni_platform"),
    ("mecanum", "omni_platform"),
    ("copter", "quadrotor"),
    ("hexapod", "hexapod"),
    ("ant", "hexapod"),
    ("asti", "humanoid"),
    ("nao", "humanoid"),
    ("snake", "snake"),
    ("acm", "snake"),
    ("pioneer", "pioneer_p3dx"),
    ("ur3", "ur5"),
    ("ur10", "ur5"),
    ("lbr", "panda"),
    ("delta", "delta"),
    ("irb", "ur5"),
    ("scara", "scara"),
    ("mtb", "scara"),
    ("gripper", "gripper_2f85"),
    ("grippers", "gripper_2f85"),
    ("hand", "hand"),
    ("hokuyo", "hokuyo"),
    ("sick", "sick"),
    ("laser", "laser_scanner_2d"),
    ("kinect", "kinect"),
    ("sensors", "kinect"),
    ("people", "person"),
    ("bill", "person"),
    ("conveyor", "conveyor"),
    ("belts", "conveyor"),
    ("door", "door"),
    ("doors", "door"),
    ("shelf", "shelf"),
    ("shelves", "shelf"),
    ("pallet", "pallet"),
    ("wall", "wall"),
    ("walls", "wall"),
    ("table", "table"),
    ("tables", "table"),
    ("vehicles", "ackermann"),
    ("non", "ur5"),
    ("mobile", "pioneer_p3dx"),
];

/// Returns the file name of a path without its extension.
fn stem(path: &str) -> &str {
    let name = path.rsplit(['/', '\\']).next().unwrap_or_default();
    name.rsplit_once('.').map_or(name, |(stem, _)| stem)
}

/// Returns the model that is equivalent to the model of V-REP at a path, or `None` if there is none.
pub(crate) fn same_model(path: &str) -> Option<&'static str> {
    let name: String = stem(path).chars().filter(char::is_ascii_alphanumeric).collect();
    let name = name.to_ascii_lowercase();
    SAME.iter().find(|(theirs, _)| *theirs == name).map(|(_, own)| *own)
}

/// Returns the model that is most similar to the model of V-REP at a path, or `None` if no word of the path is known.
/// The last known word determines the result, because it is the most specific one.
pub(crate) fn nearest_model(path: &str) -> Option<&'static str> {
    let path = path.to_ascii_lowercase();
    let words: Vec<&str> = path.split(|c: char| !c.is_ascii_alphanumeric()).filter(|w| !w.is_empty()).collect();
    words.iter().rev().find_map(|word| NEAREST.iter().find(|(w, _)| w == word).map(|(_, own)| *own))
}

#[cfg(test)]
mod tests {
    use super::{SAME, nearest_model, same_model};

    #[test]
    fn paths_of_the_installation_mean_the_same_models() {
        for (path, own) in [
            ("models/robots/mobile/pioneer p3dx.ttm", Some("pioneer_p3dx")),
            ("/opt/CoppeliaSim/models/robots/mobile/Quadcopter.ttm", Some("quadrotor")),
            ("models\\components\\sensors\\Hokuyo URG 04LX UG01_Fast.ttm", Some("fast_hokuyo")),
            ("models/robots/non-mobile/FrankaEmikaPanda.ttm", Some("panda")),
            ("models/robots/mobile/KUKA YouBot.ttm", None),
        ] {
            assert_eq!(same_model(path), own, "{path}");
        }
    }

    #[test]
    fn other_paths_have_a_nearest_model() {
        assert_eq!(nearest_model("models/robots/mobile/KUKA YouBot.ttm"), Some("omni_platform"));
        assert_eq!(nearest_model("models/robots/non-mobile/KUKA LBR iiwa 7 R800.ttm"), Some("panda"));
        assert_eq!(nearest_model("models/people/path planning Bill.ttm"), Some("person"));
        assert_eq!(nearest_model("models/nature/tree.ttm"), None);
    }

    #[test]
    fn replacements_exist() {
        let models = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../models");
        let own = SAME.iter().chain(super::NEAREST).map(|(_, own)| own);
        own.for_each(|own| assert!(models.join(own).join("model.toml").is_file(), "{own}"));
    }
}
