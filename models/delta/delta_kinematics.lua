-- Kinematics of the delta robot in closed form. Other scripts call its functions:
--
--     local script = sim.getScript(sim.scripttype_simulation, sim.getObject(':/kinematics'))
--     local kinematics = sim.getScriptFunctions(script)
--     local position = kinematics:forward(angles)
--     local angles = kinematics:inverse(position)
--
-- Angles are lists of three motor angles in rad, 0 for a level upper arm, positive down. Positions are those of the
-- platform's middle {x, y, z} in m in the frame of the base, which lies in the plane of the motors' axes.

local R0, L1, L2, R3 = 0.330, 0.420, 1.055, 0.125      -- m: axes of the motors, upper arm, rods, platform
local LOWEST, HIGHEST = math.rad(-40), math.rad(80)    -- rad

--- Returns the motor angles for a position of the platform, or nil and the reason.
function inverse(position)
    local angles = {}
    for i = 1, 3 do
        -- Coordinates along this arm, across it, and up.
        local turn = 2 * math.pi * (i - 1) / 3
        local along = position[1] * math.cos(turn) + position[2] * math.sin(turn)
        local across = position[2] * math.cos(turn) - position[1] * math.sin(turn)
        -- The elbow is L2 from the platform: a cos(q) + b sin(q) = c.
        local offset = R0 - R3 - along
        local a, b = 2 * offset * L1, 2 * position[3] * L1
        local c = L2 ^ 2 - L1 ^ 2 - offset ^ 2 - across ^ 2 - position[3] ^ 2
        local length = math.sqrt(a ^ 2 + b ^ 2)
        if math.abs(c) > length then return nil, 'out of reach of arm ' .. i end
        -- Of the two solutions, the one with the elbow outside.
        local q = math.atan(b, a) + math.acos(c / length)
        if q < LOWEST or q > HIGHEST then
            return nil, string.format('arm %d would be at %.1f degrees, beyond its limits', i, math.deg(q))
        end
        angles[i] = q
    end
    return angles
end

local function minus(a, b)
    return {a[1] - b[1], a[2] - b[2], a[3] - b[3]}
end

local function dot(a, b)
    return a[1] * b[1] + a[2] * b[2] + a[3] * b[3]
end

local function cross(a, b)
    return {a[2] * b[3] - a[3] * b[2], a[3] * b[1] - a[1] * b[3], a[1] * b[2] - a[2] * b[1]}
end

--- Returns the position of the platform for motor angles, or nil if the rods do not meet.
function forward(angles)
    -- The platform's middle is on three spheres of radius L2 about the elbows, moved inwards by R3.
    local p = {}
    for i = 1, 3 do
        local turn, radius = 2 * math.pi * (i - 1) / 3, R0 - R3 + L1 * math.cos(angles[i])
        p[i] = {radius * math.cos(turn), radius * math.sin(turn), -L1 * math.sin(angles[i])}
    end
    -- The middle of the circle through the three, and from there down, along the normal of their plane.
    local u, v = minus(p[2], p[1]), minus(p[3], p[1])
    local normal = cross(u, v)
    local square = dot(normal, normal)
    local to_middle = {}
    local x, y = cross(v, normal), cross(normal, u)
    for k = 1, 3 do to_middle[k] = (dot(u, u) * x[k] + dot(v, v) * y[k]) / (2 * square) end
    local rest = L2 ^ 2 - dot(to_middle, to_middle)
    if rest < 0 then return nil end
    local down = -math.sqrt(rest / square) * (normal[3] > 0 and 1 or -1)
    return {p[1][1] + to_middle[1] + down * normal[1], p[1][2] + to_middle[2] + down * normal[2],
        p[1][3] + to_middle[3] + down * normal[3]}
end
