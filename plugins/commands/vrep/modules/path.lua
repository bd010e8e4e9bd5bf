-- The script of a path since 4.2. The path stays as it was saved: its points and its shape are objects of the scene.

local path = {}
_S = _S or {}
_S.path = path

-- The object at or above the script that holds a path.
local function model()
    local at, first = sim.getObject('.'), nil
    while at ~= -1 do
        if sim.getObjectType(at) ~= sim.object_script_type then
            local data = sim.readCustomDataBlock(at, 'PATH')
            if data and #data > 0 then
                return at
            end
            first = first or at
        end
        at = sim.getObjectParent(at)
    end
    return first
end

-- Control points: children that carry their index, in its order.
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
