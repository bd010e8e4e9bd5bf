-- The world's part of the GPS: beside the tower too few satellites are visible, and the receiver has no fix.
-- This script reads the true position of the receiver; the robot does not.

local SHADOW_X, SHADOW_Y = 2.8, 3.2   -- m: the shadow is where x > SHADOW_X and |y| < SHADOW_Y

function sysCall_init()
    receiver = sim.getObject('..')
    noise = sim.getStringProperty(receiver, 'sensor.noise')
    hidden = false
end

function sysCall_actuation()
    local p = sim.getObjectPosition(receiver)
    local now = p[1] > SHADOW_X and math.abs(p[2]) < SHADOW_Y
    if now == hidden then return end
    hidden = now
    sim.setStringProperty(receiver, 'sensor.noise', hidden and 'position.dropout = 1.0' or noise)
end
