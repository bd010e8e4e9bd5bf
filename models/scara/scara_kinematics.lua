-- Kinematics of the SCARA in closed form. Other scripts call its functions:
--
--     local kinematics = sim.getScript(sim.scripttype_childscript, sim.getObject(':/kinematics'))
--     local joints = sim.callScriptFunction('inverse', kinematics, {0.4, 0.2, 0.1}, 0, 1)
--
-- Positions are those of the shaft's lower end in the frame of the base, m; its heading is about z, rad. The order of
-- joints is: arm 1, arm 2, shaft's turn (rad), shaft's slide (m, 0 at the top).

local COLUMN = 0.06         -- m, axis of joint 1 ahead of the base's origin
local ARM_1 = 0.31          -- m, from joint 1 to joint 2
local ARM_2 = 0.2615        -- m, from joint 2 to the shaft
local TOP = 0.182           -- m, height of the shaft's lower end with the slide at 0
local LIMITS = {
    {math.rad(-132), math.rad(132)},
    {math.rad(-150), math.rad(150)},
    {-2 * math.pi, 2 * math.pi},
    {-0.2, 0},
}

-- Returns the position {x, y, z} and heading of the shaft's lower end.
function forward(joints)
    local both = joints[1] + joints[2]
    local x = COLUMN + ARM_1 * math.cos(joints[1]) + ARM_2 * math.cos(both)
    local y = ARM_1 * math.sin(joints[1]) + ARM_2 * math.sin(both)
    return {x, y, TOP + joints[4]}, both + joints[3]
end

-- Returns the joint positions for a position and a heading, or nil if there is no solution. `elbow` is 1 for the elbow
-- to the right of the line from joint 1 to the shaft (the default), -1 for the left.
function inverse(position, heading, elbow)
    local x, y = position[1] - COLUMN, position[2]
    local cosine = (x ^ 2 + y ^ 2 - ARM_1 ^ 2 - ARM_2 ^ 2) / (2 * ARM_1 * ARM_2)
    if math.abs(cosine) > 1 then return nil end
    local q2 = (elbow or 1) * math.acos(cosine)
    local q1 = math.atan(y, x) - math.atan(ARM_2 * math.sin(q2), ARM_1 + ARM_2 * math.cos(q2))
    q1 = (q1 + math.pi) % (2 * math.pi) - math.pi
    -- Of the shaft angles that yield the heading, the one nearest to zero.
    local q3 = (heading - q1 - q2 + math.pi) % (2 * math.pi) - math.pi
    local joints = {q1, q2, q3, position[3] - TOP}
    for i, limit in ipairs(LIMITS) do
        if joints[i] < limit[1] - 1e-9 or joints[i] > limit[2] + 1e-9 then return nil end
    end
    return joints
end
