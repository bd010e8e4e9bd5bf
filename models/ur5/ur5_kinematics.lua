-- Kinematics of the UR5 and the UR5e in closed form.
--
-- Any script can call these functions:
--     local kinematics = sim.getScript(sim.scripttype_simulation, sim.getObject('/UR5/kinematics'))
--     local pose = sim.callScriptFunction('forward', kinematics, {0, -1.57, 1.57, -1.57, -1.57, 0})
--     local all = sim.callScriptFunction('inverse', kinematics, pose)
--
-- Joint angles are lists of six, rad, from the foot to the flange. A pose is that of the flange (tool0) in the frame of
-- the foot (base_link), as 12 numbers: the first three rows of a homogeneous matrix, position in m.

local LIMITS = {2 * math.pi, 2 * math.pi, math.pi, 2 * math.pi, 2 * math.pi, 2 * math.pi}    -- rad, symmetric about 0
local TINY = 1e-9                                                                            -- tolerance for zero

-- The geometry is that of the model: standard Denavit-Hartenberg parameters, m.
local d1, a2, a3, d4, d5, d6

function sysCall_init()
    local text = sim.readCustomStringData(sim.getObject(':'), 'dh')
    local numbers = {}
    for number in text:gmatch('%S+') do numbers[#numbers + 1] = tonumber(number) end
    d1, a2, a3, d4, d5, d6 = table.unpack(numbers)
end

-- Returns the product of two poses.
local function product(a, b)
    local c = {}
    for row = 0, 8, 4 do
        for column = 1, 4 do
            local sum = column == 4 and a[row + 4] or 0
            for k = 1, 3 do sum = sum + a[row + k] * b[4 * (k - 1) + column] end
            c[row + column] = sum
        end
    end
    return c
end

-- The pose of frame i in frame i - 1: a rotation by q about z, a translation d along z, a translation a along the new
-- x, and a rotation about that x with the given cosine and sine.
local function link(q, d, a, cosine, sine)
    local c, s = math.cos(q), math.sin(q)
    return {
        c, -s * cosine, s * sine, a * c,
        s, c * cosine, -c * sine, a * s,
        0, sine, cosine, d,
    }
end

-- The reference frame of the maker's tables is rotated by half a turn about z relative to base_link.
local function half_turn(pose)
    local p = {}
    for i = 1, 12 do p[i] = i <= 8 and -pose[i] or pose[i] end
    return p
end

-- Returns the angle, wrapped to (-pi, pi].
local function wrapped(angle)
    angle = angle % (2 * math.pi)
    return angle > math.pi and angle - 2 * math.pi or angle
end

-- Returns the arc cosine, tolerating rounding errors at the border of the workspace; nil beyond it.
local function arc_cosine(x)
    if math.abs(x) > 1 + TINY then return nil end
    return math.acos(math.max(-1, math.min(1, x)))
end

-- Returns the pose of the flange.
function forward(q)
    local pose = link(q[1], d1, 0, 0, 1)
    pose = product(pose, link(q[2], 0, a2, 1, 0))
    pose = product(pose, link(q[3], 0, a3, 1, 0))
    pose = product(pose, link(q[4], d4, 0, 0, 1))
    pose = product(pose, link(q[5], d5, 0, 0, -1))
    return half_turn(product(pose, link(q[6], d6, 0, 1, 0)))
end

-- Appends the two elbows that reach a wrist, given the angles of base, wrist 2 and wrist 3.
local function add_elbows(solutions, p, q1, q5, q6)
    local c1, s1, c5, s5, c6, s6 = math.cos(q1), math.sin(q1), math.cos(q5), math.sin(q5), math.cos(q6), math.sin(q6)
    -- Shoulder, elbow and wrist 1 turn about parallel axes: the rest is a plane problem, with coordinates along
    -- the arm (x) and upwards (y). A direction of the tool is u x' + v y' + w z'.
    local function plane(u, v, w)
        local x = u * p[1] + v * p[2] + w * p[3]
        local y = u * p[5] + v * p[6] + w * p[7]
        return c1 * x + s1 * y, u * p[9] + v * p[10] + w * p[11]
    end
    -- From the flange back by d6 along its z axis, then by d5 along the axis of wrist 2.
    local back_x, back_y = plane(0, 0, 1)
    local axis_x, axis_y = plane(-s6, -c6, 0)
    local x = c1 * p[4] + s1 * p[8] - d6 * back_x - d5 * axis_x
    local y = p[12] - d1 - d6 * back_y - d5 * axis_y
    -- The sum of the three angles is the direction of the axis x of wrist 1.
    local along_x, along_y = plane(c5 * c6, -c5 * s6, -s5)
    local sum = math.atan(along_y, along_x)

    local q3 = arc_cosine((x * x + y * y - a2 * a2 - a3 * a3) / (2 * a2 * a3))
    if not q3 then return end
    for _, elbow in ipairs{q3, -q3} do
        local q2 = math.atan(y, x) - math.atan(a3 * math.sin(elbow), a2 + a3 * math.cos(elbow))
        solutions[#solutions + 1] = {
            wrapped(q1), wrapped(q2), wrapped(elbow), wrapped(sum - q2 - elbow), wrapped(q5), wrapped(q6),
        }
    end
end

-- Returns all joint angles that put the flange at a pose: up to 8 solutions, each angle in (-pi, pi]; an empty list out
-- of reach. Where the axes of wrist 1 and wrist 3 are parallel, wrist 3 is free, and is set to the angle `free`,
-- default 0.
function inverse(pose, free)
    local p, solutions = half_turn(pose), {}
    -- The centre of wrist 2 is at distance d4 from the plane in which the arm moves.
    local x, y = p[4] - d6 * p[3], p[8] - d6 * p[7]
    local aside = arc_cosine(d4 / math.sqrt(x * x + y * y))
    if not aside then return solutions end
    for _, side in ipairs{aside, -aside} do
        local q1 = math.atan(y, x) + side + math.pi / 2
        local c1, s1 = math.cos(q1), math.sin(q1)
        local q5 = arc_cosine((s1 * p[4] - c1 * p[8] - d4) / d6)
        for _, wrist in ipairs(q5 and {q5, -q5} or {}) do
            local q6 = free or 0
            local sine = math.sin(wrist)
            if math.abs(sine) > TINY then
                q6 = math.atan((c1 * p[6] - s1 * p[2]) / sine, (s1 * p[1] - c1 * p[5]) / sine)
            end
            add_elbows(solutions, p, q1, wrist, q6)
        end
    end
    return solutions
end

-- Returns the solution that is nearest to given angles, with full turns added where that brings it nearer within the
-- limits of the joints; nil if the pose is out of reach.
function nearest(pose, q)
    local best, least
    for _, solution in ipairs(inverse(pose, q[6])) do
        local sum = 0
        for i = 1, 6 do
            local turned = solution[i] + 2 * math.pi * math.floor((q[i] - solution[i]) / (2 * math.pi) + 0.5)
            if math.abs(turned) <= LIMITS[i] then solution[i] = turned end
            sum = sum + (solution[i] - q[i]) ^ 2
        end
        if not least or sum < least then best, least = solution, sum end
    end
    return best
end
