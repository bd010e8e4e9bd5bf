//! Commands that accept any arguments and return a neutral value: windows, visual effects, and features of V-REP that
//! Tatu does not have.
//!
//! A stub is not offered if a different file declares a command with the same name.

use tatu_commands_common::Gives::{self, *};

use crate::kit::*;

const WINDOWS: &str = "there is no window";
const OLD_UI: &str = "the oldest kind of user interface is not supported";
const LOOKS: &str = "nothing is drawn";
const THREADS: &str = "threads are coroutines";
const PORTS: &str = "scripts have no serial ports";
const SHAPES: &str = "shapes have no textures";
const CLOUDS: &str = "there are no octrees or point clouds";
const PLANNING: &str = "there is no path planning";
const EDITOR: &str = "there is no editor";
const PROGRAM: &str = "this exists only in V-REP";
const PICTURES: &str = "images are not changed";
const SCRIPTS: &str = "only the scene and `tatu.addScript` create scripts";

/// Commands of `sim` that have a flat name: the two names, the return value, and the reason why there is no effect.
const OLD: &[(Names, Gives, &str)] = &[
    (["sim.setUIButtonTexture", "simSetUIButtonTexture"], Int(-1), OLD_UI),
    (["sim.setUIButtonArrayColor", "simSetUIButtonArrayColor"], Int(-1), OLD_UI),
    (["sim.createUIButtonArray", "simCreateUIButtonArray"], Int(-1), OLD_UI),
    (["sim.deleteUIButtonArray", "simDeleteUIButtonArray"], Int(-1), OLD_UI),
    (["sim.getUIButtonSize", "simGetUIButtonSize"], Int(-1), OLD_UI),
    (["sim.handleUI", "simHandleUI"], Int(-1), OLD_UI),
    (["sim.cameraFitToView", "simCameraFitToView"], Int(1), WINDOWS),
    (["sim.getPage", "simGetPage"], Int(0), WINDOWS),
    (["sim.setPage", "simSetPage"], Int(1), WINDOWS),
    (["sim.getNavigationMode", "simGetNavigationMode"], Int(0), WINDOWS),
    (["sim.setNavigationMode", "simSetNavigationMode"], Int(1), WINDOWS),
    (["sim.refreshDialogs", "simRefreshDialogs"], Int(1), WINDOWS),
    (["sim.announceSceneContentChange", "simAnnounceSceneContentChange"], Int(1), WINDOWS),
    (["sim.addGhost", "simAddGhost"], Int(1), LOOKS),
    (["sim.modifyGhost", "simModifyGhost"], Int(1), LOOKS),
    (["sim.addPointCloud", "simAddPointCloud"], Int(1), LOOKS),
    (["sim.modifyPointCloud", "simModifyPointCloud"], Int(1), LOOKS),
    (["sim.setShapeTexture", "simSetShapeTexture"], Int(1), SHAPES),
    (["sim.getShapeTextureId", "simGetShapeTextureId"], Int(-1), SHAPES),
    (["sim.getTextureId", "simGetTextureId"], Int(-1), SHAPES),
    (["sim.createTexture", "simCreateTexture"], Int(-1), SHAPES),
    (["sim.writeTexture", "simWriteTexture"], Int(1), SHAPES),
    (["sim.readTexture", "simReadTexture"], Nothing, SHAPES),
    (
        ["sim.reorientShapeBoundingBox", "simReorientShapeBoundingBox"],
        Int(1),
        "the bounding box of a shape is centred on its frame",
    ),
    (["sim.enableWorkThreads", "simEnableWorkThreads"], Int(0), THREADS),
    (["sim.waitForWorkThreads", "simWaitForWorkThreads"], Int(0), THREADS),
    (["sim.setThreadIsFree", "simSetThreadIsFree"], Int(1), THREADS),
    (["sim.setThreadResumeLocation", "simSetThreadResumeLocation"], Int(1), THREADS),
    (["sim.getThreadId", "simGetThreadId"], Int(1), THREADS),
    (["sim.setThreadSwitchTiming", "simSetThreadSwitchTiming"], Int(1), THREADS),
    (["sim.getThreadSwitchTiming", "simGetThreadSwitchTiming"], Int(2), THREADS),
    (["sim.setThreadAutomaticSwitch", "simSetThreadAutomaticSwitch"], Int(1), THREADS),
    (["sim.getThreadAutomaticSwitch", "simGetThreadAutomaticSwitch"], Int(1), THREADS),
    (["sim.getThreadExistRequest", "simGetThreadExistRequest"], Int(0), THREADS),
    (["sim.getThreadExitRequest", "simGetThreadExitRequest"], Int(0), THREADS),
    (["sim.lockResources", "simLockResources"], Int(0), THREADS),
    (["sim.unlockResources", "simUnlockResources"], Int(0), THREADS),
    (
        ["sim.delegateChildScriptExecution", "simDelegateChildScriptExecution"],
        Int(0),
        "child scripts are called by the host",
    ),
    (["sim.handleSensingChildScripts", "simHandleSensingChildScripts"], Int(0), "child scripts are called by the host"),
    (["sim.addScript", "simAddScript"], Int(-1), SCRIPTS),
    (["sim.associateScriptWithObject", "simAssociateScriptWithObject"], Int(-1), SCRIPTS),
    (["sim.setScriptText", "simSetScriptText"], Int(-1), SCRIPTS),
    (["sim.setScriptRawBuffer", "simSetScriptRawBuffer"], Int(-1), SCRIPTS),
    (["sim.getScriptRawBuffer", "simGetScriptRawBuffer"], Nothing, SCRIPTS),
    (["sim.serialOpen", "simSerialOpen"], Int(-1), PORTS),
    (["sim.serialClose", "simSerialClose"], Int(-1), PORTS),
    (["sim.serialSend", "simSerialSend"], Int(-1), PORTS),
    (["sim.serialRead", "simSerialRead"], Nothing, PORTS),
    (["sim.serialCheck", "simSerialCheck"], Int(-1), PORTS),
    (["sim.serialPortOpen", "simSerialPortOpen"], Int(-1), PORTS),
    (["sim.serialPortClose", "simSerialPortClose"], Int(-1), PORTS),
    (["sim.serialPortSend", "simSerialPortSend"], Int(-1), PORTS),
    (["sim.serialPortRead", "simSerialPortRead"], Nothing, PORTS),
    (["sim.loadModule", "simLoadModule"], Int(-1), "V-REP plugins are not supported"),
    (["sim.unloadModule", "simUnloadModule"], Int(0), "V-REP plugins are not supported"),
    (["sim.getModuleInfo", "simGetModuleInfo"], Int(0), "V-REP plugins are not supported"),
    (["sim.auxFunc", "simAuxFunc"], Int(-1), PROGRAM),
    (["sim.test", "simTest"], Int(-1), PROGRAM),
    (["sim.getExtensionString", "simGetExtensionString"], Text(""), PROGRAM),
    (["sim.getConfigurationTree", "simGetConfigurationTree"], Int(1), "configurations are not stored"),
    (["sim.setConfigurationTree", "simSetConfigurationTree"], Int(1), "configurations are not stored"),
    (["sim.getObjectConfiguration", "simGetObjectConfiguration"], Int(1), "configurations are not stored"),
    (["sim.setObjectConfiguration", "simSetObjectConfiguration"], Int(1), "configurations are not stored"),
    (["sim.getApiFunc", "simGetApiFunc"], Empty, EDITOR),
    (["sim.getApiInfo", "simGetApiInfo"], Text(""), EDITOR),
    (["sim.openTextEditor", "simOpenTextEditor"], Text(""), EDITOR),
    (["sim.createOctree", "simCreateOctree"], Int(-1), CLOUDS),
    (["sim.createPointCloud", "simCreatePointCloud"], Int(-1), CLOUDS),
    (["sim.getOctreeVoxels", "simGetOctreeVoxels"], Empty, CLOUDS),
    (["sim.getPointCloudPoints", "simGetPointCloudPoints"], Empty, CLOUDS),
    (["sim.getPointCloudOptions", "simGetPointCloudOptions"], Float(0.0), CLOUDS),
    (["sim.setPointCloudOptions", "simSetPointCloudOptions"], Int(1), CLOUDS),
    (["sim.insertObjectIntoOctree", "simInsertObjectIntoOctree"], Int(0), CLOUDS),
    (["sim.insertVoxelsIntoOctree", "simInsertVoxelsIntoOctree"], Int(0), CLOUDS),
    (["sim.removeVoxelsFromOctree", "simRemoveVoxelsFromOctree"], Int(0), CLOUDS),
    (["sim.subtractObjectFromOctree", "simSubtractObjectFromOctree"], Int(0), CLOUDS),
    (["sim.checkOctreePointOccupancy", "simCheckOctreePointOccupancy"], Int(0), CLOUDS),
    (["sim.insertObjectIntoPointCloud", "simInsertObjectIntoPointCloud"], Int(0), CLOUDS),
    (["sim.insertPointsIntoPointCloud", "simInsertPointsIntoPointCloud"], Int(0), CLOUDS),
    (["sim.removePointsFromPointCloud", "simRemovePointsFromPointCloud"], Int(0), CLOUDS),
    (["sim.intersectPointsWithPointCloud", "simIntersectPointsWithPointCloud"], Int(0), CLOUDS),
    (["sim.subtractObjectFromPointCloud", "simSubtractObjectFromPointCloud"], Int(0), CLOUDS),
    (["sim.applyMilling", "simApplyMilling"], Int(0), "there are no mills"),
    (["sim.getPathPlanningHandle", "simGetPathPlanningHandle"], Int(-1), PLANNING),
    (["sim.initializePathSearch", "simInitializePathSearch"], Int(-1), PLANNING),
    (["sim.performPathSearchStep", "simPerformPathSearchStep"], Int(0), PLANNING),
    (["sim.searchPath", "simSearchPath"], Int(0), PLANNING),
    (["sim.createMotionPlanning", "simCreateMotionPlanning"], Int(-1), PLANNING),
    (["sim.getMotionPlanningHandle", "simGetMotionPlanningHandle"], Int(-1), PLANNING),
    (["sim.removeMotionPlanning", "simRemoveMotionPlanning"], Int(-1), PLANNING),
    (
        ["sim.setPathTargetNominalVelocity", "simSetPathTargetNominalVelocity"],
        Int(1),
        "nothing moves along a path automatically",
    ),
    (["sim.getPathPlanningObject", "simGetPathPlanningObject"], Int(-1), PLANNING),
    (["sim.checkCollisionEx", "simCheckCollisionEx"], Int(0), "sim.checkCollision returns whether shapes overlap"),
    (["sim.exportMesh", "simExportMesh"], Int(-1), "meshes cannot be exported"),
    (["sim.exportIk", "simExportIk"], Int(-1), "there is no inverse kinematics"),
    (["sim.setSimulationTimeStep", "simSetSimulationTimeStep"], Int(-1), "the step is set by the scene"),
    (["sim.getSimulationPassesPerRenderingPass", "simGetSimulationPassesPerRenderingPass"], Int(1), WINDOWS),
    (["sim.setSimulationPassesPerRenderingPass", "simSetSimulationPassesPerRenderingPass"], Int(1), WINDOWS),
    (
        ["sim.isRealTimeSimulationStepNeeded", "simIsRealTimeSimulationStepNeeded"],
        Int(1),
        "simulation time is the only clock",
    ),
    (["sim.getLastErrorCode", "simGetLastErrorCode"], Int(0), PROGRAM),
    (["sim.setIkGroupProperties", "simSetIkGroupProperties"], Int(-1), "there is no inverse kinematics"),
    (["sim.setIkElementProperties", "simSetIkElementProperties"], Int(-1), "there is no inverse kinematics"),
    (["sim.checkIkGroup", "simCheckIkGroup"], Int(0), "there is no inverse kinematics"),
    (["sim.computeJacobian", "simComputeJacobian"], Int(-1), "there is no inverse kinematics"),
    (["sim.getIkGroupMatrix", "simGetIkGroupMatrix"], Nothing, "there is no inverse kinematics"),
    (["sim.generateIkPath", "simGenerateIkPath"], Nothing, "there is no inverse kinematics"),
    (["sim.getConfigForTipPose", "simGetConfigForTipPose"], Nothing, "there is no inverse kinematics"),
    (["sim.findMpPath", "simFindMpPath"], Nothing, PLANNING),
    (["sim.simplifyMpPath", "simSimplifyMpPath"], Nothing, PLANNING),
    (["sim.getMpConfigTransition", "simGetMpConfigTransition"], Nothing, PLANNING),
    (["sim.transformBuffer", "simTransformBuffer"], Text(""), PICTURES),
    (["sim.combineRgbImages", "simCombineRgbImages"], Text(""), PICTURES),
    (["sim.createIkGroup", "simCreateIkGroup"], Int(-1), "there is no inverse kinematics"),
    (["sim.createIkElement", "simCreateIkElement"], Int(-1), "there is no inverse kinematics"),
    (["sim.removeIkGroup", "simRemoveIkGroup"], Int(-1), "there is no inverse kinematics"),
];

