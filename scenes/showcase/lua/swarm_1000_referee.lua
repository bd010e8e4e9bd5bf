-- The referee: reads the true positions of all motes, counts the cells of the floor that contain at least one, and
-- raises an error if the motes do not spread out in time, or if one leaves the arena or falls over.

local SIDE = 6.0            -- m, of the arena
local CELL = 0.5            -- m
local EVERY = 10            -- steps between two counts
local GOAL = 0.70           -- fraction of the cells that must be occupied ...
local GOAL_TIME = 8         -- ... after this time, s
local TILT_MOST = 0.5       -- rad; a mote tilted by more than this has fallen over
local FALLEN_MOST = 0       -- maximum number of motes that have fallen over

local motes, graph, stream
local step, told, covered = 0, false, 0

local function count()
    local taken, cells, fallen = {}, 0, 0
    for _, mote in ipairs(motes) do
        local m = sim.getObjectMatrix(mote)
        if math.abs(m[4]) > SIDE / 2 or math.abs(m[8]) > SIDE / 2 or m[12] < 0 then
            error(string.format('a mote has left the arena: %.2f %.2f %.2f m', m[4], m[8], m[12]))
        end
        if m[11] < math.cos(TILT_MOST) then fallen = fallen + 1 end
        local cell = math.floor((m[4] + SIDE / 2) / CELL) * 1000 + math.floor((m[8] + SIDE / 2) / CELL)
        if not taken[cell] then
            taken[cell] = true
            cells = cells + 1
        end
    end
    if fallen > FALLEN_MOST then error(string.format('%d motes have fallen over', fallen)) end
    return cells / (SIDE / CELL) ^ 2
end

function sysCall_init()
    motes = {}
    for i, shape in ipairs(sim.getObjectsInTree(sim.getObject('/swarm'), sim.object_shape_type, 2)) do
        if sim.getObjectAlias(shape):find('^mote') then motes[#motes + 1] = shape end
    end
    graph = sim.getObject('/spread')
    stream = sim.addGraphStream(graph, 'floor taken', '%')
end

function sysCall_sensing()
    if step % EVERY == 0 then covered = count() end
    step = step + 1
    sim.setGraphStreamValue(graph, stream, 100 * covered)
    local now = sim.getSimulationTime()
    if covered >= GOAL and not told then
        told = true
        print(string.format('%d motes have taken %.0f %% of the floor after %.1f s', #motes, 100 * covered, now))
    end
    if not told and now > GOAL_TIME then
        error(string.format('after %d s only %.0f %% of the floor are taken', GOAL_TIME, 100 * covered))
    end
end
