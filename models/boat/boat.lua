-- Sails from waypoint to waypoint, in a loop.
--
-- Sensors: GPS (position, velocity), compass (heading), gyroscope (rate of turn). Waypoints are objects that users may
-- move; the boat's own pose is never read. Guidance: along the line from the last waypoint to the next. Control: speed
-- and yaw rate, with the gains of heron_controller.

local HALF_TRACK = 0.377654    -- m, of the thrusters
local ANTENNA = {0.015, 0.05}  -- m, in the base frame
local ARRIVED = 2.0            -- m from a waypoint, at which the boat turns to the next one
local LOOKAHEAD = 2.0          -- m ahead on the line
local SLIDE_TIME = 2.2         -- s for which the boat drifts on
local CORNER_SPEED = 0.4       -- m/s at a waypoint, where the boat turns
local CORNER_GAIN = 0.25        -- 1/s, speed per distance from a waypoint
local HOLD_GAIN = 0.3          -- 1/s, speed per distance from the only waypoint
local HOLD_RADIUS = 0.5        -- m from the only waypoint, within which the boat does not turn
local TURN_GAIN = 1.2          -- 1/s, yaw rate per heading error
local TURN_MOST = 0.5          -- rad/s (heron_controller)

-- Force per speed, per speed error and per integral of the error (heron_controller), N s/m, N s/m, N/m.
local SPEED_GAIN = {feed = 20, error = 40, integral = 2}
-- Torque per yaw rate and per yaw rate error, N m s (heron_controller).
local RATE_GAIN = {feed = 10, error = 60}

local COMPASS_TIME = 5         -- s, time constant of the correction of the gyroscope by the compass
local POSITION_TIME = 1        -- s, time constant of the correction of position and speed by fixes
local LEEWAY_TIME = 15         -- s, time constant of the estimate of the leeway angle (course minus heading)
local STRAIGHT_TIME = 3        -- s without a turn, after which the boat no longer drifts sideways
local LEEWAY_SPEED = 0.4       -- m/s; below this speed, the course is unknown

local function clamp(x, least, most) return math.max(least, math.min(most, x)) end

local function wrapped(angle) return (angle + math.pi) % (2 * math.pi) - math.pi end

