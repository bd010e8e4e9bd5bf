-- Pushes the robot every few seconds, shows each push by an arrow, and checks that the robot stays upright and keeps
-- driving. It reads the true pose, which the robot itself never does.

local EVERY = 5.0             -- s: from one push to the next
local IMPULSE = 0.06          -- N s
local DURATION = 0.1          -- s
local HEIGHT = 0.144          -- m above the axle: the top of the brick
local ARROW = 0.25            -- m
local SHOWN = 0.8             -- s
local TILT_MOST = math.rad(40)
local LAP_MOST = 60           -- s

local robot, graph, streams, arrow
local next_push, until_time, direction = 4.0, -1, 1
local since, passed_far, laps = 0, false, 0

function sysCall_init()
    robot = sim.getObject('/nxtway')
    graph = sim.getObject('/balance')
    streams = {sim.addGraphStream(graph, 'tilt', 'deg'), sim.addGraphStream(graph, 'push', 'N')}
    arrow = sim.addDrawingObject(sim.drawing_lines, 4, 0, -1, 10, {0.9, 0.1, 0.1})
end

-- A push along the robot's own x axis, alternately to the front and to the rear.
local function push(now)
    if now >= next_push then
        next_push, until_time, direction = now + EVERY, now + DURATION - 1e-6, -direction
        local m = sim.getObjectMatrix(robot)
        local dx, dy = direction * m[1], direction * m[5]
        local px, py, pz = m[4] - 0.03 * dx, m[8] - 0.03 * dy, m[12] + HEIGHT
        local function line(a, b) sim.addDrawingObjectItem(arrow, {a[1], a[2], a[3], b[1], b[2], b[3]}) end
        local tip = {px, py, pz}
        line({px - ARROW * dx, py - ARROW * dy, pz}, tip)
        line({px - 0.06 * dx, py - 0.06 * dy, pz + 0.03}, tip)
        line({px - 0.06 * dx, py - 0.06 * dy, pz - 0.03}, tip)
    end
    local force = now < until_time and direction * IMPULSE / DURATION or 0
    if force ~= 0 then sim.addForce(robot, {0, 0, HEIGHT}, {force, 0, 0}) end
    if now > until_time + SHOWN then sim.addDrawingObjectItem(arrow, nil) end
    sim.setGraphStreamValue(graph, streams[2], force)
end

function sysCall_actuation()
    push(sim.getSimulationTime())
end

function sysCall_sensing()
    local now, m = sim.getSimulationTime(), sim.getObjectMatrix(robot)
    local tilt = math.acos(math.min(1, m[11]))
    sim.setGraphStreamValue(graph, streams[1], math.deg(tilt))
    if tilt > TILT_MOST then error(string.format('the robot has fallen after %.1f s', now)) end
    if m[4] > 2.8 then passed_far = true end
    if passed_far and m[4] < 0 then
        passed_far, laps, since = false, laps + 1, now
        print(string.format('lap %d ends after %.1f s', laps, now))
    end
    if now - since > LAP_MOST then error(string.format('lap %d has taken more than %d s', laps + 1, LAP_MOST)) end
end
