-- The delta robot's demonstration: a cycle of 25 mm up, 305 mm across, 25 mm down,
-- and back, rotated by 60 degrees after each cycle. It does not pick any pieces; see pick.lua for that.

local MIDDLE = {0, 0, -1.05}      -- m, in the frame of the base: middle of the cycle
local WIDTH = 0.305               -- m
local HEIGHT = 0.025              -- m
local MOVE_TIME = 0.5             -- s: in one direction
local PAUSE = 0.1                 -- s

local motors, kinematics

local function aim(position)
    local angles, why = kinematics:inverse(position)
    if not angles then
        error(string.format('the position %.3f %.3f %.3f m: %s', position[1], position[2], position[3], why))
    end
    for i, motor in ipairs(motors) do sim.setJointTargetPosition(motor, angles[i]) end
end

-- A motion from rest to rest, up at the beginning and down at the end.
local function move(from, to)
    local start, t = sim.getSimulationTime(), 0
    while t < 1 do
        t = math.min((sim.getSimulationTime() - start) / MOVE_TIME, 1)
        local s = t * t * t * (10 + t * (6 * t - 15))
        local lift = HEIGHT * math.min(1, 4 * math.min(s, 1 - s))
        aim{from[1] + s * (to[1] - from[1]), from[2] + s * (to[2] - from[2]), from[3] + s * (to[3] - from[3]) + lift}
        sim.step()
    end
    sim.wait(PAUSE)
end

function sysCall_init()
    motors = {}
    for i = 1, 3 do motors[i] = sim.getObject(':/motor_' .. i) end
    kinematics = sim.getScriptFunctions(sim.getScript(sim.scripttype_simulation, sim.getObject(':/kinematics')))
end

function sysCall_thread()
    local angles = {}
    for i, motor in ipairs(motors) do angles[i] = sim.getJointPosition(motor) end
    local at = kinematics:forward(angles)
    local turn = 0
    while true do
        local x, y = WIDTH / 2 * math.cos(turn), WIDTH / 2 * math.sin(turn)
        for _, side in ipairs{1, -1, 1} do
            local to = {MIDDLE[1] + side * x, MIDDLE[2] + side * y, MIDDLE[3]}
            move(at, to)
            at = to
        end
        turn = turn + math.pi / 3
    end
end
