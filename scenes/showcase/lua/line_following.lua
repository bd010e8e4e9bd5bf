-- Follows a black line with two floor sensors, and drives around obstacles on it with the infrared sensors.
--
-- Both floor sensors read dark on the line; the one that turns bright has left it (PD control). In front of an
-- obstacle, the robot turns to the left until the path is clear, drives an arc to the right at a distance from the
-- obstacle, and crosses the line behind it. The Thymio has no encoders, so motions without sensor contact are timed.

local RADIUS = 0.021            -- m, of the wheels
local TOP_SPEED = 9.53          -- rad/s
local CRUISE = 8.0              -- rad/s, on the line
local GAIN = 4.5                -- rad/s of the wheels, if one sensor is bright and the other dark
local GAIN_CHANGE = 0.15        -- rad/s of the wheels, per change of the difference in a second
local SLOWER = 0.4              -- fraction of CRUISE, if one sensor is bright
local BRIGHT, DARK = 0.75, 0.10 -- readings of white floor and tape
local SEARCH = 3.5              -- rad/s of the wheels, turning on the spot when the line is lost

local STOP = 0.055              -- m: distance to an obstacle ahead at which evasion starts
local SPIN = 3.0                -- rad/s, turning on the spot
local FARTHER = 0.35            -- s for which the robot keeps turning after the path is clear
local AROUND = 5.0              -- rad/s of the wheels, around the obstacle
local KEEP = 0.075              -- m, target distance of the rightmost sensor from the obstacle
local GAIN_KEEP = 60            -- rad/s per m
local BACK_TURN = 1.1           -- rad/s: turn to the right while the obstacle is not detected
local LEAVE = 1.5               -- s after the start of evasion, from which the line is detected again
local SENSORS_AHEAD = 0.074     -- m, distance of the floor sensors ahead of the axle

local GREEN, YELLOW, RED = {0.20, 0.90, 0.35}, {0.95, 0.80, 0.20}, {0.95, 0.20, 0.15}

function sysCall_init()
    left, right = sim.getObject(':/motor_left'), sim.getObject(':/motor_right')
    ground, strips = sim.getObject(':/prox_ground'), sim.getObject(':/leds_top')
    infrared = {}
    for i = 0, 4 do infrared[i] = sim.getObject(':/prox_horizontal_' .. i) end
    state, since = 'follow', 0
    last_off, side, free_at = 0, 1, 0   -- side of the last line detection: 1 left, -1 right
end

local function limit(value, most)
    return math.max(-most, math.min(most, value))
end

-- 0 on the tape, 1 on the white floor.
local function brightness(value)
    return math.max(0, math.min(1, (value - DARK) / (BRIGHT - DARK)))
end

-- Returns the distances of the five front infrared sensors, from left to right; infinity if nothing is detected.
local function look_around()
    local d = {}
    for i = 0, 4 do
        local found, distance = sim.readProximitySensor(infrared[i])
        d[i] = found == 1 and distance or math.huge
    end
    return d
end

-- Each state function receives the brightness on the left and right, the infrared distances and the time in this state.
-- It returns the speed and the difference of the wheels (rad/s, positive turns left), and the next state.
local states, lamps = {}, {follow = GREEN, turn_away = RED, around = RED, cross = YELLOW, align = YELLOW}

function states.follow(l, r, d)
    if math.min(d[1], d[2], d[3]) < STOP then return 0, 0, 'turn_away' end
    if l > 0.9 and r > 0.9 then return 0, SEARCH * side, 'follow' end
    local off = r - l           -- positive: the line is to the left
    local change = (off - last_off) / sim.getSimulationTimeStep()
    last_off = off
    if math.abs(off) > 0.2 then side = off > 0 and 1 or -1 end
    return CRUISE * (1 - SLOWER * math.abs(off)), GAIN * off + GAIN_CHANGE * change, 'follow'
end

-- To the left until ahead and right are free, and a little farther, so that the robot does not touch the corner.
function states.turn_away(l, r, d, lasted)
    if math.min(d[1], d[2], d[3], d[4]) < math.huge then free_at = lasted + FARTHER end
    return 0, SPIN, lasted > free_at and 'around' or 'turn_away'
end

function states.around(l, r, d, lasted)
    if lasted > LEAVE and (l < 0.3 or r < 0.3) then return AROUND, 0, 'cross' end
    if math.min(d[1], d[2], d[3]) < STOP then return 0, SPIN, 'around' end
    if d[4] == math.huge then return AROUND, -BACK_TURN, 'around' end
    return AROUND, limit(GAIN_KEEP * (KEEP - d[4]), SPIN), 'around'
end

-- Straight on until the axle is on the line.
function states.cross(l, r, d, lasted)
    return AROUND, 0, lasted * AROUND * RADIUS > SENSORS_AHEAD and 'align' or 'cross'
end

-- To the left until the line is below both sensors.
function states.align(l, r)
    side = 1
    return 0, SPIN, (l < 0.5 and r < 0.5) and 'follow' or 'align'
end

function sysCall_actuation()
    local reading = tatu.read(ground)
    if reading.sequence == 0 then return end
    local l, r = brightness(reading.value[1]), brightness(reading.value[2])
    local now = sim.getSimulationTime()
    local speed, turn, next_state = states[state](l, r, look_around(), now - since)
    if next_state ~= state then
        state, since, last_off = next_state, now, 0
        sim.setObjectColor(strips, 0, sim.colorcomponent_ambient_diffuse, lamps[state])
    end
    sim.setJointTargetVelocity(left, limit(speed - turn, TOP_SPEED))
    sim.setJointTargetVelocity(right, limit(speed + turn, TOP_SPEED))
end
