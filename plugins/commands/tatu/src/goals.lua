-- Goals: conditions of a run that are checked in each step, and reported when they are reached or have failed.
-- docs/guide/exercises.md describes the syntax of their lines, docs/guide/tests-and-grading.md the tables.
--
--     local goals = require('tatu.goals')
--
--     function sysCall_init()
--         goals.begin{'/Robot within 0.3 m of /Flag before 30 s', {'never /Robot touches /Wall', points = 2}}
--     end
--
--     sysCall_sensing, sysCall_cleanup = goals.check, goals.finish

local M = {}
local goals = {}
-- The simulation time at the end of the last step, s.
local now = 0

-- Returns the object at a path. Raises an error that quotes the line of the goal if there is no such object.
local function object(path, line)
    local found = sim.getObject(path, {noError = true})
    if found == -1 then
        error('the goal "' .. line .. '": there is no object ' .. path, 0)
    end
    return found
end

local function distance(a, b)
    return math.sqrt((a[1] - b[1]) ^ 2 + (a[2] - b[2]) ^ 2 + (a[3] - b[3]) ^ 2)
end

local function position(o)
    return sim.getObjectPosition(o, -1)
end

-- Parses a number in a line. Raises an error that quotes the line of the goal if the number is invalid.
local function amount(text, line)
    return tonumber(text) or error('the goal "' .. line .. '": ' .. text .. ' is not a number', 0)
end

-- Types of conditions: a pattern, and a function that takes the line and the captures of the pattern and returns the
-- function that checks the condition.
local conditions = {
    {'^(/%S+) within ([%d.]+) m of (/%S+)$', function(line, a, reach, b)
        a, b, reach = object(a, line), object(b, line), amount(reach, line)
        return function()
            return distance(position(a), position(b)) <= reach
        end
    end},
    {'^(/%S+) goes ([%d.]+) m$', function(line, a, way)
        a, way = object(a, line), amount(way, line)
        local gone, last = 0, position(a)
        return function()
            local now = position(a)
            gone, last = gone + distance(now, last), now
            return gone >= way
        end
    end},
    {'^(/%S+) touches (/%S+)$', function(line, a, b)
        a, b = object(a, line), object(b, line)
        local touched = false
        local function below(o, top)
            while o ~= -1 and o ~= top do
                o = sim.getObjectParent(o)
            end
            return o == top
        end
        tatu.on('collision', function(e)
            touched = touched or below(e.a, a) and below(e.b, b) or below(e.a, b) and below(e.b, a)
        end)
        return function()
            local now = touched
            touched = false
            return now
        end
    end},
    {'^(/%S+) jumps$', function(line, a)
        a = object(a, line)
        local last, speed = position(a), 0
        local isShape = tatu.get(a, 'object.kind') == 'shape'
        return function()
            local now, velocity = position(a), sim.getObjectVelocity(a)
            local before = speed
            speed = distance(velocity, {0, 0, 0})
            local way = distance(now, last)
            last = now
            -- A body moves by its velocity times the time step; the factor and the margin allow for collisions. The
            -- velocity of a shape that is not dynamic only tells how far a script has moved it.
            local isMoved = isShape and not tatu.get(a, 'shape.dynamic')
            return way > 0.05 + (isMoved and 0 or 3 * math.max(before, speed)) * sim.getSimulationTimeStep()
        end
    end},
    {'^(/%S+) ([%l_]+%.[%l_]+)%.?([xyz]?) ([<>]) (-?[%d.]+)$', function(line, a, key, part, sign, bound)
        a, bound = object(a, line), amount(bound, line)
        local index = part ~= '' and part:byte() - ('x'):byte() + 1
        local function value()
            local all = tatu.get(a, key)
            return index and type(all) == 'table' and all[index] or all
        end
        if type(value()) ~= 'number' then
            error('the goal "' .. line .. '": ' .. key .. ' is not a number; if it is a list, add .x, .y or .z', 0)
        end
        return function()
            if sign == '<' then
                return value() < bound
            end
            return value() > bound
        end
    end},
}

