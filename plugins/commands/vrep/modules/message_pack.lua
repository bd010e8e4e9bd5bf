-- Encodes values as MessagePack (https://msgpack.org), and decodes them.
local module = {}

local strings, arrays, integers, numbers = "string_compat", "without_hole", "unsigned", "double"

local function choice(names, name, set)
    for _, n in ipairs(names) do
        if n == name then return set(name) end
    end
    error("expected one of " .. table.concat(names, ", ") .. ", found " .. tostring(name), 3)
end
-- Sets how strings are encoded: as text without the type `str 8` ("string_compat"), as text ("string") or as binary
-- data ("binary").
function module.set_string(name)
    choice({ "string_compat", "string", "binary" }, name, function(n) strings = n end)
end
-- Sets which tables are encoded as arrays: those with the keys 1 to n ("without_hole"), all tables whose keys are
-- positive integers ("with_hole"), or none ("always_as_map").
function module.set_array(name)
    choice({ "without_hole", "with_hole", "always_as_map" }, name, function(n) arrays = n end)
end
function module.set_integer(name)
    choice({ "unsigned", "signed" }, name, function(n) integers = n end)
end
function module.set_number(name)
    choice({ "integer", "float", "double" }, name, function(n) numbers = n end)
end

-- Returns the header for `n` items. Below `few`, it is the byte `base` + `n`; otherwise, it is the byte `one`, `two` or
-- `four` followed by `n` in as many bytes. If `one` is 0, that type does not exist.
local function head(n, base, few, one, two, four)
    if n < few then return string.char(base + n) end
    if one ~= 0 and n <= 0xFF then return string.pack(">BB", one, n) end
    if n <= 0xFFFF then return string.pack(">BI2", two, n) end
    if n <= 0xFFFFFFFF then return string.pack(">BI4", four, n) end
    error("cannot encode a value of " .. n .. " bytes or elements: expected fewer than 2^32", 0)
end

local function integer(n)
    if n >= 0 then
        if n <= 0x7F then return string.pack("B", n) end
        if integers == "unsigned" then
            if n <= 0xFF then return string.pack(">BB", 0xCC, n) end
            if n <= 0xFFFF then return string.pack(">BI2", 0xCD, n) end
            if n <= 0xFFFFFFFF then return string.pack(">BI4", 0xCE, n) end
            return string.pack(">Bi8", 0xCF, n)
        end
    elseif n >= -0x20 then
        return string.pack("b", n)
    end
    if n >= -0x80 and n <= 0x7F then return string.pack(">Bb", 0xD0, n) end
    if n >= -0x8000 and n <= 0x7FFF then return string.pack(">Bi2", 0xD1, n) end
    if n >= -0x80000000 and n <= 0x7FFFFFFF then return string.pack(">Bi4", 0xD2, n) end
    return string.pack(">Bi8", 0xD3, n)
end

local function number(x)
    if math.type(x) == "integer" then return integer(x) end
    if numbers == "integer" and math.tointeger(x) then return integer(math.tointeger(x)) end
    if numbers == "float" then return string.pack(">Bf", 0xCA, x) end
    return string.pack(">Bd", 0xCB, x)
end

local function text(s)
    if strings == "binary" then return head(#s, 0, 0, 0xC4, 0xC5, 0xC6) .. s end
    return head(#s, 0xA0, 0x20, strings == "string" and 0xD9 or 0, 0xDA, 0xDB) .. s
end

-- Returns the number of elements of a table that is encoded as an array, or nil for any other table.
local function length(t)
    if arrays == "always_as_map" then return nil end
    local count, last = 0, 0
    for k in pairs(t) do
        if math.type(k) ~= "integer" or k < 1 then return nil end
        count, last = count + 1, math.max(last, k)
    end
    if arrays == "with_hole" then return last end
    return count == last and count or nil
end

local encode

local function map(t, inside)
    local keys, rank = {}, { boolean = 1, number = 2, string = 3, table = 4 }
    for k in pairs(t) do keys[#keys + 1] = k end
    -- Keys are sorted, so that the same table always yields the same bytes.
    table.sort(keys, function(a, b)
        local x, y = rank[type(a)] or 5, rank[type(b)] or 5
        if x ~= y then return x < y end
        if type(a) == "number" or type(a) == "string" then return a < b end
        return tostring(a) < tostring(b)
    end)
    local out = { head(#keys, 0x80, 0x10, 0, 0xDE, 0xDF) }
    for _, k in ipairs(keys) do
        out[#out + 1] = encode(k, inside)
        out[#out + 1] = encode(t[k], inside)
    end
    return table.concat(out)
end

function encode(value, inside)
    local kind = type(value)
    if kind == "nil" then return "\xC0" end
    if kind == "boolean" then return value and "\xC3" or "\xC2" end
    if kind == "number" then return number(value) end
    if kind == "string" then return text(value) end
    if kind ~= "table" then error("cannot encode a " .. kind .. " as MessagePack", 0) end
    if inside[value] then error("cannot encode a table that contains itself as MessagePack", 0) end
    inside[value] = true
    local out
    local n = length(value)
    if n then
        local all = { head(n, 0x90, 0x10, 0, 0xDC, 0xDD) }
        for i = 1, n do all[#all + 1] = encode(value[i], inside) end
        out = table.concat(all)
    else
        out = map(value, inside)
    end
    inside[value] = nil
    return out
end

-- Returns a value encoded as a string of bytes.
function module.pack(value)
    return encode(value, {})
end

local DEEPEST = 100

local decode

local function read(s, at, format)
    local size = string.packsize(format)
    if at + size - 1 > #s then error("the data is truncated: it ends within a value", 0) end
    return string.unpack(format, s, at)
end
local function bytes(s, at, n)
    if at + n - 1 > #s then error("the data is truncated: it ends within a string", 0) end
    return s:sub(at, at + n - 1), at + n
end
local function list(s, at, n, depth)
    local out = {}
    for i = 1, n do out[i], at = decode(s, at, depth + 1) end
    return out, at
end
local function dictionary(s, at, n, depth)
    local out, key = {}, nil
    for _ = 1, n do
        key, at = decode(s, at, depth + 1)
        local value
        value, at = decode(s, at, depth + 1)
        if key ~= nil and key == key then out[key] = value end
    end
    return out, at
end

-- Formats of the numbers that follow the type bytes for numbers.
local NUMBERS = {
    [0xCA] = ">f", [0xCB] = ">d", [0xCC] = ">B", [0xCD] = ">I2", [0xCE] = ">I4", [0xCF] = ">i8", [0xD0] = ">b",
    [0xD1] = ">i2", [0xD2] = ">i4", [0xD3] = ">i8",
}
-- By type byte: the format of the count that follows the byte, and the function that reads the counted items.
local COUNTED = {
    [0xC4] = { ">B", bytes }, [0xC5] = { ">I2", bytes }, [0xC6] = { ">I4", bytes },
    [0xD9] = { ">B", bytes }, [0xDA] = { ">I2", bytes }, [0xDB] = { ">I4", bytes },
    [0xDC] = { ">I2", list }, [0xDD] = { ">I4", list }, [0xDE] = { ">I2", dictionary }, [0xDF] = { ">I4", dictionary },
}

function decode(s, at, depth)
    if depth > DEEPEST then error("the data is nested more than " .. DEEPEST .. " levels deep", 0) end
    local form
    form, at = read(s, at, "B")
    if form <= 0x7F then return form, at end
    if form >= 0xE0 then return form - 0x100, at end
    if form <= 0x8F then return dictionary(s, at, form - 0x80, depth) end
    if form <= 0x9F then return list(s, at, form - 0x90, depth) end
    if form <= 0xBF then return bytes(s, at, form - 0xA0) end
    if form == 0xC0 then return nil, at end
    if form == 0xC2 or form == 0xC3 then return form == 0xC3, at end
    if NUMBERS[form] then return read(s, at, NUMBERS[form]) end
    if COUNTED[form] then
        local n
        n, at = read(s, at, COUNTED[form][1])
        return COUNTED[form][2](s, at, n, depth)
    end
    error(string.format("the byte 0x%02X is not a type of MessagePack", form), 0)
end

-- Decodes a string that contains exactly one value.
function module.unpack(s)
    if type(s) ~= "string" then error("expected a string, found a " .. type(s), 2) end
    local value, at = decode(s, 1, 0)
    if at <= #s then error("expected a single value, but " .. #s - at + 1 .. " bytes follow it", 0) end
    return value
end

-- Iterates over the values in a string. Yields the position after each value, and the value.
function module.unpacker(s)
    local at = 1
    return function()
        if at > #s then return nil end
        local value
        value, at = decode(s, at, 0)
        return at, value
    end
end

return module
