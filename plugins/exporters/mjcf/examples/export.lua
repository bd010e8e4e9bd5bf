local arm = sim.createPrimitiveShape(sim.primitiveshape_cuboid, {0.1, 0.1, 0.4})
sim.setObjectAlias(arm, 'arm')
local text, files, report = export.mjcf(arm)
assert(text:find('<mujoco model="arm">', 1, true) and text:find('type="box" size="0.05 0.05 0.2"', 1, true))
