-- `sim-2`, an API with objects instead of handles. Calls of functions that are not defined here are forwarded to `sim`,
-- with objects converted to handles.

local old = sim
local unpack = table.unpack

local Object = {}
local wrap

-- Converts objects to their handles, including those in plain tables; returns any other value unchanged.
local function bare(x)
    if getmetatable(x) == Object then
        return rawget(x, 'handle')
    end
    if type(x) == 'table' and getmetatable(x) == nil then
        local out = {}
        for k, v in pairs(x) do
            out[k] = bare(v)
        end
        return out
    end
    return x
end

local function call(f, ...)
    local arguments = { n = select('#', ...), ... }
    for i = 1, arguments.n do
        arguments[i] = bare(arguments[i])
    end
    return f(unpack(arguments, 1, arguments.n))
end

-- Converts a list of handles to objects; a handle of -1 becomes nil.
local function objects(handles)
    local out = {}
    for i, handle in ipairs(handles) do
        out[i] = wrap(handle)
    end
    return out
end

-- Returns an object for the properties with a common prefix, such as `object.customData`.
local function group(handle, name)
    return setmetatable({}, {
        __index = function(_, key)
            return old.getProperty(handle, name .. '.' .. key, { noError = true })
        end,
        __newindex = function(_, key, value)
            old.setProperty(handle, name .. '.' .. key, bare(value))
        end,
    })
end

-- By object type, the word in names of functions of `sim`, such as `Joint` in `sim.getJointPosition`.
local KINDS = {
    [old.object_shape_type] = 'Shape',
    [old.object_joint_type] = 'Joint',
    [old.object_graph_type] = 'Graph',
    [old.object_proximitysensor_type] = 'ProximitySensor',
    [old.object_visionsensor_type] = 'VisionSensor',
    [old.object_forcesensor_type] = 'ForceSensor',
}

-- Returns the function of `sim` to which a method name refers, or nil if there is none. The caller must pass the handle
-- as the first argument. Names are completed by the type of the object: `getPosition` is getObjectPosition,
-- `setTargetVelocity` of a joint is setJointTargetVelocity, `read` of a sensor is readProximitySensor.
local function method(name, handle)
    local verb, rest = name:match('^(%l+)(%u.*)$')
    for _, kind in ipairs { KINDS[old.getObjectType(handle)] or 'Object', 'Object' } do
        local f = old[(verb or name) .. kind .. (rest or '')]
        if type(f) == 'function' then
            return f
        end
    end
    return type(old[name]) == 'function' and old[name] or nil
end

-- Getters of the fields that an object has in addition to its properties.
local fields = {
    parent = function(self)
        return wrap(old.getObjectParent(self.handle))
    end,
    children = function(self)
        local out, i = {}, 0
        while true do
            local child = old.getObjectChild(self.handle, i)
            if child == -1 then
                return out
            end
            i = i + 1
            out[i] = wrap(child)
        end
    end,
    objectType = function(self)
        return old.getProperty(self.handle, 'object.kind')
    end,
}

-- Setters of those fields that can be set. The world coordinates are fields because the properties `pose`, `position`
-- and `quaternion` are in the parent's frame.
local setters = {
    parent = function(self, above)
        old.setObjectParent(self.handle, above and bare(above) or -1, true)
    end,
    worldPosition = function(self, x)
        old.setObjectPosition(self.handle, x, old.handle_world)
    end,
    worldQuaternion = function(self, x)
        old.setObjectQuaternion(self.handle, x, old.handle_world)
    end,
}

function fields.worldPosition(self)
    return old.getObjectPosition(self.handle, old.handle_world)
end

function fields.worldQuaternion(self)
    return old.getObjectQuaternion(self.handle, old.handle_world)
end

