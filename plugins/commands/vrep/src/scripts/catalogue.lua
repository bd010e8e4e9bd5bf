-- Functions that must be written in Lua because they modify their arguments in place, run code or return functions.
local _ = ...
-- Local copies, because scripts can redefine these globals.
local load, pcall, setmetatable = load, pcall, setmetatable

-- `sim.invertMatrix` modifies its argument in place.
rawset(sim, 'invertMatrix', function(matrix)
    local inverse = sim.getInvertedMatrix(matrix)
    for i = 1, 12 do
        matrix[i] = inverse[i]
    end
    return 1
end)

-- Runs code in this script, for sim.executeScriptString. Returns whether it succeeded, and its results or the error.
function _tatu_execute(text)
    local chunk, why = load('return ' .. text, '=string', 't')
    if not chunk then
        chunk, why = load(text, '=string', 't')
    end
    if not chunk then
        return false, why
    end
    return pcall(chunk)
end

-- Sets a global of this script, for sim.setScriptVariable.
function _tatu_assign(name, value)
    _G[name] = value
end

-- Returns a table whose methods call the functions of another script: sim.getScriptFunctions(handle):move(1).
rawset(sim, 'getScriptFunctions', function(script)
    return setmetatable({}, {
        __index = function(_, name)
            return function(_, ...)
                return sim.callScriptFunction(name, script, ...)
            end
        end,
    })
end)

return {}
