--- sim.displayDialog
local dlg, ui = sim.displayDialog('Question', 'Go on?', sim.dlgstyle_yes_no, false)
assert(dlg > 0 and sim.getDialogResult(dlg) == sim.dlgret_still_open)
--- sim.getDialogResult
function sysCall_init()
    dlg = sim.displayDialog('Question', 'Go on?', sim.dlgstyle_yes_no, false)
    assert(sim.getDialogResult(dlg) == sim.dlgret_still_open)
end
function sysCall_actuation()
    if sim.getSimulationTime() > 0.01 then
        assert(sim.getDialogResult(dlg) == sim.dlgret_yes)
    end
end
--- sim.getDialogInput
local dlg = sim.displayDialog('Name', 'Who?', sim.dlgstyle_input, false, 'Ada')
assert(sim.getDialogInput(dlg) == 'Ada')
--- sim.endDialog
local dlg = sim.displayDialog('Note', 'Hello', sim.dlgstyle_message, false)
assert(sim.endDialog(dlg) == 1)
assert(not pcall(sim.getDialogResult, dlg))
--- sim.msgBox
assert(sim.msgBox(sim.msgbox_type_info, sim.msgbox_buttons_yesno, 'Note', 'Sure?') == sim.msgbox_return_yes)
--- sim.sendData
local me = sim.sendData(sim.handle_all, 7, 'hello', 'data')
assert(me == 1)
--- sim.receiveData
assert(sim.receiveData(7, 'what nobody sends') == nil)
--- sim.broadcastMsg
sim.broadcastMsg({id = 'hello', x = 1})
--- sim.ruckigPos
local p = sim.ruckigPos(1, 0.001, -1, {0, 0, 0}, {1, 1, 10}, {1}, {1, 0})
local result, state = 0
while result == 0 do
    result, state = sim.ruckigStep(p, 0.05)
    assert(state[2] <= 1 + 1e-9)
end
assert(state[1] == 1)
sim.ruckigRemove(p)
--- sim.ruckigVel
local p = sim.ruckigVel(1, 0.001, -1, {0, 0, 0}, {1, 100}, {1}, {0.5})
local result
repeat
    result, state = sim.ruckigStep(p, 0.05)
until result == 1
assert(math.abs(state[2] - 0.5) < 1e-9)
--- sim.rmlPos
local p = sim.rmlPos(2, 0.001, -1, {0, 0, 0, 0, 0, 0}, {1, 1, 1, 1, 9, 9}, {1, 1}, {1, 2, 0, 0})
local result, state = sim.rmlStep(p, 0.5)
assert(result == 0 and math.abs(state[2] - 2 * state[1]) < 1e-9)        -- on a straight line
--- sim.rmlVel
local p = sim.rmlVel(1, 0.001, -1, {0, 0, 0}, {1, 100}, {1}, {0.5})
local result, state = sim.rmlStep(p, 1)
assert(result == 1 and math.abs(state[2] - 0.5) < 1e-9)
--- sim.ruckigStep
local p = sim.ruckigPos(2, 0.001, sim.ruckig_phasesync, {0, 0, 0, 0, 0, 0}, {1, 1, 1, 1, 9, 9}, {1, 1}, {1, 2, 0, 0})
local result, state, left = sim.ruckigStep(p, 0.5)
assert(result == 0 and left > 0.5 and #state == 6 and math.abs(state[2] - 2 * state[1]) < 1e-9)
--- sim.ruckigRemove
local p = sim.ruckigVel(1, 0.001, -1, {0, 0, 0}, {1, 100}, {1}, {0.5})
sim.ruckigRemove(p)
assert(not pcall(sim.ruckigStep, p, 0.05))
