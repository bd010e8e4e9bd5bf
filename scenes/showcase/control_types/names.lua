-- Writes the signs in front of the pens: the methods by which the robots are driven.

local letters = require 'letters'

local SIZE, PIXELS = 0.17, 4        -- m, height of the letters
local LIGHTER = 0.45              -- share of white in the colour
local RIGHT, UP = {1, 0, 0}, {0, 0.6, 0.8}      -- tilted back, so that the signs can be read from above as well

function sysCall_init()
    for _, object in ipairs(sim.getObjectsInTree(sim.handle_scene, sim.sceneobject_dummy)) do
        if sim.getObjectAlias(object) == 'sign' then
            local color = {}
            for part in sim.readCustomStringData(object, 'color'):gmatch('%S+') do
                color[#color + 1] = LIGHTER + (1 - LIGHTER) * tonumber(part)
            end
            local at = sim.getObjectPosition(object, sim.handle_world)
            letters.write(sim.readCustomStringData(object, 'text'), at, RIGHT, UP, SIZE, PIXELS, color)
        end
    end
end
