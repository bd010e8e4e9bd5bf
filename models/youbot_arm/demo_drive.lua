-- Drives the platform of the demo sideways while the arm rests with the cube on the load plate, alternately to the left
-- and to the right. The distance is measured by wheel encoders.

local SPEED = 0.15          -- m/s, maximum
local WAY = 0.5             -- m
local RADIUS = 0.05         -- m, of a wheel

function sysCall_init()
    robot = sim.getObject('..')
    arm = sim.getObject(':/arm_link_0')
    encoder = sim.getObject(':/encoder_fr')
end

local function resting_with_cube()
    return sim.readCustomStringData(arm, 'state') == 'resting' and sim.readCustomStringData(arm, 'part') == 'place'
end

-- The front right wheel turns ahead when the platform goes to the left.
local function left()
    return tatu.read(encoder).position * RADIUS
end

function sysCall_thread()
    local side = 1
    while true do
        while not resting_with_cube() do sim.step() end
        local start = left()
        local gone = 0
        while gone < WAY - 0.001 do
            -- Slow near both ends of the path, so that the cube does not slide.
            local speed = math.min(SPEED, 0.02 + 0.8 * gone, 0.01 + 0.8 * (WAY - gone))
            tatu.drive(robot, 0, side * speed, 0)
            sim.step()
            gone = side * (left() - start)
        end
        tatu.drive(robot, 0, 0, 0)
        side = -side
        while resting_with_cube() do sim.step() end
    end
end
