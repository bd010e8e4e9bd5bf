//! What is taken and answered with a neutral value: windows, drawing for the eye, and parts of the original for which
//! there is nothing here.
//!
//! A stub yields to a command of its name that another file declares.

use crate::{Vrep, kit::*};

/// What a stub gives.
#[derive(Clone, Copy)]
enum Gives {
    Nothing,
    Int(i64),
    Float(f64),
    Text(&'static str),
    False,
    Empty,
    /// Two integers, as one table or as two values.
    Pair,
    TwoInts,
    Three(f64),
}
use Gives::*;

const WINDOWS: &str = "there is no window";
const OLD_UI: &str = "there are no user interfaces of the oldest kind";
const LOOKS: &str = "nothing is drawn";
const THREADS: &str = "threads are coroutines";
const PORTS: &str = "scripts have no serial ports";
const SHAPES: &str = "shapes have no textures";
const CLOUDS: &str = "there are no octrees and point clouds";
const PLANNING: &str = "there is no path planning";
const ENGINE: &str = "the engine has no parameters of the original's engines";
const EDITOR: &str = "there is no editor";
const PROGRAM: &str = "the original's program has it, this one does not";
const PICTURES: &str = "images are not changed";
const SCRIPTS: &str = "scripts are made with the scene";

/// Commands of `sim` that had a flat name: name, what it gives, what a failed call gave, why.
const OLD: &[(&str, Gives, &str)] = &[
    ("getUIHandle", Int(-1), OLD_UI),
    ("getUISlider", Int(-1), OLD_UI),
    ("setUISlider", Int(-1), OLD_UI),
    ("getUIButtonLabel", Int(-1), OLD_UI),
    ("setUIButtonLabel", Int(-1), OLD_UI),
    ("getUIEventButton", Int(-1), OLD_UI),
    ("getUIButtonProperty", Int(-1), OLD_UI),
    ("setUIButtonProperty", Int(-1), OLD_UI),
    ("setUIButtonColor", Int(-1), OLD_UI),
    ("setUIButtonTexture", Int(-1), OLD_UI),
    ("setUIButtonArrayColor", Int(-1), OLD_UI),
    ("createUIButtonArray", Int(-1), OLD_UI),
    ("deleteUIButtonArray", Int(-1), OLD_UI),
    ("getUIButtonSize", Int(-1), OLD_UI),
    ("getUIPosition", Pair, OLD_UI),
    ("setUIPosition", Int(-1), OLD_UI),
    ("getUIProperty", Int(-1), OLD_UI),
    ("setUIProperty", Int(-1), OLD_UI),
    ("createUI", Int(-1), OLD_UI),
    ("createUIButton", Int(-1), OLD_UI),
    ("removeUI", Int(-1), OLD_UI),
    ("handleUI", Int(-1), OLD_UI),
    ("cameraFitToView", Int(1), WINDOWS),
    ("getPage", Int(0), WINDOWS),
    ("setPage", Int(1), WINDOWS),
    ("getNavigationMode", Int(0), WINDOWS),
    ("setNavigationMode", Int(1), WINDOWS),
    ("refreshDialogs", Int(1), WINDOWS),
    ("announceSceneContentChange", Int(1), WINDOWS),
    ("addGhost", Int(1), LOOKS),
    ("modifyGhost", Int(1), LOOKS),
    ("addPointCloud", Int(1), LOOKS),
    ("modifyPointCloud", Int(1), LOOKS),
    ("getLightParameters", Int(1), LOOKS),
    ("setLightParameters", Int(1), LOOKS),
    ("setShapeTexture", Int(1), SHAPES),
    ("getShapeTextureId", Int(-1), SHAPES),
    ("getTextureId", Int(-1), SHAPES),
    ("createTexture", Int(-1), SHAPES),
    ("writeTexture", Int(1), SHAPES),
    ("readTexture", Nothing, SHAPES),
    ("setShapeMaterial", Int(1), "friction is a property of its own: shape.friction"),
    ("reorientShapeBoundingBox", Int(1), "the box of a shape lies about its frame"),
    ("enableWorkThreads", Int(0), THREADS),
    ("waitForWorkThreads", Int(0), THREADS),
    ("setThreadIsFree", Int(1), THREADS),
    ("setThreadResumeLocation", Int(1), THREADS),
    ("getThreadId", Int(1), THREADS),
    ("setThreadSwitchTiming", Int(1), THREADS),
    ("getThreadSwitchTiming", Int(2), THREADS),
    ("setThreadAutomaticSwitch", Int(1), THREADS),
    ("getThreadAutomaticSwitch", Int(1), THREADS),
    ("getThreadExistRequest", Int(0), THREADS),
    ("getThreadExitRequest", Int(0), THREADS),
    ("lockResources", Int(0), THREADS),
    ("unlockResources", Int(0), THREADS),
    ("delegateChildScriptExecution", Int(0), "child scripts are called by the host"),
    ("handleSensingChildScripts", Int(0), "child scripts are called by the host"),
    ("addScript", Int(-1), SCRIPTS),
    ("associateScriptWithObject", Int(-1), SCRIPTS),
    ("setScriptText", Int(-1), SCRIPTS),
    ("setScriptRawBuffer", Int(-1), SCRIPTS),
    ("getScriptRawBuffer", Nothing, SCRIPTS),
    ("serialOpen", Int(-1), PORTS),
    ("serialClose", Int(-1), PORTS),
    ("serialSend", Int(-1), PORTS),
    ("serialRead", Nothing, PORTS),
    ("serialCheck", Int(-1), PORTS),
    ("serialPortOpen", Int(-1), PORTS),
    ("serialPortClose", Int(-1), PORTS),
    ("serialPortSend", Int(-1), PORTS),
    ("serialPortRead", Nothing, PORTS),
    ("launchExecutable", Int(-1), "scripts start no programs"),
    ("loadModule", Int(-1), "there are no plugins of the original's kind"),
    ("unloadModule", Int(0), "there are no plugins of the original's kind"),
    ("getModuleInfo", Int(0), "there are no plugins of the original's kind"),
    ("auxFunc", Int(-1), PROGRAM),
    ("test", Int(-1), PROGRAM),
    ("getExtensionString", Text(""), PROGRAM),
    ("getConfigurationTree", Int(1), "configurations are not kept"),
    ("setConfigurationTree", Int(1), "configurations are not kept"),
    ("getObjectConfiguration", Int(1), "configurations are not kept"),
    ("setObjectConfiguration", Int(1), "configurations are not kept"),
    ("getApiFunc", Empty, EDITOR),
    ("getApiInfo", Text(""), EDITOR),
    ("openTextEditor", Text(""), EDITOR),
    ("getEngineBoolParameter", False, ENGINE),
    ("getEngineInt32Parameter", Int(0), ENGINE),
    ("getEngineFloatParameter", Float(0.0), ENGINE),
    ("setEngineBoolParameter", Int(1), ENGINE),
    ("setEngineInt32Parameter", Int(1), ENGINE),
    ("setEngineFloatParameter", Int(1), ENGINE),
    ("createOctree", Int(-1), CLOUDS),
    ("createPointCloud", Int(-1), CLOUDS),
    ("getOctreeVoxels", Empty, CLOUDS),
    ("getPointCloudPoints", Empty, CLOUDS),
    ("getPointCloudOptions", Float(0.0), CLOUDS),
    ("setPointCloudOptions", Int(1), CLOUDS),
    ("insertObjectIntoOctree", Int(0), CLOUDS),
    ("insertVoxelsIntoOctree", Int(0), CLOUDS),
    ("removeVoxelsFromOctree", Int(0), CLOUDS),
    ("subtractObjectFromOctree", Int(0), CLOUDS),
    ("checkOctreePointOccupancy", Int(0), CLOUDS),
    ("insertObjectIntoPointCloud", Int(0), CLOUDS),
    ("insertPointsIntoPointCloud", Int(0), CLOUDS),
    ("removePointsFromPointCloud", Int(0), CLOUDS),
    ("intersectPointsWithPointCloud", Int(0), CLOUDS),
    ("subtractObjectFromPointCloud", Int(0), CLOUDS),
    ("applyMilling", Int(0), "there are no mills"),
    ("getPathPlanningHandle", Int(-1), PLANNING),
    ("initializePathSearch", Int(-1), PLANNING),
    ("performPathSearchStep", Int(0), PLANNING),
    ("searchPath", Int(0), PLANNING),
    ("createMotionPlanning", Int(-1), PLANNING),
    ("getMotionPlanningHandle", Int(-1), PLANNING),
    ("removeMotionPlanning", Int(-1), PLANNING),
    ("setPathTargetNominalVelocity", Int(1), "nothing moves along a path by itself"),
    ("getPathPlanningObject", Int(-1), PLANNING),
    ("checkCollisionEx", Int(0), "sim.checkCollision tells whether shapes overlap"),
    ("exportMesh", Int(-1), "meshes are not written"),
    ("exportIk", Int(-1), "there is no inverse kinematics"),
    ("setSimulationTimeStep", Int(-1), "the step belongs to the scene"),
    ("getSimulationPassesPerRenderingPass", Int(1), WINDOWS),
    ("setSimulationPassesPerRenderingPass", Int(1), WINDOWS),
    ("isRealTimeSimulationStepNeeded", Int(1), "simulation time is the only clock"),
    ("getLastErrorCode", Int(0), PROGRAM),
    ("setIkGroupProperties", Int(-1), "there is no inverse kinematics"),
    ("setIkElementProperties", Int(-1), "there is no inverse kinematics"),
    ("checkIkGroup", Int(0), "there is no inverse kinematics"),
    ("computeJacobian", Int(-1), "there is no inverse kinematics"),
    ("getIkGroupMatrix", Nothing, "there is no inverse kinematics"),
    ("generateIkPath", Nothing, "there is no inverse kinematics"),
    ("getConfigForTipPose", Nothing, "there is no inverse kinematics"),
    ("findMpPath", Nothing, PLANNING),
    ("simplifyMpPath", Nothing, PLANNING),
    ("getMpConfigTransition", Nothing, PLANNING),
    ("transformBuffer", Text(""), PICTURES),
    ("combineRgbImages", Text(""), PICTURES),
    ("createIkGroup", Int(-1), "there is no inverse kinematics"),
    ("createIkElement", Int(-1), "there is no inverse kinematics"),
    ("removeIkGroup", Int(-1), "there is no inverse kinematics"),
];

/// Commands of `sim` that never had a flat name.
const MODERN: &[(&str, Gives, &str)] = &[
    ("getEngineBoolParam", False, ENGINE),
    ("getEngineInt32Param", Int(0), ENGINE),
    ("getEngineFloatParam", Float(0.0), ENGINE),
    ("setEngineBoolParam", Nothing, ENGINE),
    ("setEngineInt32Param", Nothing, ENGINE),
    ("setEngineFloatParam", Nothing, ENGINE),
    ("getNamedStringParam", Nothing, "the command line hands no parameters to scripts"),
    ("getNamedBoolParam", Nothing, "the command line hands no parameters to scripts"),
    ("getNamedFloatParam", Nothing, "the command line hands no parameters to scripts"),
    ("getNamedInt32Param", Nothing, "the command line hands no parameters to scripts"),
    ("setNamedStringParam", Nothing, "the command line hands no parameters to scripts"),
    ("setNamedBoolParam", Nothing, "the command line hands no parameters to scripts"),
    ("setNamedFloatParam", Nothing, "the command line hands no parameters to scripts"),
    ("setNamedInt32Param", Nothing, "the command line hands no parameters to scripts"),
    ("setAutoYieldDelay", Nothing, THREADS),
    ("getAutoYieldDelay", Float(0.002), THREADS),
    ("acquireLock", Nothing, THREADS),
    ("releaseLock", Nothing, THREADS),
    ("setStepping", Int(0), THREADS),
    ("fastIdleLoop", Nothing, WINDOWS),
    ("handleExtCalls", Nothing, PROGRAM),
    ("systemSemaphore", Nothing, PROGRAM),
    ("pushUserEvent", Nothing, PROGRAM),
    ("getGenesisEvents", Empty, PROGRAM),
    ("registerScriptFuncHook", Int(-1), "functions of scripts are not hooked"),
    ("getStackTraceback", Text(""), "errors tell where they happened"),
    ("getUserVariables", Empty, EDITOR),
    ("initScript", Nothing, SCRIPTS),
    ("createScript", Int(-1), SCRIPTS),
    ("textEditorOpen", Int(-1), EDITOR),
    ("textEditorShow", Nothing, EDITOR),
    ("textEditorClose", Text(""), EDITOR),
    ("textEditorGetInfo", Text(""), EDITOR),
    ("getPluginInfo", Text(""), "there are no plugins of the original's kind"),
    ("setPluginInfo", Nothing, "there are no plugins of the original's kind"),
    ("setModuleInfo", Nothing, "there are no plugins of the original's kind"),
    ("moduleEntry", Int(-1), WINDOWS),
    ("getShapeViz", Empty, LOOKS),
    ("generateTextShape", Int(-1), LOOKS),
    ("setObjectHierarchyOrder", Nothing, "the order of siblings stays"),
    ("setExplicitHandlingFlags", Nothing, PROGRAM),
    ("relocateShapeFrame", Int(1), "the frame of a shape stays"),
    ("alignShapeBB", Int(1), "the box of a shape lies about its frame"),
    ("getObjectFloatArrayParam", Empty, PROGRAM),
    ("setObjectFloatArrayParam", Nothing, PROGRAM),
    ("createCustomObject", Int(-1), PROGRAM),
    ("getExitRequest", Int(0), PROGRAM),
    ("getAlternateConfigs", Nothing, PLANNING),
];

/// Marks of curves, by their numbers.
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

/// Commands of the module for windows.
const UI: &[(&str, Gives)] = &[
    ("create", Int(1)),
    ("destroy", Nothing),
    ("setLabelText", Nothing),
    ("setSliderValue", Nothing),
    ("getSliderValue", Int(0)),
    ("getPosition", TwoInts),
    ("setPosition", Nothing),
    ("getSize", TwoInts),
    ("setSize", Nothing),
    ("adjustSize", Nothing),
    ("msgBox", Int(2)),
    ("inputDialog", Text("")),
    ("colorDialog", Three(0.0)),
    ("fileDialog", Empty),
    ("getCheckboxValue", Int(0)),
    ("setCheckboxValue", Nothing),
    ("getRadiobuttonValue", Int(0)),
    ("setRadiobuttonValue", Nothing),
    ("setEditValue", Nothing),
    ("getEditValue", Text("")),
    ("getSpinboxValue", Int(0)),
    ("setSpinboxValue", Nothing),
    ("setEnabled", Nothing),
    ("setWidgetVisibility", Nothing),
    ("hide", Nothing),
    ("show", Nothing),
    ("isVisible", False),
    ("getComboboxSelectedIndex", Int(0)),
    ("getComboboxItemText", Text("")),
    ("getComboboxItemCount", Int(0)),
    ("getComboboxItems", Empty),
    ("setComboboxItems", Nothing),
    ("setComboboxSelectedIndex", Nothing),
    ("insertComboboxItem", Nothing),
    ("removeComboboxItem", Nothing),
    ("setImage", Nothing),
    ("setImageData", Nothing),
    ("setStyleSheet", Nothing),
    ("setCurrentEditWidget", Nothing),
    ("getCurrentEditWidget", Text("")),
    ("setItem", Nothing),
    ("getItem", Text("")),
    ("clearTable", Nothing),
    ("setRowCount", Nothing),
    ("setColumnCount", Nothing),
    ("getRowCount", Int(0)),
    ("getColumnCount", Int(0)),
    ("setRowHeaderText", Nothing),
    ("setColumnHeaderText", Nothing),
    ("setColumnWidth", Nothing),
    ("setRowHeight", Nothing),
    ("setItemEditable", Nothing),
    ("setTableSelection", Nothing),
    ("insertTableRow", Nothing),
    ("removeTableRow", Nothing),
    ("insertTableColumn", Nothing),
    ("removeTableColumn", Nothing),
    ("setMouseOptions", Nothing),
    ("replot", Nothing),
    ("addCurve", Nothing),
    ("removeCurve", Nothing),
    ("clearCurve", Nothing),
    ("addCurveTimePoints", Nothing),
    ("addCurveXYPoints", Nothing),
    ("growPlotXRange", Nothing),
    ("growPlotYRange", Nothing),
    ("setPlotRanges", Nothing),
    ("setPlotXRange", Nothing),
    ("setPlotYRange", Nothing),
    ("setPlotLabels", Nothing),
    ("setPlotXLabel", Nothing),
    ("setPlotYLabel", Nothing),
    ("rescaleAxes", Nothing),
    ("rescaleAxesAll", Nothing),
    ("setLegendVisibility", Nothing),
    ("setProgress", Nothing),
    ("setTitle", Nothing),
    ("getTitle", Text("")),
    ("setText", Nothing),
    ("getText", Text("")),
    ("setButtonText", Nothing),
    ("getButtonText", Text("")),
    ("setButtonPressed", Nothing),
    ("getLabelText", Text("")),
    ("clearTree", Nothing),
    ("addTreeItem", Nothing),
    ("updateTreeItemText", Nothing),
    ("removeTreeItem", Nothing),
    ("expandAll", Nothing),
    ("collapseAll", Nothing),
    ("getCurrentTab", Int(0)),
    ("setCurrentTab", Nothing),
    ("setWindowEnabled", Nothing),
    ("getKeyboardModifiers", Empty),
    ("setScene3DNodeParam", Nothing),
    ("setScene3DNodeFloatParam", Nothing),
    ("setScene3DNodeIntParam", Nothing),
    ("setScene3DNodeStringParam", Nothing),
    ("addScene3DNode", Int(1)),
    ("removeScene3DNode", Nothing),
    ("setUrl", Nothing),
    ("loadURL", Nothing),
    ("setPropertiesRows", Nothing),
    ("setProperties", Nothing),
    ("setPropertiesSelection", Nothing),
    ("setClipboardText", Nothing),
    ("getClipboardText", Text("")),
];

pub(crate) fn offer(offer: &mut Offer<Vrep>) {
    for (name, gives, why) in OLD {
        let on_error = if matches!(gives, Nothing | Text(_) | Empty | Pair) { NIL } else { MINUS };
        add(offer, format!("sim.{name}"), Some((flat_name(name), on_error)), *gives, why);
    }
    for (name, gives, why) in MODERN {
        add(offer, format!("sim.{name}"), None, *gives, why);
    }
    for (name, gives) in UI {
        let on_error = if matches!(gives, Int(_)) { MINUS } else { NIL };
        add(offer, format!("simUI.{name}"), Some((format!("simExtCustomUI_{name}"), on_error)), *gives, WINDOWS);
    }
    let remote = "no remote API of the original's kind is started from scripts";
    for (name, flat, gives) in [
        ("start", "simExtRemoteApiStart", 1),
        ("stop", "simExtRemoteApiStop", 1),
        ("status", "simExtRemoteApiStatus", -1),
        ("reset", "simExtRemoteApiReset", 1),
    ] {
        add(offer, format!("simRemoteApi.{name}"), Some((flat.to_owned(), MINUS)), Int(gives), remote);
    }
    // The ROS interface of before 2016; without a node nothing is sent, and topics have no names.
    for name in ["enablePublisher", "enableSubscriber"] {
        let flat = format!("simExtROS_{name}");
        add(offer, flat, None, Nothing, "there is no ROS node");
    }
    for name in ["disablePublisher", "disableSubscriber", "wakePublisher"] {
        add(offer, format!("simExtROS_{name}"), None, Int(-1), "there is no ROS node");
    }
    offer.prelude("lua", "sim-1", "return sim");
    offer.prelude("lua", "sim-2", "return sim");
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

fn add(offer: &mut Offer<Vrep>, name: String, flat: Option<(String, [Value; 1])>, gives: Gives, why: &str) {
    if offer.has_command(&name) {
        return;
    }
    let mut command = Cmd::new(name, move |c| {
        match gives {
            Nothing => {}
            Int(i) => c.ret(i),
            Float(x) => c.ret(x),
            Text(t) => c.ret::<str>(t),
            False => c.ret(false),
            Empty => c.ret::<Value>(Value::List(Vec::new())),
            Pair => c.ret::<[i64]>(&[0, 0][..]),
            TwoInts => {
                c.ret(0_i64);
                c.ret(0_i64);
            }
            Three(x) => c.ret::<[f64]>(&[x; 3][..]),
        }
        Ok(())
    });
    if let Some((flat, on_error)) = flat.filter(|(flat, _)| !offer.has_command(flat)) {
        command = command.old_name(flat, on_error);
    }
    let returns = match gives {
        Nothing => None,
        Int(_) => Some(Param::int("result")),
        Float(_) => Some(Param::float("result")),
        Text(_) => Some(Param::string("text")),
        False => Some(Param::bool("result")),
        Empty | Pair | TwoInts => Some(Param::any("result")),
        Three(_) => Some(Param::floats("result", 3)),
    };
    let mut command = command.param(Param::any("arguments").rest());
    if let Some(r) = returns {
        command = command.returns(r);
    }
    offer.command(command.text("Takes what it is given, and does nothing.").stub(why));
}
