-- Checks the commands of guard: each failure raises an error with a description, and afterwards the commands still
-- work.
local function fails(with, f, ...)
    local ok, why = pcall(f, ...)
    assert(not ok and why:find(with, 1, true), tostring(why))
    print(why)
end

function sysCall_init()
    assert(guard.at({5, 6}, 2) == 6)
    fails('there is no element 3 in a table of 2', guard.at, {5, 6}, 3)
    fails('there is no element 0', guard.at, {5, 6}, 0)
    fails('there is no element 1', guard.at, {}, 1)
    assert(guard.number('1.5') == 1.5)
    fails('stod', guard.number, 'five')
    fails('stod', guard.number, '1e999')
    fails('more text after', guard.number, '5 apples')
    local squares = guard.map({1, 2, 3}, function(x) return x * x end)
    assert(#squares == 3 and squares[3] == 9)
    fails('did not return a number', guard.map, {1}, function() end)
    fails('no luck', guard.map, {1}, function() error('no luck') end)
    assert(guard.at({7}, 1) == 7)
end

function sysCall_actuation()
    fails('there is no element 9', guard.at, {1}, 9)
    calls = (calls or 0) + 1
end

function sysCall_cleanup() assert(calls and calls >= 5) end
