-- Referee: reads true positions, which the robot does not know. Counts laps, checks that the robot does not push the
-- obstacles, and draws the path.

local LAP_LIMIT = 55            -- s
local PUSHED = 0.003            -- m: an obstacle that has moved by more than this beside the robot was pushed
local EVERY = 0.1               -- s between two pieces of the path

function sysCall_init()
    robot = sim.getObject('/Thymio')
    obstacles = {sim.getObject('/carton'), sim.getObject('/can')}
    places = {}
    trail = sim.addDrawingObject(sim.drawing_lines + sim.drawing_cyclic, 3, 0, -1, 450, {0.95, 0.35, 0.10})
    turned, laps, lap_start, next_at = 0, 0, 0, 0
end

local function distance(a, b)
    return math.sqrt((a[1] - b[1]) ^ 2 + (a[2] - b[2]) ^ 2)
end

function sysCall_sensing()
    local now = sim.getSimulationTime()
    if now < next_at then return end
    next_at = now + EVERY
    local p = sim.getObjectPosition(robot)
    for i, obstacle in ipairs(obstacles) do
        local at = sim.getObjectPosition(obstacle)
        -- A user may move an obstacle, but not while the robot is beside it.
        if places[i] and distance(places[i], p) < 0.25 and distance(places[i], at) > PUSHED then
            error('the robot has pushed ' .. sim.getObjectAlias(obstacle))
        end
        if not places[i] or distance(at, p) > 0.25 then places[i] = at end
    end
    local angle = math.atan(p[2], p[1])
    if last then
        turned = turned + (angle - last_angle + math.pi) % (2 * math.pi) - math.pi
        sim.addDrawingObjectItem(trail, {last[1], last[2], 0.004, p[1], p[2], 0.004})
    end
    last, last_angle = p, angle
    if turned > 2 * math.pi then
        turned, laps = turned - 2 * math.pi, laps + 1
        print(string.format('lap %d: %.1f s', laps, now - lap_start))
        lap_start = now
    elseif now - lap_start > LAP_LIMIT then
        error('no lap within ' .. LAP_LIMIT .. ' s')
    end
end
