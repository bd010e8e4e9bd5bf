-- Raises an error if the arm or the cube touches the wall, or if the cube is not on the left board in time.

local DEADLINE = 30                               -- s
local LEFT, NEAR = {0.45, 0.30}, 0.05             -- m

local wall, cube, moving, delivered

function sysCall_init()
    wall, cube = sim.getObject('/wall'), sim.getObject('/cube')
    moving = sim.createCollection(0)
    sim.addItemToCollection(moving, sim.handle_tree, sim.getObject('/panda/panda_joint2'), 0)
    sim.addItemToCollection(moving, sim.handle_single, cube, 0)
end

function sysCall_sensing()
    if sim.checkCollision(moving, wall) == 1 then
        error(string.format('at %.2f s, the wall was touched', sim.getSimulationTime()))
    end
    local p = sim.getObjectPosition(cube)
    local away = math.sqrt((p[1] - LEFT[1]) ^ 2 + (p[2] - LEFT[2]) ^ 2)
    if not delivered and away < NEAR and p[3] < 0.05 then
        delivered = true
        print(string.format('the cube is on the left board at %.1f s', sim.getSimulationTime()))
    end
    if not delivered and sim.getSimulationTime() > DEADLINE then
        error(string.format('the cube is %.2f m from the left board', away))
    end
end
