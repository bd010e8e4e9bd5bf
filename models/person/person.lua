-- The person walks from waypoint to waypoint. A waypoint counts as reached from a small distance, so that corners are
-- rounded. Feet stay in place on the floor while they carry: the angles of the legs are computed from the positions of
-- feet and hips.
--
-- The speed, m/s, can be changed at run time; 0 stops the person:
--     sim.writeCustomStringData(sim.getObject('/person'), 'speed', '0.6')

local REACHED = 0.3          -- m, from a waypoint
local TURNING = 1.8          -- rad/s, maximum turning rate
local STANCE = 0.6           -- fraction of a cycle in which a foot is on the floor
local LIFT = 0.07            -- m, lift of a swinging foot
local HIP_DROP = 0.035       -- m, by which the hips are lower than with straight legs
local BOB = 0.012            -- m, vertical motion of the hips
local ARMS = 0.42            -- rad, swing of the arms at 1.2 m/s
local STRETCH = 0.996        -- maximum extension, as a fraction of the legs' length

local function clamp(x, most)
    return math.max(-most, math.min(most, x))
end

function sysCall_init()
    base = sim.getObject(':')
    walker, body = sim.getObject(':/walker'), sim.getObject(':/body')
    thigh, shin, ankle = sim.readCustomStringData(base, 'legs'):match('(%S+) (%S+) (%S+)')
    thigh, shin, ankle = tonumber(thigh), tonumber(shin), tonumber(ankle)
    joints = {}
    for _, side in ipairs{'left', 'right'} do
        joints[side] = {}
        for _, name in ipairs{'hip', 'knee', 'ankle', 'shoulder'} do
            joints[side][name] = sim.getObject(':/' .. side .. '_' .. name)
        end
    end
    local path = sim.getObject(':/waypoints')
    local points = sim.getProperty(path, 'path.points')
    closed = sim.getBoolProperty(path, 'path.closed')
    waypoints = {}
    for i = 1, #points, 7 do waypoints[#waypoints + 1] = {points[i], points[i + 1]} end
    if #waypoints < 2 then error('person: waypoints has ' .. #waypoints .. ' points, expected at least 2') end
    target, direction = 2, 1
    x, y = waypoints[1][1], waypoints[1][2]
    heading = math.atan(waypoints[2][2] - y, waypoints[2][1] - x)
    phase, pace = 0, 0
end

local function nextWaypoint()
    target = target + direction
    if closed then
        target = (target - 1) % #waypoints + 1
    elseif not waypoints[target] then
        direction = -direction
        target = target + 2 * direction
    end
end

-- Steers to the next waypoint; slower in sharp turns. Returns the distance covered.
local function walk(speed, dt)
    local dx, dy = waypoints[target][1] - x, waypoints[target][2] - y
    if math.sqrt(dx * dx + dy * dy) < REACHED then nextWaypoint() end
    local off = math.atan(dy, dx) - heading
    off = math.atan(math.sin(off), math.cos(off))
    heading = heading + clamp(4 * off, TURNING) * dt
    local way = speed * math.max(0.15, math.cos(off)) * dt
    x, y = x + way * math.cos(heading), y + way * math.sin(heading)
    sim.setObjectPosition(walker, {x, y, 0}, base)
    sim.setObjectOrientation(walker, {0, 0, heading}, base)
    return way
end

-- Position of a foot: ahead of the hips and above the floor. `u` is the phase, 0 to 1; `stride` the length of a cycle.
local function foot(u, stride)
    local half = STANCE * stride / 2
    if u < STANCE then return half - u * stride, 0 end
    local s = (u - STANCE) / (1 - STANCE)
    -- Relative to the hips, the foot leaves and touches the floor at the floor's speed.
    local back = stride * (1 - STANCE)
    local smooth = s * s * (3 - 2 * s)
    return -half + 2 * half * smooth - back * (s - smooth), LIFT * math.sin(math.pi * s)
end

local function moveLeg(side, u, stride, hip)
    local ahead, up = foot(u, stride)
    local reach = STRETCH * (thigh + shin)
    local down = hip - ankle - up
    -- If the leg is too short, the ankle is raised: the foot stands on the heel in front, on the toes behind.
    local short = 0
    if ahead * ahead + down * down > reach * reach then
        local possible = math.sqrt(reach * reach - ahead * ahead)
        short, down = down - possible, possible
    end
    local d = math.sqrt(ahead * ahead + down * down)
    local bend = math.acos(clamp((thigh * thigh + shin * shin - d * d) / (2 * thigh * shin), 1))
    local inner = math.acos(clamp((thigh * thigh + d * d - shin * shin) / (2 * thigh * d), 1))
    local hipAngle = math.atan(ahead, down) + inner
    local kneeAngle = bend - math.pi
    local pitch = ahead > 0 and math.min(short / 0.12, 0.35) or -math.asin(clamp(short / 0.14, 0.7))
    sim.setJointPosition(joints[side].hip, hipAngle)
    sim.setJointPosition(joints[side].knee, kneeAngle)
    sim.setJointPosition(joints[side].ankle, pitch - hipAngle - kneeAngle)
    return ahead
end

function sysCall_actuation()
    local dt = sim.getSimulationTimeStep()
    local speed = tonumber(sim.readCustomStringData(base, 'speed')) or 0
    local way = walk(speed, dt)
    -- Faster people take longer steps; at low speeds the gait fades out, so that nobody stops on one leg.
    local stride = 2 * math.sqrt(0.3 * math.max(speed, 0.05))
    pace = pace + clamp(math.min(1, speed / 0.2) - pace, 2 * dt)
    phase = (phase + way / stride) % 1
    local step = stride * pace
    local drop = HIP_DROP * pace + BOB * pace * math.cos(4 * math.pi * phase)
    sim.setObjectPosition(body, {0, 0, -drop}, walker)
    local hip = thigh + shin + ankle - drop
    local swing = ARMS * math.min(1.2, speed / 1.2) * pace
    for side, shift in pairs{left = 0, right = 0.5} do
        local u = (phase + shift) % 1
        moveLeg(side, u, step, hip)
        sim.setJointPosition(joints[side].shoulder, 0.05 - swing * math.cos(2 * math.pi * (u - 0.02)))
    end
end
