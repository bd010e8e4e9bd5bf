-- Substitute for the configuration window of a model. No window opens, so the model always uses its saved
-- configuration.

local nothing = {}
nothing.__index = function()
    return function() end
end

function ConfigUI(kind, schema, generate)
    return setmetatable({ modelType = kind, schema = schema, generate = generate }, nothing)
end

return ConfigUI
