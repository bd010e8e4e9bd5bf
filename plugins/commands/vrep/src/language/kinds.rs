//! Words in a script's source from which its kind is inferred.

use crate::kit::*;

/// Script kinds with the words that identify them. The first kind with a matching word is selected.
const KIND_MARKERS: &[(&str, &[&str])] = &[
    // Commands that run the stages of a step, which only main scripts call.
    ("main", &["simHandleSimulationStart", "simHandleDynamics", "simLaunchThreadedChildScripts", "defaultMainScript"]),
    ("main", &["handleSimulationStart", "handleDynamics", "launchThreadedChildScripts", "handleChildScripts"]),
    ("add-on", &["sim_addonscriptcall_", "sysCall_info", "sysCall_addOnScript"]),
    ("customization", &["sim_customizationscriptcall_", "sysCall_nonSimulation"]),
    ("customization", &["sysCall_beforeSimulation", "sysCall_afterSimulation"]),
    ("customization", &["sysCall_beforeInstanceSwitch", "sysCall_afterInstanceSwitch"]),
    // Words that only threaded scripts use. Since 4.2, every script can use threads.
    ("threaded", &["sysCall_threadmain", "sim_childscriptcall_threaded"]),
    ("threaded", &["simSetThreadSwitchTiming", "simSetThreadAutomaticSwitch", "simSwitchThread"]),
    ("threaded", &["simDelegateChildScriptExecution"]),
    ("child", &["sysCall_", "sim_call_type"]),
];

pub(crate) fn offer(offer: &mut Offer<Vrep>) {
    for (kind, words) in KIND_MARKERS {
        for word in *words {
            offer.kind_mark("lua", kind, word, 0);
            offer.kind_mark("python", kind, word, 0);
        }
    }
    // A module is a script without callbacks that returns a value.
    offer.kind_mark("lua", "module", "return", TATU_MARK_LAST_LINE);
}