-- Parses the line of a goal: `[TEXT:] [never] CONDITION [for S s] [before S s] [if goal N]`.
local function parse(line)
    local text, rest = line:match('^(.*):%s+(.+)$')
    local goal = {text = text or line, state = 'open', points = 1}
    rest = rest or line
    local function take(pattern)
        local before, number = rest:match(pattern)
        rest = before or rest
        return number and amount(number, line)
    end
    goal.requires = take('^(.-)%s+if goal (%d+)$')
    goal.before = take('^(.-)%s+before ([%d.]+) s$')
    goal.during = take('^(.-)%s+for ([%d.]+) s$')
    local kept = rest:match('^never%s+(.+)$')
    goal.never, rest = kept ~= nil, kept or rest
    for _, kind in ipairs(conditions) do
        local captures = {rest:match(kind[1])}
        if captures[1] then
            goal.holds = kind[2](line, table.unpack(captures))
            return goal
        end
    end
    error('the goal "' .. line .. '" cannot be read: expected a condition such as "/Robot within 0.3 m of /Flag before 30 s", '
        .. '"never /Robot touches /Wall", "never /Robot jumps", "/Robot goes 5 m" or "/Pole object.position.z > 0.8 for 5 s"', 0)
end

-- Returns the goal that an element of the list describes: a line, or a table with a line or with a function.
local function read(given)
    if type(given) == 'string' then
        return parse(given)
    elseif type(given) ~= 'table' then
        error('a goal is a ' .. type(given) .. '; expected a line, or a table such as {"/Robot goes 5 m", points = 2}', 0)
    end
    local goal = given[1] and parse(given[1])
    if not goal then
        if type(given.text) ~= 'string' or type(given.holds) ~= 'function' then
            error('a goal without a line needs a string `text` and a function `holds`', 0)
        end
        goal = {text = given.text, state = 'open', holds = given.holds, never = given.never or false,
            during = given.during, before = given.before, requires = given.requires}
    end
    goal.points = given.points or 1
    if type(goal.points) ~= 'number' or goal.points < 0 then
        error('the goal "' .. goal.text .. '": `points` must be a number that is not negative', 0)
    end
    return goal
end

local function tell()
    local all = {}
    for i, goal in ipairs(goals) do
        all[i] = {text = goal.text, state = goal.state, points = goal.points,
            time = goal.state ~= 'open' and goal.time or -1}
    end
    tatu.emit('exercise.goals', {goals = all})
end

-- Decides a goal. A goal that requires another one waits until that one is reached. If the other one is reached only at
-- the end, as with `never`, the goal counts as reached unless the other one fails later.
local function ends(goal, state)
    local required = goal.requires and goals[goal.requires]
    goal.time = goal.time or now
    if state == 'reached' and required then
        goal.waits = required.state == 'open' and not required.never
        if goal.waits then
            return
        elseif required.state == 'failed' then
            state = 'failed'
        end
    end
    goal.state = state
    sim.addLog(sim.verbosity_scriptinfos, string.format('%s at %.2f s: %s', state, goal.time, goal.text))
    tell()
    for _, other in ipairs(goals) do
        if goals[other.requires] == goal and (other.waits or other.state == 'reached' and state == 'failed') then
            other.time = now
            ends(other, state)
        end
    end
end

-- Begins to check goals: a list of lines and tables, or a text with one line per goal.
function M.begin(list)
    goals = {}
    if type(list) == 'string' then
        local lines = {}
        for line in list:gmatch('[^\r\n]+') do
            line = line:match('^%s*(.-)%s*$')
            if line ~= '' then
                lines[#lines + 1] = line
            end
        end
        list = lines
    end
    for i, given in ipairs(list) do
        goals[i] = read(given)
    end
    for i, goal in ipairs(goals) do
        if goal.requires and (not goals[goal.requires] or goal.requires >= i) then
            error('the goal "' .. goal.text .. '": expected the number of an earlier goal after "if goal"', 0)
        end
    end
    tell()
end

-- Checks the goals. To be called at the end of each step.
function M.check()
    now = sim.getSimulationTime() + sim.getSimulationTimeStep()
    for _, goal in ipairs(goals) do
        if goal.state == 'open' and not goal.waits then
            if goal.holds() then
                goal.since = goal.since or now
                if now - goal.since >= (goal.during or 0) - 1e-9 then
                    ends(goal, goal.never and 'failed' or 'reached')
                end
            else
                goal.since = nil
            end
            if goal.state == 'open' and not goal.waits and goal.before and now >= goal.before - 1e-9 then
                ends(goal, goal.never and 'reached' or 'failed')
            end
        end
    end
end

-- Decides the goals that are open at the end of the run.
function M.finish()
    for _, goal in ipairs(goals) do
        if goal.state == 'open' and not goal.waits then
            -- A condition that must never be met has not been met by the end of the run, so its goal is reached.
            ends(goal, goal.never and 'reached' or 'failed')
        end
    end
end

return M
