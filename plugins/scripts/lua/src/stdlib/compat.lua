-- Functions that were removed from Lua. Arguments: whether the dialect is old, and three helper functions.
local old, truncating, getfenv51, setfenv51 = ...
-- Local copies, because scripts may redefine these globals.
local type, pairs, tonumber, math = type, pairs, tonumber, math

unpack = unpack or table.unpack
math.pow = math.pow or function(x, y) return x ^ y end
math.atan2 = math.atan2 or function(y, x) return math.atan(y, x) end
math.log10 = math.log10 or function(x) return math.log(x, 10) end

if not old then return end

-- Truncates a number towards zero, as Lua 5.1 did for integer arguments.
local function integer(x)
  x = tonumber(x)
  return x and (x < 0 and math.ceil(x) or math.floor(x))
end

-- Functions of Lua 5.1, including those that it retained from 5.0.
loadstring = load
getfenv, setfenv = getfenv51, setfenv51
math.cosh = math.cosh or function(x) return (math.exp(x) + math.exp(-x)) / 2 end
math.sinh = math.sinh or function(x) return (math.exp(x) - math.exp(-x)) / 2 end
math.tanh = math.tanh or function(x) return 1 - 2 / (math.exp(2 * x) + 1) end
math.ldexp = math.ldexp or function(x, e) return x * 2.0 ^ e end
math.frexp = math.frexp or function(x)
  if x == 0 or x ~= x or x == math.huge or x == -math.huge then return x, 0 end
  local e = 0
  while math.abs(x) >= 1 do x, e = x / 2, e + 1 end
  while math.abs(x) < 0.5 do x, e = x * 2, e - 1 end
  return x, e
end
string.gfind = string.gmatch

function table.getn(t) return #t end
function table.maxn(t)
  local most = 0
  for k in pairs(t) do
    if type(k) == "number" and k > most then most = k end
  end
  return most
end
function table.foreach(t, f)
  for k, v in pairs(t) do
    local r = f(k, v)
    if r ~= nil then return r end
  end
end
function table.foreachi(t, f)
  for i = 1, #t do
    local r = f(i, t[i])
    if r ~= nil then return r end
  end
end

-- Lua 5.1 truncated fractions in arguments that must be integers.
math.random = truncating(math.random, 1)
string.char = truncating(string.char, 1)
string.rep = truncating(string.rep, 2)
string.sub = truncating(string.sub, 2)
string.byte = truncating(string.byte, 2)

-- In Lua 5.1, all numbers were floats, so the remainder of a division by 0 was NaN instead of an error.
local fmod = math.fmod
function math.fmod(x, y)
  if tonumber(y) == 0 and tonumber(x) then return 0 / 0 end
  return fmod(x, y)
end
math.mod = math.fmod

-- In Lua 5.1, positions outside of the list did not raise errors.
local insert, remove = table.insert, table.remove
function table.insert(t, ...)
  local at, value = ...
  if select("#", ...) ~= 2 or type(t) ~= "table" then return insert(t, ...) end
  at = integer(at)
  if at and at >= 1 and at <= #t + 1 then return insert(t, at, value) end
  if not at then return insert(t, ...) end
  for i = #t + 1, at + 1, -1 do t[i] = t[i - 1] end
  t[at] = value
end
function table.remove(t, at)
  if at == nil or type(t) ~= "table" then return remove(t) end
  at = integer(at)
  if at and (at < 1 or at > #t) then return end
  return remove(t, at)
end
table.concat = truncating(table.concat, 3)
unpack = truncating(unpack, 2)
