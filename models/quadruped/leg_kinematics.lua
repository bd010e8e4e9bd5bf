-- Closed-form kinematics of one leg: hip about x, thigh and calf about y.
--
-- Frame of a leg: origin on the hip joint, x ahead, y left, z up, parallel to the trunk. `side` is 1 for left legs
-- and -1 for right ones. Joint angles are in rad, lengths in m. Other scripts call these functions by
--     legs = sim.getScriptFunctions(sim.getScript(sim.scripttype_simulation, sim.getObject('/go1/kinematics')))
--     hip, thigh, calf = legs:jointsOf(0, 0.08, -0.25, 1)

OFFSET = 0.08      -- m, lateral offset of the thigh joint from the hip joint
THIGH = 0.213      -- m, thigh joint to calf joint
CALF = 0.213       -- m, calf joint to the centre of the foot

-- Returns the centre of the foot for given joint angles.
function footOf(hip, thigh, calf, side)
    local x = -THIGH * math.sin(thigh) - CALF * math.sin(thigh + calf)
    local down = THIGH * math.cos(thigh) + CALF * math.cos(thigh + calf)
    local across = side * OFFSET
    return x, across * math.cos(hip) + down * math.sin(hip), across * math.sin(hip) - down * math.cos(hip)
end

-- Returns the joint angles that move the centre of the foot to (x, y, z), with the knee behind the line from hip to
-- foot. A point out of reach is replaced by the nearest reachable one on the same ray.
function jointsOf(x, y, z, side)
    -- In the front view, the leg forms a right triangle with the offset as one side.
    local down = math.sqrt(math.max(y * y + z * z - OFFSET * OFFSET, 1e-6))
    local hip = math.atan(z, y) - math.atan(-down, side * OFFSET)
    hip = (hip + math.pi) % (2 * math.pi) - math.pi
    -- In the plane of the leg, the law of cosines yields the knee angle.
    local cosine = (x * x + down * down - THIGH * THIGH - CALF * CALF) / (2 * THIGH * CALF)
    local calf = -math.acos(math.max(-1, math.min(1, cosine)))
    local thigh = math.atan(-x, down) - math.atan(CALF * math.sin(calf), THIGH + CALF * math.cos(calf))
    return hip, thigh, calf
end
