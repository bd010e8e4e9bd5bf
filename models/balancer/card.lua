-- Measurements of the NXTway-GS. Each one runs in a separate world that contains a floor and the robot.

local RADIUS, TRACK = 0.04, 0.14    -- m

local function robot() return sim.getObject('/nxtway') end

local function motor(side) return sim.getObject('/nxtway/' .. side .. '_motor') end

-- The same voltage on both motors, without controller: their target is the speed without load.
local function voltage(value)
    local speed = value * (0.317 / 6.69) / (0.317 * 0.468 / 6.69 + 0.0022)
    sim.setJointTargetVelocity(motor('left'), speed)
    sim.setJointTargetVelocity(motor('right'), speed)
end

-- Applies a forward impulse, N s, at the top of the body within one step.
local function push(impulse)
    sim.addForce(robot(), {0, 0, 0.144}, {impulse / sim.getSimulationTimeStep(), 0, 0})
    sim.step()
end

function mass() return measure.mass(robot()) end

function rest_drift()
    sim.wait(1)
    return measure.drift(robot(), 60)
end

function rest_tilt()
    local most = 0
    for _ = 1, 1200 do
        sim.step()
        most = math.max(most, measure.tilt(robot()))
    end
    return most
end

function falls_without_controller()
    push(0.001)
    sim.wait(3)
    return measure.tilt(robot())
end

function fall_rate()
    push(0.0005)
    local function when(tilt)
        while measure.tilt(robot()) < tilt do sim.step() end
        return sim.getSimulationTime(), measure.tilt(robot())
    end
    local t1, a1 = when(0.02)
    local t2, a2 = when(0.1)
    return math.log(a2 / a1) / (t2 - t1)
end

function stall_torque()
    sim.setObjectPosition(robot(), {0, 0, 0.3})
    sim.step()
    voltage(8)
    sim.step()
    -- Wheel and rotor relative to the body and the other wheel; the motor's back EMF slows them with a time constant.
    local wheel, body, damping = 0.03 * RADIUS ^ 2 / 2 + 1e-5, 0.6 * 0.072 ^ 2 / 3, 0.317 * 0.468 / 6.69 + 0.0022
    local rate = (1 / wheel + 2 / body) * damping
    sim.step()
    local t = 2 * sim.getSimulationTimeStep()
    return sim.getJointVelocity(motor('left')) / (1 - math.exp(-rate * t)) * damping
end

function no_load_speed()
    sim.setObjectPosition(robot(), {0, 0, 0.3})
    voltage(8)
    sim.wait(1)
    return sim.getJointVelocity(motor('left'))
end

function settles_after_push()
    sim.wait(2)
    local start, last = sim.getSimulationTime(), sim.getSimulationTime()
    push(0.02)
    for _ = 1, 600 do
        sim.step()
        if measure.tilt(robot()) > math.rad(1) then last = sim.getSimulationTime() end
    end
    return last - start
end

function forward_speed()
    tatu.drive(robot(), 0.2, 0, 0)
    sim.wait(15)
    local from = sim.getObjectPosition(robot())
    sim.wait(10)
    return measure.distance(from, sim.getObjectPosition(robot())) / 10
end

local function turned(seconds)
    local from = measure.angle(robot())
    for _ = 1, seconds * 20 do
        sim.step()
        measure.angle(robot())
    end
    return measure.angle(robot()) - from
end

function turning_rate()
    tatu.drive(robot(), 0, 0, 1)
    sim.wait(3)
    return turned(10) / 10
end

function odometry()
    local function difference()
        return tatu.read(sim.getObject('/nxtway/right_motor/right_encoder')).position
            - tatu.read(sim.getObject('/nxtway/left_motor/left_encoder')).position
    end
    tatu.drive(robot(), 0, 0, 1)
    sim.wait(3)
    local from = difference()
    local turn = turned(10)
    return (difference() - from) * RADIUS / TRACK / turn
end
