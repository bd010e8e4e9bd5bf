-- Throws a ball at the humanoid every few seconds, from a different side each time, and checks that the robot stays on
-- its feet. This script reads true poses, which the robot never does.

local BALLS = {'/ball_red', '/ball_yellow', '/ball_blue', '/ball_green'}
local SIDES = {0, 180, 90, -90}      -- degrees: directions of the balls, counter-clockwise from the robot's x axis
local FIRST, EVERY = 3.0, 4.0        -- s
local FROM = 1.0                     -- m: distance of the throw from the robot
local SPEED = 3.5                    -- m/s, horizontal
local AIM = 0.36                     -- m: height at which a ball hits
local GRAVITY = 9.81                 -- m/s^2
local TILT_MOST = math.rad(40)

local robot, graph, stream
local balls, thrown, next_time, moved = {}, 0, FIRST, nil

-- Throws a ball so that it hits the middle of the robot: it falls by g t^2 / 2 during its flight.
local function throw(ball, side)
    local at, a = sim.getObjectPosition(robot), math.rad(side)
    local dx, dy = -math.cos(a), -math.sin(a)
    local rise = GRAVITY * (FROM / SPEED) / 2
    sim.setObjectPose(ball, {at[1] - FROM * dx, at[2] - FROM * dy, AIM, 0, 0, 0, 1})
    sim.resetDynamicObject(ball)
    -- A force applied for one step produces the velocity.
    local push = tatu.get(ball, 'shape.mass') / sim.getSimulationTimeStep()
    sim.addForceAndTorque(ball, {push * SPEED * dx, push * SPEED * dy,
        push * (rise + GRAVITY * sim.getSimulationTimeStep())}, {0, 0, 0})
end

function sysCall_init()
    robot, graph = sim.getObject('/nao'), sim.getObject('/stand')
    for i, path in ipairs(BALLS) do balls[i] = sim.getObject(path) end
    stream = sim.addGraphStream(graph, 'tilt', 'deg')
end

function sysCall_actuation()
    local now = sim.getSimulationTime()
    if now < next_time then return end
    next_time = now + EVERY
    throw(balls[thrown % #BALLS + 1], SIDES[thrown % #SIDES + 1])
    thrown = thrown + 1
end

function sysCall_sensing()
    local m = sim.getObjectMatrix(robot)
    local tilt = math.acos(math.max(-1, math.min(1, m[11])))
    sim.setGraphStreamValue(graph, stream, math.deg(tilt))
    if tilt > TILT_MOST then
        error(string.format('the robot has fallen after %d balls, at %.1f s', thrown, sim.getSimulationTime()))
    end
end
