local function walker()
    return sim.getObject('/person/walker')
end

local function speed(seconds)
    local from = sim.getObjectPosition(walker())
    sim.wait(seconds)
    return measure.distance(from, sim.getObjectPosition(walker())) / seconds
end

function walking_speed()
    sim.wait(1)
    return speed(10)
end

function slow_speed()
    sim.writeCustomStringData(measure.model(), 'speed', '0.5')
    sim.wait(1)
    return speed(10)
end

-- The sole is 0.068 m below the ankle. Each foot touches down once per cycle.
local function height(foot)
    return sim.getObjectPosition(foot)[3] - 0.068
end

function cadence()
    local foot, count, high = sim.getObject('/person/left_foot'), 0, false
    sim.wait(2)
    for _ = 1, 400 do
        sim.step()
        if height(foot) > 0.06 then high = true end
        if high and height(foot) < 0.03 then count, high = count + 1, false end
    end
    return count / (400 * sim.getSimulationTimeStep())
end

function foot_slip()
    local foot, last, most = sim.getObject('/person/left_foot'), nil, 0
    sim.wait(2)
    for _ = 1, 400 do
        sim.step()
        local flat = math.abs(height(foot)) < 0.003
        local at = sim.getObjectPosition(foot)
        if flat and last then most = math.max(most, measure.distance(at, last)) end
        last = flat and at or nil
    end
    return most
end

function off_corner()
    local most = 0
    for _ = 1, 1200 do
        sim.step()
        local at = sim.getObjectPosition(walker())
        most = math.max(most, math.sqrt((at[1] - 1.5) ^ 2 + (at[2] - 1) ^ 2))
    end
    return most
end
