-- Measurements of the TurtleBot3 Burger. Each one runs in a separate world that contains a floor and the robot.

local function robot() return sim.getObject('/turtlebot3_burger') end

-- Drives straight, and accelerates or brakes by 1 m/s^2 to a speed, so that no wheel slips.
local speed = 0
local function accelerate(to)
    while speed ~= to do
        speed = speed + math.max(-0.05, math.min(0.05, to - speed))
        tatu.drive(robot(), speed, 0, 0)
        sim.wait(0.05)
    end
end

-- Mean speed over a number of seconds.
local function speed_over(seconds)
    local from = sim.getObjectPosition(robot())
    sim.wait(seconds)
    return measure.distance(from, sim.getObjectPosition(robot())) / seconds
end

function mass() return measure.mass(robot()) end

function rest_drift()
    sim.wait(1)
    return measure.drift(robot(), 60)
end

function top_speed()
    tatu.drive(robot(), 0.22, 0, 0)
    sim.wait(1)
    return speed_over(8)
end

function turning_rate()
    tatu.drive(robot(), 0, 0, 2.84)
    sim.wait(1)
    local from, start = measure.angle(robot()), sim.getSimulationTime()
    while sim.getSimulationTime() < start + 8 do
        sim.step()
        measure.angle(robot())
    end
    return (measure.angle(robot()) - from) / (sim.getSimulationTime() - start)
end

-- Half of the maximum distance between any two points of the path, over more than one turn.
function circle_radius()
    tatu.drive(robot(), 0.2, 0, 0.5)
    sim.wait(1)
    local from, far = sim.getObjectPosition(robot()), 0
    for _ = 1, 280 do
        sim.step()
        far = math.max(far, measure.distance(from, sim.getObjectPosition(robot())))
    end
    return far / 2
end

function odometry()
    local from = sim.getObjectPosition(robot())
    local function angle()
        local sum = 0
        for _, side in ipairs{'left', 'right'} do
            local joint = '/turtlebot3_burger/wheel_' .. side .. '_joint/'
            sum = sum + tatu.read(sim.getObject(joint .. 'wheel_' .. side .. '_encoder')).position
        end
        return sum / 2
    end
    sim.wait(0.5)
    local start = angle()
    from = sim.getObjectPosition(robot())
    accelerate(0.2)
    sim.wait(10)
    accelerate(0)
    sim.wait(1)
    return 0.033 * (angle() - start) / measure.distance(from, sim.getObjectPosition(robot()))
end

-- Distances of the beam straight ahead, from scans of a wall whose face is 1.5 m ahead of the scanner.
local function scans(count)
    local wall = sim.createPrimitiveShape(sim.primitiveshape_cuboid, {0.1, 2, 0.5})
    local scanner = sim.getObject('/turtlebot3_burger/base_scan')
    sim.setObjectPosition(wall, {sim.getObjectPosition(scanner)[1] + 1.5 + 0.05, 0, 0.25})
    sim.wait(0.5)
    local list, seen = {}, tatu.read(scanner).sequence
    while #list < count do
        sim.step()
        local scan = tatu.read(scanner)
        if scan.sequence ~= seen then
            seen = scan.sequence
            list[#list + 1] = scan.distance[181]     -- 0 degrees: the first beam points straight back
        end
    end
    return list
end

local function mean(list)
    local sum = 0
    for _, x in ipairs(list) do sum = sum + x end
    return sum / #list
end

function scan_distance() return mean(scans(50)) end

function scan_spread()
    local list = scans(200)
    local m, sum = mean(list), 0
    for _, x in ipairs(list) do sum = sum + (x - m) ^ 2 end
    return math.sqrt(sum / (#list - 1))
end

-- A block of 15 kg rests on top, above the middle of the plates.
function payload()
    local load = sim.createPrimitiveShape(sim.primitiveshape_cuboid, {0.12, 0.12, 0.1})
    sim.setObjectInt32Param(load, sim.shapeintparam_static, 0)
    sim.setObjectInt32Param(load, sim.shapeintparam_respondable, 1)
    sim.setShapeMass(load, 15)
    local p = sim.getObjectPosition(robot())
    sim.setObjectPosition(load, {p[1] - 0.032, p[2], 0.192 + 0.0505})
    sim.wait(1)
    accelerate(0.22)
    sim.wait(1)
    return speed_over(8)
end

function turn_rate_of_imu()
    tatu.drive(robot(), 0, 0, 1)
    sim.wait(1)
    local imu, sum, n = sim.getObject('/turtlebot3_burger/imu_link'), 0, 0
    for _ = 1, 200 do
        sim.step()
        sum, n = sum + tatu.read(imu).angular_velocity[3], n + 1
    end
    return sum / n
end
