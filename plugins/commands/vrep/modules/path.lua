-- The script that paths have since V-REP 4.2. It does not recompute the path: the points and the shape that are saved
-- in the scene are used.

local path = {}
_S = _S or {}
_S.path = path

local model_with = require 'models.model_with'

local function model()
    return model_with('PATH')
end

-- Returns the handles of the control points, which are the child dummies with a data block `ABC_PATHCTRLPT`, sorted by
-- the index in that block; and the numbers in the data block `PATH`.
function path.init()
    local points = {}
    for _, h in ipairs(sim.getObjectsInTree(model(), sim.object_dummy_type, 3)) do
        local data = sim.readCustomDataBlock(h, 'ABC_PATHCTRLPT')
        if data and #data > 0 then
            points[#points + 1] = { h, sim.unpackTable(data).index or 0 }
        end
    end
    table.sort(points, function(a, b) return a[2] < b[2] end)
    local handles = {}
    for i, point in ipairs(points) do
        handles[i] = point[1]
    end
    return handles, sim.unpackDoubleTable(sim.readCustomDataBlock(model(), 'PATH') or '') or {}
end

path.setup = path.init

function sysCall_init() path.init() end

return path
