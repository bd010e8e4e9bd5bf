-- The Thymio's controller: follows a dark line that is wider than the distance between its two ground sensors, 24 mm,
-- and waits in front of obstacles.
--
-- In the middle of a line of 45 mm, both sensors read dark; the one that turns bright has left the line on its side.

local CRUISE = 7.5               -- rad/s; the maximum is 9.53
local STEER = 5.0                -- rad/s added to one wheel and subtracted from the other, if only one sensor is bright
local SEARCH = 3.5               -- rad/s of the wheels, turning on the spot, when the line is lost
local OBSTACLE = 2000            -- counts of one of the three sensors ahead, 68 mm
local BRIGHT = 0.7               -- of the white floor's value; between DARK and BRIGHT, a sensor is partly on the line
local DARK = 0.1

-- Pairs of distance in mm and counts of the infrared sensors: Webots' Thymio2DistanceSensor.proto, every fourth pair.
local TABLE = {
    {0, 4235}, {13.3, 4253}, {26.7, 3733}, {40, 2965}, {53.3, 2475}, {66.7, 2044}, {80, 1597}, {90, 1195}, {93.3, 0},
}

local GREEN, YELLOW, RED = {0.20, 0.90, 0.35}, {0.95, 0.80, 0.20}, {0.95, 0.20, 0.15}
local LIT, UNLIT = {1.0, 0.85, 0.20}, {0.50, 0.45, 0.30}

local function counts(sensor)
    if sensor < 0 then return 0 end
    local seen, distance = sim.readProximitySensor(sensor)
    if seen ~= 1 then return 0 end
    local mm = distance * 1000
    for i = 2, #TABLE do
        local low, high = TABLE[i - 1], TABLE[i]
        if mm <= high[1] then return low[2] + (high[2] - low[2]) * (mm - low[1]) / (high[1] - low[1]) end
    end
    return 0
end

-- 0 on the line, 1 on a white floor.
local function brightness(value)
    return math.max(0, math.min(1, (value - DARK) / (BRIGHT - DARK)))
end

local function shine(color)
    if color == shown then return end
    sim.setObjectColor(strips, 0, sim.colorcomponent_ambient_diffuse, color)
    shown = color
end

-- Lights the lamp of the circle on the side to which the robot turns: 0 is ahead, 2 on the right, 6 on the left.
local function point(turn)
    local lamp = turn > 0.5 and 7 or turn < -0.5 and 1 or 0
    if lamp == pointed then return end
    if pointed then sim.setObjectColor(circle[pointed], 0, sim.colorcomponent_ambient_diffuse, UNLIT) end
    sim.setObjectColor(circle[lamp], 0, sim.colorcomponent_ambient_diffuse, LIT)
    pointed = lamp
end

function sysCall_init()
    left, right = sim.getObject(':/motor_left'), sim.getObject(':/motor_right')
    ground = sim.getObject(':/prox_ground', {noError = true})
    strips = sim.getObject(':/leds_top')
    ahead, circle = {}, {}
    for i = 1, 3 do ahead[i] = sim.getObject(':/prox_horizontal_' .. i, {noError = true}) end
    for i = 0, 7 do circle[i] = sim.getObject(':/led_circle_' .. i) end
    side = 1                     -- side on which the line was last detected: 1 left, -1 right
end

local function drive(cruise, turn)
    sim.setJointTargetVelocity(left, cruise - turn)
    sim.setJointTargetVelocity(right, cruise + turn)
end

function sysCall_actuation()
    local reading = ground >= 0 and tatu.read(ground)
    -- In the first step, nothing has been measured yet.
    if not reading or reading.sequence == 0 then return drive(0, 0) end
    local blocked = 0
    for i = 1, 3 do blocked = math.max(blocked, counts(ahead[i])) end
    if blocked > OBSTACLE then
        shine(RED)
        return drive(0, 0)
    end
    local l, r = brightness(reading.value[1]), brightness(reading.value[2])
    if l > 0.9 and r > 0.9 then
        shine(YELLOW)
        point(side)
        return drive(0, SEARCH * side)
    end
    -- A bright left sensor means that the line is on the right.
    if math.abs(l - r) > 0.2 then side = l < r and 1 or -1 end
    shine(GREEN)
    point(r - l)
    drive(CRUISE * (1 - 0.4 * math.abs(r - l)), STEER * (r - l))
end
