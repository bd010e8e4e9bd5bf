-- Functions shared by controllers of a TurtleBot3: odometry from wheel encoders, scans, and driving by speed and rate.
--
--   local base = require 'turtlebot3_base'
--   function sysCall_init() base.init(0, 0, 0) end          -- initial pose in the odometry frame
--   function sysCall_actuation()
--       local x, y, heading = base.odometry()                -- in each step
--       local scan = base.new_scan()                         -- nil if there is no new one
--       base.drive(0.1, 0.5)                                 -- m/s, rad/s
--   end

local RADIUS = 0.033            -- m, of the wheels
local TRACK = 0.160             -- m, between the wheels
local MAX_ACCELERATION = 0.8    -- m/s^2
local SCANNER_X = -0.032        -- m, of the scanner ahead of the axle

local base = {MAX_SPEED = 0.22, MAX_TURN = 2.0, SCANNER_X = SCANNER_X}

local left, right, left_encoder, right_encoder, scanner
local x, y, heading, last_left, last_right
local seen, speed = 0, 0

function base.limit(value, most)
    return math.max(-most, math.min(most, value))
end

function base.wrap(angle)
    return (angle + math.pi) % (2 * math.pi) - math.pi
end

function base.init(x0, y0, heading0)
    left, right = sim.getObject(':/wheel_left_joint'), sim.getObject(':/wheel_right_joint')
    left_encoder, right_encoder = sim.getObject(':/wheel_left_encoder'), sim.getObject(':/wheel_right_encoder')
    scanner = sim.getObject(':/base_scan')
    x, y, heading, last_left, last_right = x0, y0, heading0, 0, 0
end

-- Returns the pose in the odometry frame, m and rad: each step is integrated as an arc.
function base.odometry()
    local l, r = tatu.read(left_encoder), tatu.read(right_encoder)
    if l.sequence == 0 then return x, y, heading end
    local dl, dr = (l.position - last_left) * RADIUS, (r.position - last_right) * RADIUS
    last_left, last_right = l.position, r.position
    local ahead, turn = (dl + dr) / 2, (dr - dl) / TRACK
    x, y = x + ahead * math.cos(heading + turn / 2), y + ahead * math.sin(heading + turn / 2)
    heading = base.wrap(heading + turn)
    return x, y, heading
end

-- Returns the last scan if it is a new one: distance and angle, lists of 360 values.
function base.new_scan()
    local scan = tatu.read(scanner)
    if scan.sequence == seen then return nil end
    seen = scan.sequence
    return scan
end

function base.drive(want_speed, want_turn)
    local change = MAX_ACCELERATION * sim.getSimulationTimeStep()
    speed = speed + base.limit(base.limit(want_speed, base.MAX_SPEED) - speed, change)
    local turn = base.limit(want_turn, base.MAX_TURN)
    sim.setJointTargetVelocity(left, (speed - turn * TRACK / 2) / RADIUS)
    sim.setJointTargetVelocity(right, (speed + turn * TRACK / 2) / RADIUS)
end

return base
