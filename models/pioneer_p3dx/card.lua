-- Measurements for the card of the Pioneer.

local function wheels(left, right)
    sim.setJointTargetVelocity(sim.getObject('/Pioneer_p3dx_leftMotor'), left)
    sim.setJointTargetVelocity(sim.getObject('/Pioneer_p3dx_rightMotor'), right)
end

-- The mean velocity over some seconds, after two seconds in which the robot starts and the caster swings round.
local function mean_velocity(seconds)
    local robot = measure.model()
    sim.wait(2)
    local from, at = sim.getObjectPosition(robot), sim.getSimulationTime()
    sim.wait(seconds)
    local to, time = sim.getObjectPosition(robot), sim.getSimulationTime() - at
    return (to[1] - from[1]) / time, (to[2] - from[2]) / time
end

function mass()
    return measure.mass(measure.model())
end

function rest_drift()
    sim.wait(1)
    return measure.drift(measure.model(), 60)
end

function top_speed()
    wheels(12.3, 12.3)
    return (mean_velocity(4))
end

function straight_speed()
    wheels(2, 2)
    return (mean_velocity(5))
end

function sideways()
    wheels(2, 2)
    local ahead, left = mean_velocity(5)
    return left / ahead
end

function turning_rate()
    wheels(-2, 2)
    sim.wait(2)
    local _, angle = measure.motion(measure.model(), 100)
    return angle / (100 * sim.getSimulationTimeStep())
end

-- A wall approaches by 1 mm per step, until sonar 5 detects it.
function sonar_range()
    local sonar = sim.getObject('/Pioneer_p3dx_ultrasonicSensor5')
    local wall = sim.createPrimitiveShape(sim.primitiveshape_cuboid, {0.1, 2, 1})
    sim.setObjectInt32Param(wall, sim.shapeintparam_static, 1)
    sim.setBoolProperty(wall, 'shape.detectable', true)
    local at = sim.getObjectPosition(sonar)
    local turn = math.rad(10)
    for distance = 1.05, 0.9, -0.001 do
        -- The wall is perpendicular to the line of sight.
        local x, y = at[1] + (distance + 0.05) * math.cos(turn), at[2] - (distance + 0.05) * math.sin(turn)
        sim.setObjectPosition(wall, {x, y, 0.5})
        sim.setObjectOrientation(wall, {0, 0, -turn})
        sim.step()
        if sim.readProximitySensor(sonar) == 1 then return distance end
    end
    error('sonar 5 sees no wall')
end
