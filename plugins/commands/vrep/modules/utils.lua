-- Helper functions that scripts for V-REP 3.4 to 4.6 load by `require 'utils'` or `include('/lua/name.lua')`.

local type, pairs, tostring = type, pairs, tostring

-- Converts a value to text in the format of older versions: without spaces, with double quotes.
local function text(v)
    if type(v) == 'table' then
        return table.tostring(v)
    elseif type(v) ~= 'string' then
        return tostring(v)
    end
    v = v:gsub('\n', '\\n')
    if v:find('"', 1, true) and not v:find("'", 1, true) then
        return "'" .. v .. "'"
    end
    return '"' .. v:gsub('"', '\\"') .. '"'
end

table.val_to_str = text

function table.key_to_str(k)
    if type(k) == 'string' and k:match('^[_%a][_%a%d]*$') then
        return k
    end
    return '[' .. text(k) .. ']'
end

function table.tostring(t)
    local out, n = {}, 0
    for i, v in ipairs(t) do
        n = i
        out[i] = text(v)
    end
    for k, v in pairs(t) do
        if math.type(k) ~= 'integer' or k < 1 or k > n then
            out[#out + 1] = table.key_to_str(k) .. '=' .. text(v)
        end
    end
    return '{' .. table.concat(out, ',') .. '}'
end

function math.hypotn(a, b)
    local sum = 0
    for i = 1, #a do
        sum = sum + (a[i] - b[i]) ^ 2
    end
    return math.sqrt(sum)
end

function string.split(s, pattern)
    local out, at = {}, 1
    while true do
        local first, last = s:find(pattern, at)
        if not first or last < first then
            break
        end
        out[#out + 1] = s:sub(at, first - 1)
        at = last + 1
    end
    out[#out + 1] = s:sub(at)
    return out
end

function string.splitlines(s)
    return s:split('\r?\n')
end

function getObjectsWithTag(tag, models_only)
    local out = {}
    for _, h in ipairs(sim.getObjectsWithTag(tag, models_only)) do
        out[#out + 1] = h
    end
    return out
end

function getObjectHandle_noError(name)
    return sim.getObject(name:sub(1, 1) == '/' and name or '/' .. name, { noError = true })
end

function include(file)
    return require((file:gsub('^.*[/\\]', ''):gsub('%.lua$', '')))
end

return {}
