-- The serpenoid gait: joint i goes to A sin(w t - i d) - offset; a positive offset steers to the left. The wave runs
-- from head to tail and pushes the snake ahead.
--
-- Amplitude A (rad), angular frequency w (rad/s), phase d (rad) and offset (rad) are the custom data `gait` of the
-- base, a string of four numbers; a script may change them at any time:
--     sim.writeCustomStringData(sim.getObject('/snake'), 'gait', '0.5 2 0.7 0.05')
-- Its only input is the time. With `wander`, the snake turns to the left at times.

local BEGIN = 2.0              -- s, in which the amplitude grows from 0
local TURN = 0.08              -- rad, offset while turning
local WAY = 10.0               -- s, duration of straight sections and of turns
local BLEND = 2.0              -- s, in which the offset changes

function sysCall_init()
    robot = sim.getObject(':')
    local modules = tonumber(sim.readCustomStringData(robot, 'modules'))
    wander = sim.readCustomStringData(robot, 'wander') == '1'
    joints = {}
    for i = 1, modules - 1 do joints[i] = sim.getObject(':/joint_' .. i) end
    offset, angle, last = 0, 0, 0
end

local function gait()
    local text, numbers = sim.readCustomStringData(robot, 'gait'), {}
    for number in text:gmatch('%S+') do numbers[#numbers + 1] = tonumber(number) end
    if #numbers ~= 4 then
        error('custom data `gait` of the base is "' .. text .. '"; expected four numbers: amplitude rate phase offset')
    end
    return table.unpack(numbers)
end

-- Alternately straight and left, so that the snake stays near its starting position.
local function wandering(t)
    return math.floor(t / WAY) % 2 == 1 and TURN or 0
end

function sysCall_actuation()
    local t = sim.getSimulationTime()
    local amplitude, rate, phase, steer = gait()
    if wander then steer = wandering(t) end
    local dt = t - last
    last = t
    -- The phase of the wave is integrated, so that a change of its rate does not cause a jump.
    angle = angle + rate * dt
    offset = offset + (steer - offset) * math.min(1, dt / BLEND)
    local grown = amplitude * math.min(1, t / BEGIN)
    for i, joint in ipairs(joints) do
        sim.setJointTargetPosition(joint, grown * math.sin(angle - (i - 1) * phase) - offset)
    end
end