function sysCall_init()
    imu, compass, gps = sim.getObject(':/imu'), sim.getObject(':/compass'), sim.getObject(':/gps')
    drives = sim.getScript(sim.scripttype_simulation, sim.getObject(':/thrusters'))
    cruise = tonumber(sim.readCustomStringData(sim.getObject('..'), 'speed'))
    -- Detaching the waypoints keeps them in place when the boat moves; a stop attaches them again.
    waypoints = {}
    local handle = sim.getObject(':/waypoint_0', {noError = true})
    while handle >= 0 do
        waypoints[#waypoints + 1] = handle
        sim.setObjectParent(handle, -1, true)
        handle = sim.getObject(':/waypoint_' .. #waypoints, {noError = true})
    end
    nextOne, integral, leeway, straight, lastFix = 1, 0, 0, 0, 0
end

-- The compass heading, rad, counter-clockwise from +x.
local function compassHeading(reading) return wrapped(math.pi / 2 - reading.heading) end

-- Updates heading, yaw rate, position and velocity; returns whether all are known.
local function estimate(dt)
    local motion, field, fix = tatu.read(imu), tatu.read(compass), tatu.read(gps)
    if field.sequence == 0 or motion.sequence == 0 then return false end
    rate = motion.angular_velocity[3]
    if not heading then heading, gyroBias = compassHeading(field), 0 end
    rate = rate - gyroBias
    heading = heading + rate * dt
    local off = wrapped(compassHeading(field) - heading)
    heading = wrapped(heading + off * dt / COMPASS_TIME)
    gyroBias = gyroBias - off * dt / (4 * COMPASS_TIME ^ 2)
    if position then for k = 1, 2 do position[k] = position[k] + velocity[k] * dt end end
    if fix.valid == 1 and fix.sequence ~= lastFix then
        lastFix = fix.sequence
        local c, s = math.cos(heading), math.sin(heading)
        local at = {
            fix.position[1] - c * ANTENNA[1] + s * ANTENNA[2],
            fix.position[2] - s * ANTENNA[1] - c * ANTENNA[2],
        }
        position, velocity = position or at, velocity or {0, 0}
        local share = clamp((fix.time - (fixTime or fix.time)) / POSITION_TIME, 0, 1)
        fixTime = fix.time
        for k = 1, 2 do
            position[k] = position[k] + share * (at[k] - position[k])
            velocity[k] = velocity[k] + math.min(1, 2 * share) * (fix.velocity[k] - velocity[k])
        end
    end
    return position ~= nil
end

-- The course along the line to the waypoint, rad, and the distance to it, m.
local function guidance()
    local goal = sim.getObjectPosition(waypoints[nextOne])
    local dx, dy = goal[1] - position[1], goal[2] - position[2]
    local distance = math.sqrt(dx * dx + dy * dy)
    from = from or {position[1], position[2]}
    local lx, ly = goal[1] - from[1], goal[2] - from[2]
    local length = math.sqrt(lx * lx + ly * ly)
    if #waypoints == 1 or length < ARRIVED then return math.atan(dy, dx), distance end
    -- Components along the line and across it, positive to the left.
    local along = (lx * (position[1] - from[1]) + ly * (position[2] - from[2])) / length
    local aside = (lx * (position[2] - from[2]) - ly * (position[1] - from[1])) / length
    if distance < ARRIVED or along > length then
        from, nextOne = {goal[1], goal[2]}, nextOne % #waypoints + 1
    end
    -- Cross-track error is corrected in advance, because the boat drifts sideways after a turn.
    local drift = (lx * velocity[2] - ly * velocity[1]) / length
    return math.atan(ly, lx) - math.atan(aside + SLIDE_TIME * drift, LOOKAHEAD), distance
end

-- Forward force, N, for a speed over ground, m/s.
local function forceFor(speed, dt)
    local now = velocity[1] * math.cos(heading + leeway) + velocity[2] * math.sin(heading + leeway)
    local off = speed - now
    integral = clamp(integral + SPEED_GAIN.integral * off * dt, -15, 15)
    return SPEED_GAIN.feed * speed + SPEED_GAIN.error * off + integral
end

function sysCall_actuation()
    local dt = sim.getSimulationTimeStep()
    if #waypoints == 0 or not estimate(dt) then return end
    local course, distance = guidance()
    -- Current and compass errors make the course differ from the heading; steering compensates for this leeway. After a
    -- turn, the boat drifts sideways for a while, since a catamaran has little lateral resistance: that is not leeway.
    local speed = math.sqrt(velocity[1] ^ 2 + velocity[2] ^ 2)
    straight = math.abs(rate) < 0.06 and straight + dt or 0
    if speed > LEEWAY_SPEED and straight > STRAIGHT_TIME then
        local now = wrapped(math.atan(velocity[2], velocity[1]) - heading)
        if math.abs(now) < 0.6 then leeway = leeway + (now - leeway) * dt / LEEWAY_TIME end
    end
    local off = wrapped(course - leeway - heading)
    local wanted
    if #waypoints == 1 then
        -- Station keeping: the closer the waypoint, the slower, and in reverse if the waypoint is behind.
        wanted = clamp(HOLD_GAIN * distance, 0, cruise) * math.cos(off)
        if distance < HOLD_RADIUS then off = 0 end
    else
        wanted = math.min(cruise, math.max(CORNER_SPEED, CORNER_GAIN * distance)) * math.max(0.2, math.cos(off))
    end
    local turn = clamp(TURN_GAIN * off, -TURN_MOST, TURN_MOST)
    local force = forceFor(wanted, dt)
    local torque = RATE_GAIN.feed * turn + RATE_GAIN.error * (turn - rate)
    -- Steering takes precedence: forward thrust uses what remains of both sides.
    local aside = clamp(torque / (2 * HALF_TRACK), -26, 26)
    local each = clamp(force / 2, -19.88 + math.abs(aside), 33.6 - math.abs(aside))
    local left = sim.callScriptFunction('commandFor', drives, each - aside)
    local right = sim.callScriptFunction('commandFor', drives, each + aside)
    sim.callScriptFunction('setCommands', drives, left, right)
end
