-- Measurements of the snake; see card.toml.

local PERIOD = math.pi     -- s, period of the gait with 2 rad/s

-- Mean position of all modules.
local function middle()
    local sum, count = {0, 0, 0}, 0
    local module = measure.model()
    repeat
        local p = sim.getObjectPosition(module)
        for k = 1, 3 do sum[k] = sum[k] + p[k] end
        count = count + 1
        module = sim.getObject('/module_' .. count, {noError = true})
    until module == -1
    return {sum[1] / count, sum[2] / count, sum[3] / count}
end

-- Angle of the chord from the tail to the head, which swings less than the head does.
local function heading()
    local a, b = sim.getObjectPosition(sim.getObject('/module_11')), sim.getObjectPosition(measure.model())
    return math.atan(b[2] - a[2], b[1] - a[1])
end

function mass()
    return measure.mass(measure.model())
end

function rest_drift()
    sim.wait(1)
    return measure.drift(measure.model(), 60)
end

function length()
    sim.wait(1)
    return measure.distance(sim.getObjectPosition(measure.model()), sim.getObjectPosition(sim.getObject('/module_11')))
end

function joint_speed()
    local joint = sim.getObject('/joint_11')
    sim.setJointTargetPosition(joint, 1.5)
    sim.wait(0.2)
    local from = sim.getJointPosition(joint)
    sim.wait(0.3)
    return (sim.getJointPosition(joint) - from) / 0.3
end

function speed()
    sim.wait(4)
    local from = middle()
    sim.wait(2 * PERIOD)
    return measure.distance(from, middle()) / (2 * PERIOD)
end

function equal_friction()
    return speed()
end

function straight()
    sim.wait(4)
    local a = middle()
    sim.wait(PERIOD)
    local b = middle()
    sim.wait(PERIOD)
    local c = middle()
    sim.wait(PERIOD)
    local d = middle()
    return math.atan(d[2] - c[2], d[1] - c[1]) - math.atan(b[2] - a[2], b[1] - a[1])
end

function turn_rate()
    sim.wait(7)
    local from = heading()
    sim.wait(2 * PERIOD)
    return ((heading() - from + math.pi) % (2 * math.pi) - math.pi) / (2 * PERIOD)
end
