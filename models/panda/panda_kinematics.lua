-- Kinematics of the Panda in closed form. Other scripts call its functions:
--
--     local script = sim.getScript(sim.scripttype_simulation, sim.getObject(':/kinematics'))
--     local kinematics = sim.getScriptFunctions(script)
--     local pose = kinematics:forward(joints)
--     local solutions = kinematics:inverse(pose, q7, near)
--
-- Joints are lists of seven angles in rad. Poses are those of the flange (panda_link8) in the frame of panda_link0, as
-- {x, y, z, qx, qy, qz, qw}, m. The inverse resolves the arm's redundancy by the angle of joint 7: once it is fixed,
-- the centre of the wrist is known, the elbow follows from a triangle, and the remaining angles from one equation each.

local D1, D3, D5, DF = 0.333, 0.316, 0.384, 0.107      -- m: base to shoulder, to elbow, to wrist; joint 7 to flange
local A4, A7 = 0.0825, 0.088                           -- m: offsets of the elbow and of the flange's axis
local LOWER = {-2.8973, -1.7628, -2.8973, -3.0718, -2.8973, -0.0175, -2.8973}      -- rad
local UPPER = {2.8973, 1.7628, 2.8973, -0.0698, 2.8973, 3.7525, 2.8973}            -- rad
local SLACK = 1e-9                                     -- rad: tolerance of the limits for rounding errors

-- Rotation matrices are lists of nine elements in row-major order.
local function times(a, b)
    local c = {}
    for row = 0, 6, 3 do
        for column = 1, 3 do
            c[row + column] = a[row + 1] * b[column] + a[row + 2] * b[column + 3] + a[row + 3] * b[column + 6]
        end
    end
    return c
end

local function rotated(a, v)
    return {
        a[1] * v[1] + a[2] * v[2] + a[3] * v[3],
        a[4] * v[1] + a[5] * v[2] + a[6] * v[3],
        a[7] * v[1] + a[8] * v[2] + a[9] * v[3],
    }
end

local function unrotated(a, v)
    return {
        a[1] * v[1] + a[4] * v[2] + a[7] * v[3],
        a[2] * v[1] + a[5] * v[2] + a[8] * v[3],
        a[3] * v[1] + a[6] * v[2] + a[9] * v[3],
    }
end

local function about_z(angle)
    local c, s = math.cos(angle), math.sin(angle)
    return {c, -s, 0, s, c, 0, 0, 0, 1}
end

local UP = {1, 0, 0, 0, 0, -1, 0, 1, 0}                -- a quarter turn about x
local DOWN = {1, 0, 0, 0, 0, 1, 0, -1, 0}              -- and back

local function matrix_of(qx, qy, qz, qw)
    return {
        1 - 2 * (qy * qy + qz * qz), 2 * (qx * qy - qz * qw), 2 * (qx * qz + qy * qw),
        2 * (qx * qy + qz * qw), 1 - 2 * (qx * qx + qz * qz), 2 * (qy * qz - qx * qw),
        2 * (qx * qz - qy * qw), 2 * (qy * qz + qx * qw), 1 - 2 * (qx * qx + qy * qy),
    }
end

local function quaternion_of(m)
    local w = math.sqrt(math.max(0, 1 + m[1] + m[5] + m[9])) / 2
    local x = math.sqrt(math.max(0, 1 + m[1] - m[5] - m[9])) / 2
    local y = math.sqrt(math.max(0, 1 - m[1] + m[5] - m[9])) / 2
    local z = math.sqrt(math.max(0, 1 - m[1] - m[5] + m[9])) / 2
    -- The largest element determines the signs of the others.
    if w >= x and w >= y and w >= z then
        return (m[8] - m[6]) / (4 * w), (m[3] - m[7]) / (4 * w), (m[4] - m[2]) / (4 * w), w
    elseif x >= y and x >= z then
        return x, (m[2] + m[4]) / (4 * x), (m[3] + m[7]) / (4 * x), (m[8] - m[6]) / (4 * x)
    elseif y >= z then
        return (m[2] + m[4]) / (4 * y), y, (m[6] + m[8]) / (4 * y), (m[3] - m[7]) / (4 * y)
    end
    return (m[3] + m[7]) / (4 * z), (m[6] + m[8]) / (4 * z), z, (m[4] - m[2]) / (4 * z)
end

-- For each joint: its position in the frame of the previous link, and its quarter turn about x.
local FRAMES = {
    {{0, 0, D1}}, {{0, 0, 0}, DOWN}, {{0, -D3, 0}, UP}, {{A4, 0, 0}, UP},
    {{-A4, D5, 0}, DOWN}, {{0, 0, 0}, UP}, {{A7, 0, 0}, UP},
}

