//! Substitutes for Lua modules of V-REP that scripts load with `require`.
//!
//! A file with the same name takes precedence if the script can read it.

use crate::kit::*;

pub(crate) fn offer(offer: &mut Offer<Vrep>) {
    let graph = include_str!("../../modules/graph.lua");
    let path = include_str!("../../modules/path.lua");
    let conveyor = include_str!("../../modules/conveyor.lua");
    for (name, text) in [
        ("defaultMainScript", include_str!("../../modules/default_main_script.lua")),
        ("utils", include_str!("../../modules/utils.lua")),
        ("configUi", include_str!("../../modules/config_ui.lua")),
        ("gcode", include_str!("../../modules/gcode.lua")),
        ("sim-1", "return sim"),
        ("sim-2", include_str!("../../modules/sim_2.lua")),
        ("messagePack", include_str!("../../modules/message_pack.lua")),
        ("org.conman.cbor", include_str!("../../modules/cbor.lua")),
        ("models.model_with", include_str!("../../modules/model_with.lua")),
        ("graph_customization", graph),
        ("models.graph_customization", graph),
        ("models.deprecated.graph_customization", graph),
        ("models.graph_customization-2", graph),
        ("path_customization", path),
        ("models.path_customization", path),
        ("models.deprecated.path_customization", path),
        ("models.path_customization-2", path),
    ] {
        offer.prelude("lua", name, text);
    }
    // Since the first version, the scripts of conveyors use the same data.
    let efficient =
        "local conveyor = require 'models.conveyor_customization-3' conveyor.efficient = true return conveyor";
    for folder in ["", "models.", "models.deprecated."] {
        for version in ["", "-2", "-3"] {
            for (name, text) in [("conveyor", conveyor), ("conveyorSystem", conveyor), ("efficientConveyor", efficient)]
            {
                offer.prelude("lua", &format!("{folder}{name}_customization{version}"), text);
            }
        }
    }
}
