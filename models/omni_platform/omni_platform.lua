-- Drives ahead, and passes obstacles sideways without turning, as only an omnidirectional platform can. Where that side
-- is blocked, or an obstacle is too wide, the platform turns in place until the path is clear. The laser scanner is the
-- only input.

local RADIUS = 0.05         -- m, of a wheel
local REACH = 0.386         -- m, sum of half the wheelbase and half the track
local WHEELS = {'fl', 'fr', 'bl', 'br'}

local CRUISE = 0.4          -- m/s ahead
local SLIDE = 0.25          -- m/s to the side
local TURN = 0.8            -- rad/s in place
local ACCELERATION = 1.0    -- m/s^2, and rad/s^2
local STOP = 0.25           -- m ahead of the scanner at which the platform stops
local FREE = 0.9            -- m ahead of the scanner beyond which evasion of an obstacle ends
local CLEAR = 1.5           -- m that must be free ahead before the platform stops turning
local PATIENCE = 3.5        -- s of evading an obstacle, after which the platform turns instead
local HALF_WIDTH = 0.26     -- m, half of the lane that must be free ahead
local SIDE = 0.45           -- m from the middle to an obstacle beside the platform, below which that side is blocked
local BEHIND = 0.10         -- m behind the scanner up to which obstacles beside the platform count

function sysCall_init()
    scanner = sim.getObject(':/base_laser_front')
    wheels = {}
    for i, name in ipairs(WHEELS) do wheels[i] = sim.getObject(':/wheel_joint_' .. name) end
    velocity, goal = {0, 0, 0}, {0, 0, 0}   -- ahead and left, m/s, and about z, rad/s
    seen = 0                                -- sequence number of the last scan processed
    evade = nil                             -- side on which the platform evades an obstacle: 1 left, -1 right
    turning = false                         -- whether the platform turns in place
end

-- Sets the wheel speeds, rad/s, for a velocity of the platform in its own frame, m/s and rad/s.
local function drive(ahead, left, turn)
    local speeds = {
        ahead - left - REACH * turn,
        ahead + left + REACH * turn,
        ahead + left - REACH * turn,
        ahead - left + REACH * turn,
    }
    for i, wheel in ipairs(wheels) do sim.setJointTargetVelocity(wheel, speeds[i] / RADIUS) end
end

-- Distances, m, from the scanner to the nearest obstacles ahead within the lane, to the left and to the right.
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

-- Returns the desired velocities: ahead, to the left and about z.
local function decide(front, left, right)
    local now = sim.getSimulationTime()
    if turning then
        if front < CLEAR then return 0, 0, evade * TURN end
        turning, evade = false, nil
    end
    if front > FREE then
        evade = nil
        -- Walls alongside repel the platform gently.
        local push = 0
        if left < SIDE then push = push - (SIDE - left) end
        if right < SIDE then push = push + (SIDE - right) end
        return CRUISE, push, 0
    end
    -- A chosen side is retained: otherwise the platform would oscillate in front of an obstacle.
    if not evade then
        evade, since = left >= right and 1 or -1, now
    end
    -- An obstacle that takes long to pass is assumed to be a wall.
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
    -- The scanner measures less often than once per scene step.
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
