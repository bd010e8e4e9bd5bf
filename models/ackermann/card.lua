-- Measurements of the race car. Each one runs in a separate world that contains a floor and the car.

local RADIUS = 0.05             -- m, of the wheels
local COM_X = 0.17145           -- m, of the centre of mass ahead of the rear axle

local function car() return sim.getObject('/racecar') end

local function drive(speed, steering)
    sim.setJointTargetVelocity(sim.getObject('/racecar/motor_joint'), speed / RADIUS)
    sim.setJointTargetPosition(sim.getObject('/racecar/steering_joint'), steering or 0)
end

-- Accelerates from rest by 2.5 m/s^2.
local function accelerate(speed, steering)
    local v, dt = 0, sim.getSimulationTimeStep()
    while v < speed do
        v = math.min(speed, v + 2.5 * dt)
        drive(v, steering)
        sim.step()
    end
end

function mass() return measure.mass(car()) end

function centre_of_mass()
    local sum, total = 0, 0
    for _, shape in ipairs(sim.getObjectsInTree(car(), sim.object_shape_type)) do
        if tatu.get(shape, 'shape.dynamic') then
            local m, c = tatu.get(shape, 'shape.mass'), tatu.get(shape, 'shape.com')
            local p = sim.multiplyVector(sim.getObjectMatrix(shape), c)
            sum, total = sum + m * p[1], total + m
        end
    end
    return sum / total - sim.getObjectPosition(car())[1]
end

function rest_drift()
    sim.wait(1)
    return measure.drift(car(), 60)
end

function top_speed()
    for v = 0.1, 5.04, 0.1 do
        tatu.drive(car(), v, 0, 0)
        sim.step()
    end
    tatu.drive(car(), 5.04, 0, 0)
    sim.wait(2)
    local from = sim.getObjectPosition(car())
    sim.wait(4)
    return measure.distance(from, sim.getObjectPosition(car())) / 4
end

function acceleration()
    sim.wait(0.5)
    local start = sim.getSimulationTime()
    drive(60)
    while measure.speed(car()) < 3 do sim.step() end
    return measure.speed(car()) / (sim.getSimulationTime() - start)
end

function straightness()
    accelerate(3)
    sim.wait(20 / 3)
    return math.abs(sim.getObjectPosition(car())[2])
end

-- Distance travelled by the rear axle, divided by the angle through which the car turns.
local function radius(speed, steering)
    accelerate(speed, steering)
    sim.wait(2)
    local way, last, from = 0, sim.getObjectPosition(car()), measure.angle(car())
    for _ = 1, 200 do
        sim.step()
        local p = sim.getObjectPosition(car())
        way, last = way + measure.distance(p, last), p
        measure.angle(car())
    end
    return way / math.abs(measure.angle(car()) - from)
end

function least_radius_left() return radius(1, 0.4189) end

function least_radius_right() return radius(1, -0.4189) end

function radius_at_0_2() return radius(2, 0.2) end

local function wheel_angle(side)
    drive(0, 0.4189)
    sim.wait(1)
    return sim.getJointPosition(sim.getObject('/racecar/' .. side .. '_steering_hinge_joint'))
end

function inner_wheel() return wheel_angle('left') end

function outer_wheel() return wheel_angle('right') end

function steering_rate()
    local servo = sim.getObject('/racecar/steering_joint')
    drive(0, -0.4189)
    sim.wait(1)
    drive(0, 0.4189)
    local low, high = -0.6 * 0.4189, 0.6 * 0.4189
    while sim.getJointPosition(servo) < low do sim.step() end
    local from, start = sim.getJointPosition(servo), sim.getSimulationTime()
    while sim.getJointPosition(servo) < high do sim.step() end
    return (sim.getJointPosition(servo) - from) / (sim.getSimulationTime() - start)
end

-- Maximum product of speed and turning rate while the speed grows slowly beyond the grip of the tyres.
function grip()
    local most = 0
    for v = 1, 5, 0.01 do
        drive(v, 0.2)
        sim.step()
        local linear, angular = sim.getVelocity(car())
        most = math.max(most, math.sqrt(linear[1] ^ 2 + linear[2] ^ 2) * math.abs(angular[3]))
    end
    return most
end

function scan_range()
    local wall = sim.createPrimitiveShape(sim.primitiveshape_cuboid, {0.1, 2, 0.5})
    local scanner = sim.getObject('/racecar/laser')
    sim.setObjectPosition(wall, {sim.getObjectPosition(scanner)[1] + 25.05, 0, 0.25})
    sim.wait(0.5)
    local sum = 0
    for _ = 1, 100 do
        sim.step()
        sum = sum + tatu.read(scanner).distance[541]     -- 0 degrees
    end
    return sum / 100
end
