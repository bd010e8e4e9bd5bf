-- `gcode`: converts programs of machine tools (RS-274) to lists of points along the tool path.
--
-- Lengths are in mm (G21) or inches (G20) in a program, and in m in points; the angles A, B and C are in degrees in a
-- program, and in rad in points.

LOG = { TRACE = 10, DEBUG = 20, INFO = 30, WARN = 40, ERROR = 50 }
loglevel = LOG.INFO

function log(level, text, ...)
    if level >= loglevel then
        print('gcode: ' .. string.format(text, ...))
    end
end

-- Initial state of an interpreter. A program changes the state of the instance that runs it, not these defaults.
GCodeInterpreter = {
    pathResolution = 150, -- points per m
    multiplier = 0.001,   -- m per unit of the program
    absolute = true,
    motion = 0,
    speed = 0,            -- m/s, set by F in units per minute
}
GCodeInterpreter.__index = GCodeInterpreter

function GCodeInterpreter:new(o)
    return setmetatable(o or {}, { __index = self })
end

-- Maximum difference between the radii at both ends of an arc, m.
local MOST_OFF = 0.0025
-- Tolerance, m or rad, below which differences between positions or angles are treated as zero.
local NOTHING = 1e-9

local AXES = { X = 1, Y = 2, Z = 3, A = 4, B = 5, C = 6 }
-- Letters of words that are accepted without a warning: they belong to a motion or to another word, or are ignored.
local KNOWN = {}
for letter in ('ABCFIJKPRUVWXYZN'):gmatch('.') do KNOWN[letter] = true end

local function copy(point)
    return { table.unpack(point) }
end

