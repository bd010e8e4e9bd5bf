-- Referee: reads true poses, which the robot does not know. Counts laps around the middle of the room, and draws the
-- path.

local LAP_LIMIT = 95            -- s: maximum duration of a lap
local TOUCH = 0.005             -- m: a smaller distance from the walls counts as a touch
local EVERY = 0.25              -- s between two measurements

function sysCall_init()
    robot = sim.getObject('/turtlebot3_burger')
    furniture = sim.getObjectsInTree(sim.getObject('/room'), sim.object_shape_type, 1)
    trail = sim.addDrawingObject(sim.drawing_lines + sim.drawing_cyclic, 3, 0, -1, 300, {0.95, 0.35, 0.10})
    turned, laps, lap_start, next_at, least = 0, 0, 0, 0, math.huge
end

function sysCall_sensing()
    local now = sim.getSimulationTime()
    if now < next_at then return end
    next_at = now + EVERY
    local p = sim.getObjectPosition(robot)
    local angle = math.atan(p[2], p[1])
    if last then
        turned = turned + (angle - last_angle + math.pi) % (2 * math.pi) - math.pi
        sim.addDrawingObjectItem(trail, {last[1], last[2], 0.01, p[1], p[2], 0.01})
    end
    last, last_angle = p, angle

    local gap = math.huge
    for _, thing in ipairs(furniture) do
        local _, data = sim.checkDistance(robot, thing, 0)
        gap = math.min(gap, data[7])
    end
    least = math.min(least, gap)
    if gap < TOUCH then error(string.format('the robot touches something at %.2f, %.2f', p[1], p[2])) end

    if turned > 2 * math.pi then
        turned, laps = turned - 2 * math.pi, laps + 1
        print(string.format('lap %d: %.1f s, at least %.3f m from the walls', laps, now - lap_start, least))
        lap_start, least = now, math.huge
    elseif now - lap_start > LAP_LIMIT then
        error('no lap within ' .. LAP_LIMIT .. ' s')
    end
end
