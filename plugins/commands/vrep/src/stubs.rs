//! Commands that accept any arguments and return a neutral value: windows, visual effects, and features of V-REP that
//! Tatu does not have.
//!
//! A stub is not offered if a different file declares a command with the same name.

use tatu_commands_common::StubResult::{self, *};

use crate::kit::*;

const NO_WINDOW: &str = "there is no window";
const NO_OLD_UI: &str = "the oldest kind of user interface is not supported";
const NOTHING_DRAWN: &str = "nothing is drawn";
const COROUTINE_THREADS: &str = "threads are coroutines";
const NO_SERIAL_PORTS: &str = "scripts have no serial ports";
const NO_TEXTURES: &str = "shapes have no textures";
const NO_POINT_CLOUDS: &str = "there are no octrees or point clouds";
const NO_PATH_PLANNING: &str = "the path planning objects of old scenes are not read: use simOMPL or tatu.plan";
const NO_EDITOR: &str = "there is no editor";
const VREP_ONLY: &str = "this exists only in V-REP";
const IMAGES_UNCHANGED: &str = "images are not changed";
const NO_NEW_SCRIPTS: &str = "only the scene and `tatu.addScript` create scripts";

/// Commands of `sim` that have a flat name: the two names, the return value, and the reason why there is no effect.
const STUBS_WITH_FLAT_NAMES: &[(CommandNames, StubResult, &str)] = &[
    (["sim.setUIButtonTexture", "simSetUIButtonTexture"], Int(-1), NO_OLD_UI),
    (["sim.setUIButtonArrayColor", "simSetUIButtonArrayColor"], Int(-1), NO_OLD_UI),
    (["sim.createUIButtonArray", "simCreateUIButtonArray"], Int(-1), NO_OLD_UI),
    (["sim.deleteUIButtonArray", "simDeleteUIButtonArray"], Int(-1), NO_OLD_UI),
    (["sim.getUIButtonSize", "simGetUIButtonSize"], Int(-1), NO_OLD_UI),
    (["sim.handleUI", "simHandleUI"], Int(-1), NO_OLD_UI),
    (["sim.cameraFitToView", "simCameraFitToView"], Int(1), NO_WINDOW),
    (["sim.getPage", "simGetPage"], Int(0), NO_WINDOW),
    (["sim.setPage", "simSetPage"], Int(1), NO_WINDOW),
    (["sim.getNavigationMode", "simGetNavigationMode"], Int(0), NO_WINDOW),
    (["sim.setNavigationMode", "simSetNavigationMode"], Int(1), NO_WINDOW),
    (["sim.refreshDialogs", "simRefreshDialogs"], Int(1), NO_WINDOW),
    (["sim.announceSceneContentChange", "simAnnounceSceneContentChange"], Int(1), NO_WINDOW),
    (["sim.addGhost", "simAddGhost"], Int(1), NOTHING_DRAWN),
    (["sim.modifyGhost", "simModifyGhost"], Int(1), NOTHING_DRAWN),
    (["sim.addPointCloud", "simAddPointCloud"], Int(1), NOTHING_DRAWN),
    (["sim.modifyPointCloud", "simModifyPointCloud"], Int(1), NOTHING_DRAWN),
    (["sim.setShapeTexture", "simSetShapeTexture"], Int(1), NO_TEXTURES),
    (["sim.getShapeTextureId", "simGetShapeTextureId"], Int(-1), NO_TEXTURES),
    (["sim.getTextureId", "simGetTextureId"], Int(-1), NO_TEXTURES),
    (["sim.createTexture", "simCreateTexture"], Int(-1), NO_TEXTURES),
    (["sim.writeTexture", "simWriteTexture"], Int(1), NO_TEXTURES),
    (["sim.readTexture", "simReadTexture"], Nothing, NO_TEXTURES),
    (
        ["sim.reorientShapeBoundingBox", "simReorientShapeBoundingBox"],
        Int(1),
        "the bounding box of a shape is centred on its frame",
    ),
    (["sim.enableWorkThreads", "simEnableWorkThreads"], Int(0), COROUTINE_THREADS),
    (["sim.waitForWorkThreads", "simWaitForWorkThreads"], Int(0), COROUTINE_THREADS),
    (["sim.setThreadIsFree", "simSetThreadIsFree"], Int(1), COROUTINE_THREADS),
    (["sim.setThreadResumeLocation", "simSetThreadResumeLocation"], Int(1), COROUTINE_THREADS),
    (["sim.getThreadId", "simGetThreadId"], Int(1), COROUTINE_THREADS),
    (["sim.setThreadSwitchTiming", "simSetThreadSwitchTiming"], Int(1), COROUTINE_THREADS),
    (["sim.getThreadSwitchTiming", "simGetThreadSwitchTiming"], Int(2), COROUTINE_THREADS),
    (["sim.setThreadAutomaticSwitch", "simSetThreadAutomaticSwitch"], Int(1), COROUTINE_THREADS),
    (["sim.getThreadAutomaticSwitch", "simGetThreadAutomaticSwitch"], Int(1), COROUTINE_THREADS),
    (["sim.getThreadExistRequest", "simGetThreadExistRequest"], Int(0), COROUTINE_THREADS),
    (["sim.getThreadExitRequest", "simGetThreadExitRequest"], Int(0), COROUTINE_THREADS),
    (["sim.lockResources", "simLockResources"], Int(0), COROUTINE_THREADS),
    (["sim.unlockResources", "simUnlockResources"], Int(0), COROUTINE_THREADS),
    (
        ["sim.delegateChildScriptExecution", "simDelegateChildScriptExecution"],
        Int(0),
        "child scripts are called by the host",
    ),
    (["sim.handleSensingChildScripts", "simHandleSensingChildScripts"], Int(0), "child scripts are called by the host"),
    (["sim.addScript", "simAddScript"], Int(-1), NO_NEW_SCRIPTS),
    (["sim.associateScriptWithObject", "simAssociateScriptWithObject"], Int(-1), NO_NEW_SCRIPTS),
    (["sim.setScriptText", "simSetScriptText"], Int(-1), NO_NEW_SCRIPTS),
    (["sim.setScriptRawBuffer", "simSetScriptRawBuffer"], Int(-1), NO_NEW_SCRIPTS),
    (["sim.getScriptRawBuffer", "simGetScriptRawBuffer"], Nothing, NO_NEW_SCRIPTS),
    (["sim.serialOpen", "simSerialOpen"], Int(-1), NO_SERIAL_PORTS),
    (["sim.serialClose", "simSerialClose"], Int(-1), NO_SERIAL_PORTS),
    (["sim.serialSend", "simSerialSend"], Int(-1), NO_SERIAL_PORTS),
    (["sim.serialRead", "simSerialRead"], Nothing, NO_SERIAL_PORTS),
    (["sim.serialCheck", "simSerialCheck"], Int(-1), NO_SERIAL_PORTS),
    (["sim.serialPortOpen", "simSerialPortOpen"], Int(-1), NO_SERIAL_PORTS),
    (["sim.serialPortClose", "simSerialPortClose"], Int(-1), NO_SERIAL_PORTS),
    (["sim.serialPortSend", "simSerialPortSend"], Int(-1), NO_SERIAL_PORTS),
    (["sim.serialPortRead", "simSerialPortRead"], Nothing, NO_SERIAL_PORTS),
    (["sim.loadModule", "simLoadModule"], Int(-1), "V-REP plugins are not supported"),
    (["sim.unloadModule", "simUnloadModule"], Int(0), "V-REP plugins are not supported"),
    (["sim.getModuleInfo", "simGetModuleInfo"], Int(0), "V-REP plugins are not supported"),
    (["sim.auxFunc", "simAuxFunc"], Int(-1), VREP_ONLY),
    (["sim.test", "simTest"], Int(-1), VREP_ONLY),
    (["sim.getExtensionString", "simGetExtensionString"], Text(""), VREP_ONLY),
    (["sim.getConfigurationTree", "simGetConfigurationTree"], Int(1), "configurations are not stored"),
    (["sim.setConfigurationTree", "simSetConfigurationTree"], Int(1), "configurations are not stored"),
    (["sim.getObjectConfiguration", "simGetObjectConfiguration"], Int(1), "configurations are not stored"),
    (["sim.setObjectConfiguration", "simSetObjectConfiguration"], Int(1), "configurations are not stored"),
    (["sim.getApiFunc", "simGetApiFunc"], Empty, NO_EDITOR),
    (["sim.getApiInfo", "simGetApiInfo"], Text(""), NO_EDITOR),
    (["sim.openTextEditor", "simOpenTextEditor"], Text(""), NO_EDITOR),
    (["sim.createOctree", "simCreateOctree"], Int(-1), NO_POINT_CLOUDS),
    (["sim.createPointCloud", "simCreatePointCloud"], Int(-1), NO_POINT_CLOUDS),
    (["sim.getOctreeVoxels", "simGetOctreeVoxels"], Empty, NO_POINT_CLOUDS),
    (["sim.getPointCloudPoints", "simGetPointCloudPoints"], Empty, NO_POINT_CLOUDS),
    (["sim.getPointCloudOptions", "simGetPointCloudOptions"], Float(0.0), NO_POINT_CLOUDS),
    (["sim.setPointCloudOptions", "simSetPointCloudOptions"], Int(1), NO_POINT_CLOUDS),
    (["sim.insertObjectIntoOctree", "simInsertObjectIntoOctree"], Int(0), NO_POINT_CLOUDS),
    (["sim.insertVoxelsIntoOctree", "simInsertVoxelsIntoOctree"], Int(0), NO_POINT_CLOUDS),
    (["sim.removeVoxelsFromOctree", "simRemoveVoxelsFromOctree"], Int(0), NO_POINT_CLOUDS),
    (["sim.subtractObjectFromOctree", "simSubtractObjectFromOctree"], Int(0), NO_POINT_CLOUDS),
    (["sim.checkOctreePointOccupancy", "simCheckOctreePointOccupancy"], Int(0), NO_POINT_CLOUDS),
    (["sim.insertObjectIntoPointCloud", "simInsertObjectIntoPointCloud"], Int(0), NO_POINT_CLOUDS),
    (["sim.insertPointsIntoPointCloud", "simInsertPointsIntoPointCloud"], Int(0), NO_POINT_CLOUDS),
    (["sim.removePointsFromPointCloud", "simRemovePointsFromPointCloud"], Int(0), NO_POINT_CLOUDS),
    (["sim.intersectPointsWithPointCloud", "simIntersectPointsWithPointCloud"], Int(0), NO_POINT_CLOUDS),
    (["sim.subtractObjectFromPointCloud", "simSubtractObjectFromPointCloud"], Int(0), NO_POINT_CLOUDS),
    (["sim.applyMilling", "simApplyMilling"], Int(0), "there are no mills"),
    (["sim.getPathPlanningHandle", "simGetPathPlanningHandle"], Int(-1), NO_PATH_PLANNING),
    (["sim.initializePathSearch", "simInitializePathSearch"], Int(-1), NO_PATH_PLANNING),
    (["sim.performPathSearchStep", "simPerformPathSearchStep"], Int(0), NO_PATH_PLANNING),
    (["sim.searchPath", "simSearchPath"], Int(0), NO_PATH_PLANNING),
    (["sim.createMotionPlanning", "simCreateMotionPlanning"], Int(-1), NO_PATH_PLANNING),
    (["sim.getMotionPlanningHandle", "simGetMotionPlanningHandle"], Int(-1), NO_PATH_PLANNING),
    (["sim.removeMotionPlanning", "simRemoveMotionPlanning"], Int(-1), NO_PATH_PLANNING),
    (
        ["sim.setPathTargetNominalVelocity", "simSetPathTargetNominalVelocity"],
        Int(1),
        "nothing moves along a path automatically",
    ),
    (["sim.getPathPlanningObject", "simGetPathPlanningObject"], Int(-1), NO_PATH_PLANNING),
    (["sim.checkCollisionEx", "simCheckCollisionEx"], Int(0), "sim.checkCollision returns whether shapes overlap"),
    (["sim.exportMesh", "simExportMesh"], Int(-1), "meshes cannot be exported"),
    (["sim.exportIk", "simExportIk"], Int(-1), "there is no inverse kinematics"),
    (["sim.setSimulationTimeStep", "simSetSimulationTimeStep"], Int(-1), "the step is set by the scene"),
    (["sim.getSimulationPassesPerRenderingPass", "simGetSimulationPassesPerRenderingPass"], Int(1), NO_WINDOW),
    (["sim.setSimulationPassesPerRenderingPass", "simSetSimulationPassesPerRenderingPass"], Int(1), NO_WINDOW),
    (
        ["sim.isRealTimeSimulationStepNeeded", "simIsRealTimeSimulationStepNeeded"],
        Int(1),
        "simulation time is the only clock",
    ),
    (["sim.getLastErrorCode", "simGetLastErrorCode"], Int(0), VREP_ONLY),
    (["sim.findMpPath", "simFindMpPath"], Nothing, NO_PATH_PLANNING),
    (["sim.simplifyMpPath", "simSimplifyMpPath"], Nothing, NO_PATH_PLANNING),
    (["sim.getMpConfigTransition", "simGetMpConfigTransition"], Nothing, NO_PATH_PLANNING),
    (["sim.transformBuffer", "simTransformBuffer"], Text(""), IMAGES_UNCHANGED),
    (["sim.combineRgbImages", "simCombineRgbImages"], Text(""), IMAGES_UNCHANGED),
];

