-- Measurements of the Crazyflie.

local MASS, GRAVITY = 0.0282, 9.81    -- kg, m/s^2

local function rotor(i) return sim.getObject('/crazyflie/m' .. i) end

-- Sets the rotor speeds, rad/s; one value for all, or four.
local function rotors(a, b, c, d)
    for i, speed in ipairs{a, b or a, c or a, d or a} do tatu.set(rotor(i), 'propeller.speed', speed) end
end

local function hoverSpeed()
    local k = tatu.get(rotor(1), 'propeller.max_thrust') / tatu.get(rotor(1), 'propeller.max_speed') ^ 2
    return math.sqrt(MASS * GRAVITY / 4 / k)
end

-- Vertical speed and turning rate.
local function motion()
    local linear, angular = sim.getObjectVelocity(measure.model())
    return linear[3], angular[3]
end

-- Returns the target, once the controller has detached it into the world.
local function target()
    while sim.getObject('/target', {noError = true}) < 0 do sim.step() end
    return sim.getObject('/target')
end

local function greatestError(seconds)
    local robot, goal, most = measure.model(), target(), 0
    local stop = sim.getSimulationTime() + seconds
    while sim.getSimulationTime() < stop do
        sim.step()
        most = math.max(most, measure.distance(sim.getObjectPosition(robot), sim.getObjectPosition(goal)))
    end
    return most
end

function mass()
    return measure.mass(measure.model())
end

function rest_drift()
    sim.wait(1)
    return measure.drift(measure.model(), 60)
end

-- Aerodynamic drag opposes motion, so the slope of a velocity at velocity 0 is extrapolated from two later slopes.
local function slopeAtRest(velocity, wait)
    local function slope()
        local from, t = velocity(), sim.getSimulationTime()
        sim.wait(0.1)
        local to = velocity()
        return (to - from) / (sim.getSimulationTime() - t), (from + to) / 2
    end
    sim.wait(wait)
    local a1, v1 = slope()
    sim.wait(0.2)
    local a2, v2 = slope()
    return a1 - v1 * (a2 - a1) / (v2 - v1)
end

function climb()
    rotors(1e9)
    return slopeAtRest(motion, 0.6)
end

function motor_lag()
    local most = tatu.get(rotor(1), 'propeller.max_speed')
    rotors(most)
    local from = sim.getSimulationTime()
    repeat sim.step() until tatu.read(rotor(1)).speed >= (1 - math.exp(-1)) * most
    return sim.getSimulationTime() - from
end

function yaw_acceleration()
    local hover = hoverSpeed()
    rotors(1.1 * hover)
    sim.wait(1)
    rotors(1.1 * hover, hover, 1.1 * hover, hover)
    return slopeAtRest(function() return select(2, motion()) end, 0.5)
end

function hover_speed()
    sim.wait(6)
    local sum, n = 0, 0
    for _ = 1, 100 do
        sim.step()
        for i = 1, 4 do sum, n = sum + tatu.read(rotor(i)).speed, n + 1 end
    end
    return sum / n
end

function hover_error()
    sim.wait(8)
    return greatestError(20)
end

hover_error_exact = hover_error

function yaw_error()
    sim.wait(5)
    local goal, robot, most = target(), measure.model(), 0
    sim.setObjectOrientation(goal, {0, 0, math.pi / 2})
    sim.wait(5)
    for _ = 1, 200 do
        sim.step()
        most = math.max(most, math.abs(measure.angle(robot) - math.pi / 2))
    end
    return most
end

function arrival()
    sim.wait(6)
    local goal, robot = target(), measure.model()
    local at = sim.getObjectPosition(goal)
    sim.setObjectPosition(goal, {at[1] + 1, at[2], at[3]})
    local from, last = sim.getSimulationTime(), 0
    while sim.getSimulationTime() < from + 8 do
        sim.step()
        local away = measure.distance(sim.getObjectPosition(robot), sim.getObjectPosition(goal))
        if away > 0.02 then last = sim.getSimulationTime() - from end
    end
    return last
end

function overshoot()
    sim.wait(6)
    local goal, robot, most = target(), measure.model(), -1
    local at = sim.getObjectPosition(goal)
    sim.setObjectPosition(goal, {at[1] + 1, at[2], at[3]})
    for _ = 1, 160 do
        sim.step()
        most = math.max(most, sim.getObjectPosition(robot)[1] - at[1] - 1)
    end
    return math.max(0, most)
end

function attitude_rise()
    sim.wait(6)
    local script = sim.getScript(sim.scripttype_simulation, '/crazyflie/controller')
    sim.callScriptFunction('setAttitude', script, math.rad(20), 0, 0, MASS * GRAVITY)
    local from = sim.getSimulationTime()
    repeat sim.step() until measure.tilt(measure.model()) > math.rad(18)
    return sim.getSimulationTime() - from
end

function payload_error()
    -- The controller does not know about the payload.
    tatu.set(measure.model(), 'shape.mass', MASS + 0.015)
    sim.wait(10)
    return greatestError(10)
end

function range_front()
    local wall = sim.createPrimitiveShape(sim.primitiveshape_cuboid, {0.02, 0.5, 0.5})
    local far = 2.1
    repeat
        far = far - 0.002
        sim.setObjectPosition(wall, {far + 0.01, 0, 0.25})
        sim.step()
        sim.step()
    until sim.readProximitySensor(sim.getObject('/crazyflie/range_front')) == 1
    return far
end
