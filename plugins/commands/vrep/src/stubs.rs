//! What is taken and answered with a neutral value: windows, drawing for the eye, and parts of the original for which
//! there is nothing here.
//!
//! A stub yields to a command of its name that another file declares.

use crate::kit::*;

/// What a stub gives.
#[derive(Clone, Copy)]
enum Gives {
    Nothing,
    Int(i64),
    Float(f64),
    Text(&'static str),
    Empty,
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
const EDITOR: &str = "there is no editor";
const PROGRAM: &str = "the original's program has it, this one does not";
const PICTURES: &str = "images are not changed";
const SCRIPTS: &str = "scripts are made with the scene";

/// Commands of `sim` that had a flat name: name, what it gives, what a failed call gave, why.
const OLD: &[(&str, Gives, &str)] = &[
    ("sim.setUIButtonTexture", Int(-1), OLD_UI),
    ("sim.setUIButtonArrayColor", Int(-1), OLD_UI),
    ("sim.createUIButtonArray", Int(-1), OLD_UI),
    ("sim.deleteUIButtonArray", Int(-1), OLD_UI),
    ("sim.getUIButtonSize", Int(-1), OLD_UI),
    ("sim.handleUI", Int(-1), OLD_UI),
    ("sim.cameraFitToView", Int(1), WINDOWS),
    ("sim.getPage", Int(0), WINDOWS),
    ("sim.setPage", Int(1), WINDOWS),
    ("sim.getNavigationMode", Int(0), WINDOWS),
    ("sim.setNavigationMode", Int(1), WINDOWS),
    ("sim.refreshDialogs", Int(1), WINDOWS),
    ("sim.announceSceneContentChange", Int(1), WINDOWS),
    ("sim.addGhost", Int(1), LOOKS),
    ("sim.modifyGhost", Int(1), LOOKS),
    ("sim.addPointCloud", Int(1), LOOKS),
    ("sim.modifyPointCloud", Int(1), LOOKS),
    ("sim.setShapeTexture", Int(1), SHAPES),
    ("sim.getShapeTextureId", Int(-1), SHAPES),
    ("sim.getTextureId", Int(-1), SHAPES),
    ("sim.createTexture", Int(-1), SHAPES),
    ("sim.writeTexture", Int(1), SHAPES),
    ("sim.readTexture", Nothing, SHAPES),
    ("sim.reorientShapeBoundingBox", Int(1), "the box of a shape lies about its frame"),
    ("sim.enableWorkThreads", Int(0), THREADS),
    ("sim.waitForWorkThreads", Int(0), THREADS),
    ("sim.setThreadIsFree", Int(1), THREADS),
    ("sim.setThreadResumeLocation", Int(1), THREADS),
    ("sim.getThreadId", Int(1), THREADS),
    ("sim.setThreadSwitchTiming", Int(1), THREADS),
    ("sim.getThreadSwitchTiming", Int(2), THREADS),
    ("sim.setThreadAutomaticSwitch", Int(1), THREADS),
    ("sim.getThreadAutomaticSwitch", Int(1), THREADS),
    ("sim.getThreadExistRequest", Int(0), THREADS),
    ("sim.getThreadExitRequest", Int(0), THREADS),
    ("sim.lockResources", Int(0), THREADS),
    ("sim.unlockResources", Int(0), THREADS),
    ("sim.delegateChildScriptExecution", Int(0), "child scripts are called by the host"),
    ("sim.handleSensingChildScripts", Int(0), "child scripts are called by the host"),
    ("sim.addScript", Int(-1), SCRIPTS),
    ("sim.associateScriptWithObject", Int(-1), SCRIPTS),
    ("sim.setScriptText", Int(-1), SCRIPTS),
    ("sim.setScriptRawBuffer", Int(-1), SCRIPTS),
    ("sim.getScriptRawBuffer", Nothing, SCRIPTS),
    ("sim.serialOpen", Int(-1), PORTS),
    ("sim.serialClose", Int(-1), PORTS),
    ("sim.serialSend", Int(-1), PORTS),
    ("sim.serialRead", Nothing, PORTS),
    ("sim.serialCheck", Int(-1), PORTS),
    ("sim.serialPortOpen", Int(-1), PORTS),
    ("sim.serialPortClose", Int(-1), PORTS),
    ("sim.serialPortSend", Int(-1), PORTS),
    ("sim.serialPortRead", Nothing, PORTS),
    ("sim.loadModule", Int(-1), "there are no plugins of the original's kind"),
    ("sim.unloadModule", Int(0), "there are no plugins of the original's kind"),
    ("sim.getModuleInfo", Int(0), "there are no plugins of the original's kind"),
    ("sim.auxFunc", Int(-1), PROGRAM),
    ("sim.test", Int(-1), PROGRAM),
    ("sim.getExtensionString", Text(""), PROGRAM),
    ("sim.getConfigurationTree", Int(1), "configurations are not kept"),
    ("sim.setConfigurationTree", Int(1), "configurations are not kept"),
    ("sim.getObjectConfiguration", Int(1), "configurations are not kept"),
    ("sim.setObjectConfiguration", Int(1), "configurations are not kept"),
    ("sim.getApiFunc", Empty, EDITOR),
    ("sim.getApiInfo", Text(""), EDITOR),
    ("sim.openTextEditor", Text(""), EDITOR),
    ("sim.createOctree", Int(-1), CLOUDS),
    ("sim.createPointCloud", Int(-1), CLOUDS),
    ("sim.getOctreeVoxels", Empty, CLOUDS),
    ("sim.getPointCloudPoints", Empty, CLOUDS),
    ("sim.getPointCloudOptions", Float(0.0), CLOUDS),
    ("sim.setPointCloudOptions", Int(1), CLOUDS),
    ("sim.insertObjectIntoOctree", Int(0), CLOUDS),
    ("sim.insertVoxelsIntoOctree", Int(0), CLOUDS),
    ("sim.removeVoxelsFromOctree", Int(0), CLOUDS),
    ("sim.subtractObjectFromOctree", Int(0), CLOUDS),
    ("sim.checkOctreePointOccupancy", Int(0), CLOUDS),
    ("sim.insertObjectIntoPointCloud", Int(0), CLOUDS),
    ("sim.insertPointsIntoPointCloud", Int(0), CLOUDS),
    ("sim.removePointsFromPointCloud", Int(0), CLOUDS),
    ("sim.intersectPointsWithPointCloud", Int(0), CLOUDS),
    ("sim.subtractObjectFromPointCloud", Int(0), CLOUDS),
    ("sim.applyMilling", Int(0), "there are no mills"),
    ("sim.getPathPlanningHandle", Int(-1), PLANNING),
    ("sim.initializePathSearch", Int(-1), PLANNING),
    ("sim.performPathSearchStep", Int(0), PLANNING),
    ("sim.searchPath", Int(0), PLANNING),
    ("sim.createMotionPlanning", Int(-1), PLANNING),
    ("sim.getMotionPlanningHandle", Int(-1), PLANNING),
    ("sim.removeMotionPlanning", Int(-1), PLANNING),
    ("sim.setPathTargetNominalVelocity", Int(1), "nothing moves along a path by itself"),
    ("sim.getPathPlanningObject", Int(-1), PLANNING),
    ("sim.checkCollisionEx", Int(0), "sim.checkCollision tells whether shapes overlap"),
    ("sim.exportMesh", Int(-1), "meshes are not written"),
    ("sim.exportIk", Int(-1), "there is no inverse kinematics"),
    ("sim.setSimulationTimeStep", Int(-1), "the step belongs to the scene"),
    ("sim.getSimulationPassesPerRenderingPass", Int(1), WINDOWS),
    ("sim.setSimulationPassesPerRenderingPass", Int(1), WINDOWS),
    ("sim.isRealTimeSimulationStepNeeded", Int(1), "simulation time is the only clock"),
    ("sim.getLastErrorCode", Int(0), PROGRAM),
    ("sim.setIkGroupProperties", Int(-1), "there is no inverse kinematics"),
    ("sim.setIkElementProperties", Int(-1), "there is no inverse kinematics"),
    ("sim.checkIkGroup", Int(0), "there is no inverse kinematics"),
    ("sim.computeJacobian", Int(-1), "there is no inverse kinematics"),
    ("sim.getIkGroupMatrix", Nothing, "there is no inverse kinematics"),
    ("sim.generateIkPath", Nothing, "there is no inverse kinematics"),
    ("sim.getConfigForTipPose", Nothing, "there is no inverse kinematics"),
    ("sim.findMpPath", Nothing, PLANNING),
    ("sim.simplifyMpPath", Nothing, PLANNING),
    ("sim.getMpConfigTransition", Nothing, PLANNING),
    ("sim.transformBuffer", Text(""), PICTURES),
    ("sim.combineRgbImages", Text(""), PICTURES),
    ("sim.createIkGroup", Int(-1), "there is no inverse kinematics"),
    ("sim.createIkElement", Int(-1), "there is no inverse kinematics"),
    ("sim.removeIkGroup", Int(-1), "there is no inverse kinematics"),
];

/// Commands of `sim` that never had a flat name.
const MODERN: &[(&str, Gives, &str)] = &[
    ("sim.getNamedStringParam", Nothing, "the command line hands no parameters to scripts"),
    ("sim.getNamedBoolParam", Nothing, "the command line hands no parameters to scripts"),
    ("sim.getNamedFloatParam", Nothing, "the command line hands no parameters to scripts"),
    ("sim.getNamedInt32Param", Nothing, "the command line hands no parameters to scripts"),
    ("sim.setNamedStringParam", Nothing, "the command line hands no parameters to scripts"),
    ("sim.setNamedBoolParam", Nothing, "the command line hands no parameters to scripts"),
    ("sim.setNamedFloatParam", Nothing, "the command line hands no parameters to scripts"),
    ("sim.setNamedInt32Param", Nothing, "the command line hands no parameters to scripts"),
    ("sim.setAutoYieldDelay", Nothing, THREADS),
    ("sim.getAutoYieldDelay", Float(0.002), THREADS),
    ("sim.acquireLock", Nothing, THREADS),
    ("sim.releaseLock", Nothing, THREADS),
    ("sim.setStepping", Int(0), THREADS),
    ("sim.fastIdleLoop", Nothing, WINDOWS),
    ("sim.handleExtCalls", Nothing, PROGRAM),
    ("sim.systemSemaphore", Nothing, PROGRAM),
    ("sim.pushUserEvent", Nothing, PROGRAM),
    ("sim.getGenesisEvents", Empty, PROGRAM),
    ("sim.registerScriptFuncHook", Int(-1), "functions of scripts are not hooked"),
    ("sim.getStackTraceback", Text(""), "errors report where they happened"),
    ("sim.getUserVariables", Empty, EDITOR),
    ("sim.initScript", Nothing, SCRIPTS),
    ("sim.createScript", Int(-1), SCRIPTS),
    ("sim.textEditorOpen", Int(-1), EDITOR),
    ("sim.textEditorShow", Nothing, EDITOR),
    ("sim.textEditorClose", Text(""), EDITOR),
    ("sim.textEditorGetInfo", Text(""), EDITOR),
    ("sim.getPluginInfo", Text(""), "there are no plugins of the original's kind"),
    ("sim.setPluginInfo", Nothing, "there are no plugins of the original's kind"),
    ("sim.setModuleInfo", Nothing, "there are no plugins of the original's kind"),
    ("sim.moduleEntry", Int(-1), WINDOWS),
    ("sim.getShapeViz", Empty, LOOKS),
    ("sim.generateTextShape", Int(-1), LOOKS),
    ("sim.setObjectHierarchyOrder", Nothing, "the order of siblings stays"),
    ("sim.setExplicitHandlingFlags", Nothing, PROGRAM),
    ("sim.relocateShapeFrame", Int(1), "the frame of a shape stays"),
    ("sim.alignShapeBB", Int(1), "the box of a shape lies about its frame"),
    ("sim.getObjectFloatArrayParam", Empty, PROGRAM),
    ("sim.setObjectFloatArrayParam", Nothing, PROGRAM),
    ("sim.createCustomObject", Int(-1), PROGRAM),
    ("sim.getExitRequest", Int(0), PROGRAM),
    ("sim.getAlternateConfigs", Nothing, PLANNING),
];

pub(crate) fn offer(offer: &mut Offer<Vrep>) {
    for (name, gives, why) in OLD {
        let on_error = if matches!(gives, Nothing | Text(_) | Empty) { NIL } else { MINUS };
        add(offer, name, Some((&flat_name(name), on_error)), *gives, why);
    }
    for (name, gives, why) in MODERN {
        add(offer, name, None, *gives, why);
    }
    let why = "a service listens, but does not report the state of its connections";
    add(offer, "simRemoteApi.status", Some(("simExtRemoteApiStatus", MINUS)), Int(-1), why);
    // The ROS interface of before 2016; without a node nothing is sent, and topics have no names.
    for (name, gives) in [
        ("simExtROS_enablePublisher", Nothing),
        ("simExtROS_enableSubscriber", Nothing),
        ("simExtROS_disablePublisher", Int(-1)),
        ("simExtROS_disableSubscriber", Int(-1)),
        ("simExtROS_wakePublisher", Int(-1)),
    ] {
        add(offer, name, None, gives, "there is no ROS node");
    }
    offer.prelude("lua", "sim-1", "return sim");
    offer.prelude("lua", "sim-2", "return sim");
}

fn add(offer: &mut Offer<Vrep>, name: &str, flat: Option<(&str, [Value; 1])>, gives: Gives, why: &str) {
    if offer.has_command(name) {
        return;
    }
    let mut command = Cmd::new(name, move |c| {
        match gives {
            Nothing => {}
            Int(i) => c.ret(i),
            Float(x) => c.ret(x),
            Text(t) => c.ret(t),
            Empty => c.ret(Value::List(Vec::new())),
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
        Empty => Some(Param::any("result")),
    };
    let mut command = command.param(Param::any("arguments").rest());
    if let Some(r) = returns {
        command = command.returns(r);
    }
    offer.command(command.text("Takes what it is given, and does nothing.").stub(why));
}
