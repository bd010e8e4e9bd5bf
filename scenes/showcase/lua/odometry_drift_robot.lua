-- Follows the line with the floor sensor, and integrates the encoders to a pose (dead reckoning). The pose is not used
-- for driving: the robot follows the line, which makes the drift visible against a known course.
--
-- Systematic errors of odometry, unequal wheels first among them: Borenstein and Feng, "Measurement and Correction of
-- Systematic Odometry Errors in Mobile Robots", IEEE Transactions on Robotics and Automation 12 (1996).

local WHEEL_RADIUS = 0.0975           -- m; as the data sheet states it, for both wheels
local TRACK = 0.331                   -- m, between the wheels
local COUNTS_PER_TURN = 76600         -- of an encoder, per turn of the wheel

local SPEED = 0.95                    -- m/s on the line
local SEARCH_SPEED = 0.30             -- m/s without it
local ACCELERATION = 0.8              -- m/s^2
local GAIN = 6.0                      -- rad/s of yaw rate per metre of offset from the line
local MAX_TURN = 1.5                  -- rad/s
local SPOT_PITCH = 0.035              -- m, between the spots of the floor sensor
local DARK, BRIGHT = 0.55, 0.85       -- values of pavement and paint

local SENSOR_AHEAD = 0.2              -- m, of the floor sensor ahead of the axle, to whose middle odometry refers
local START = {-SENSOR_AHEAD, -2.5, 0.0}   -- x, y (m) and heading (rad) when the sensor meets the start line
local LAPS = 3                        -- until the odometry is reset
local DEBOUNCE = 10.0                 -- s; a start line detected sooner after the last one is the same one

local ORANGE, BLUE = {1.0, 0.55, 0.10}, {0.25, 0.55, 1.0}

function sysCall_init()
    left, right = sim.getObject(':/Pioneer_p3dx_leftMotor'), sim.getObject(':/Pioneer_p3dx_rightMotor')
    left_encoder, right_encoder = sim.getObject(':/left_encoder'), sim.getObject(':/right_encoder')
    line_sensor, gps = sim.getObject(':/line_sensor'), sim.getObject(':/gps')

    trail = sim.addDrawingObject(sim.drawing_lines, 3, 0, -1, 0, ORANGE)
    ghost = sim.addDrawingObject(sim.drawing_lines, 5, 0, -1, 0, ORANGE)
    fixes = sim.addDrawingObject(sim.drawing_points, 5, 0, -1, 0, BLUE)

    speed, side = 0, 0                -- m/s; side of the last line detection: positive to the left
    lap = 0                           -- 0: on the way to the start line
    crossed = -math.huge              -- s, time of the last crossing
    fix = 0                           -- sequence number of the last GPS fix that was drawn
end

-- Odometry -------------------------------------------------------------------

local function reset_odometry()
    x, y, heading = table.unpack(START)
    drawn_x, drawn_y = x, y
    sim.addDrawingObjectItem(trail, nil)
    sim.addDrawingObjectItem(fixes, nil)
end

-- Integrates the motion of the wheels since the last call. The arc is approximated by its chord, which has the
-- direction of the mean heading.
local function integrate()
    local l, r = tatu.read(left_encoder).ticks, tatu.read(right_encoder).ticks
    local per_count = 2 * math.pi * WHEEL_RADIUS / COUNTS_PER_TURN
    local rolled_left = (l - (last_left or l)) * per_count
    local rolled_right = (r - (last_right or r)) * per_count
    last_left, last_right = l, r
    if lap == 0 then return end
    local ahead, turn = (rolled_left + rolled_right) / 2, (rolled_right - rolled_left) / TRACK
    x = x + ahead * math.cos(heading + turn / 2)
    y = y + ahead * math.sin(heading + turn / 2)
    heading = heading + turn
end

-- Line -----------------------------------------------------------------------

-- Converts the spots to a range from 0 (pavement) to 1 (paint); returns the position of the line, and the minimum
-- value.
local function look(values)
    local sum, moment, least = 0, 0, 1
    local middle = (#values + 1) / 2
    for i, value in ipairs(values) do
        local paint = math.max(0, math.min(1, (value - DARK) / (BRIGHT - DARK)))
        sum, moment = sum + paint, moment + paint * (i - middle) * SPOT_PITCH
        least = math.min(least, paint)
    end
    return sum > 0.5 and moment / sum or nil, least
end

local function cross_start_line()
    local now = sim.getSimulationTime()
    if now - crossed < DEBOUNCE then return end
    crossed = now
    lap = lap % LAPS + 1
    if lap == 1 then reset_odometry() end
    sim.setInt32Signal('lap', lap)
end

local function drive()
    local reading = tatu.read(line_sensor)
    if reading.sequence == 0 then return end
    local offset, least = look(reading.value)
    if least > 0.7 then
        cross_start_line()
        offset = 0
    end
    local wanted = offset and SPEED or SEARCH_SPEED
    side = offset or (side < 0 and -0.2 or 0.2)
    local dt = sim.getSimulationTimeStep()
    speed = speed + math.max(-ACCELERATION * dt, math.min(ACCELERATION * dt, wanted - speed))
    local turn = math.max(-MAX_TURN, math.min(MAX_TURN, GAIN * side))
    sim.setJointTargetVelocity(left, (speed - turn * TRACK / 2) / WHEEL_RADIUS)
    sim.setJointTargetVelocity(right, (speed + turn * TRACK / 2) / WHEEL_RADIUS)
end

-- Drawing --------------------------------------------------------------------

-- Draws the robot at the odometry pose: a ring with a line ahead.
local function draw_ghost()
    local z, radius, corners = 0.26, 0.25, 16
    sim.addDrawingObjectItem(ghost, nil)
    for i = 1, corners do
        local a, b = 2 * math.pi * i / corners, 2 * math.pi * (i + 1) / corners
        sim.addDrawingObjectItem(ghost, {x + radius * math.cos(a), y + radius * math.sin(a), z,
            x + radius * math.cos(b), y + radius * math.sin(b), z})
    end
    sim.addDrawingObjectItem(ghost, {x, y, z, x + 0.4 * math.cos(heading), y + 0.4 * math.sin(heading), z})
end

local function draw()
    draw_ghost()
    if math.abs(x - drawn_x) + math.abs(y - drawn_y) > 0.1 then
        sim.addDrawingObjectItem(trail, {drawn_x, drawn_y, 0.03, x, y, 0.03})
        drawn_x, drawn_y = x, y
    end
    local reading = tatu.read(gps)
    if reading.sequence ~= fix and reading.valid == 1 then
        fix = reading.sequence
        sim.addDrawingObjectItem(fixes, {reading.position[1], reading.position[2], 0.05})
    end
end

-- Steps ----------------------------------------------------------------------

function sysCall_actuation()
    drive()
end

function sysCall_sensing()
    integrate()
    if lap == 0 then return end
    draw()
    sim.setFloatSignal('odometry_x', x)
    sim.setFloatSignal('odometry_y', y)
end
