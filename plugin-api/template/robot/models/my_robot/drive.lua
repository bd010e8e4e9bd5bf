-- Drives up to a wall, and stops in front of it. Requires a proximity sensor `eye` in the slot `front`.
local me, eye, arrived

function sysCall_init()
    me, eye = sim.getObject('..'), sim.getObject('./eye')
end

function sysCall_actuation()
    local seen, distance = sim.readProximitySensor(eye)
    arrived = seen == 1 and distance < 0.5
    tatu.drive(me, arrived and 0 or 0.4, 0, 0)
end

function sysCall_cleanup()
    print(sim.getObjectAlias(me, 2) .. (arrived and ' has arrived' or ' is on its way'))
end
