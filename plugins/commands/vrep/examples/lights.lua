--- sim.getLightParameters
local light = sim.createDummy(0.01)
assert(sim.getLightParameters(light) == 1)
--- sim.setLightParameters
local light = sim.createDummy(0.01)
sim.setLightParameters(light, 0, nil, {1, 0.5, 0}, {0, 0, 0})
local state, zero, diffuse = sim.getLightParameters(light)
assert(state == 0 and diffuse[2] == 0.5)
