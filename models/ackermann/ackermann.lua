-- Follow-the-gap controller: steers towards the deepest opening in the scan that is wide enough for the car. The laser
-- scanner is its only input.

local WHEELBASE = 0.3302        -- m
local RADIUS = 0.05             -- m, of the wheels
local STEER_LIMIT = 0.4189      -- rad
local CRUISE = 3.0              -- m/s
local CREEP = 0.6               -- m/s: the lowest forward speed
local ACCELERATION = 2.5        -- m/s^2, also for braking: the limit of F1TENTH's driver
local SIDE_ACCELERATION = 4.0   -- m/s^2 in bends, less than half of what the tyres hold
local HALF_WIDTH = 0.28         -- m: half the width that the car needs; the car is 0.31 m wide
local FIELD = math.rad(80)      -- rad: half the field of view that is evaluated
local SCANNER_X = 0.265         -- m, ahead of the rear axle
local LOOK_AHEAD = 1.5          -- m: maximum distance of the point that the car steers towards
local SIDE_TOUCH = 0.18         -- m, beside the scanner: with an obstacle closer than this, no steering to that side
local SIDE_FREE = 0.30          -- m: with no obstacle closer than this, steering to that side is unrestricted
local EVERY = 4                 -- only every fourth of the 1081 beams is used: one per degree
local FAR = 6.0                 -- m: ranges are clamped to this value
local JUMP = 0.25               -- m: neighbouring beams that differ by more are an edge
local MARGIN = 0.45             -- m: stopping distance to an obstacle, measured from the scanner
local BLOCKED = 0.40            -- m: with an obstacle closer than this, the car reverses; the bumper is at 0.2
local BACK = 1.2                -- s

function sysCall_init()
    motor = sim.getObject(':/motor_joint')
    servo = sim.getObject(':/steering_joint')
    scanner = sim.getObject(':/laser')
    speed, steer = 0, 0
    back_until = -1             -- s: the car reverses until this time
end

-- Ranges of the evaluated beams, from right to left, clamped to FAR.
local function view(scan)
    local angles, depths = {}, {}
    for i = 1, #scan.distance, EVERY do
        local a = scan.angle[i]
        if math.abs(a) <= FIELD then
            angles[#angles + 1] = a
            depths[#depths + 1] = math.min(scan.distance[i], FAR)
        end
    end
    return angles, depths
end

-- Widens near obstacles by half the width of the car, so that the car fits through any direction that is still deep.
local function widened(angles, depths)
    local out = {}
    for i = 1, #depths do out[i] = depths[i] end
    local step = (angles[#angles] - angles[1]) / (#angles - 1)
    for i = 1, #depths - 1 do
        if math.abs(depths[i + 1] - depths[i]) > JUMP then
            local near, toward = i, 1
            if depths[i + 1] < depths[i] then near, toward = i + 1, -1 end
            local d = depths[near]
            local beams = math.ceil(math.asin(math.min(1, HALF_WIDTH / math.max(d, 0.01))) / step)
            for k = 1, beams do
                local j = near + k * toward
                if not out[j] then break end
                out[j] = math.min(out[j], d)
            end
        end
    end
    return out
end

-- Returns the middle of the directions that are nearly as deep as the deepest one, and the depth there.
local function aim(angles, depths)
    local best = 1
    for i = 2, #depths do
        if depths[i] > depths[best] or (depths[i] == depths[best] and math.abs(angles[i]) < math.abs(angles[best])) then
            best = i
        end
    end
    local first, last = best, best
    while first > 1 and depths[first - 1] > 0.9 * depths[best] do first = first - 1 end
    while last < #depths and depths[last + 1] > 0.9 * depths[best] do last = last + 1 end
    return (angles[first] + angles[last]) / 2, depths[best]
end

-- Distance from the scanner to the nearest obstacle in the lane straight ahead, m.
local function clearance(angles, depths)
    local least = FAR
    for i, d in ipairs(depths) do
        if math.abs(d * math.sin(angles[i])) < 0.16 then least = math.min(least, d * math.cos(angles[i])) end
    end
    return least
end

-- Steering angle of the arc that takes the rear axle to a point given by direction and range from the scanner (pure
-- pursuit).
local function pursue(direction, distance)
    local x, y = SCANNER_X + distance * math.cos(direction), distance * math.sin(direction)
    return math.max(-STEER_LIMIT, math.min(STEER_LIMIT, math.atan(2 * WHEELBASE * y / (x * x + y * y))))
end

-- Reduces the steering angle if there is an obstacle beside the car on the inner side, which its rear would touch.
local function guard(scan, steering)
    local side = steering > 0 and 1 or -1
    local beside = math.huge
    for i = 1, #scan.distance, EVERY do
        local a = side * scan.angle[i]
        if a > math.rad(50) and a < math.rad(130) then beside = math.min(beside, scan.distance[i] * math.sin(a)) end
    end
    return steering * math.max(0, math.min(1, (beside - SIDE_TOUCH) / (SIDE_FREE - SIDE_TOUCH)))
end

local function toward(value, target, most)
    return value + math.max(-most, math.min(most, target - value))
end

function sysCall_actuation()
    local scan = tatu.read(scanner)
    if scan.sequence == 0 then return end
    local now, dt = sim.getSimulationTime(), sim.getSimulationTimeStep()
    local angles, depths = view(scan)
    local ahead = clearance(angles, depths)
    local direction, depth = aim(angles, widened(angles, depths))
    steer = guard(scan, pursue(direction, math.min(depth, LOOK_AHEAD)))
    local radius = WHEELBASE / math.max(math.abs(math.tan(steer)), 0.01)
    local want = math.min(CRUISE, math.sqrt(SIDE_ACCELERATION * radius),
        math.sqrt(2 * ACCELERATION * math.max(0, math.min(depth, ahead * 2) - MARGIN)))
    want = math.max(CREEP, want)
    if ahead < BLOCKED and now > back_until then back_until = now + BACK end
    if now < back_until then
        want, steer = -CREEP, -steer
    end
    speed = toward(speed, want, ACCELERATION * dt)
    sim.setJointTargetVelocity(motor, speed / RADIUS)
    sim.setJointTargetPosition(servo, steer)
end
