function sysCall_init()
    local n = 0
    for _, shape in ipairs(sim.getObjectsInTree(sim.handle_scene, sim.sceneobject_shape)) do
        local p = sim.getObjectPosition(shape)
        print(sim.getObjectAlias(shape), string.format('%.1f %.1f %.1f', p[1], p[2], p[3]))
        n = n + 1
    end
    assert(n == 3, n)
end
