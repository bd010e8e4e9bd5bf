//! Commands that are accepted but have no effect, and the constants of `simUI`.

use tatu_commands_common::{
    Gives::{self, *},
    stub,
};
use tatu_plugin_api::safe::{Constant, Offer, Value};

use crate::plugin::{SimUi, old_name};

const ASKS: &str = "no dialog is shown: the answer is always yes, or the previous value";
const LOOKS: &str = "views lay out windows automatically";
const RARE: &str = "this element is not supported";

const STUBS: &[(&str, Gives, &str)] = &[
    ("simUI.msgBox", Int(2), ASKS),
    ("simUI.inputDialog", Text(""), ASKS),
    ("simUI.colorDialog", Zeros, ASKS),
    ("simUI.fileDialog", Empty, ASKS),
    ("simUI.adjustSize", Nothing, LOOKS),
    ("simUI.setCurrentEditWidget", Nothing, LOOKS),
    ("simUI.getCurrentEditWidget", Text(""), LOOKS),
    ("simUI.setColumnWidth", Nothing, LOOKS),
    ("simUI.setRowHeight", Nothing, LOOKS),
    ("simUI.setRowHeaderText", Nothing, LOOKS),
    ("simUI.setItemEditable", Nothing, LOOKS),
    ("simUI.setTableSelection", Nothing, LOOKS),
    ("simUI.insertTableRow", Nothing, LOOKS),
    ("simUI.removeTableRow", Nothing, LOOKS),
    ("simUI.insertTableColumn", Nothing, LOOKS),
    ("simUI.removeTableColumn", Nothing, LOOKS),
    ("simUI.growPlotXRange", Nothing, LOOKS),
    ("simUI.growPlotYRange", Nothing, LOOKS),
    ("simUI.setPlotRanges", Nothing, LOOKS),
    ("simUI.setPlotXRange", Nothing, LOOKS),
    ("simUI.setPlotYRange", Nothing, LOOKS),
    ("simUI.setPlotLabels", Nothing, LOOKS),
    ("simUI.setPlotXLabel", Nothing, LOOKS),
    ("simUI.setPlotYLabel", Nothing, LOOKS),
    ("simUI.rescaleAxes", Nothing, LOOKS),
    ("simUI.rescaleAxesAll", Nothing, LOOKS),
    ("simUI.setLegendVisibility", Nothing, LOOKS),
    ("simUI.setMouseOptions", Nothing, LOOKS),
    ("simUI.getKeyboardModifiers", Empty, LOOKS),
    ("simUI.setClipboardText", Nothing, LOOKS),
    ("simUI.getClipboardText", Text(""), LOOKS),
    ("simUI.setImage", Nothing, RARE),
    ("simUI.setScene3DNodeParam", Nothing, RARE),
    ("simUI.setScene3DNodeFloatParam", Nothing, RARE),
    ("simUI.setScene3DNodeIntParam", Nothing, RARE),
    ("simUI.setScene3DNodeStringParam", Nothing, RARE),
    ("simUI.addScene3DNode", Int(1), RARE),
    ("simUI.removeScene3DNode", Nothing, RARE),
    ("simUI.setUrl", Nothing, RARE),
    ("simUI.loadURL", Nothing, RARE),
    ("simUI.setPropertiesRows", Nothing, RARE),
    ("simUI.setProperties", Nothing, RARE),
    ("simUI.setPropertiesSelection", Nothing, RARE),
];

/// Names and values of the constants for curve markers.
const SCATTER: &[(&str, i64)] = &[
    ("none", 0),
    ("dot", 1),
    ("cross", 2),
    ("plus", 3),
    ("circle", 4),
    ("disc", 5),
    ("square", 6),
    ("diamond", 7),
    ("star", 8),
    ("triangle", 9),
    ("triangle_inverted", 10),
    ("cross_square", 11),
    ("plus_square", 12),
    ("cross_circle", 13),
    ("plus_circle", 14),
    ("peace", 15),
];

pub(crate) fn offer(offer: &mut Offer<SimUi>) {
    for (name, gives, why) in STUBS {
        offer.command(stub(name, *gives, why).old_name(old_name(name), gives.on_error()));
    }
    let named = |pairs: &[(&str, i64)]| -> Value {
        Value::Map(pairs.iter().map(|(k, v)| (Value::text(k), Value::Int(*v))).collect())
    };
    for (name, value) in [
        ("msgbox_type", named(&[("info", 0), ("question", 1), ("warning", 2), ("critical", 3)])),
        ("msgbox_buttons", named(&[("ok", 0), ("yesno", 1), ("yesnocancel", 2), ("okcancel", 3)])),
        ("msgbox_result", named(&[("cancel", 0), ("no", 1), ("yes", 2), ("ok", 3), ("error", 4)])),
        ("filedialog_type", named(&[("load", 0), ("save", 1), ("load_multiple", 2), ("folder", 3)])),
        ("curve_type", named(&[("time", 0), ("xy", 1)])),
        ("curve_style", named(&[("scatter", 0), ("line", 1), ("line_and_scatter", 2), ("step_left", 3)])),
        ("scatter_shape", named(SCATTER)),
        ("curve_scatter_shape", named(SCATTER)),
    ] {
        offer.constant(Constant::new(format!("simUI.{name}"), value));
    }
}
