-- Drives ahead, and passes obstacles sideways without turning, as only an omnidirectional platform can. Where that side
-- is closed, or an obstacle is too wide, it turns in place until the way is free. It reads nothing but the laser
-- scanner.

local RADIUS = 0.05         -- m, of a wheel
local REACH = 0.386         -- m, half the wheelbase and half the track together
local WHEELS = {'fl', 'fr', 'bl', 'br'}

local CRUISE = 0.4          -- m/s ahead
local SLIDE = 0.25          -- m/s to the side
local TURN = 0.8            -- rad/s in place
local ACCELERATION = 1.0    -- m/s^2, and rad/s^2
local STOP = 0.25           -- m ahead of the scanner at which it stands
local FREE = 0.9            -- m ahead of the scanner from which it passes an obstacle no more
local CLEAR = 1.5           -- m that must be free ahead before it stops turning
local PATIENCE = 3.5        -- s of passing an obstacle, after which it turns instead
local HALF_WIDTH = 0.26     -- m, half of the lane that must be free ahead
local SIDE = 0.45           -- m from the middle to an obstacle beside it, below which that side is closed
local BEHIND = 0.10         -- m, how far behind the scanner obstacles beside it still count

function sysCall_init()
    scanner = sim.getObject(':/base_laser_front')
    wheels = {}
    for i, name in ipairs(WHEELS) do wheels[i] = sim.getObject(':/wheel_joint_' .. name) end
    velocity, goal = {0, 0, 0}, {0, 0, 0}   -- ahead and left, m/s, and about z, rad/s
    seen = 0                                -- number of the scan that it has seen last
    evade = nil                             -- side to which it passes an obstacle: 1 left, -1 right
    turning = false                         -- whether it turns in place
end

-- Wheel speeds, rad/s, for a velocity of the platform in its own frame, m/s and rad/s.
local function drive(ahead, left, turn)
    local speeds = {
        ahead - left - REACH * turn,
        ahead + left + REACH * turn,
        ahead + left - REACH * turn,
        ahead - left + REACH * turn,
    }
    for i, wheel in ipairs(wheels) do sim.setJointTargetVelocity(wheel, speeds[i] / RADIUS) end
end

-- The nearest obstacle ahead within the lane, and to the left and the right of the platform, m from the scanner.
local function look()
    local scan = tatu.read(scanner)
    local front, left, right = math.huge, math.huge, math.huge
    for i, distance in ipairs(scan.distance) do
        if distance < math.huge then
            local x, y = distance * math.cos(scan.angle[i]), distance * math.sin(scan.angle[i])
            if math.abs(y) < HALF_WIDTH then
                front = math.min(front, x)
            elseif x < STOP and x > -BEHIND then
                if y > 0 then left = math.min(left, y) else right = math.min(right, -y) end
            end
        end
    end
    return front, left, right
end

-- Where it wants to go: velocities ahead, to the left and about z.
local function decide(front, left, right)
    local now = sim.getSimulationTime()
    if turning then
        if front < CLEAR then return 0, 0, evade * TURN end
        turning, evade = false, nil
    end
    if front > FREE then
        evade = nil
        -- Walls alongside push it away gently.
        local push = 0
        if left < SIDE then push = push - (SIDE - left) end
        if right < SIDE then push = push + (SIDE - right) end
        return CRUISE, push, 0
    end
    -- A side, once chosen, is kept: otherwise the platform would hesitate in front of an obstacle.
    if not evade then
        evade, since = left >= right and 1 or -1, now
    end
    -- What takes long to pass is a wall.
    if (evade > 0 and left or right) < SIDE or now - since > PATIENCE then
        turning = true
        return 0, 0, evade * TURN
    end
    return CRUISE * math.max(0, math.min(1, (front - STOP) / (FREE - STOP))), evade * SLIDE, 0
end

local function towards(value, goal, step)
    return value + math.max(-step, math.min(step, goal - value))
end

function sysCall_actuation()
    -- The scanner measures less often than the scene steps.
    local sequence = tatu.read(scanner).sequence
    if sequence ~= seen then
        seen = sequence
        goal = {decide(look())}
    end
    local step = ACCELERATION * sim.getSimulationTimeStep()
    for i = 1, 3 do velocity[i] = towards(velocity[i], goal[i], step) end
    drive(velocity[1], velocity[2], velocity[3])
end

function sysCall_cleanup()
    if wheels then drive(0, 0, 0) end
end
