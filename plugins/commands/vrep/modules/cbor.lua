-- `org.conman.cbor`: converts Lua values, including tables, to CBOR (RFC 8949), and back.

local cbor = {}
local pack, unpack, type, pairs = string.pack, string.unpack, type, pairs

-- Returns the initial byte of a major type, followed by the argument `n` in its shortest form.
local function head(major, n)
    if n < 24 then
        return pack('B', major << 5 | n)
    elseif n < 0x100 then
        return pack('>BB', major << 5 | 24, n)
    elseif n < 0x10000 then
        return pack('>BI2', major << 5 | 25, n)
    elseif n < 0x100000000 then
        return pack('>BI4', major << 5 | 26, n)
    end
    return pack('>BI8', major << 5 | 27, n)
end

-- Returns the bits of a number as a 16-bit float, or nil if this would not be exact.
local function half(x)
    if x ~= x then
        return 0x7e00
    end
    local sign = (x < 0 or 1 / x < 0) and 0x8000 or 0
    local size = math.abs(x)
    if size == 0 or size == math.huge then
        return sign | (size == 0 and 0 or 0x7c00)
    end
    -- Below 2^-14, half-precision numbers are spaced by 2^-24; above, there are 1024 of them for each power of 2.
    if size < 2.0 ^ -14 then
        local steps = size * 2.0 ^ 24
        return steps == math.floor(steps) and sign | math.floor(steps) or nil
    elseif size > 65504 then
        return nil
    end
    local e = 0
    while size >= 2 do size, e = size / 2, e + 1 end
    while size < 1 do size, e = size * 2, e - 1 end
    local steps = (size - 1) * 1024
    return steps == math.floor(steps) and sign | (e + 15) << 10 | math.floor(steps) or nil
end

local function float(x)
    local bits = half(x)
    if bits then
        return pack('>BI2', 0xf9, bits)
    end
    local single = pack('>f', x)
    if unpack('>f', single) == x then
        return '\xfa' .. single
    end
    return pack('>Bd', 0xfb, x)
end

local MOST_DEPTH = 100

