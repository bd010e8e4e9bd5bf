-- Measurements of the platform. Without its controller, the wheels hold their commanded speeds.

local WHEELS = {'fl', 'fr', 'bl', 'br'}
local TOP = 14.81        -- rad/s: maximum speed of a wheel

-- Accelerates the wheels to their speeds, rad/s, within a second: front left, front right, back left, back right.
local function spin(...)
    local start = sim.getSimulationTime()
    repeat
        local part = math.min(1, sim.getSimulationTime() - start)
        for i, speed in ipairs{...} do
            sim.setJointTargetVelocity(sim.getObject('/base_link/wheel_joint_' .. WHEELS[i]), part * speed)
        end
        sim.step()
    until part == 1
end

-- Returns the mean velocity of the platform over some seconds, in the world: ahead and left, m/s.
local function velocity(seconds)
    local base = measure.model()
    sim.wait(1)
    local from, start = sim.getObjectPosition(base), sim.getSimulationTime()
    sim.wait(seconds)
    local to, time = sim.getObjectPosition(base), sim.getSimulationTime() - start
    return (to[1] - from[1]) / time, (to[2] - from[2]) / time
end

function mass()
    return measure.mass(measure.model())
end

function rest_drift()
    return measure.drift(measure.model(), 60)
end

function ahead_speed()
    spin(TOP, TOP, TOP, TOP)
    return (velocity(4))
end

function sideways_speed()
    spin(-TOP, TOP, TOP, -TOP)
    local _, left = velocity(4)
    return left
end

-- Forward deviation per metre of sideways motion.
function sideways_stray()
    spin(-TOP, TOP, TOP, -TOP)
    local ahead, left = velocity(4)
    return ahead / left
end

-- The front left and the rear right wheel stand still.
function diagonal_speed()
    spin(0, TOP, TOP, 0)
    local ahead, left = velocity(4)
    return math.sqrt(ahead ^ 2 + left ^ 2)
end

function sideways_turn()
    spin(-TOP, TOP, TOP, -TOP)
    sim.wait(1)
    local base = measure.model()
    local from = measure.angle(base)
    sim.wait(4)
    return measure.angle(base) - from
end

function turning_rate()
    spin(-TOP, TOP, -TOP, TOP)
    sim.wait(1)
    local base = measure.model()
    local from, start = measure.angle(base), sim.getSimulationTime()
    while sim.getSimulationTime() < start + 6 do
        measure.angle(base)
        sim.step()
    end
    return (measure.angle(base) - from) / (sim.getSimulationTime() - start)
end

function turning_stray()
    spin(-5, 5, -5, 5)
    return measure.drift(measure.model(), 10)
end

-- The speed that the encoder of the front left wheel reports, compared with the speed over ground.
function encoder_speed()
    spin(10, 10, 10, 10)
    sim.wait(2)
    return tatu.read(sim.getObject('/base_link/encoder_fl')).velocity * 0.05
end

-- Measures a wall 2 m ahead of the scanner.
function laser_distance()
    local wall = sim.createPrimitiveShape(sim.primitiveshape_cuboid, {0.1, 3, 1})
    sim.setObjectPosition(wall, {2.35, 0, 0.5})
    sim.setObjectInt32Param(wall, sim.shapeintparam_respondable, 0)
    sim.wait(0.5)
    local scan = tatu.read(sim.getObject('/base_link/base_laser_front'))
    return scan.distance[257]
end