-- Adds the points of a move to a program's path; `at(part)` must return the point at a fraction of the move, 0 to 1.
local function way(self, length, at)
    local steps = math.max(1, math.ceil(length * self.pathResolution))
    local points = {}
    for i = 0, steps do
        for _, x in ipairs(at(i / steps)) do
            points[#points + 1] = x
        end
    end
    local duration = length / self.speed
    if length < NOTHING then
        duration = 0
    end
    self.items[#self.items + 1] = { duration, points }
    self:draw(points)
end

local function straight(self, to)
    local from, length = copy(self.at), 0
    for i = 1, 3 do
        length = length + (to[i] - from[i]) ^ 2
    end
    way(self, math.sqrt(length), function(part)
        local point = {}
        for i = 1, 6 do
            point[i] = from[i] + part * (to[i] - from[i])
        end
        return point
    end)
    self.at = to
end

-- Returns the centre of an arc given by its radius, to the right or left of the chord; a negative radius selects the
-- longer arc.
local function middle(line, from, to, radius, clockwise)
    local dx, dy = to[1] - from[1], to[2] - from[2]
    local half = math.sqrt(dx * dx + dy * dy) / 2
    if half < NOTHING then
        error('line ' .. line .. ': an arc with R must not end at its start point; specify I and J instead', 0)
    elseif half > math.abs(radius) + MOST_OFF then
        error('line ' .. line .. ': the radius R is too small to reach the end of the arc', 0)
    end
    local off = math.sqrt(math.max(0, radius * radius - half * half)) / (2 * half)
    if clockwise == (radius > 0) then
        off = -off
    end
    return (from[1] + to[1]) / 2 - off * dy, (from[2] + to[2]) / 2 + off * dx
end

local function arc(self, line, to, words, clockwise)
    local from = copy(self.at)
    if math.abs(to[3] - from[3]) > NOTHING then
        error('line ' .. line .. ': the arc changes Z; only arcs in a plane of constant Z are supported', 0)
    end
    local x, y
    if words.R then
        x, y = middle(line, from, to, words.R * self.multiplier, clockwise)
    else
        x, y = from[1] + (words.I or 0) * self.multiplier, from[2] + (words.J or 0) * self.multiplier
    end
    local function polar(point)
        local dx, dy = point[1] - x, point[2] - y
        return math.sqrt(dx * dx + dy * dy), math.atan2(dy, dx)
    end
    local r0, a0 = polar(from)
    local r1, a1 = polar(to)
    if math.abs(r0 - r1) > MOST_OFF then
        error(string.format('line %d: an arc starts %.2f mm from its centre, but ends %.2f mm from it', line, r0 * 1000,
            r1 * 1000), 0)
    end
    -- An arc that ends at its start point is a full circle.
    local turn = a1 - a0
    if clockwise and turn > -NOTHING then
        turn = turn - 2 * math.pi
    elseif not clockwise and turn < NOTHING then
        turn = turn + 2 * math.pi
    end
    way(self, math.abs(turn) * (r0 + r1) / 2, function(part)
        local r, a = r0 + part * (r1 - r0), a0 + part * turn
        local point = { x + r * math.cos(a), y + r * math.sin(a), from[3] }
        for i = 4, 6 do
            point[i] = from[i] + part * (to[i] - from[i])
        end
        return point
    end)
    self.at = to
end

-- Returns the target position that the words of a line specify.
local function target(self, words)
    local to = copy(self.at)
    for letter, i in pairs(AXES) do
        if words[letter] then
            local x = words[letter] * (i < 4 and self.multiplier or math.pi / 180)
            to[i] = self.absolute and x or to[i] + x
        end
    end
    return to
end

local function home(self, words)
    local by = target(self, words)
    self.motion = 0
    for i = 1, 6 do
        if by[i] ~= self.at[i] then
            straight(self, by)
            break
        end
    end
    straight(self, { 0, 0, 0, 0, 0, 0 })
end

local function run(self, line, words, codes)
    -- The units that a line selects apply to the whole line.
    for _, g in ipairs(codes) do
        if g == 20 or g == 21 then
            self.multiplier = g == 20 and 0.0254 or 0.001
        end
    end
    if words.F then
        self.speed = words.F * self.multiplier / 60
    end
    local moved = false
    for _, g in ipairs(codes) do
        if g >= 0 and g <= 3 and g == math.floor(g) then
            self.motion = g
        elseif g == 4 then
            self.items[#self.items + 1] = { (words.P or 0) / 1000, copy(self.at) }
            moved = true
        elseif g == 28 then
            home(self, words)
            moved = true
        elseif g == 90 or g == 91 then
            self.absolute = g == 90
        elseif g ~= 20 and g ~= 21 then
            log(LOG.WARN, 'line %d: G%g is not implemented', line, g)
        end
    end
    local goes = words.I or words.J
    for letter in pairs(AXES) do
        goes = goes or words[letter]
    end
    if not goes or moved then
        return
    end
    if self.motion < 2 then
        straight(self, target(self, words))
    else
        arc(self, line, target(self, words), words, self.motion == 2)
    end
end

-- Draws a move: red for rapid moves, green for working moves, and blue where a move ends.
function GCodeInterpreter:draw(points)
    local lines = self.motion == 0 and self.red or self.green
    if not lines then
        return
    end
    for i = 7, #points, 6 do
        local a, b = i - 6, i
        sim.addDrawingObjectItem(lines,
            { points[a], points[a + 1], points[a + 2], points[b], points[b + 1], points[b + 2] })
    end
    sim.addDrawingObjectItem(self.blue, { points[#points - 5], points[#points - 4], points[#points - 3] })
end

function GCodeInterpreter:runProgram(text, visualize)
    self.items, self.at = {}, { 0, 0, 0, 0, 0, 0 }
    self.green, self.red, self.blue = nil, nil, nil
    for _, key in ipairs { 'multiplier', 'absolute', 'motion', 'speed' } do
        self[key] = GCodeInterpreter[key]
    end
    if visualize then
        self.green = sim.addDrawingObject(sim.drawing_lines, 2, 0, -1, 99999, { 0, 1, 0 })
        self.red = sim.addDrawingObject(sim.drawing_lines, 2, 0, -1, 99999, { 1, 0, 0 })
        self.blue = sim.addDrawingObject(sim.drawing_points, 5, 0, -1, 99999, { 0, 0, 1 })
    end
    local line = 0
    for whole in (text .. '\n'):gmatch('(.-)\r?\n') do
        line = line + 1
        local words, codes = {}, {}
        for letter, number in whole:gsub('%b()', ' '):gsub(';.*', ''):gmatch('(%a)%s*([-+%d.]*)') do
            letter = letter:upper()
            local x = tonumber(number)
            if not x then
                error(string.format("line %d: expected a number after %s, found '%s'", line, letter, number), 0)
            elseif letter == 'G' then
                codes[#codes + 1] = x
            elseif KNOWN[letter] then
                words[letter] = x
            else
                log(LOG.WARN, 'line %d: %s%g is not implemented', line, letter, x)
            end
        end
        run(self, line, words, codes)
    end
    return self.items, self.green, self.red, self.blue
end

return GCodeInterpreter
