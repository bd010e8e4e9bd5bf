-- Measurements of BubbleRob.

local AXLE = 0.05    -- m, the axle ahead of the base's origin

local function wheels(left, right)
    sim.setJointTargetVelocity(sim.getObject('/bubbleRob/leftMotor'), left)
    sim.setJointTargetVelocity(sim.getObject('/bubbleRob/rightMotor'), right)
end

-- Mean speed over some seconds, once the motion is steady.
local function meanSpeed(seconds)
    local robot = measure.model()
    sim.wait(2)
    local from = sim.getObjectPosition(robot)
    sim.wait(seconds)
    return measure.distance(from, sim.getObjectPosition(robot)) / seconds
end

local function meanTurn(seconds)
    local robot = measure.model()
    local from, time = measure.angle(robot), sim.getSimulationTime()
    while sim.getSimulationTime() < time + seconds do
        sim.step()
        measure.angle(robot)
    end
    return (measure.angle(robot) - from) / (sim.getSimulationTime() - time)
end

-- Moves the slider of the robot's window, as a user does.
local function moveSlider(position)
    sim.step()
    tatu.actOnWindow(tatu.windows()[1].window, 2, 'change', position)    -- 1 is its label
end

-- Puts a cylinder of the tutorial in front of the nose, so that the robot backs up at once.
local function cylinderAhead(distance)
    local cylinder = sim.createPrimitiveShape(sim.primitiveshape_cylinder, {0.1, 0.1, 0.2})
    sim.setObjectPosition(cylinder, {0.1 + distance + 0.05, 0, 0.1})
    return cylinder
end

function mass()
    return measure.mass(measure.model())
end

function rest_drift()
    sim.wait(1)
    return measure.drift(measure.model(), 60)
end

function straight_speed()
    wheels(2, 2)
    return meanSpeed(5)
end

function turning_rate()
    wheels(-2, 2)
    sim.wait(1)
    return meanTurn(10)
end

function start_speed()
    return meanSpeed(5)
end

function top_speed()
    moveSlider(100)
    return meanSpeed(5)
end

function least_speed()
    moveSlider(0)
    return meanSpeed(5)
end

function backing_turn()
    cylinderAhead(0.14)
    sim.wait(1)
    return meanTurn(2)
end

function backing_radius()
    cylinderAhead(0.14)
    sim.wait(1)
    local robot = measure.model()
    local function axle()
        local m = sim.getObjectMatrix(robot)
        return {m[4] + AXLE * m[1], m[8] + AXLE * m[5], 0}
    end
    local from, angle, way = axle(), measure.angle(robot), 0
    local last = from
    for _ = 1, 40 do
        sim.step()
        local now = axle()
        way = way + measure.distance(last, now)
        last = now
    end
    return way / math.abs(measure.angle(robot) - angle)
end

function backing_time()
    local cylinder = cylinderAhead(0.14)
    sim.wait(0.5)
    sim.removeObjects({cylinder})
    local from = sim.getSimulationTime()
    local motor = sim.getObject('/bubbleRob/leftMotor')
    while sim.getJointTargetVelocity(motor) < 0 do sim.step() end
    return sim.getSimulationTime() - from
end

function nose_range()
    local nose = sim.getObject('/bubbleRob/sensingNose')
    local wall = sim.createPrimitiveShape(sim.primitiveshape_cuboid, {0.02, 0.5, 0.5})
    local far = 0.2
    repeat
        far = far - 0.0005
        sim.setObjectPosition(wall, {0.1 + far + 0.01, 0, 0.25})
        sim.step()
        sim.step()
    until sim.readProximitySensor(nose) == 1
    return far
end

function nose_angle()
    local nose = sim.getObject('/bubbleRob/sensingNose')
    local pole = sim.createPrimitiveShape(sim.primitiveshape_cylinder, {0.001, 0.001, 0.3})
    local first, last
    for tenths = -250, 250 do
        local a = math.rad(tenths / 10)
        sim.setObjectPosition(pole, {0.1 + 0.1 * math.cos(a), 0.1 * math.sin(a), 0.15})
        sim.step()
        sim.step()
        if sim.readProximitySensor(nose) == 1 then
            first, last = first or a, a
        end
    end
    return last - first
end

function image_width()
    local cylinder = cylinderAhead(0.35)
    sim.setObjectColor(cylinder, 0, sim.colorcomponent_ambient_diffuse, {0.9, 0.9, 0.9})
    sim.wait(0.5)
    local image, size = sim.getVisionSensorImg(sim.getObject('/bubbleRob/vision'))
    -- The image row of the horizon, which shows the two edges of the cylinder.
    local first, last
    for column = 1, size[1] do
        if image:byte((size[2] // 2 * size[1] + column - 1) * 3 + 1) > 127 then
            first, last = first or column, column
        end
    end
    return last - first
end
