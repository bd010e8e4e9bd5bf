-- The lift's controller. It moves the platform to the requested floor, 0 being the lowest:
--     sim.setInt32Signal('lift.floor', 2)      -- the base's unique name; the second one is 'lift#0.floor'
--     sim.writeCustomStringData(sim.getObject('/lift'), 'floor', '2')
-- The signal takes precedence while it is set. Without a request, the lift visits all floors, one after another.
-- The custom data `at` holds the current floor; it is empty while the lift moves.

local CLOSE = 0.002      -- m, within which the lift has arrived

local function askedFor()
    local floor = sim.getInt32Signal(signal) or tonumber(sim.readCustomStringData(base, 'floor'))
    if floor and not heights[floor + 1] then
        error(string.format('lift: floor %s was asked for, expected 0 to %d', floor, #heights - 1))
    end
    return floor
end

function sysCall_init()
    base = sim.getObject(':')
    motor = sim.getObject(':/lift_motor')
    signal = sim.getStringProperty(base, 'object.name') .. '.floor'
    stay = tonumber(sim.readCustomStringData(base, 'stay'))
    heights = {}
    for i = 1, tonumber(sim.readCustomStringData(base, 'floors')) do
        local dummy = sim.getObject(':/floor_' .. i - 1)
        heights[i] = sim.getObjectPosition(dummy, base)[3]
    end
    floor, direction, arrived = 0, 1, nil
end

-- The next floor without a request: up to the highest, and down again.
local function nextOnTour(now)
    if stay == 0 or #heights == 1 or not arrived or now - arrived < stay then return floor end
    if not heights[floor + 1 + direction] then direction = -direction end
    return floor + direction
end

function sysCall_actuation()
    local now = sim.getSimulationTime()
    local wanted = askedFor() or nextOnTour(now)
    if wanted ~= floor then floor, arrived = wanted, nil end
    local target = heights[floor + 1] - heights[1]
    sim.setJointTargetPosition(motor, target)
    if not arrived and math.abs(sim.getJointPosition(motor) - target) < CLOSE then
        arrived = now
        sim.writeCustomStringData(base, 'at', tostring(floor))
    elseif not arrived then
        sim.writeCustomStringData(base, 'at', '')
    end
end
