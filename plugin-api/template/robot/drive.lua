-- Drives up to a wall, and stops before it.
local me, eye, arrived

function sysCall_init()
    me, eye = sim.getObject('./body'), sim.getObject('./eye')
end

function sysCall_actuation()
    local seen, distance = sim.readProximitySensor(eye)
    arrived = seen == 1 and distance < 0.5
    tatu.drive(me, arrived and 0 or 0.4, 0, 0)
end

function sysCall_cleanup()
    print(arrived and 'my_robot has arrived' or 'my_robot is on its way')
end
