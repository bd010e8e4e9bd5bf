//! Words by which the kind of a script is recognized from its source.

use crate::kit::*;

/// The first match decides.
const MARKS: &[(&str, &[&str])] = &[
    // Only main scripts run the stages of a step.
    ("main", &["simHandleSimulationStart", "simHandleDynamics", "simLaunchThreadedChildScripts", "defaultMainScript"]),
    ("main", &["handleSimulationStart", "handleDynamics", "launchThreadedChildScripts", "handleChildScripts"]),
    ("add-on", &["sim_addonscriptcall_", "sysCall_info", "sysCall_addOnScript"]),
    ("customization", &["sim_customizationscriptcall_", "sysCall_nonSimulation"]),
    ("customization", &["sysCall_beforeSimulation", "sysCall_afterSimulation"]),
    ("customization", &["sysCall_beforeInstanceSwitch", "sysCall_afterInstanceSwitch"]),
    // Words that only threaded scripts use; since 4.2 every script may use threads.
    ("threaded", &["sysCall_threadmain", "sim_childscriptcall_threaded"]),
    ("threaded", &["simSetThreadSwitchTiming", "simSetThreadAutomaticSwitch", "simSwitchThread"]),
    ("threaded", &["simDelegateChildScriptExecution"]),
    ("child", &["sysCall_", "sim_call_type"]),
];

pub(crate) fn offer(offer: &mut Offer<Vrep>) {
    for (kind, words) in MARKS {
        for word in *words {
            offer.kind_mark("lua", kind, word, 0);
        }
    }
    // A script without callbacks that returns a value.
    offer.kind_mark("lua", "module", "return", TATU_MARK_LAST_LINE);
}
