-- Compares the robot's estimate with the true pose, which only a referee can read. When the estimate has been right for
-- a while, moves the robot to another position without informing it. Raises an error if localization is too slow.

local PLACES = {{1.2, 0.9, 180}, {1.6, -0.8, 90}, {-1.2, -0.9, 20}, {0.3, -0.6, -60}, {-1.6, 0.6, -90}}  -- m, m, deg

local NEAR, HEADING_NEAR = 0.15, math.rad(12)     -- m, rad: tolerance of a correct estimate
local HOLD = 3.0                      -- s for which the estimate must stay correct
local MAX_TIME = 60.0                 -- s, time limit for localization
local REST = 10.0                     -- s from localization until the robot is moved

function sysCall_init()
    robot, graph = sim.getObject('/turtlebot3_burger'), sim.getObject('/Error')
    height = sim.getObjectPosition(robot)[3]
    place, carried = 0, 0
    right_since, found = nil, nil
end

local function carry(now)
    place = place % #PLACES + 1
    local x, y, half = PLACES[place][1], PLACES[place][2], math.rad(PLACES[place][3]) / 2
    sim.setObjectPose(robot, {x, y, height, 0, 0, math.sin(half), math.cos(half)})
    carried, right_since, found = now, nil, nil
end

local function errors()
    local x = sim.getFloatSignal('guess_x')
    if not x then return end
    local m = sim.getObjectMatrix(robot)
    local y, heading = sim.getFloatSignal('guess_y'), sim.getFloatSignal('guess_heading')
    local turn = heading - math.atan(m[5], m[1])
    return math.sqrt((x - m[4]) ^ 2 + (y - m[8]) ^ 2), math.abs(math.atan(math.sin(turn), math.cos(turn)))
end

local function record(off)
    sim.setGraphUserData(graph, 'error', off)
    sim.setGraphUserData(graph, 'spread of the particles', sim.getFloatSignal('spread'))
    sim.setGraphUserData(graph, 'particles', sim.getInt32Signal('particles'))
end

function sysCall_sensing()
    local now = sim.getSimulationTime()
    local off, turn = errors()
    if not off then return end
    record(off)
    if found then
        if now - found > REST then carry(now) end
        return
    end
    right_since = off < NEAR and turn < HEADING_NEAR and (right_since or now) or nil
    if right_since and now - right_since > HOLD then
        found = now
        print(string.format('found after %.1f s; the estimate is off by %.0f mm and %.1f degrees',
            right_since - carried, 1000 * off, math.deg(turn)))
    elseif now - carried > MAX_TIME then
        error('the robot does not find out where it is')
    end
end