local function encode(v, depth)
    local kind = type(v)
    if v == nil then
        return '\xf6'
    elseif kind == 'boolean' then
        return v and '\xf5' or '\xf4'
    elseif math.type(v) == 'integer' then
        return v >= 0 and head(0, v) or head(1, -1 - v)
    elseif kind == 'number' then
        return float(v)
    elseif kind == 'string' then
        local text = utf8.len(v) and not v:find('[%z\1-\6\14-\31]')
        return head(text and 3 or 2, #v) .. v
    elseif kind ~= 'table' then
        error('Cannot encode ' .. kind, 0)
    elseif depth > MOST_DEPTH then
        error('Cannot encode tables nested more than ' .. MOST_DEPTH .. ' deep', 0)
    end
    local meta = getmetatable(v)
    if type(meta) == 'table' and meta.__tocbor then
        return meta.__tocbor(v)
    end
    local out = {}
    if #v > 0 then
        for i = 1, #v do
            out[i] = encode(v[i], depth + 1)
        end
        return head(4, #v) .. table.concat(out)
    end
    local n = 0
    for k, e in pairs(v) do
        n = n + 1
        out[n] = encode(k, depth + 1) .. encode(e, depth + 1)
    end
    return head(5, n) .. table.concat(out)
end

function cbor.encode(value)
    return encode(value, 0)
end

local function fail(at)
    error({ msg = 'no more input', pos = at }, 0)
end

local SIMPLE = { [20] = 'false', [21] = 'true', [22] = 'null', [23] = 'undefined' }
local SIZES = { [24] = 'B', [25] = '>I2', [26] = '>I4', [27] = '>I8' }

local decode

-- Returns the argument of an initial byte, or nil for an indefinite length, and the position after it.
local function argument(text, at, low)
    if low < 24 then
        return low, at
    elseif low == 31 then
        return nil, at
    end
    local form = SIZES[low] or error({ msg = 'invalid data', pos = at }, 0)
    if at + string.packsize(form) - 1 > #text then
        fail(at)
    end
    return unpack(form, text, at)
end

local function bytes(text, at, n, major, depth)
    if n then
        if n < 0 or n > #text - at + 1 then
            fail(at)
        end
        return text:sub(at, at + n - 1), at + n
    end
    -- A string of indefinite length consists of chunks up to a break byte.
    local pieces = {}
    while text:byte(at) ~= 0xff do
        if (text:byte(at) or fail(at)) >> 5 ~= major then
            error({ msg = 'invalid data', pos = at }, 0)
        end
        pieces[#pieces + 1], at = decode(text, at, depth + 1)
    end
    return table.concat(pieces), at + 1
end

local function items(text, at, n, depth, each)
    local i = 0
    while n == nil and text:byte(at) ~= 0xff or n and i < n do
        i = i + 1
        at = each(i, at)
    end
    return n and at or at + 1
end

local function number(low, text, at)
    local form = ({ [25] = '>I2', [26] = '>f', [27] = '>d' })[low]
    if at + string.packsize(form) - 1 > #text then
        fail(at)
    end
    local x, after = unpack(form, text, at)
    if low ~= 25 then
        return x, after, low == 26 and 'single' or 'double'
    end
    local sign, e, steps = x >= 0x8000 and -1 or 1, x >> 10 & 31, x & 1023
    if e == 31 then
        x = steps == 0 and math.huge or 0 / 0
    else
        x = e == 0 and steps * 2.0 ^ -24 or (1 + steps / 1024) * 2.0 ^ (e - 15)
    end
    return sign * x, after, 'half'
end

function decode(text, at, depth)
    local first = text:byte(at) or fail(at)
    if depth > MOST_DEPTH then
        error({ msg = 'nested too deep', pos = at }, 0)
    end
    local major, low = first >> 5, first & 31
    if low == 31 and (major < 2 or major > 5) then
        error({ msg = 'invalid data', pos = at }, 0)
    end
    if major == 7 then
        if low >= 25 and low <= 27 then
            return number(low, text, at + 1)
        elseif low == 20 or low == 21 then
            return low == 21, at + 1, SIMPLE[low]
        elseif low == 22 or low == 23 then
            return nil, at + 1, SIMPLE[low]
        end
        local n, after = argument(text, at + 1, low)
        return n, after, 'SIMPLE'
    end
    local n, after = argument(text, at + 1, low)
    if major == 0 then
        return n < 0 and n + 2.0 ^ 64 or n, after, 'UINT'
    elseif major == 1 then
        return n < 0 and -1 - (n + 2.0 ^ 64) or -1 - n, after, 'NINT'
    elseif major == 2 or major == 3 then
        local s
        s, after = bytes(text, after, n, major, depth)
        return s, after, major == 2 and 'BIN' or 'TEXT'
    elseif major == 6 then
        local value
        value, after = decode(text, after, depth + 1)
        return value, after, 'TAG_' .. n
    end
    local out = {}
    if major == 4 then
        after = items(text, after, n, depth, function(i, from)
            out[i], from = decode(text, from, depth + 1)
            return from
        end)
        return out, after, 'ARRAY'
    end
    after = items(text, after, n, depth, function(_, from)
        local key, value
        key, from = decode(text, from, depth + 1)
        value, from = decode(text, from, depth + 1)
        if key ~= nil and key == key then
            out[key] = value
        end
        return from
    end)
    return out, after, 'MAP'
end

-- Decodes the value at a position. Returns the value, the position after it, and the name of its CBOR type.
function cbor.decode(text, position)
    text = tostring(text)
    if #text == 0 then
        error('no input', 0)
    end
    return decode(text, position or 1, 0)
end

function cbor.pencode(value)
    local good, result = pcall(cbor.encode, value)
    if good then
        return result
    end
    return nil, result
end

function cbor.pdecode(text, position)
    local good, value, after, kind = pcall(cbor.decode, text, position)
    if good then
        return value, after, kind
    end
    local wrong = type(value) == 'table' and value or { msg = value, pos = 1 }
    return nil, wrong.pos, '__error', wrong.msg
end

function cbor.isnumber(kind)
    return cbor.isinteger(kind) or cbor.isfloat(kind)
end

function cbor.isinteger(kind)
    return kind == 'UINT' or kind == 'NINT'
end

function cbor.isfloat(kind)
    return kind == 'half' or kind == 'single' or kind == 'double'
end

cbor._VERSION = '1.0'

return cbor
