-- Stretches the terrain's mesh, or replaces it by one built from the list of heights.

local function numbers(tag)
    local out = {}
    for word in sim.readCustomStringData(terrain, tag):gmatch('%S+') do out[#out + 1] = tonumber(word) end
    return out
end

local function stretched(surface, by)
    local points = surface[1]
    for i = 1, #points do points[i] = points[i] * by[(i - 1) % 3 + 1] end
    return {points, surface[2]}
end

-- `list` has 7 numbers for each point; the third is its height. Points are ordered row by row.
local function fromHeights(list, rows, size)
    local count = #list // 7
    local columns = count // rows
    if rows < 2 or columns < 2 or columns * rows ~= count then
        local text = 'terrain: heights has %d rows and %d numbers, expected equal rows, at least 2 by 2'
        error(string.format(text, rows, count))
    end
    local points, triangles = {}, {}
    for i = 0, rows - 1 do
        for j = 0, columns - 1 do
            local height = list[(i * columns + j) * 7 + 3]
            for _, c in ipairs{size[1] * (i / (rows - 1) - 0.5), size[2] * (j / (columns - 1) - 0.5), height} do
                points[#points + 1] = c
            end
            if i < rows - 1 and j < columns - 1 then
                local a = i * columns + j
                for _, k in ipairs{a, a + columns, a + columns + 1, a, a + columns + 1, a + 1} do
                    triangles[#triangles + 1] = k
                end
            end
        end
    end
    return {points, triangles}
end

function sysCall_init()
    terrain = sim.getObject(':')
    local rows = numbers('rows')[1]
    -- A restarted script must not stretch the mesh a second time.
    if sim.readCustomStringData(terrain, 'shaped') == 'yes' then return end
    local surface
    if rows > 0 then
        surface = fromHeights(sim.getProperty(sim.getObject(':/heights'), 'path.points'), rows, numbers('size'))
    else
        surface = sim.getProperty(terrain, 'shape.surface')
        surface = stretched(surface, numbers('stretch'))
    end
    sim.setProperty(terrain, 'shape.surface', surface)
    sim.writeCustomStringData(terrain, 'shaped', 'yes')
end
