-- The walker steers the quadruped to the two ends of the course, alternately. The robot's own controller trots: it
-- receives a forward speed and a turning rate, and detects the ground by contact sensors. The position is measured by a
-- satellite receiver with corrections, the heading by the IMU.

local GOALS = {{4.0, 0.0}, {0.0, 0.0}}      -- m: ends of the course
local NEAR = 0.25                           -- m: distance at which a goal counts as reached
local SPEED = 0.35                          -- m/s
local TURN_GAIN = 1.2                       -- 1/s: turning rate per rad of bearing
local TURN_MOST = 0.7                       -- rad/s
local AHEAD = math.rad(35)                  -- beyond this bearing, the robot turns on the spot
local SMOOTH = 0.4                          -- weight of a new fix of the receiver
local PAUSE = 1.0                           -- s: pause at the ends of the course

local robot, imu, gps, x, y
local goal, last_fix, wait_until = 1, 0, 1.0

-- Returns the bearing of the goal relative to the robot's heading, rad.
local function bearing()
    local q = tatu.read(imu).orientation
    local heading = math.atan(2 * (q[4] * q[3] + q[1] * q[2]), 1 - 2 * (q[2] ^ 2 + q[3] ^ 2))
    local off = math.atan(GOALS[goal][2] - y, GOALS[goal][1] - x) - heading
    return (off + math.pi) % (2 * math.pi) - math.pi
end

local function command(ahead, turn)
    sim.writeCustomStringData(robot, 'command', string.format('%.3f 0 %.3f', ahead, turn))
end

function sysCall_init()
    robot, imu, gps = sim.getObject(':'), sim.getObject(':/imu'), sim.getObject(':/back/gps')
    command(0, 0)
end

function sysCall_actuation()
    local fix = tatu.read(gps)
    if fix.sequence == 0 then return end
    if fix.sequence ~= last_fix then
        last_fix = fix.sequence
        x = (x or fix.position[1]) + SMOOTH * (fix.position[1] - (x or fix.position[1]))
        y = (y or fix.position[2]) + SMOOTH * (fix.position[2] - (y or fix.position[2]))
    end
    local now = sim.getSimulationTime()
    if now < wait_until then return command(0, 0) end
    if math.sqrt((GOALS[goal][1] - x) ^ 2 + (GOALS[goal][2] - y) ^ 2) < NEAR then
        goal, wait_until = goal % #GOALS + 1, now + PAUSE
        return command(0, 0)
    end
    local off = bearing()
    local turn = math.max(-TURN_MOST, math.min(TURN_MOST, TURN_GAIN * off))
    command(math.abs(off) < AHEAD and SPEED or 0, turn)
end
