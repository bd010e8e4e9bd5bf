function sysCall_init()
    local about, n = example.describe(2, 'arm', {1, 2, 3}, function(sum) return sum / 2 end)
    print(about.name, about.scaled[3] == 6, about.sum == 6, about.called == 3, n == 3)
    local ok, why = pcall(example.refuse, 'not today')
    print(ok, tostring(why):find('not today') ~= nil)
    print(pcall(example.describe, 'two', 'arm', {1}, print) == false)
    example.later(function() return 'now' end)
    print(example.fire(), pcall(example.fire) == false)
    print(example.count(), example.count())
end

function sysCall_thread()
    print(string.format('%.2f', example.nextStep()))
end
