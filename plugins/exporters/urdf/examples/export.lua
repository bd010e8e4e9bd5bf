local arm = sim.createPrimitiveShape(sim.primitiveshape_cuboid, {0.1, 0.1, 0.4})
sim.setObjectAlias(arm, 'arm')
local text, files, report = export.urdf(arm)
assert(text:find('<robot name="arm">', 1, true) and text:find('<box size="0.1 0.1 0.4"/>', 1, true))
