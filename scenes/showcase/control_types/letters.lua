-- Stroke letters for drawings: capitals, digits, hyphen and space.
--
-- letters.write(text, at, right, up, size, pixels, color) draws a line of text, centred at `at`, and returns the
-- drawing. `right` and `up` are directions in the world.

local letters = {}

-- Each stroke joins points of a grid: column 0 to 2, row 0 (bottom) to 4, as two digits.
local STROKES = {
    A = '00 03 14 23 20, 02 22', B = '00 04 14 23 12 02, 12 21 10 00', C = '24 04 00 20', D = '00 04 14 23 21 10 00',
    E = '24 04 00 20, 02 12', F = '24 04 00, 02 12', G = '24 04 00 20 22 12', H = '00 04, 20 24, 02 22', I = '10 14',
    J = '24 20 00 01', K = '00 04, 24 02 20', L = '04 00 20', M = '00 04 12 24 20', N = '00 04 20 24',
    O = '00 04 24 20 00', P = '00 04 24 22 02', Q = '00 04 24 20 00, 11 20', R = '00 04 24 22 02, 12 20',
    S = '24 04 02 22 20 00', T = '04 24, 14 10', U = '04 00 20 24', V = '04 10 24', W = '04 00 12 20 24',
    X = '00 24, 04 20', Y = '04 12 24, 12 10', Z = '04 24 00 20', ['-'] = '02 22', [' '] = '',
}
local ADVANCE = 3       -- columns from one letter to the next
local ROWS = 4

function letters.write(text, at, right, up, size, pixels, color)
    local unit = size / ROWS
    local drawing = sim.addDrawingObject(sim.drawing_lines, pixels, 0, -1, 0, color)
    local function point(column, row)
        local x, y = (column - (#text * ADVANCE - 1) / 2) * unit, (row - ROWS / 2) * unit
        return at[1] + x * right[1] + y * up[1], at[2] + x * right[2] + y * up[2], at[3] + x * right[3] + y * up[3]
    end
    for i = 1, #text do
        for stroke in STROKES[text:sub(i, i)]:gmatch('[^,]+') do
            local x, y, z
            for column, row in stroke:gmatch('(%d)(%d)') do
                local x2, y2, z2 = point((i - 1) * ADVANCE + column, tonumber(row))
                if x then sim.addDrawingObjectItem(drawing, {x, y, z, x2, y2, z2}) end
                x, y, z = x2, y2, z2
            end
        end
    end
    return drawing
end

return letters
