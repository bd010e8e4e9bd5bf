-- Turns the visible propellers, slowed down so that the eye can follow.

local SLOWER = 25

function sysCall_init()
    rotors = {}
    for i = 0, 3 do
        local rotor = sim.getObject(':/rotor_' .. i)
        rotors[i + 1] = {
            rotor = rotor, joint = sim.getObject(':/rotor_' .. i .. '_joint'), angle = 0,
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
