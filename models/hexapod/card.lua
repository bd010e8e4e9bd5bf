-- Measurements of the hexapod; see card.toml.

local LEGS = {'lf', 'lm', 'lr', 'rf', 'rm', 'rr'}

function mass()
    return measure.mass(measure.model())
end

function rest_drift()
    sim.wait(1)
    return measure.drift(measure.model(), 60)
end

function stand_height()
    sim.wait(2)
    return sim.getObjectPosition(measure.model())[3]
end

-- The robot is lifted above the floor, and falls while the leg swings.
function servo_speed()
    local body = measure.model()
    local position = sim.getObjectPosition(body)
    sim.setObjectPosition(body, {position[1], position[2], 20})
    local coxa = sim.getObject('/phantomx/j_c1_lm')
    sim.setJointTargetPosition(coxa, 2.6)
    local fastest = 0
    for _ = 1, 12 do
        sim.step()
        fastest = math.max(fastest, math.abs(sim.getJointVelocity(coxa)))
    end
    return fastest
end

function walk_speed()
    sim.wait(3)
    local from = sim.getObjectPosition(measure.model())
    sim.wait(8)
    return measure.distance(from, sim.getObjectPosition(measure.model())) / 8
end

function turn_rate()
    sim.wait(2)
    local from = measure.angle(measure.model())
    for _ = 1, 16 do
        sim.wait(0.5)
        measure.angle(measure.model())
    end
    return (measure.angle(measure.model()) - from) / 8
end

function level()
    sim.wait(2)
    local worst = 0
    for _ = 1, 100 do
        sim.step()
        worst = math.max(worst, measure.tilt(measure.model()))
    end
    return worst
end

function feet_down()
    sim.wait(2)
    local least = #LEGS
    for _ = 1, 100 do
        sim.step()
        local down = 0
        for _, leg in ipairs(LEGS) do
            down = down + tatu.read(sim.getObject('/phantomx/foot_contact_' .. leg)).touching
        end
        least = math.min(least, down)
    end
    return least
end

function inverse_kinematics()
    local script = sim.getScript(sim.scripttype_simulation, sim.getObject('/phantomx/kinematics'))
    local legs = sim.getScriptFunctions(script)
    local worst = 0
    for _ = 1, 200 do
        local coxa, femur = (math.random() - 0.5) * 1.5, (math.random() - 0.3) * 1.2
        local tibia = (math.random() - 0.5) * 1.2 - 0.3
        local x, y, z = legs:footOf(coxa, femur, tibia)
        local a, b, c = legs:jointsOf(x, y, z)
        local u, v, w = legs:footOf(a, b, c)
        worst = math.max(worst, math.sqrt((x - u) ^ 2 + (y - v) ^ 2 + (z - w) ^ 2))
    end
    return worst
end
