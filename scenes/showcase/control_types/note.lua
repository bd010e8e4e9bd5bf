-- A note above a robot that waits for its client, and a line on the status bar that shows how to start the client.
--
-- The notes use the true position of a robot, which is not used for driving.

local letters = require 'letters'

local note = {}

local AMBER = {1.0, 0.62, 0.05}
local ABOVE, SIZE = 0.30, 0.10      -- m, above the middle of the robot; height of the letters
local PIXELS = 3

local shown = {}                    -- robot to drawing

function note.show(robot, text, help)
    if shown[robot] then return end
    local p = sim.getObjectPosition(robot, sim.handle_world)
    shown[robot] = letters.write(text, {p[1], p[2], p[3] + ABOVE}, {1, 0, 0}, {0, 0, 1}, SIZE, PIXELS, AMBER)
    sim.addLog(sim.verbosity_scriptinfos, '/' .. sim.getObjectAlias(robot) .. ' waits: ' .. help)
end

function note.hide(robot)
    if not shown[robot] then return end
    sim.removeDrawingObject(shown[robot])
    shown[robot] = nil
    sim.addLog(sim.verbosity_scriptinfos, '/' .. sim.getObjectAlias(robot) .. ' is driven')
end

return note
