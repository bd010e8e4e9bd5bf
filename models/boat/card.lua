-- Measurements of the Heron. The water surface is 1 m above the floor.

local SURFACE = 1.0             -- m
local BOTTOM = -0.18            -- m, of the hull's box in the base frame

local function commands(left, right)
    sim.callScriptFunction('setCommands', sim.getScript(sim.scripttype_simulation, '/heron/thrusters'), left, right)
end

-- Steady-state speed, m/s.
local function steadySpeed(command)
    sim.step()
    commands(command, command)
    sim.wait(12)
    local from = sim.getObjectPosition(measure.model())
    sim.wait(3)
    return measure.distance(from, sim.getObjectPosition(measure.model())) / 3
end

local function depthNow()
    return SURFACE - sim.getObjectPosition(measure.model())[3] - BOTTOM
end

function mass()
    return measure.mass(measure.model())
end

function rest_drift()
    sim.wait(2)
    return measure.drift(measure.model(), 60)
end

function depth()
    sim.wait(5)
    return depthNow()
end

function payload_depth()
    tatu.set(measure.model(), 'shape.mass', 38)
    sim.wait(10)
    return depthNow()
end

function roll_period()
    sim.wait(1)
    local boat = measure.model()
    sim.addForceAndTorque(boat, {0, 0, 0}, {400, 0, 0})
    -- Times at which the roll angle changes sign.
    local times, last = {}, nil
    for _ = 1, 600 do
        sim.step()
        local roll = sim.getObjectMatrix(boat)[10]
        if last and roll * last < 0 then
            times[#times + 1] = sim.getSimulationTime() - sim.getSimulationTimeStep() * roll / (roll - last)
        end
        last = roll
    end
    return times[3] - times[1]
end

function top_speed() return steadySpeed(1) end

function back_speed() return steadySpeed(-1) end

function cruise_command() return steadySpeed(0.6) end

function yaw_rate()
    sim.step()
    commands(-1, 1)
    sim.wait(6)
    local boat = measure.model()
    local from, time = measure.angle(boat), sim.getSimulationTime()
    for _ = 1, 100 do
        sim.step()
        measure.angle(boat)
    end
    return (measure.angle(boat) - from) / (sim.getSimulationTime() - time)
end

function acceleration()
    sim.wait(2)
    commands(1, 1)
    sim.wait(1)
    return measure.speed(measure.model()) / 1
end

function path_error()
    local corners = {{12, 0}, {12, 10}, {-2, 10}, {-2, 0}}
    -- The first round lasts about half a minute; the second begins at the last corner.
    local boat, most = measure.model(), 0
    sim.wait(50)
    for _ = 1, 1000 do
        sim.step()
        local p = sim.getObjectPosition(boat)
        local away, corner = 1e9, 1e9
        for i, a in ipairs(corners) do
            local b = corners[i % 4 + 1]
            local x, y = b[1] - a[1], b[2] - a[2]
            local length = math.sqrt(x * x + y * y)
            local along = ((p[1] - a[1]) * x + (p[2] - a[2]) * y) / length
            local aside = math.abs((p[1] - a[1]) * y - (p[2] - a[2]) * x) / length
            if along > 0 and along < length then away = math.min(away, aside) end
            corner = math.min(corner, math.sqrt((p[1] - a[1]) ^ 2 + (p[2] - a[2]) ^ 2))
        end
        if corner > 4 then most = math.max(most, away) end
    end
    return most
end

function cruise_speed()
    sim.wait(15)
    local from = sim.getObjectPosition(measure.model())
    sim.wait(30)
    return measure.distance(from, sim.getObjectPosition(measure.model())) / 30
end

function holding()
    sim.wait(60)
    local boat, most = measure.model(), 0
    for _ = 1, 1200 do
        sim.step()
        local p = sim.getObjectPosition(boat)
        most = math.max(most, math.sqrt((p[1] - 3) ^ 2 + p[2] ^ 2))
    end
    return most
end
