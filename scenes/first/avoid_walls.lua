-- Drives ahead, and steers away from obstacles that the front sonars detect.
-- Each sonar slows the wheel on the other side: the nearer an obstacle, the more.

local far, near = 0.6, 0.2   -- m: no reaction beyond, full reaction within
local cruise = 3.0           -- rad/s of both wheels with nothing in sight

function sysCall_init()
    sonars = {}
    for i = 1, 8 do
        sonars[i] = sim.getObject('./Pioneer_p3dx_ultrasonicSensor' .. i)
    end
    left = sim.getObject('./Pioneer_p3dx_leftMotor')
    right = sim.getObject('./Pioneer_p3dx_rightMotor')
end

-- Returns 0 if nothing is near, up to 1 if an obstacle is very near.
local function nearness(sonar)
    local seen, distance = sim.readProximitySensor(sonar)
    if seen < 1 or distance > far then return 0 end
    return math.min(1, (far - distance) / (far - near))
end

function sysCall_actuation()
    local turn_right, turn_left, ahead = 0, 0, 0
    for i = 1, 4 do turn_right = turn_right + i * nearness(sonars[i]) end
    for i = 5, 8 do turn_left = turn_left + (9 - i) * nearness(sonars[i]) end
    ahead = math.max(nearness(sonars[4]), nearness(sonars[5]))
    local turn = 0.8 * (turn_right - turn_left)
    -- With an obstacle ahead, keep turning to one side until the path is clear: otherwise, corners cause oscillation.
    if ahead > 0 then
        side = side or (turn < 0 and -1 or 1)
        turn = side * math.max(1.5, math.abs(turn))
    else
        side = nil
    end
    local speed = cruise * (1 - ahead)
    sim.setJointTargetVelocity(left, speed + turn)
    sim.setJointTargetVelocity(right, speed - turn)
end
