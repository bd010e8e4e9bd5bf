//! Commands that are accepted but have no effect, and the constants of `simUI`.

use tatu_commands_common::{
    StubResult::{self, *},
    stub,
};
use tatu_plugin_api::safe::{Constant, Offer, Value};

use crate::plugin::{SimUi, old_name};

const NO_DIALOG: &str = "no dialog is shown: the answer is always yes, or the previous value";
const AUTOMATIC_LAYOUT: &str = "views lay out windows automatically";
const UNSUPPORTED_ELEMENT: &str = "this element is not supported";

const STUBS: &[(&str, StubResult, &str)] = &[
    ("simUI.msgBox", Int(2), NO_DIALOG),
    ("simUI.inputDialog", Text(""), NO_DIALOG),
    ("simUI.colorDialog", Zeros, NO_DIALOG),
    ("simUI.fileDialog", Empty, NO_DIALOG),
    ("simUI.adjustSize", Nothing, AUTOMATIC_LAYOUT),
    ("simUI.setCurrentEditWidget", Nothing, AUTOMATIC_LAYOUT),
    ("simUI.getCurrentEditWidget", Text(""), AUTOMATIC_LAYOUT),
    ("simUI.setColumnWidth", Nothing, AUTOMATIC_LAYOUT),
    ("simUI.setRowHeight", Nothing, AUTOMATIC_LAYOUT),
    ("simUI.setRowHeaderText", Nothing, AUTOMATIC_LAYOUT),
    ("simUI.setItemEditable", Nothing, AUTOMATIC_LAYOUT),
    ("simUI.setTableSelection", Nothing, AUTOMATIC_LAYOUT),
    ("simUI.insertTableRow", Nothing, AUTOMATIC_LAYOUT),
    ("simUI.removeTableRow", Nothing, AUTOMATIC_LAYOUT),
    ("simUI.insertTableColumn", Nothing, AUTOMATIC_LAYOUT),
    ("simUI.removeTableColumn", Nothing, AUTOMATIC_LAYOUT),
    ("simUI.growPlotXRange", Nothing, AUTOMATIC_LAYOUT),
    ("simUI.growPlotYRange", Nothing, AUTOMATIC_LAYOUT),
    ("simUI.setPlotRanges", Nothing, AUTOMATIC_LAYOUT),
    ("simUI.setPlotXRange", Nothing, AUTOMATIC_LAYOUT),
    ("simUI.setPlotYRange", Nothing, AUTOMATIC_LAYOUT),
    ("simUI.setPlotLabels", Nothing, AUTOMATIC_LAYOUT),
    ("simUI.setPlotXLabel", Nothing, AUTOMATIC_LAYOUT),
    ("simUI.setPlotYLabel", Nothing, AUTOMATIC_LAYOUT),
    ("simUI.rescaleAxes", Nothing, AUTOMATIC_LAYOUT),
    ("simUI.rescaleAxesAll", Nothing, AUTOMATIC_LAYOUT),
    ("simUI.setLegendVisibility", Nothing, AUTOMATIC_LAYOUT),
    ("simUI.setMouseOptions", Nothing, AUTOMATIC_LAYOUT),
    ("simUI.getKeyboardModifiers", Empty, AUTOMATIC_LAYOUT),
    ("simUI.setClipboardText", Nothing, AUTOMATIC_LAYOUT),
    ("simUI.getClipboardText", Text(""), AUTOMATIC_LAYOUT),
    ("simUI.setImage", Nothing, UNSUPPORTED_ELEMENT),
    ("simUI.setScene3DNodeParam", Nothing, UNSUPPORTED_ELEMENT),
    ("simUI.setScene3DNodeFloatParam", Nothing, UNSUPPORTED_ELEMENT),
    ("simUI.setScene3DNodeIntParam", Nothing, UNSUPPORTED_ELEMENT),
    ("simUI.setScene3DNodeStringParam", Nothing, UNSUPPORTED_ELEMENT),
    ("simUI.addScene3DNode", Int(1), UNSUPPORTED_ELEMENT),
    ("simUI.removeScene3DNode", Nothing, UNSUPPORTED_ELEMENT),
    ("simUI.setUrl", Nothing, UNSUPPORTED_ELEMENT),
    ("simUI.loadURL", Nothing, UNSUPPORTED_ELEMENT),
    ("simUI.setPropertiesRows", Nothing, UNSUPPORTED_ELEMENT),
    ("simUI.setProperties", Nothing, UNSUPPORTED_ELEMENT),
    ("simUI.setPropertiesSelection", Nothing, UNSUPPORTED_ELEMENT),
];

/// Names and values of the constants for curve markers.
const SCATTER_CONSTANTS: &[(&str, i64)] = &[
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
        ("scatter_shape", named(SCATTER_CONSTANTS)),
        ("curve_scatter_shape", named(SCATTER_CONSTANTS)),
    ] {
        offer.constant(Constant::new(format!("simUI.{name}"), value));
    }
}