local methods = {
    -- Searches relative to the object: './x' is a child, '../x' a sibling.
    getObject = function(self, path, options)
        local more = { proxy = self.handle }
        for k, v in pairs(options or {}) do
            more[k] = v
        end
        return wrap(old.getObject(path, more))
    end,
    getDescendants = function(self)
        return objects(old.getObjectsInTree(self.handle, old.handle_all, 1))
    end,
    getParent = fields.parent,
    getProperty = function(self, name, options)
        return old.getProperty(self.handle, name, options)
    end,
    setProperty = function(self, name, value)
        old.setProperty(self.handle, name, bare(value))
    end,
    remove = function(self)
        old.removeObjects { self.handle }
    end,
}

-- Returns the value of a key: a method defined above, a group of properties, a property, or a method that calls a
-- function of `sim`. Raises an error for any other string.
local function read(self, key, own_methods, own_method)
    if own_methods[key] then
        return own_methods[key]
    end
    if type(key) ~= 'string' then
        return nil
    elseif key == 'customData' or key == 'signal' then
        return group(rawget(self, 'handle'), key)
    end
    local value = old.getProperty(rawget(self, 'handle'), key, { noError = true })
    if value ~= nil then
        return value
    end
    local f = own_method(key, rawget(self, 'handle'))
    if f then
        return function(_, ...)
            if own_methods == methods then
                return call(f, self, ...)
            end
            return call(f, ...)
        end
    end
    error("there is no property or method '" .. key .. "': expected a property of docs/reference/properties.md, or the name of "
        .. 'a function of sim', 2)
end

function Object.__index(self, key)
    if fields[key] then
        return fields[key](self)
    end
    return read(self, key, methods, method)
end

function Object.__newindex(self, key, value)
    if setters[key] then
        setters[key](self, value)
    else
        old.setProperty(rawget(self, 'handle'), key, bare(value))
    end
end

function Object.__eq(a, b)
    return a.handle == b.handle
end

function Object.__tostring(self)
    return string.format("object %d '%s'", self.handle, old.getObjectAlias(self.handle, 1))
end

function wrap(handle)
    if handle == -1 or handle == nil then
        return nil
    end
    return setmetatable({ handle = handle }, Object)
end

-- Creates the object for the scene or the program, whose functions are those of `sim` without a handle as the first
-- argument.
local function world(handle, own_methods)
    return setmetatable({ handle = handle }, {
        __index = function(self, key)
            return read(self, key, own_methods, function(name)
                local f = old[name]
                if type(f) == 'function' and name:match('^[gs]et%w+Property$') then
                    return function(...)
                        return f(handle, ...)
                    end
                end
                return type(f) == 'function' and f or nil
            end)
        end,
        __newindex = function(_, key, value)
            old.setProperty(handle, key, bare(value))
        end,
    })
end

local scene = {
    getObject = function(_, path, options)
        return wrap(old.getObject(path, options))
    end,
    getObjects = function()
        return objects(old.getObjectsInTree(old.handle_scene, old.handle_all, 0))
    end,
    start = function() return old.startSimulation() end,
    stop = function() return old.stopSimulation() end,
    pause = function() return old.pauseSimulation() end,
}
for name, f in pairs { getProperty = old.getProperty, setProperty = old.setProperty } do
    scene[name] = function(self, ...)
        return call(f, self.handle, ...)
    end
end

local sim_2 = {
    version = 2,
    scene = world(old.handle_scene, scene),
    app = world(old.handle_app, { getProperty = scene.getProperty, setProperty = scene.setProperty }),
    Object = function(handle) return wrap(handle) end,
}

-- The object to which the script belongs.
local has_object, own = pcall(old.getObject, '.')
sim_2.self = has_object and wrap(own) or nil

local functions = {}
return setmetatable(sim_2, {
    __index = function(_, name)
        local there = old[name]
        if type(there) ~= 'function' then
            return there
        end
        functions[name] = functions[name] or function(...)
            return call(there, ...)
        end
        return functions[name]
    end,
})
