-- Measurements of the Thymio.

local AHEAD = 0.07355            -- m, from the axle to the ground sensors
local BLACK, WHITE = {0, 0, 0}, {1, 1, 1}

local function motors(left, right)
    sim.setJointTargetVelocity(sim.getObject('/Thymio/motor_left'), left)
    sim.setJointTargetVelocity(sim.getObject('/Thymio/motor_right'), right)
end

-- Adds a flat sheet on the floor, detected by the ground sensors only. `top` is the height of its upper face.
local function sheet(size, place, heading, color, top)
    local s = sim.createPrimitiveShape(sim.primitiveshape_cuboid, {size[1], size[2], 0.0002})
    sim.setObjectPosition(s, {place[1], place[2], top - 0.0001})
    sim.setObjectOrientation(s, {0, 0, heading})
    sim.setObjectColor(s, 0, sim.colorcomponent_ambient_diffuse, color)
    return s
end

-- The mean reading of a spot of the ground sensors.
local function spot(index, count)
    local sum = 0
    for _ = 1, count do
        sim.step()
        sum = sum + tatu.read(sim.getObject('/Thymio/prox_ground')).value[index]
    end
    return sum / count
end

local function wallAhead(x)
    local wall = sim.createPrimitiveShape(sim.primitiveshape_cuboid, {0.02, 0.4, 0.2})
    sim.setObjectPosition(wall, {x + 0.01, 0, 0.1})
    return wall
end

-- Position of the ground sensors, m.
local function nose()
    local m = sim.getObjectMatrix(measure.model())
    return m[4] + AHEAD * m[1], m[8] + AHEAD * m[5]
end

function mass()
    return measure.mass(measure.model())
end

function rest_drift()
    sim.wait(1)
    return measure.drift(measure.model(), 60)
end

function top_speed()
    motors(9.53, 9.53)
    sim.wait(1)
    local from = sim.getObjectPosition(measure.model())
    sim.wait(4)
    return measure.distance(from, sim.getObjectPosition(measure.model())) / 4
end

function turning_rate()
    motors(-9.53, 9.53)
    sim.wait(1)
    local _, angle = measure.motion(measure.model(), 100)
    return angle / (100 * sim.getSimulationTimeStep())
end

function arc_radius()
    motors(3, 6)
    sim.wait(1)
    local way, angle = measure.motion(measure.model(), 100)
    return way / angle
end

function ground_white()
    sheet({0.3, 0.3}, {0, 0}, 0, WHITE, 0.0001)
    sim.step()
    return spot(1, 200)
end

function ground_grey()
    sheet({0.3, 0.3}, {0, 0}, 0, {0.5, 0.5, 0.5}, 0.0001)
    sim.step()
    return spot(1, 200)
end

function ground_edge()
    sheet({0.4, 0.4}, {0, 0}, 0, WHITE, 0.0001)
    local edge, black = 0.03, sheet({0.4, 0.2}, {0, 0.2}, 0, BLACK, 0.0003)
    repeat
        edge = edge - 0.0001
        sim.setObjectPosition(black, {0, edge + 0.1, 0.0002})
        sim.step()
    until spot(1, 2) < 0.3
    return edge
end

function infrared_range()
    local sensor = sim.getObject('/Thymio/prox_horizontal_2')
    sim.setStringProperty(sensor, 'sensor.noise', 'none')
    local far, wall = 0.12, wallAhead(0.3)
    repeat
        far = far - 0.0002
        sim.setObjectPosition(wall, {0.0816 + far + 0.01, 0, 0.1})
        sim.step()
        sim.step()
    until sim.readProximitySensor(sensor) == 1
    return far
end

function infrared_noise()
    local sensor = sim.getObject('/Thymio/prox_horizontal_2')
    wallAhead(0.0816 + 0.05)
    sim.step()
    local sum, squares = 0, 0
    for _ = 1, 1000 do
        sim.step()
        local _, distance = sim.readProximitySensor(sensor)
        sum, squares = sum + distance, squares + distance * distance
    end
    return math.sqrt(squares / 1000 - (sum / 1000) ^ 2)
end

function gravity()
    sim.wait(1)
    local a = tatu.read(sim.getObject('/Thymio/acc')).acceleration
    return math.sqrt(a[1] ^ 2 + a[2] ^ 2 + a[3] ^ 2)
end

-- A black ring on white, of 72 pieces; its centre is on the left of the robot.
function line_radius()
    local radius = 0.35
    sheet({1, 1}, {AHEAD, radius}, 0, WHITE, 0.0001)
    for k = 1, 72 do
        local a = 2 * math.pi * k / 72
        local place = {AHEAD + radius * math.sin(a), radius - radius * math.cos(a)}
        sheet({0.034, 0.045}, place, a, BLACK, 0.0003)
    end
    sim.wait(2)
    local sum = 0
    for _ = 1, 300 do
        sim.step()
        local x, y = nose()
        sum = sum + math.sqrt((x - AHEAD) ^ 2 + (y - radius) ^ 2)
    end
    return sum / 300
end

function waiting_distance()
    sheet({2, 1}, {0, 0}, 0, WHITE, 0.0001)
    sheet({2, 0.045}, {0, 0}, 0, BLACK, 0.0003)
    wallAhead(0.6)
    sim.wait(6)
    return 0.6 - sim.getObjectPosition(sim.getObject('/Thymio/prox_horizontal_2'))[1]
end
