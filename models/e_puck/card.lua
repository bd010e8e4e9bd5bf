-- Measurements of the e-puck.

local function motors(left, right)
    sim.setJointTargetVelocity(sim.getObject('/ePuck/ePuck_leftJoint'), left)
    sim.setJointTargetVelocity(sim.getObject('/ePuck/ePuck_rightJoint'), right)
end

local function speedAt(turning)
    motors(turning, turning)
    sim.wait(1)
    local from = sim.getObjectPosition(measure.model())
    sim.wait(4)
    return measure.distance(from, sim.getObjectPosition(measure.model())) / 4
end

-- Rotation of the robot within some seconds, rad.
local function turned(seconds)
    local robot = measure.model()
    local from, start = measure.angle(robot), sim.getSimulationTime()
    while sim.getSimulationTime() < start + seconds - 1e-9 do
        sim.step()
        measure.angle(robot)
    end
    return measure.angle(robot) - from
end

-- Adds a wall perpendicular to y, whose face is at a distance to the right of a position.
local function wallOnTheRight(y)
    local wall = sim.createPrimitiveShape(sim.primitiveshape_cuboid, {0.3, 0.02, 0.1})
    sim.setObjectPosition(wall, {0, y - 0.01, 0.05})
    return wall
end

-- Mean and standard deviation of the distances that a sensor measures.
local function spread(sensor, count)
    local sum, squares, n = 0, 0, 0
    while n < count do
        sim.step()
        local seen, distance = sim.readProximitySensor(sensor)
        if seen == 1 then
            sum, squares, n = sum + distance, squares + distance * distance, n + 1
        end
    end
    return sum / n, math.sqrt(squares / n - (sum / n) ^ 2)
end

function mass()
    return measure.mass(measure.model())
end

mass_2 = mass

function rest_drift()
    sim.wait(1)
    return measure.drift(measure.model(), 60)
end

function top_speed()
    return speedAt(6.28)
end

function top_speed_2()
    return speedAt(7.536)
end

function turning_rate()
    motors(-6.28, 6.28)
    sim.wait(1)
    return turned(5) / 5
end

function arc_radius()
    motors(2, 4)
    sim.wait(1)
    local way, angle = measure.motion(measure.model(), 100)
    return way / angle
end

function encoder_steps()
    local robot, encoder = measure.model(), sim.getObject('/ePuck/ePuck_leftJoint/left_encoder')
    motors(6, 6)
    sim.wait(1)
    local from, ticks = sim.getObjectPosition(robot), tatu.read(encoder).ticks
    sim.wait(5)
    return (tatu.read(encoder).ticks - ticks) / measure.distance(from, sim.getObjectPosition(robot))
end

function slip_when_blocked()
    local wall = sim.createPrimitiveShape(sim.primitiveshape_cuboid, {0.02, 0.3, 0.1})
    sim.setObjectInt32Param(wall, sim.shapeintparam_respondable, 1)
    sim.setObjectPosition(wall, {0.05, 0, 0.05})
    motors(3, 3)
    sim.wait(2)
    local encoder = sim.getObject('/ePuck/ePuck_leftJoint/left_encoder')
    local from = tatu.read(encoder).position
    sim.wait(1)
    return tatu.read(encoder).position - from
end

-- ps2 faces to the right from y = -31 mm, and up by 9.2 degrees.
function infrared_range()
    local sensor, far = sim.getObject('/ePuck/ps2'), 0.08
    sim.setStringProperty(sensor, 'sensor.noise', 'none')
    local wall = wallOnTheRight(-0.031 - far)
    while true do
        sim.setObjectPosition(wall, {0, -0.031 - far - 0.01, 0.05})
        sim.step()
        sim.step()
        local seen, distance = sim.readProximitySensor(sensor)
        if seen == 1 then return distance end
        far = far - 0.0002
    end
end

function infrared_noise()
    local sensor = sim.getObject('/ePuck/ps2')
    -- A wall whose nearest point within the cone is 30 mm away.
    wallOnTheRight(-0.031 - 0.03 * math.cos(math.rad(9.2) - 0.05))
    sim.step()
    local _, deviation = spread(sensor, 1000)
    return deviation
end

function tof_noise()
    local wall = sim.createPrimitiveShape(sim.primitiveshape_cuboid, {0.02, 1, 1})
    sim.setObjectPosition(wall, {0.034 + 1.01, 0, 0.5})
    sim.step()
    local _, deviation = spread(sim.getObject('/ePuck/tof'), 1000)
    return deviation
end

function ground_contrast()
    local function mean(color)
        local sheet = sim.createPrimitiveShape(sim.primitiveshape_cuboid, {0.2, 0.2, 0.0002})
        sim.setObjectColor(sheet, 0, sim.colorcomponent_ambient_diffuse, color)
        sim.setObjectPosition(sheet, {0, 0, 0})
        sim.step()
        local sum = 0
        for _ = 1, 200 do
            sim.step()
            sum = sum + tatu.read(sim.getObject('/ePuck/gs')).value[2]
        end
        sim.removeObjects({sheet})
        return sum / 200
    end
    return mean({1, 1, 1}) - mean({0, 0, 0})
end
