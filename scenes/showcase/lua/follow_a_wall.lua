-- Keeps the nearest wall at a fixed distance on the right. The laser scanner is the only input.
--
-- The nearest point on the right side and ahead counts as the wall. It should be at a right angle to the robot, at the
-- distance KEEP. At an outer corner, the nearest point is the corner itself, and the robot drives an arc around it; at
-- an inner corner, the wall ahead becomes the nearest, and the robot turns away from it.

local RADIUS = 0.033            -- m, of the wheels
local TRACK = 0.160             -- m, between the wheels
local MAX_SPEED = 0.22          -- m/s
local MAX_TURN = 2.4            -- rad/s
local MAX_ACCELERATION = 0.8    -- m/s^2
local KEEP = 0.27               -- m, from the scanner to the wall
local FAR = 1.2                 -- m: farther walls are not followed
local FROM, TO = math.rad(-150), math.rad(40)   -- the sector that is searched for the wall
local WINDOW = 4                -- beams to either side over which distances are averaged to reduce noise
local SAME = 0.03               -- m: beams up to this much longer than the shortest one hit the same part of the wall
local GAIN_DISTANCE = 3.0       -- rad of approach per m of distance error
local MAX_APPROACH = math.rad(45)
local GAIN_ANGLE = 2.2          -- rad/s per rad
local HALF_LANE = 0.10          -- m: obstacles ahead within this distance of the middle slow the robot down
local STOP, SLOW = 0.20, 0.55   -- m from the scanner to an obstacle ahead: the speed falls from SLOW to STOP

function sysCall_init()
    left = sim.getObject(':/wheel_left_joint')
    right = sim.getObject(':/wheel_right_joint')
    scanner = sim.getObject(':/base_scan')
    graph = sim.getObject('/Wall')
    kept = sim.addGraphStream(graph, 'distance to the wall', 'm')
    wanted = sim.addGraphStream(graph, 'set point', 'm')
    seen = 0                    -- sequence number of the last scan used
    speed, want_speed, want_turn = 0, 0, 0
end

local function limit(value, most)
    return math.max(-most, math.min(most, value))
end

-- Returns the mean distance of the beams around beam i; beams without a hit count as FAR.
local function smooth(distance, i)
    local sum = 0
    for k = i - WINDOW, i + WINDOW do
        sum = sum + math.min(FAR, distance[(k - 1) % #distance + 1])
    end
    return sum / (2 * WINDOW + 1)
end

-- Returns distance and bearing of the wall: of the nearest point, averaged over all beams of about that distance.
local function find_wall(scan)
    local smoothed, least, at = {}, FAR, nil
    for i, a in ipairs(scan.angle) do
        if a >= FROM and a <= TO then
            smoothed[i] = smooth(scan.distance, i)
            if smoothed[i] < least then least, at = smoothed[i], a end
        end
    end
    if not at then return end
    local sum, n = 0, 0
    for i, a in ipairs(scan.angle) do
        if smoothed[i] and smoothed[i] < least + SAME and math.abs(a - at) < math.rad(40) then
            sum, n = sum + a, n + 1
        end
    end
    return least, sum / n
end

local function clear_ahead(scan)
    local free = FAR
    for i, a in ipairs(scan.angle) do
        local d = scan.distance[i]
        if math.abs(a) < math.pi / 2 and math.abs(d * math.sin(a)) < HALF_LANE then
            free = math.min(free, d * math.cos(a))
        end
    end
    return free
end

local function decide(scan)
    local distance, bearing = find_wall(scan)
    local free = clear_ahead(scan)
    want_speed = MAX_SPEED * math.max(0, math.min(1, (free - STOP) / (SLOW - STOP)))
    if not distance then
        want_turn = 0           -- no wall: drive straight until there is one
        return
    end
    -- Parallel to the wall, its bearing is -90 degrees. If too far away, the robot turns towards it, up to
    -- MAX_APPROACH.
    local approach = limit(GAIN_DISTANCE * (distance - KEEP), MAX_APPROACH)
    want_turn = limit(GAIN_ANGLE * (bearing + math.pi / 2 - approach), MAX_TURN)
    want_speed = want_speed * math.max(0.25, 1 - math.abs(want_turn) / MAX_TURN)
    sim.setGraphStreamValue(graph, kept, distance)
    sim.setGraphStreamValue(graph, wanted, KEEP)
end

function sysCall_actuation()
    local scan = tatu.read(scanner)
    if scan.sequence == 0 then return end
    if scan.sequence ~= seen then
        seen = scan.sequence
        decide(scan)
    end
    local change = MAX_ACCELERATION * sim.getSimulationTimeStep()
    speed = speed + limit(want_speed - speed, change)
    sim.setJointTargetVelocity(left, (speed - want_turn * TRACK / 2) / RADIUS)
    sim.setJointTargetVelocity(right, (speed + want_turn * TRACK / 2) / RADIUS)
end
