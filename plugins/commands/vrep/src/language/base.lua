-- Global functions that V-REP provides to every script: functions of older Lua versions, and small helpers.
local script = ...
-- Local copies, because scripts can redefine these globals.
local type, pairs, ipairs, tostring, select, print = type, pairs, ipairs, tostring, select, print
local math, table, string = math, table, string

table.getn = table.getn or function(t) return #t end
math.mod = math.mod or math.fmod
math.ldexp = math.ldexp or function(x, e) return x * 2.0 ^ e end
math.frexp = math.frexp or function(x)
    if x == 0 or x ~= x or x == math.huge or x == -math.huge then
        return x, 0
    end
    local e = 0
    while math.abs(x) >= 1 do x, e = x / 2, e + 1 end
    while math.abs(x) < 0.5 do x, e = x * 2, e - 1 end
    return x, e
end
loadstring = loadstring or load

function math.hypot(...)
    local sum = 0
    for i = 1, select("#", ...) do
        sum = sum + select(i, ...) ^ 2
    end
    return math.sqrt(sum)
end

function math.sign(x) return x > 0 and 1 or x < 0 and -1 or 0 end

-- Converts a table to Lua source: the array part first, then the other keys in a stable order. V-REP has two such
-- formats; this is the one with spaces and unescaped quotes.
local function write(t, separator, inside)
    if inside[t] then
        return "..."
    end
    inside[t] = true
    local out, rank = {}, { boolean = 1, number = 2, string = 3, ["function"] = 4, userdata = 5, thread = 6, table = 7 }
    local function value(v)
        if type(v) == "table" then
            return write(v, separator, inside)
        end
        return type(v) == "string" and "'" .. v .. "'" or tostring(v)
    end
    local n = 0
    for i, v in ipairs(t) do
        n = i
        out[#out + 1] = value(v)
    end
    local keys = {}
    for k in pairs(t) do
        if math.type(k) ~= "integer" or k < 1 or k > n then
            keys[#keys + 1] = k
        end
    end
    local function before(a, b)
        local x, y = rank[type(t[a])], rank[type(t[b])]
        if x ~= y then
            return x < y
        end
        if type(a) ~= type(b) then
            return type(a) < type(b)
        end
        if type(a) == "number" or type(a) == "string" then
            return a < b
        end
        return tostring(a) < tostring(b)
    end
    table.sort(keys, before)
    for _, k in ipairs(keys) do
        out[#out + 1] = (type(k) == "string" and k or "[" .. tostring(k) .. "]") .. " = " .. value(t[k])
    end
    inside[t] = nil
    return "{" .. table.concat(out, separator) .. "}"
end

-- `printf` was introduced in 2019, `table.tostring` in 4.6. A script's own definitions are executed later and replace
-- these functions.
if script.has("printf") then
    function printf(format, ...)
        local values = { ... }
        for i = 1, select("#", ...) do
            local v = values[i]
            values[i] = type(v) == "table" and write(v, ", ", {}) or v == nil and "nil" or v
        end
        print(string.format(format, table.unpack(values, 1, select("#", ...))))
    end
end
if script.has("tostring") then
    function table.tostring(t, separator) return write(t, separator or ", ", {}) end
end

-- Tables of V-REP's own scripts, in which some public scripts store values.
if script.has("_S") then _S = {} end
if script.has("__HIDDEN__") then __HIDDEN__ = {} end

return {}
