-- Configuration window of a model. It never opens, so the model always uses its saved configuration.

local nothing = {}
nothing.__index = function()
    return function() end
end

function ConfigUI(kind, schema, generate)
    return setmetatable({ modelType = kind, schema = schema, generate = generate }, nothing)
end

return ConfigUI