--- Returns the pose of the flange.
function forward(joints)
    local m, p = {1, 0, 0, 0, 1, 0, 0, 0, 1}, {0, 0, 0}
    for i, frame in ipairs(FRAMES) do
        local d = rotated(m, frame[1])
        p = {p[1] + d[1], p[2] + d[2], p[3] + d[3]}
        if frame[2] then m = times(m, frame[2]) end
        m = times(m, about_z(joints[i]))
    end
    return {p[1] + DF * m[3], p[2] + DF * m[6], p[3] + DF * m[9], quaternion_of(m)}
end

local function wrapped(angle, low, high)
    while angle < low - SLACK do angle = angle + 2 * math.pi end
    while angle > high + SLACK do angle = angle - 2 * math.pi end
    if angle < low - SLACK then return nil end
    return math.min(math.max(angle, low), high)
end

local function within_limits(joints)
    for i = 1, 7 do
        joints[i] = wrapped(joints[i], LOWER[i], UPPER[i])
        if not joints[i] then return nil end
    end
    return joints
end

local function distance(a, b)
    local sum = 0
    for i = 1, 7 do sum = sum + (a[i] - b[i]) ^ 2 end
    return sum
end

--- Returns all joint angles that put the flange at `pose` with joint 7 at `q7`: a list of up to eight solutions,
-- nearest to `near` first (default: the ready pose); empty if the pose is out of reach.
function inverse(pose, q7, near)
    near = near or {0, -math.pi / 4, 0, -3 * math.pi / 4, 0, math.pi / 2, math.pi / 4}
    local m7 = matrix_of(pose[4], pose[5], pose[6], pose[7])
    local m6 = times(times(m7, about_z(-q7)), DOWN)
    local wrist = {}
    for i = 1, 3 do
        wrist[i] = pose[i] - DF * m7[3 * i] - A7 * m6[3 * i - 2]
    end
    -- The shoulder as seen from the wrist, in frame 6.
    local v = unrotated(m6, {-wrist[1], -wrist[2], D1 - wrist[3]})
    local upper, lower = math.sqrt(D3 ^ 2 + A4 ^ 2), math.sqrt(D5 ^ 2 + A4 ^ 2)
    local square = v[1] ^ 2 + v[2] ^ 2 + v[3] ^ 2
    local cosine = (upper ^ 2 + lower ^ 2 - square) / (2 * upper * lower)
    local solutions = {}
    if math.abs(cosine) > 1 then return solutions end
    local straight = math.atan(D3, A4) + math.atan(D5, A4)
    for _, angle in ipairs{math.acos(cosine), 2 * math.pi - math.acos(cosine)} do
        local q4 = straight - angle
        -- The shoulder as seen from the wrist, in frame 4; its z is 0.
        local ux = -A4 * math.cos(q4) - D3 * math.sin(q4) + A4
        local uy = A4 * math.sin(q4) - D3 * math.cos(q4) - D5
        -- Joint 6 rotates v until its component along the forearm is uy.
        local sine = uy / math.sqrt(v[1] ^ 2 + v[2] ^ 2)
        if math.abs(sine) <= 1 then
            local phase, first = math.atan(v[2], v[1]), math.asin(sine)
            for _, q6 in ipairs{first - phase, math.pi - first - phase} do
                local along = math.cos(q6) * v[1] - math.sin(q6) * v[2]
                local sign = ux < 0 and -1 or 1
                local q5 = math.atan(sign * v[3], sign * along)
                local m5 = times(times(m6, about_z(-q6)), DOWN)
                local m4 = times(times(m5, about_z(-q5)), UP)
                local m3 = times(times(m4, about_z(-q4)), DOWN)
                -- m3 is a rotation about z by q1, about y by q2, and about z by q3.
                local bend = math.acos(math.min(math.max(m3[9], -1), 1))
                for _, q2 in ipairs{bend, -bend} do
                    local q1, q3
                    if math.abs(math.sin(q2)) > 1e-9 then
                        local s = q2 < 0 and -1 or 1
                        q1 = math.atan(s * m3[6], s * m3[3])
                        q3 = math.atan(s * m3[8], -s * m3[7])
                    else
                        -- The axes of joints 1 and 3 coincide: joint 1 keeps its angle.
                        q1 = near[1]
                        q3 = math.atan(m3[4], m3[1]) - q1
                    end
                    local joints = within_limits({q1, q2, q3, q4, q5, q6, q7})
                    if joints then solutions[#solutions + 1] = joints end
                end
            end
        end
    end
    table.sort(solutions, function(a, b) return distance(a, near) < distance(b, near) end)
    return solutions
end
