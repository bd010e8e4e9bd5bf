-- What only Lua can do for Lua: functions of the catalogue that change their arguments, or run text.
local _ = ...
-- Scripts may use these names for something of their own.
local load, pcall, setmetatable = load, pcall, setmetatable

-- `sim.invertMatrix` changes the table that it is given; poses too.
rawset(sim, 'invertMatrix', function(matrix)
    local inverse = sim.getInvertedMatrix(matrix)
    for i = 1, 12 do
        matrix[i] = inverse[i]
    end
    return 1
end)

-- Runs a text in this script, for sim.executeScriptString: whether it could, and its first result.
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

-- Functions of another script as if they were fields: sim.getScriptFunctions(handle):move(1).
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