/// Commands of `sim` without a flat name: the name, the return value, and the reason why there is no effect.
const STUBS: &[(&str, StubResult, &str)] = &[
    ("sim.getNamedStringParam", Nothing, "the command line does not pass parameters to scripts"),
    ("sim.getNamedBoolParam", Nothing, "the command line does not pass parameters to scripts"),
    ("sim.getNamedFloatParam", Nothing, "the command line does not pass parameters to scripts"),
    ("sim.getNamedInt32Param", Nothing, "the command line does not pass parameters to scripts"),
    ("sim.setNamedStringParam", Nothing, "the command line does not pass parameters to scripts"),
    ("sim.setNamedBoolParam", Nothing, "the command line does not pass parameters to scripts"),
    ("sim.setNamedFloatParam", Nothing, "the command line does not pass parameters to scripts"),
    ("sim.setNamedInt32Param", Nothing, "the command line does not pass parameters to scripts"),
    ("sim.setAutoYieldDelay", Nothing, COROUTINE_THREADS),
    ("sim.getAutoYieldDelay", Float(0.002), COROUTINE_THREADS),
    ("sim.acquireLock", Nothing, COROUTINE_THREADS),
    ("sim.releaseLock", Nothing, COROUTINE_THREADS),
    ("sim.setStepping", Int(0), COROUTINE_THREADS),
    ("sim.fastIdleLoop", Nothing, NO_WINDOW),
    ("sim.handleExtCalls", Nothing, VREP_ONLY),
    ("sim.systemSemaphore", Nothing, VREP_ONLY),
    ("sim.pushUserEvent", Nothing, VREP_ONLY),
    ("sim.getGenesisEvents", Empty, VREP_ONLY),
    ("sim.registerScriptFuncHook", Int(-1), "functions of scripts cannot be hooked"),
    ("sim.getStackTraceback", Text(""), "errors are reported with their traceback"),
    ("sim.getUserVariables", Empty, NO_EDITOR),
    ("sim.initScript", Nothing, NO_NEW_SCRIPTS),
    ("sim.createScript", Int(-1), NO_NEW_SCRIPTS),
    ("sim.textEditorOpen", Int(-1), NO_EDITOR),
    ("sim.textEditorShow", Nothing, NO_EDITOR),
    ("sim.textEditorClose", Text(""), NO_EDITOR),
    ("sim.textEditorGetInfo", Text(""), NO_EDITOR),
    ("sim.getPluginInfo", Text(""), "V-REP plugins are not supported"),
    ("sim.setPluginInfo", Nothing, "V-REP plugins are not supported"),
    ("sim.setModuleInfo", Nothing, "V-REP plugins are not supported"),
    ("sim.moduleEntry", Int(-1), NO_WINDOW),
    ("sim.getShapeViz", Empty, NOTHING_DRAWN),
    ("sim.setObjectHierarchyOrder", Nothing, "the order of siblings cannot be changed"),
    ("sim.setExplicitHandlingFlags", Nothing, VREP_ONLY),
    ("sim.relocateShapeFrame", Int(1), "the frame of a shape cannot be changed"),
    ("sim.alignShapeBB", Int(1), "the bounding box of a shape is centred on its frame"),
    ("sim.getObjectFloatArrayParam", Empty, VREP_ONLY),
    ("sim.setObjectFloatArrayParam", Nothing, VREP_ONLY),
    ("sim.createCustomObject", Int(-1), VREP_ONLY),
    ("sim.getExitRequest", Int(0), VREP_ONLY),
];

