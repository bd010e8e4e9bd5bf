-- The conveyor's controller: accelerates the belt to the requested speed, at a limited acceleration.
--
-- Other scripts, the page or remote clients set the speed, in m/s, in one of two ways:
--     sim.writeCustomStringData(sim.getObject('/conveyor'), 'speed', '0.5')
--     sim.setFloatSignal('conveyor.speed', 0.5)      -- the base's unique name; the second one is 'conveyor#0.speed'
-- The signal takes precedence while it is set. The custom data `belt_speed` holds the current speed of the belt.

local DEFAULT_ACCELERATION = 0.5      -- m/s^2

local function number(tag)
    return tonumber(sim.readCustomStringData(base, tag))
end

local function setBelt(value)
    speed = value
    sim.setProperty(belt, 'shape.surface_velocity', {speed, 0, 0})
    sim.writeCustomStringData(base, 'belt_speed', string.format('%.4f', speed))
end

function sysCall_init()
    base = sim.getObject(':')
    belt = sim.getObject(':/belt')
    signal = sim.getStringProperty(base, 'object.name') .. '.speed'
    acceleration = number('acceleration') or DEFAULT_ACCELERATION
    length = number('length')
    seams, moved = {}, 0
    local seam = sim.getObject(':/seam_0')
    while seam >= 0 do
        seams[#seams + 1] = {handle = seam, at = sim.getObjectPosition(seam, base)}
        seam = sim.getObject(':/seam_' .. #seams, {noError = true})
    end
    setBelt(number('speed') or 0)
end

-- Marks leave the belt at one end and reappear at the other.
local function moveSeams(by)
    moved = (moved + by) % length
    for _, seam in ipairs(seams) do
        local x = (seam.at[1] + length / 2 + moved) % length - length / 2
        sim.setObjectPosition(seam.handle, {x, seam.at[2], seam.at[3]}, base)
    end
end

function sysCall_actuation()
    local dt = sim.getSimulationTimeStep()
    local wanted = sim.getFloatSignal(signal) or number('speed')
    if not wanted then
        error("conveyor: the custom data `speed` is '" .. sim.readCustomStringData(base, 'speed') .. "', expected m/s")
    end
    if wanted ~= speed then
        local most = acceleration * dt
        setBelt(speed + math.max(-most, math.min(most, wanted - speed)))
    end
    if speed ~= 0 then moveSeams(speed * dt) end
end
