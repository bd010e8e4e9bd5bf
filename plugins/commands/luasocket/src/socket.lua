-- LuaSocket's objects, built on numbered sockets. Where versions 2 and 3 of LuaSocket differ, this follows version 3.
local luasocket = luasocket
local error, ipairs, math, rawget, select, setmetatable, string, table, tonumber, tostring, type, unpack, pcall, getmetatable =
    error, ipairs, math, rawget, select, setmetatable, string, table, tonumber, tostring, type, table.unpack, pcall, getmetatable

local M = { _VERSION = 'LuaSocket 3.1.0', BLOCKSIZE = 2048, _DATAGRAMSIZE = 8192, _SETSIZE = 1024, _SOCKETINVALID = -1, dns = {} }
-- Key of an object's private state: socket number (nil if closed), class, timeouts, byte counts.
local OWN = {}
local methods = {}
local meta = { __metatable = false }

function meta.__index(object, key)
    if key == 'class' then return rawget(object, OWN).class end
    return methods[key]
end
function meta.__newindex() error('fields of LuaSocket objects cannot be set', 2) end
function meta.__tostring(object)
    local own = rawget(object, OWN)
    return own.class .. ': ' .. own.id
end
local function new(class, number)
    local own = { class = class, number = number, block = -1, total = -1, sent = 0, received = 0, id = number or 'new' }
    return setmetatable({ [OWN] = own }, meta)
end

local function bad(argument, method, text)
    error(string.format("bad argument #%d to '%s' (%s)", argument, method, text), 3)
end

