local n = 0
function sysCall_sensing()
    n = n + 1
    local state, distance, point, object = sim.readProximitySensor(sim.getObject('/feeler'))
    if n > 4 then return end
    print(state, string.format('%.4f %.4f', distance, point[3]), object == sim.getObject('/wall'))
    if n == 2 then tatu.set(sim.getObject('/feeler'), 'example_range.step', 0.1) end
end
