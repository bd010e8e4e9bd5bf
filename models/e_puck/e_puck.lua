-- The e-puck's controller: drives around obstacles that its infrared sensors detect, and lights the LEDs on that side.
--
-- It works on counts, as the real robot does: 0 to 4095, higher at closer range. The real sensors return counts only;
-- the simulated ones measure the distance, and the table below converts it to counts.

local CRUISE = 0.6               -- of the top speed
local WEIGHTS = {                -- fractions of the top speed, for 1000 counts of ps0 to ps7, added to the left wheel;
                                 -- the right one mirrors them
    [0] = -0.60, -0.40, -0.12, 0, 0, 0.12, 0.30, 0.30,
}
local NEAR = 100                 -- counts from which an LED is lit, 55 mm
-- In front of a wall perpendicular to the path, the weights of both sides cancel out: the robot turns on the spot until
-- the path is clear.
local BLOCKED = 500              -- counts of one of the four sensors ahead, 17 mm
local FREE = 200                 -- counts below which the robot drives on, 35 mm
local SPIN = 0.4                 -- of the top speed

-- Pairs of distance in mm and counts: Webots' E-puckDistanceSensor.proto.
local TABLE = {
    {0, 4095}, {5, 2133.33}, {10, 1465.73}, {15, 601.46}, {20, 383.84}, {30, 234.93}, {40, 158.03}, {50, 120},
    {60, 104.09}, {70, 67.19},
}
local LIT, DARK = {1.0, 0.16, 0.10}, {0.42, 0.10, 0.10}

-- The LEDs beside each sensor, 0 to 7.
local LEDS = {[0] = 0, 1, 2, 3, 5, 6, 7, 0}

local function counts(distance)
    local mm = distance * 1000
    for i = 2, #TABLE do
        local low, high = TABLE[i - 1], TABLE[i]
        if mm <= high[1] then return low[2] + (high[2] - low[2]) * (mm - low[1]) / (high[1] - low[1]) end
    end
    return 0
end

function sysCall_init()
    left, right = sim.getObject(':/ePuck_leftJoint'), sim.getObject(':/ePuck_rightJoint')
    topSpeed = tonumber(sim.readCustomStringData(sim.getObject('..'), 'top_speed'))
    sensors, leds, lit = {}, {}, {}
    for i = 0, 7 do
        -- Of V-REP's sensors, 1 is on the left and 4 is ahead on the right: ps0.
        sensors[i] = sim.getObject(':/ps' .. i, {noError = true})
        if sensors[i] < 0 then sensors[i] = sim.getObject(':/ePuck_proxSensor' .. (i + 3) % 8 + 1, {noError = true}) end
        leds[i] = sim.getObject(':/ePuck_led' .. i)
    end
    turning = 0                  -- 0: driving; 1, -1: turning to the left or right until the path is clear
end

local function readAll()
    local values = {}
    for i = 0, 7 do
        local seen, distance = 0, nil
        if sensors[i] >= 0 then seen, distance = sim.readProximitySensor(sensors[i]) end
        values[i] = seen == 1 and counts(distance) or 0
    end
    return values
end

local function light(values)
    local wanted = {}
    for i = 0, 7 do
        if values[i] >= NEAR then wanted[LEDS[i]] = true end
    end
    for k = 0, 7 do
        if wanted[k] ~= lit[k] then
            sim.setObjectColor(leds[k], 0, sim.colorcomponent_ambient_diffuse, wanted[k] and LIT or DARK)
            lit[k] = wanted[k]
        end
    end
end

function sysCall_actuation()
    local values = readAll()
    light(values)
    local ahead = math.max(values[0], values[1], values[6], values[7])
    if turning == 0 and ahead > BLOCKED then
        turning = values[0] + values[1] >= values[6] + values[7] and 1 or -1
    elseif turning ~= 0 and ahead < FREE then
        turning = 0
    end
    local l, r = CRUISE, CRUISE
    if turning ~= 0 then
        l, r = -SPIN * turning, SPIN * turning
    else
        for i = 0, 7 do
            l = l + WEIGHTS[i] * values[i] / 1000
            r = r + WEIGHTS[7 - i] * values[i] / 1000
        end
    end
    sim.setJointTargetVelocity(left, topSpeed * math.max(-1, math.min(1, l)))
    sim.setJointTargetVelocity(right, topSpeed * math.max(-1, math.min(1, r)))
end