-- Returns the private state of an object that belongs to one of the given classes; raises an error for any other value.
local function own_of(object, method, ...)
    local own = type(object) == 'table' and rawget(object, OWN)
    if own then
        for i = 1, select('#', ...) do
            local class = select(i, ...)
            if own.class:sub(1, #class) == class then return own end
        end
    end
    error(string.format("calling '%s' on bad self (%s expected)", method, (...)), 3)
end
local function number_of(own) return own.number or 0 end

-- Returns the timeout of a call in seconds; negative: no limit.
local function timeout_of(own)
    if own.block < 0 then return own.total end
    if own.total < 0 then return own.block end
    return math.min(own.block, own.total)
end

local function port_of(value, argument, method)
    local number = tonumber(value)
    if not number or number ~= math.floor(number) or number < 0 or number > 65535 then
        bad(argument, method, 'port expected, 0 to 65535, got ' .. tostring(value))
    end
    return math.floor(number)
end

-- Methods of all classes

function methods.close(object)
    local own = own_of(object, 'close', 'tcp', 'udp')
    if own.number then luasocket.close(own.number) end
    own.number, own.closed = nil, true
    return 1
end

function methods.settimeout(object, seconds, mode)
    local own = own_of(object, 'settimeout', 'tcp', 'udp')
    local value = seconds == nil and -1 or tonumber(seconds)
    if not value then bad(1, 'settimeout', 'number expected, got ' .. type(seconds)) end
    mode = mode == nil and 'b' or tostring(mode):sub(1, 1)
    if mode == 'b' then own.block = value
    elseif mode == 'r' or mode == 't' then own.total = value
    else bad(2, 'settimeout', 'invalid timeout mode') end
    return 1
end

function methods.gettimeout(object)
    local own = own_of(object, 'gettimeout', 'tcp', 'udp')
    return own.block, own.total
end

function methods.getsockname(object)
    local own = own_of(object, 'getsockname', 'tcp', 'udp')
    local ip, port = luasocket.name(number_of(own), false)
    if not ip then return nil, port end
    return ip, port, 'inet'
end

function methods.getpeername(object)
    local own = own_of(object, 'getpeername', 'tcp', 'udp')
    local ip, port = luasocket.name(number_of(own), true)
    if not ip then return nil, own.number and port or 'Transport endpoint is not connected' end
    return ip, port, 'inet'
end

local options = {
    reuseaddr = 'boolean', reuseport = 'boolean', keepalive = 'boolean', ['tcp-nodelay'] = 'boolean', broadcast = 'boolean',
    dontroute = 'boolean', linger = 'table', ['recv-buffer-size'] = 'number', ['send-buffer-size'] = 'number',
}
function methods.setoption(object, name, value)
    local own = own_of(object, 'setoption', 'tcp', 'udp')
    local expected = options[name]
    if not expected then bad(1, 'setoption', 'unsupported option `' .. tostring(name) .. "'") end
    if type(value) ~= expected then bad(2, 'setoption', expected .. ' expected, got ' .. type(value)) end
    if own.number and expected == 'boolean' then luasocket.setOption(own.number, name, value) end
    return 1
end

function methods.getfd() return -1 end
function methods.getfamily() return 'inet' end

function methods.dirty(object)
    local own = own_of(object, 'dirty', 'tcp', 'udp')
    return own.number ~= nil and luasocket.isDirty(own.number)
end

function methods.getstats(object)
    local own = own_of(object, 'getstats', 'tcp')
    local now = luasocket.time()
    return own.received, own.sent, own.since and now - own.since or 0
end

-- TCP

local function opened(own, class, number)
    own.class, own.number, own.since = class, number, luasocket.time()
    own.id = number
end

function methods.bind(object, host, port)
    local own = own_of(object, 'bind', 'tcp{master}')
    local number, failure = luasocket.listen(host, port_of(port, 2, 'bind'))
    if not number then return nil, failure end
    if own.number then luasocket.close(own.number) end
    own.number, own.id = number, number
    return 1
end

function methods.listen(object)
    local own = own_of(object, 'listen', 'tcp{master}', 'tcp{server}')
    if not own.number then return nil, 'Bad file descriptor' end
    own.class = 'tcp{server}'
    return 1
end

function methods.connect(object, host, port)
    local own = own_of(object, 'connect', 'tcp{master}', 'tcp{client}')
    port = port_of(port, 2, 'connect')
    if own.class == 'tcp{client}' and own.number then return nil, 'already connected' end
    if own.closed then return nil, 'closed' end
    if own.number then luasocket.close(own.number) end
    own.class, own.number = 'tcp{client}', nil
    local number, failure = luasocket.connect(tostring(host), port, timeout_of(own))
    if not number then return nil, failure end
    opened(own, 'tcp{client}', number)
    return 1
end

function methods.accept(object)
    local own = own_of(object, 'accept', 'tcp{server}')
    local number, failure = luasocket.accept(number_of(own), timeout_of(own))
    if not number then return nil, failure end
    local client = new('tcp{client}', number)
    rawget(client, OWN).since = luasocket.time()
    return client
end

function methods.send(object, data, first, last)
    local own = own_of(object, 'send', 'tcp{client}', 'udp{connected}')
    if type(data) ~= 'string' and type(data) ~= 'number' then
        bad(1, 'send', 'string expected, got ' .. type(data))
    end
    data = tostring(data)
    if own.class == 'udp{connected}' then
        local sent, failure = luasocket.send(number_of(own), data, timeout_of(own))
        if failure then return nil, failure end
        return sent
    end
    first, last = first or 1, last or -1
    if first < 0 then first = math.max(#data + first + 1, 1) elseif first == 0 then first = 1 end
    if last < 0 then last = #data + last + 1 elseif last > #data then last = #data end
    if first > last then return first - 1, nil, nil end
    local sent, failure = luasocket.send(number_of(own), data:sub(first, last), timeout_of(own))
    own.sent = own.sent + sent
    if failure then return nil, failure, first - 1 + sent end
    return first - 1 + sent, nil, nil
end

local function wanted(pattern)
    if pattern == nil then return '*l' end
    local number = tonumber(pattern)
    if number then
        if number < 0 then bad(1, 'receive', 'invalid receive pattern') end
        return math.floor(number)
    end
    local two = type(pattern) == 'string' and pattern:sub(1, 2)
    if two ~= '*l' and two ~= '*a' then bad(1, 'receive', 'invalid receive pattern') end
    return two
end

function methods.receive(object, pattern, prefix)
    local own = own_of(object, 'receive', 'tcp{client}', 'udp')
    if own.class:sub(1, 3) == 'udp' then
        local most = pattern == nil and 8192 or tonumber(pattern)
        if not most then bad(1, 'receive', 'number expected, got ' .. type(pattern)) end
        local data, failure = luasocket.receiveFrom(number_of(own), math.floor(most), timeout_of(own))
        if not data then return nil, failure end
        return data
    end
    pattern, prefix = wanted(pattern), prefix == nil and '' or tostring(prefix)
    local data, failure, partial = luasocket.receive(number_of(own), pattern, prefix, timeout_of(own))
    own.received = own.received + #(data or partial) - #prefix
    if not data then return nil, failure, partial end
    return data, nil, nil
end

function methods.shutdown(object, how)
    local own = own_of(object, 'shutdown', 'tcp{client}', 'tcp{server}')
    how = how == nil and 'both' or how
    if how ~= 'both' and how ~= 'send' and how ~= 'receive' then bad(1, 'shutdown', 'invalid shutdown method') end
    if own.number then luasocket.shutdown(own.number, how) end
    return 1
end

-- UDP

function methods.setsockname(object, host, port)
    local own = own_of(object, 'setsockname', 'udp', 'tcp{master}')
    if own.class == 'tcp{master}' then return methods.bind(object, host, port) end
    local number, failure = luasocket.bindDatagrams(own.number or 0, host, port_of(port, 2, 'setsockname'))
    if not number then return nil, failure end
    own.number, own.id = number, number
    return 1
end

local function datagrams(own)
    if own.number or own.closed then return own.number end
    own.number = luasocket.bindDatagrams(0, '*', 0)
    return own.number
end

function methods.setpeername(object, host, port)
    local own = own_of(object, 'setpeername', 'udp', 'tcp')
    if own.class:sub(1, 3) == 'tcp' then return methods.connect(object, host, port) end
    if host == '*' then
        if own.number then luasocket.bindDatagrams(own.number, '*', 0) end
        own.class = 'udp{unconnected}'
        return 1
    end
    datagrams(own)
    local done, failure = luasocket.connectDatagrams(number_of(own), host, port_of(port, 2, 'setpeername'))
    if not done then return nil, failure end
    own.class = 'udp{connected}'
    return 1
end

function methods.sendto(object, data, host, port)
    local own = own_of(object, 'sendto', 'udp{unconnected}')
    if own.closed then return nil, 'refused' end
    datagrams(own)
    local sent, failure = luasocket.sendTo(number_of(own), tostring(data), host, port_of(port, 3, 'sendto'))
    if not sent then return nil, failure end
    return sent
end

function methods.receivefrom(object, most)
    local own = own_of(object, 'receivefrom', 'udp{unconnected}')
    local data, address, port = luasocket.receiveFrom(number_of(own), math.floor(most or 8192), timeout_of(own))
    if not data then return nil, address end
    return data, address, port
end

-- The module

function M.tcp() return new('tcp{master}') end
function M.udp() return new('udp{unconnected}') end
M.tcp4, M.udp4 = M.tcp, M.udp

function M.bind(host, port, backlog)
    local server = M.tcp()
    local done, failure = server:bind(host, port)
    if not done then return nil, failure end
    server:listen(backlog)
    return server
end

function M.connect(host, port)
    local client = M.tcp()
    local done, failure = client:connect(host, port)
    if not done then return nil, failure end
    return client
end
M.connect4 = M.connect

-- Returns the numbers of the open sockets in a list, and adds them to `objects`, a map from numbers to objects.
local function listed(list, objects)
    local numbers = {}
    for _, object in ipairs(list or {}) do
        if type(object) == 'number' then error('attempt to index a number value', 3) end
        local own = type(object) == 'table' and rawget(object, OWN)
        if own and own.number then
            numbers[#numbers + 1] = own.number
            objects[own.number] = object
        end
    end
    return numbers
end

function M.select(read, write, seconds)
    local objects = {}
    local readable, writable = luasocket.select(listed(read, objects), listed(write, objects), tonumber(seconds) or -1)
    local function found(numbers)
        local out = {}
        for i, number in ipairs(numbers) do
            out[i] = objects[number]
            out[objects[number]] = i
        end
        return out
    end
    return found(readable), found(writable), #readable + #writable == 0 and 'timeout' or nil
end

M.gettime, M.sleep = luasocket.time, luasocket.sleep

function M.dns.gethostname() return 'localhost' end
function M.dns.toip(host)
    local all, failure = luasocket.addresses(host)
    if not all then return nil, failure end
    return all[1], { name = host, alias = {}, ip = all }
end
function M.dns.tohostname(address)
    local all, failure = luasocket.addresses(address)
    if not all then return nil, failure end
    return address, { name = address, alias = {}, ip = all }
end

-- LuaSocket's exceptions: `try` raises an error, which `protect` catches and returns as nil and a message.
local RAISED = {}
function M.newtry(finalizer)
    return function(...)
        if ... then return ... end
        if finalizer then pcall(finalizer) end
        error(setmetatable({ (select(2, ...)) }, RAISED), 0)
    end
end
M.try = M.newtry()
function M.protect(f)
    return function(...)
        local results = table.pack(pcall(f, ...))
        if results[1] then return unpack(results, 2, results.n) end
        local raised = results[2]
        if type(raised) == 'table' and getmetatable(raised) == RAISED then return nil, raised[1] end
        error(raised, 0)
    end
end
function M.skip(count, ...) return select(count + 1, ...) end
function M.choose(all)
    return function(name, one, two)
        if type(name) ~= 'string' then name, one, two = 'default', name, one end
        local make = all[name or 'nil']
        if not make then error('unknown key (' .. tostring(name) .. ')', 3) end
        return make(one, two)
    end
end

M.sinkt, M.sourcet = {}, {}
local function sink(last)
    return function(connection)
        return setmetatable({ getfd = function() return -1 end, dirty = function() return connection:dirty() end }, {
            __call = function(_, chunk)
                if chunk then return connection:send(chunk) end
                if last == 'close' then connection:close() end
                return 1
            end,
        })
    end
end
M.sinkt['close-when-done'], M.sinkt['keep-open'] = sink('close'), sink()
M.sinkt.default = M.sinkt['keep-open']
M.sourcet['until-closed'] = function(connection)
    local done
    return function()
        if done then return nil end
        local chunk, failure, partial = connection:receive(M.BLOCKSIZE)
        if chunk then return chunk end
        if failure ~= 'closed' then return nil, failure end
        connection:close()
        done = true
        return partial
    end
end
M.sourcet['by-length'] = function(connection, length)
    return function()
        if length <= 0 then return nil end
        local chunk, failure = connection:receive(math.min(M.BLOCKSIZE, length))
        if not chunk then return nil, failure end
        length = length - #chunk
        return chunk
    end
end
M.sourcet.default = M.sourcet['until-closed']
M.sink, M.source = M.choose(M.sinkt), M.choose(M.sourcet)

for _, name in ipairs { 'tcp6', 'udp6', 'connect6' } do
    M[name] = function() error("LuaSocket's " .. name .. ' is not provided', 2) end
end

-- LuaSocket 2, for which scripts of V-REP 3 were written, also sets a global variable.
if rawget(_G, 'socket') == nil then socket = M end
return M
