-- Referee: reads true positions, which the robots do not know. At the end of each round, all robots must be at their
-- target positions, and none may touch another robot or a pillar.

local ROUND = 36                -- s
local PLACES = {                -- m: x and y at the end of odd rounds; at the end of even ones the robots are back
    red = {1.5, 1.0}, blue = {-1.5, -1.0}, green = {1.5, -1.0}, yellow = {-1.5, 1.0},
}
local NAMES = {'red', 'blue', 'green', 'yellow'}
local BODY = 0.09               -- m: radius of a robot
local NEAR = 0.15               -- m

function sysCall_init()
    robots, pillars = {}, {}
    for _, name in ipairs(NAMES) do robots[name] = sim.getObject('/' .. name) end
    for i = 0, 2 do pillars[i] = sim.getObject('/pillar[' .. i .. ']') end
    rounds, least = 0, math.huge
end

local function distance(a, b)
    return math.sqrt((a[1] - b[1]) ^ 2 + (a[2] - b[2]) ^ 2)
end

local function gap(value, what)
    least = math.min(least, value)
    if value < 0 then error(what) end
end

function sysCall_sensing()
    local at = {}
    for i, name in ipairs(NAMES) do
        at[name] = sim.getObjectPosition(robots[name])
        for k = 1, i - 1 do
            gap(distance(at[name], at[NAMES[k]]) - 2 * BODY, name .. ' touches ' .. NAMES[k])
        end
        for i, pillar in pairs(pillars) do
            local radius = tatu.get(pillar, 'shape.size')[1] / 2
            gap(distance(at[name], sim.getObjectPosition(pillar)) - BODY - radius, name .. ' touches a pillar')
        end
    end
    local now = sim.getSimulationTime()
    if now < (rounds + 1) * ROUND - 0.1 then return end
    rounds = rounds + 1
    local sign = rounds % 2 == 1 and 1 or -1
    for name, place in pairs(PLACES) do
        local off = distance(at[name], {sign * place[1], sign * place[2]})
        if off > NEAR then error(string.format('%s is %.2f m off its place after round %d', name, off, rounds)) end
    end
    print(string.format('round %d: all on their places; least gap %.3f m', rounds, least))
    least = math.huge
end
