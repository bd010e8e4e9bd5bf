-- A window for the configuration of a model. There are no windows: the model stays as it was saved.

local nothing = {}
nothing.__index = function()
    return function() end
end

function ConfigUI(kind, schema, generate)
    return setmetatable({ modelType = kind, schema = schema, generate = generate }, nothing)
end

return ConfigUI