pub(crate) fn offer(offer: &mut Offer<Vrep>) {
    for ([name, old], gives, why) in STUBS_WITH_FLAT_NAMES {
        add(offer, name, Some((old, gives.on_error())), *gives, why);
    }
    for (name, gives, why) in STUBS {
        add(offer, name, None, *gives, why);
    }
    let why = "a service listens, but does not report the state of its connections";
    add(offer, "simRemoteApi.status", Some(("simExtRemoteApiStatus", MINUS_ONE)), Int(-1), why);
    // The ROS interface from before 2016. Without a ROS node, nothing is sent, and no topic names are returned.
    for (name, gives) in [
        ("simExtROS_enablePublisher", Nothing),
        ("simExtROS_enableSubscriber", Nothing),
        ("simExtROS_disablePublisher", Int(-1)),
        ("simExtROS_disableSubscriber", Int(-1)),
        ("simExtROS_wakePublisher", Int(-1)),
    ] {
        add(offer, name, None, gives, "there is no ROS node");
    }
}

fn add(offer: &mut Offer<Vrep>, name: &str, flat: Option<(&str, [Value; 1])>, gives: StubResult, why: &str) {
    if offer.has_command(name) {
        return;
    }
    let mut command = tatu_commands_common::stub(name, gives, why);
    if let Some((flat, on_error)) = flat.filter(|(flat, _)| !offer.has_command(flat)) {
        command = command.old_name(flat, on_error);
    }
    offer.command(command);
}
