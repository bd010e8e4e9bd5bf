-- Turns the visible propellers, slowed down so that the eye can follow.

local SLOWER = 100

function sysCall_init()
    rotors = {}
    for i = 1, 4 do
        local rotor = sim.getObject(':/m' .. i)
        rotors[i] = {
            rotor = rotor, joint = sim.getObject(':/m' .. i .. '_joint'), angle = 0,
            sense = tatu.get(rotor, 'propeller.turns') == 'clockwise' and -1 or 1,
        }
    end
end

function sysCall_sensing()
    for _, r in ipairs(rotors) do
        local speed = tatu.read(r.rotor).speed or 0
        r.angle = (r.angle + r.sense * speed / SLOWER * sim.getSimulationTimeStep()) % (2 * math.pi)
        sim.setJointPosition(r.joint, r.angle)
    end
end
