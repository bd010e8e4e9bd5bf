//! Lua modules of the original that scripts `require`, as far as they mean something here.
//!
//! A file of the same name that a script may read comes before these.

use crate::kit::*;

pub(crate) fn offer(offer: &mut Offer<Vrep>) {
    for (name, text) in [
        ("defaultMainScript", include_str!("../../modules/default_main_script.lua")),
        ("utils", include_str!("../../modules/utils.lua")),
        ("configUi", include_str!("../../modules/config_ui.lua")),
        // Fills a window with the curves of a graph; there are no windows.
        ("graph_customization", "return {}"),
    ] {
        offer.prelude("lua", name, text);
    }
}
