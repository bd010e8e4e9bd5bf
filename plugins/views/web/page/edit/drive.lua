-- Drives ahead, and turns away from what the proximity sensors in front see. Change it and press Ctrl+S, also while it runs.

local SPEED = 0.3           -- m/s
local TURN = 0.8            -- rad/s, away from obstacles
local CURVE = 0.15          -- rad/s, for robots without sensors, which stay near this way
local NEAR = 0.6            -- m: obstacles closer than this matter
local STOP = 0.3            -- m: with an obstacle closer than this, the robot turns on the spot

function sysCall_init()
    robot = sim.getObject(':')
    sensors = {}            -- each with its direction, seen from the robot
    for _, sensor in ipairs(sim.getObjectsInTree(robot, sim.object_proximitysensor_type)) do
        local m = sim.getObjectMatrix(sensor, robot)
        local ahead, left = m[3], m[7]
        if ahead > 0.2 then sensors[#sensors + 1] = {handle = sensor, left = left} end
    end
    side = 0                -- 1 or -1 while the robot turns on the spot, to the left or right
end

function sysCall_actuation()
    local nearest, from_left, from_right = NEAR, 0, 0
    for _, sensor in ipairs(sensors) do
        local seen, distance = sim.readProximitySensor(sensor.handle)
        if seen == 1 and distance < NEAR then
            nearest = math.min(nearest, distance)
            local push = 1 - distance / NEAR
            if sensor.left > 0 then from_left = from_left + push else from_right = from_right + push end
        end
    end
    -- A side that was chosen is kept until the way is free, otherwise the robot would swing to and fro in a corner.
    if nearest > (STOP + NEAR) / 2 then side = 0 end
    if nearest < STOP and side == 0 then side = from_left > from_right and -1 or 1 end
    if #sensors == 0 then
        tatu.drive(robot, SPEED, 0, CURVE)
    elseif side ~= 0 then
        tatu.drive(robot, 0, 0, side * TURN)
    else
        local away = math.max(-1, math.min(1, from_right - from_left))
        tatu.drive(robot, SPEED * nearest / NEAR, 0, away * TURN)
    end
end
