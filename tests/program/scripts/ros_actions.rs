//! Tests of `simROS2` actions between two scripts of a world: tests/facts/script-api.md, 8.

use crate::kit::*;

/// A script with an action server, which appends an element to the sequence of its goal in each step, as public scripts
/// do.
pub const SERVER: &str = r#"
simROS2 = require 'simROS2'
function sysCall_init()
    server = simROS2.createActionServer('/fib', 'example_interfaces/action/Fibonacci', 'handleGoal', 'handleCancel', 'handleAccepted')
end
function handleGoal(id, goal)
    if goal.order < 0 then return simROS2.goal_response.reject end
    if goal.order == 0 then return simROS2.goal_response.accept_and_defer end
    return simROS2.goal_response.accept_and_execute
end
function handleCancel(id, goal)
    if goal.order == 7 then return simROS2.cancel_response.reject end
    return simROS2.cancel_response.accept
end
function handleAccepted(id, goal) item = {id = id, goal = goal, sequence = {0, 1}} end
function sysCall_actuation()
    if not item then return end
    if simROS2.actionServerIsCanceling(server, item.id) then
        simROS2.actionServerActionCanceled(server, item.id, {sequence = item.sequence})
        item = nil
        return
    end
    if not simROS2.actionServerIsExecuting(server, item.id) then
        local ok, why = pcall(simROS2.actionServerPublishFeedback, server, item.id, {})
        sim.addStatusbarMessage('> deferred: ' .. tostring(why):match('the goal was deferred'))
        simROS2.actionServerExecute(server, item.id)
    end
    local s = item.sequence
    if #s > item.goal.order then
        simROS2.actionServerActionSucceed(server, item.id, {sequence = s})
        item = nil
        return
    end
    s[#s + 1] = s[#s] + s[#s - 1]
    simROS2.actionServerPublishFeedback(server, item.id, {sequence = s})
end
"#;

/// A script with an action client that prints everything it receives.
const CLIENT: &str = r#"
simROS2 = require 'simROS2'
local function say(...) sim.addStatusbarMessage('> ' .. table.concat({...}, ' ')) end
function sysCall_init()
    client = simROS2.createActionClient('/fib', 'example_interfaces/action/Fibonacci',
        function(id, accepted) last = id say('answer', #id, tostring(accepted)) end,
        function(id, feedback) assert(id == last) say('feedback', table.concat(feedback.sequence, ',')) end,
        'result')
    nobody = simROS2.createActionClient('/nobody', 'example_interfaces/action/Fibonacci', '', '', '')
    steps = 0
end
function result(id, code, r)
    for name, value in pairs(simROS2.action_result_code) do
        if value == code then say(name, table.concat(r.sequence, ',')) end
    end
end
function sysCall_actuation()
    steps = steps + 1
    local act = plan[steps]
    if act then act() end
end
"#;

fn run(plan: &str, steps: usize) -> Vec<String> {
    let object = |alias: &str, text: &str| {
        format!(
            "[[object]]\nkind = \"dummy\"\nalias = \"{alias}\"\nscript = {{ kind = \"child\", text = '''{text}''' }}\n"
        )
    };
    let client = format!("{CLIENT}\nplan = {{{plan}}}");
    let place = TestFolder::scene(&[object("server", SERVER), object("client", &client)].concat());
    let lines = place.trace(&[], &["--steps", &steps.to_string()]);
    let said = lines.iter().flat_map(|l| l.status()).filter_map(|l| l.strip_prefix("> "));
    said.map(str::to_owned).collect()
}

#[test]
fn a_goal_is_accepted_reported_on_and_reached() {
    let heard = run("[2] = function() assert(simROS2.sendGoal(client, {order = 3})) end", 8);
    assert_eq!(heard, ["answer 32 true", "feedback 0,1,1", "feedback 0,1,1,2", "succeeded 0,1,1,2"]);
}

#[test]
fn a_goal_may_be_rejected_deferred_and_cancelled() {
    assert_eq!(
        run("[2] = function() assert(simROS2.sendGoal(client, {order = -1})) end", 4),
        ["answer 0 false"],
        "a rejection must be delivered"
    );
    assert_eq!(
        run("[2] = function() simROS2.sendGoal(client, {order = 0}) end", 4),
        ["answer 32 true", "deferred: the goal was deferred", "succeeded 0,1"]
    );
    let plan = "[2] = function() simROS2.sendGoal(client, {order = 9}) end,
        [4] = function() assert(simROS2.cancelLastGoal(client)) end,
        [8] = function() assert(not simROS2.cancelLastGoal(client)) end";
    assert_eq!(run(plan, 9), ["answer 32 true", "feedback 0,1,1", "feedback 0,1,1,2", "canceled 0,1,1,2"]);
    // A server can also reject a cancellation.
    let plan = plan.replace("order = 9", "order = 7").replace("[8]", "[20]");
    assert_eq!(run(&plan, 12).last().unwrap(), "succeeded 0,1,1,2,3,5,8,13");
}

#[test]
fn missing_clients_and_wrong_goals_raise_errors() {
    let plan = r#"[2] = function()
        local function why(f, ...) local ok, e = pcall(f, ...) assert(not ok) say2(e) end
        function say2(e) sim.addStatusbarMessage('> ' .. e) end
        why(simROS2.sendGoal, nobody, {order = 1})
        why(simROS2.sendGoal, client, {ordre = 1})
        why(simROS2.sendGoal, 1000, {})
        why(simROS2.actionServerIsActive, client, 'f')
    end"#;
    let heard = run(plan, 3);
    for (line, told) in heard.iter().zip([
        "offers the action /nobody, and the calling script cannot wait for one",
        "has no field \"ordre\"",
        "there is no action client with the handle 1000",
        "there is no action server",
    ]) {
        assert!(line.contains(told), "{line}");
    }
    assert_eq!(heard.len(), 4);
}
