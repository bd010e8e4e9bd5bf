-- Publishes the position of the reference with two random errors: one is sampled at each reading, the other once, and
-- again when the parameter is changed. The tube receives x, y, z as packed floats; each signal receives one coordinate.

local AXES = { 'x', 'y', 'z' }

-- Returns a random number between -half and half.
local function within(half)
    return (2 * math.random() - 1) * half
end

local function amplitude(name)
    local value = tonumber(sim.getScriptSimulationParameter(sim.handle_self, name)) or 0
    return math.max(0, math.min(100, value))
end

function sysCall_init()
    reference = sim.getObjectHandle('GPS_reference')
    tube = sim.tubeOpen(0, 'gpsData' .. sim.getNameSuffix(nil), 1)
    shifts, drawn = { 0, 0, 0 }, { 0, 0, 0 }
end

function sysCall_sensing()
    local position = sim.getObjectPosition(reference, -1)
    for k, axis in ipairs(AXES) do
        local wanted = amplitude(axis .. 'ShiftAmplitude')
        if wanted ~= drawn[k] then
            drawn[k], shifts[k] = wanted, within(wanted)
        end
        position[k] = position[k] + shifts[k] + within(amplitude(axis .. 'NoiseAmplitude'))
        sim.setFloatSignal('gps' .. axis:upper(), position[k])
    end
    sim.tubeWrite(tube, sim.packFloatTable(position))
end