/// Commands of `sim` without a flat name: the name, the return value, and the reason why there is no effect.
const MODERN: &[(&str, Gives, &str)] = &[
    ("sim.getNamedStringParam", Nothing, "the command line does not pass parameters to scripts"),
    ("sim.getNamedBoolParam", Nothing, "the command line does not pass parameters to scripts"),
    ("sim.getNamedFloatParam", Nothing, "the command line does not pass parameters to scripts"),
    ("sim.getNamedInt32Param", Nothing, "the command line does not pass parameters to scripts"),
    ("sim.setNamedStringParam", Nothing, "the command line does not pass parameters to scripts"),
    ("sim.setNamedBoolParam", Nothing, "the command line does not pass parameters to scripts"),
    ("sim.setNamedFloatParam", Nothing, "the command line does not pass parameters to scripts"),
    ("sim.setNamedInt32Param", Nothing, "the command line does not pass parameters to scripts"),
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
    ("sim.registerScriptFuncHook", Int(-1), "functions of scripts cannot be hooked"),
    ("sim.getStackTraceback", Text(""), "errors are reported with their traceback"),
    ("sim.getUserVariables", Empty, EDITOR),
    ("sim.initScript", Nothing, SCRIPTS),
    ("sim.createScript", Int(-1), SCRIPTS),
    ("sim.textEditorOpen", Int(-1), EDITOR),
    ("sim.textEditorShow", Nothing, EDITOR),
    ("sim.textEditorClose", Text(""), EDITOR),
    ("sim.textEditorGetInfo", Text(""), EDITOR),
    ("sim.getPluginInfo", Text(""), "V-REP plugins are not supported"),
    ("sim.setPluginInfo", Nothing, "V-REP plugins are not supported"),
    ("sim.setModuleInfo", Nothing, "V-REP plugins are not supported"),
    ("sim.moduleEntry", Int(-1), WINDOWS),
    ("sim.getShapeViz", Empty, LOOKS),
    ("sim.generateTextShape", Int(-1), LOOKS),
    ("sim.setObjectHierarchyOrder", Nothing, "the order of siblings cannot be changed"),
    ("sim.setExplicitHandlingFlags", Nothing, PROGRAM),
    ("sim.relocateShapeFrame", Int(1), "the frame of a shape cannot be changed"),
    ("sim.alignShapeBB", Int(1), "the bounding box of a shape is centred on its frame"),
    ("sim.getObjectFloatArrayParam", Empty, PROGRAM),
    ("sim.setObjectFloatArrayParam", Nothing, PROGRAM),
    ("sim.createCustomObject", Int(-1), PROGRAM),
    ("sim.getExitRequest", Int(0), PROGRAM),
    ("sim.getAlternateConfigs", Nothing, PLANNING),
];

pub(crate) fn offer(offer: &mut Offer<Vrep>) {
    for ([name, old], gives, why) in OLD {
        add(offer, name, Some((old, gives.on_error())), *gives, why);
    }
    for (name, gives, why) in MODERN {
        add(offer, name, None, *gives, why);
    }
    let why = "a service listens, but does not report the state of its connections";
    add(offer, "simRemoteApi.status", Some(("simExtRemoteApiStatus", MINUS)), Int(-1), why);
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

fn add(offer: &mut Offer<Vrep>, name: &str, flat: Option<(&str, [Value; 1])>, gives: Gives, why: &str) {
    if offer.has_command(name) {
        return;
    }
    let mut command = tatu_commands_common::stub(name, gives, why);
    if let Some((flat, on_error)) = flat.filter(|(flat, _)| !offer.has_command(flat)) {
        command = command.old_name(flat, on_error);
    }
    offer.command(command);
}
