-- Kinematics of the youBot arm in closed form. Other scripts call its functions:
--
--     local kinematics = sim.getScript(sim.scripttype_childscript, sim.getObject(':/kinematics'))
--     local joints = sim.callScriptFunction('inverse', kinematics, {0.20, 0.10, 0.015}, math.pi, 0)
--
-- Positions are in the frame of arm_link_0, m. Joint angles are those of the URDF, rad; at zero, the arm is folded.
--
-- Joints 2, 3 and 4 turn about parallel axes, so the arm is a plane mechanism that joint 1 turns about the vertical:
--
--     heading   of the plane, about z                     170 deg - q1
--     a         of link 2, from the vertical              q2 - 65 deg
--     b         of link 3, from the vertical              a + q3 + 146 deg
--     pitch     of link 4 and the gripper                 b + q4 - 102.5 deg     0: up, 90 deg: level, 180 deg: down
--     roll      of the gripper about its own axis         167.5 deg - q5

local COLUMN = 0.024        -- m, axis of joint 1 ahead of the base's origin
local SHOULDER = {0.033, 0.115} -- m, axis of joint 2 ahead of that of joint 1, and above the base
local UPPER = 0.155         -- m, from joint 2 to joint 3
local FORE = 0.135          -- m, from joint 3 to joint 4
local FLANGE = {-0.002, 0.130}  -- m, from joint 4 to arm_link_5, across and along link 4
local TIP = {0.004, 0.078}  -- m, from arm_link_5 to the point where parts are held, across and along

local ZERO = {math.rad(170), math.rad(-65), math.rad(146), math.rad(-102.5), math.rad(167.5)}
local LIMITS = {{0, 5.899}, {0, 2.705}, {-5.184, 0}, {0, 3.578}, {0, 5.847}}

-- Returns the position {x, y, z} of the point between the fingers, and heading, pitch and roll of the gripper.
function forward(joints)
    local heading, roll = ZERO[1] - joints[1], ZERO[5] - joints[5]
    local a = ZERO[2] + joints[2]
    local b = a + ZERO[3] + joints[3]
    local pitch = b + ZERO[4] + joints[4]
    local across = FLANGE[1] + TIP[1] * math.cos(roll)
    local along = FLANGE[2] + TIP[2]
    local side = TIP[1] * math.sin(roll)
    local out = SHOULDER[1] + UPPER * math.sin(a) + FORE * math.sin(b)
    local up = SHOULDER[2] + UPPER * math.cos(a) + FORE * math.cos(b)
    out = out + along * math.sin(pitch) + across * math.cos(pitch)
    up = up + along * math.cos(pitch) - across * math.sin(pitch)
    local x = COLUMN + out * math.cos(heading) - side * math.sin(heading)
    local y = out * math.sin(heading) + side * math.cos(heading)
    return {x, y, up}, heading, pitch, roll
end

-- Returns an angle shifted by whole turns as near to the middle of a joint's range as possible; nil if it is outside
-- the range.
local function within(angle, joint)
    local low, high = LIMITS[joint][1], LIMITS[joint][2]
    local middle = (low + high) / 2
    angle = middle + (angle - middle + math.pi) % (2 * math.pi) - math.pi
    if angle >= low - 1e-9 and angle <= high + 1e-9 then return math.max(low, math.min(high, angle)) end
end

-- Returns the joint angles that move the point between the fingers to a position, with a pitch and a roll of the
-- gripper, or nil if there is no solution. `elbow` is 1 for the elbow above the line from shoulder to wrist (the
-- default), -1 for below.
function inverse(position, pitch, roll, elbow)
    elbow = elbow or 1
    -- When the gripper is rolled, the point is off the gripper's axis, and therefore off the arm's plane, by `side`.
    local side = TIP[1] * math.sin(roll)
    local x, y = position[1] - COLUMN, position[2]
    local radius = math.sqrt(x ^ 2 + y ^ 2)
    if radius < math.abs(side) + 1e-6 then return nil end
    local heading = math.atan(y, x) - math.asin(side / radius)
    local out = math.sqrt(radius ^ 2 - side ^ 2)

    -- From the point back to joint 4, as seen from joint 2.
    local across = FLANGE[1] + TIP[1] * math.cos(roll)
    local along = FLANGE[2] + TIP[2]
    out = out - SHOULDER[1] - along * math.sin(pitch) - across * math.cos(pitch)
    local up = position[3] - SHOULDER[2] - along * math.cos(pitch) + across * math.sin(pitch)

    -- The triangle of joints 2, 3 and 4.
    local reach = math.sqrt(out ^ 2 + up ^ 2)
    if reach > UPPER + FORE or reach < UPPER - FORE then return nil end
    local bend = elbow * math.acos(math.max(-1, math.min(1, (reach ^ 2 - UPPER ^ 2 - FORE ^ 2) / (2 * UPPER * FORE))))
    local a = math.atan(out, up) - math.atan(FORE * math.sin(bend), UPPER + FORE * math.cos(bend))
    local b = a + bend

    local joints = {ZERO[1] - heading, a - ZERO[2], bend - ZERO[3], pitch - b - ZERO[4], ZERO[5] - roll}
    for i = 1, 5 do
        joints[i] = within(joints[i], i)
        if not joints[i] then return nil end
    end
    return joints
end
