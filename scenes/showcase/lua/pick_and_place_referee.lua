-- The referee: reads the true positions of the cubes, which the arm never does, and raises an error if no tower is
-- completed in time.

local CUBES = {'/blue', '/green', '/yellow', '/orange', '/red'}      -- from the bottom up
local EDGE = 0.045           -- m
local TABLE = 0.74           -- m: height of the table
local OFFSET_MOST = 0.015    -- m: maximum horizontal offset of a cube from the one below
local FIRST_MOST = 75        -- s: time limit for the first tower
local NEXT_MOST = 150        -- s: time limit from one tower to the next

local cubes = {}
local since, towers, standing = 0, 0, false

local function tower_stands()
    local below
    for level, cube in ipairs(cubes) do
        local at = sim.getObjectPosition(cube)
        if math.abs(at[3] - TABLE - (level - 0.5) * EDGE) > 0.004 then return false end
        if below and math.sqrt((at[1] - below[1]) ^ 2 + (at[2] - below[2]) ^ 2) > OFFSET_MOST then return false end
        below = at
    end
    return true
end

function sysCall_init()
    for i, path in ipairs(CUBES) do cubes[i] = sim.getObject(path) end
end

function sysCall_sensing()
    local now = sim.getSimulationTime()
    local stands = tower_stands()
    if stands and not standing then
        towers, since = towers + 1, now
        print(string.format('tower %d stands after %.1f s', towers, now))
    end
    standing = stands
    local most = towers == 0 and FIRST_MOST or NEXT_MOST
    if now - since > most then error(string.format('no tower for %d s after tower %d', most, towers)) end
end
