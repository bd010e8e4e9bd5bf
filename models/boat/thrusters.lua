-- The drives: convert commands from -1 to 1 into thrust, as the boat's motor controllers do.
--
-- Other scripts call sim.callScriptFunction('setCommands', script, left, right).

-- Thrust, N, at the commands -1, -0.8 ... 1 (heron, heron_description, actuators).
local THRUST = {-19.88, -16.52, -12.6, -5.6, -1.4, 0, 2.24, 9.52, 21.28, 28, 33.6}
local SPIN = 0.8    -- rad/s of the visible propellers, per N

local function thrustAt(command)
    local place = math.max(0, math.min(10, (command + 1) * 5))
    local i = math.min(9, math.floor(place))
    return THRUST[i + 1] + (place - i) * (THRUST[i + 2] - THRUST[i + 1])
end

function sysCall_init()
    thrusters = {sim.getObject(':/left_thruster'), sim.getObject(':/right_thruster')}
    joints = {sim.getObject(':/left_propeller_joint'), sim.getObject(':/right_propeller_joint')}
    angles = {0, 0}
end

-- Sets the commands of both sides, -1 to 1.
function setCommands(left, right)
    tatu.set(thrusters[1], 'thruster.thrust', thrustAt(left))
    tatu.set(thrusters[2], 'thruster.thrust', thrustAt(right))
end

-- Returns the command that produces a thrust, N, clamped to the range of the table.
function commandFor(thrust)
    if thrust <= THRUST[1] then return -1 end
    for i = 1, 10 do
        if thrust <= THRUST[i + 1] then return (i - 1 + (thrust - THRUST[i]) / (THRUST[i + 1] - THRUST[i])) / 5 - 1 end
    end
    return 1
end

-- Turns the visible propellers, in opposite directions.
function sysCall_sensing()
    for i, side in ipairs{1, -1} do
        local force = tatu.read(thrusters[i]).force or 0
        angles[i] = (angles[i] + side * SPIN * force * sim.getSimulationTimeStep()) % (2 * math.pi)
        sim.setJointPosition(joints[i], angles[i])
    end
end
