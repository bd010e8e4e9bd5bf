-- 2 N on 1 kg, three steps of four, 50 ms each: 0.3 m/s after four steps; then twice the gain, by `configure`.
local step = 0

function sysCall_init()
    puck, fan = sim.getObject('/puck'), sim.getObject('/puck/fan')
end

function sysCall_sensing()
    step = step + 1
    local v = sim.getObjectVelocity(puck)[3]
    if step == 4 then
        print(string.format('%.3f', v))
        tatu.set(fan, 'museum_fan.gain', 8)
    elseif step == 8 then
        print(string.format('%.3f', v))
        local ok = pcall(tatu.set, fan, 'museum_fan.gain', -1)
        assert(not ok)
    end
end
