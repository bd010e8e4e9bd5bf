-- Turns the ray like the device's mirror, and measures in the directions passed during a step: 684 over 240 degrees,
-- counted as 1024 per full turn. One signal contains the points measured in this step, x y z in the frame of the
-- device; after each turn, another contains all 684 distances, 0 where nothing was detected.

local POINTS, OPENING, TURN = 684, math.rad(240), 1024

local function parameter(name)
    return math.max(0, tonumber(sim.getScriptSimulationParameter(sim.handle_self, name)) or 0)
end

function sysCall_init()
    device = sim.getObjectAssociatedWithScript(sim.handle_self)
    laser = sim.getObjectHandle('Hokuyo_URG_04LX_UG01_laser')
    joint = sim.getObjectHandle('Hokuyo_URG_04LX_UG01_joint')
    signal = sim.getObjectName(device) .. '_distances'
    distances, passed, at = {}, 0, 0
end

function sysCall_sensing()
    local noise = parameter('noise')
    local points = {}
    passed = passed + sim.getSimulationTimeStep() * parameter('rate') * TURN
    -- At most one turn is measured, because a further one would overwrite it.
    while passed - at >= TURN + 1 do at = at + TURN end
    while at + 1 <= passed + 1e-6 do
        local i = at % TURN
        if i < POINTS then
            sim.setJointPosition(joint, -OPENING / 2 + i * OPENING / POINTS)
            local seen, distance, point = sim.handleProximitySensor(laser)
            distances[i + 1] = 0
            if seen > 0 then
                local measured = distance + (2 * math.random() - 1) * noise
                local scale = measured / distance
                point = sim.multiplyVector(sim.getObjectMatrix(laser, device),
                    { point[1] * scale, point[2] * scale, point[3] * scale })
                for k = 1, 3 do points[#points + 1] = point[k] end
                distances[i + 1] = measured
            end
            if i == POINTS - 1 and #distances == POINTS then
                sim.setStringSignal(signal, sim.packFloatTable(distances))
            end
        end
        at = at + 1
    end
    sim.setStringSignal('measuredDataAtThisTime', sim.packFloatTable(points) or '')
end
