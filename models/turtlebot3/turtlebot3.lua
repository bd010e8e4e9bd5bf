-- Wanders, and avoids obstacles. The laser scanner is the only input; speeds stay within the limits of the data sheet.

local RADIUS = 0.033            -- m, of the wheels
local TRACK = 0.160             -- m, between the wheels
local MAX_SPEED = 0.22          -- m/s
local MAX_TURN = 2.84           -- rad/s
local MAX_ACCELERATION = 1.0    -- m/s^2
local MAX_TURN_ACCELERATION = 8.0   -- rad/s^2
local HALF_LANE = 0.14          -- m: half the width of the lane that must be free; the robot is 0.178 m wide
local STOP = 0.28               -- m: with an obstacle this close, the robot turns on the spot; its front is at 0.07
local GO = 0.45                 -- m: free length of the lane that ends turning on the spot
local SLOW = 0.80               -- m: with an obstacle closer than this, the robot slows down
local CARE = 0.60               -- m: objects beside the lane that are closer than this push the robot to the other side
local SPOT_TURN = 1.2           -- rad/s, when turning on the spot

function sysCall_init()
    left = sim.getObject(':/wheel_left_joint')
    right = sim.getObject(':/wheel_right_joint')
    scanner = sim.getObject(':/base_scan')
    seen = -1                   -- sequence number of the last scan used
    want_speed, want_turn = 0, 0
    speed, turn = 0, 0
    side = nil                  -- 1 or -1: turning on the spot to the left or right
end

-- Returns the free length of the lane ahead (m), and the repulsion by objects on the left and right (0 to 1 each).
local function look(scan)
    local free, from_left, from_right = math.huge, 0, 0
    for i, d in ipairs(scan.distance) do
        local a = scan.angle[i]
        if math.abs(a) < math.pi / 2 and d < math.huge then
            local ahead, aside = d * math.cos(a), d * math.sin(a)
            if math.abs(aside) < HALF_LANE then free = math.min(free, ahead) end
            if d < CARE then
                local push = (CARE - d) / CARE
                if a > 0 then from_left = math.max(from_left, push) else from_right = math.max(from_right, push) end
            end
        end
    end
    return free, from_left, from_right
end

local function decide(scan)
    local free, from_left, from_right = look(scan)
    -- A chosen side is retained until the lane is free: otherwise the robot would oscillate in a corner.
    if free < STOP or (side and free < GO) then
        side = side or (from_left > from_right and -1 or 1)
        want_speed, want_turn = 0, side * SPOT_TURN
        return
    end
    side = nil
    want_speed = MAX_SPEED * math.min(1, math.max(0.3, (free - STOP) / (SLOW - STOP)))
    want_turn = 1.6 * (from_right - from_left)
end

local function toward(value, target, most)
    return value + math.max(-most, math.min(most, target - value))
end

function sysCall_actuation()
    local scan = tatu.read(scanner)
    if scan.sequence > 0 and scan.sequence ~= seen then
        seen = scan.sequence
        decide(scan)
    end
    local dt = sim.getSimulationTimeStep()
    speed = toward(speed, math.min(want_speed, MAX_SPEED), MAX_ACCELERATION * dt)
    turn = toward(turn, math.max(-MAX_TURN, math.min(MAX_TURN, want_turn)), MAX_TURN_ACCELERATION * dt)
    sim.setJointTargetVelocity(left, (speed - turn * TRACK / 2) / RADIUS)
    sim.setJointTargetVelocity(right, (speed + turn * TRACK / 2) / RADIUS)
end
