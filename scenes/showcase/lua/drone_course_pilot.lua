-- The pilot flies the quadrotor through the gates along a smooth path, and lands at its starting position.
--
-- The path is a closed Catmull-Rom spline through a point before and one behind each gate, so that it crosses the
-- gates nearly at right angles. The speed along the path is limited by the turns and by the acceleration. The flight
-- controller of the robot, which estimates its pose from IMU and motion capture, receives position, velocity and
-- acceleration of the path; this script uses only the robot's own estimate and the plan of the gates.

-- Middles of the gates, m, and the direction in which they are crossed, degrees from x to y.
local GATES = {
    {3.0, 0.0, 1.3, 60}, {2.4, 3.0, 2.2, 150}, {-0.6, 3.4, 1.2, 200}, {-3.4, 1.4, 1.8, 265},
    {-2.4, -1.8, 2.6, -35}, {0.8, -2.6, 1.3, 15},
}
local ALONG = 0.7                    -- m: path points before and behind a gate
local SAMPLE = 0.02                  -- m: approximate distance of the path's samples

local SPEED_MOST = 2.6               -- m/s; the flight controller allows 3
local ACROSS_MOST = 2.8              -- m/s^2: acceleration across the path in turns
local ALONG_MOST = 1.2               -- m/s^2: acceleration along the path
local START_HEIGHT = 1.3             -- m
local CLIMB_TIME = 3.0               -- s
local HOVER_TIME = 1.0               -- s: before the laps, and above the pad before landing
local LAPS = 2
local LAND_SPEED = 0.4               -- m/s
local ON_THE_PAD = 2.0               -- s: rest between two flights

-- Gains of the flight controller: it commands the velocity POSITION_GAIN times the position error, and the acceleration
-- VELOCITY_GAIN times the velocity error. A goal that is ahead by the terms of `goal_for` makes it follow the path
-- without lag.
local POSITION_GAIN = {1.6, 1.6, 2.5}          -- 1/s
local VELOCITY_GAIN = {3.2, 3.2, 5.0}          -- 1/s

local pilot, path, trail

-- The path ------------------------------------------------------------------------------------------------------------

local function control_points()
    local points = {}
    for _, gate in ipairs(GATES) do
        local a = math.rad(gate[4])
        for _, along in ipairs{-ALONG, ALONG} do
            points[#points + 1] = {gate[1] + along * math.cos(a), gate[2] + along * math.sin(a), gate[3]}
        end
    end
    return points
end

-- Returns a point of the uniform Catmull-Rom spline between b and c, u from 0 to 1.
local function spline(a, b, c, d, u)
    local p = {}
    for k = 1, 3 do
        p[k] = 0.5 * (2 * b[k] + (c[k] - a[k]) * u + (2 * a[k] - 5 * b[k] + 4 * c[k] - d[k]) * u * u
            + (3 * b[k] - 3 * c[k] + d[k] - a[k]) * u * u * u)
    end
    return p
end

local function distance(a, b)
    return math.sqrt((a[1] - b[1]) ^ 2 + (a[2] - b[2]) ^ 2 + (a[3] - b[3]) ^ 2)
end

-- Returns evenly spaced samples of the closed path: the spline is sampled finely, then resampled by arc length.
local function sample_path()
    local c, fine = control_points(), {}
    for i = 1, #c do
        local function at(k) return c[(i + k - 1) % #c + 1] end
        for j = 0, 199 do fine[#fine + 1] = spline(at(-1), at(0), at(1), at(2), j / 200) end
    end
    fine[#fine + 1] = fine[1]
    local length = 0
    for i = 2, #fine do length = length + distance(fine[i - 1], fine[i]) end
    local count = math.floor(length / SAMPLE)
    local step, samples, left = length / count, {fine[1]}, length / count
    for i = 2, #fine do
        local a, b = fine[i - 1], fine[i]
        local whole = distance(a, b)
        local done = 0
        while whole - done >= left and #samples < count do
            done = done + left
            local t = done / whole
            samples[#samples + 1] = {a[1] + t * (b[1] - a[1]), a[2] + t * (b[2] - a[2]), a[3] + t * (b[3] - a[3])}
            left = step
        end
        left = left - (whole - done)
    end
    return samples, step
end

-- Returns the speed at each sample: the maximum that the turn allows, then limited by the acceleration along the path.
local function plan_speeds(samples, step)
    local n, speeds = #samples, {}
    local reach = 8      -- samples to both sides, over which the curvature is measured
    for i = 1, n do
        local a, b, c = samples[(i - 1 - reach) % n + 1], samples[i], samples[(i - 1 + reach) % n + 1]
        local bend = 0
        for k = 1, 3 do bend = bend + (a[k] - 2 * b[k] + c[k]) ^ 2 end
        local curvature = math.sqrt(bend) / (reach * step) ^ 2
        speeds[i] = math.min(SPEED_MOST, math.sqrt(ACROSS_MOST / math.max(curvature, 1e-6)))
    end
    for _ = 1, 2 do      -- twice around, since the path is closed
        for i = 1, n do
            local before = speeds[(i - 2) % n + 1]
            speeds[i] = math.min(speeds[i], math.sqrt(before ^ 2 + 2 * ALONG_MOST * step))
        end
        for i = n, 1, -1 do
            local after = speeds[i % n + 1]
            speeds[i] = math.min(speeds[i], math.sqrt(after ^ 2 + 2 * ALONG_MOST * step))
        end
    end
    return speeds
end

-- Returns position, tangent and maximum speed at a distance along the path.
local function at_distance(s)
    local n = #path.samples
    local index = (s / path.step) % n
    local i, t = math.floor(index), index % 1
    local a, b = path.samples[i + 1], path.samples[(i + 1) % n + 1]
    local p, along = {}, {}
    for k = 1, 3 do
        p[k] = a[k] + t * (b[k] - a[k])
        along[k] = (b[k] - a[k]) / path.step
    end
    local speed = path.speeds[i + 1] + t * (path.speeds[(i + 1) % n + 1] - path.speeds[i + 1])
    return p, along, speed
end

local function draw_path()
    local lines = sim.addDrawingObject(sim.drawing_lines, 1, 0, -1, 2000, {0.95, 0.95, 0.98})
    local n = #path.samples
    for i = 1, n, 5 do
        local a, b = path.samples[i], path.samples[math.min(i + 3, n)]
        sim.addDrawingObjectItem(lines, {a[1], a[2], a[3], b[1], b[2], b[3]})
    end
end

-- Flight --------------------------------------------------------------------------------------------------------------

local function estimate()
    return sim.callScriptFunction('getEstimate', pilot)
end

-- Sends a goal to the flight controller, and draws the estimated position of the robot.
local last
local function go(goal, yaw)
    sim.callScriptFunction('setPosition', pilot, goal[1], goal[2], goal[3], yaw)
    local p = estimate()
    if p and (not last or distance(p, last) > 0.05) then
        if last then sim.addDrawingObjectItem(trail, {last[1], last[2], last[3], p[1], p[2], p[3]}) end
        last = p
    end
    sim.step()
end

-- Returns the goal that makes the controller follow a position that moves with a velocity and an acceleration.
local function goal_for(p, v, a)
    local goal = {}
    for k = 1, 3 do
        goal[k] = p[k] + v[k] / POSITION_GAIN[k] + a[k] / (POSITION_GAIN[k] * VELOCITY_GAIN[k])
    end
    return goal
end

-- Moves the goal in a straight line from one position to another in a time, at rest at both ends, and then holds it.
local function glide(from, to, seconds, hold, yaw)
    local dt = sim.getSimulationTimeStep()
    for i = 1, math.ceil(seconds / dt) do
        local t = math.min(1, i * dt / seconds)
        local s = t * t * (3 - 2 * t)
        go({from[1] + s * (to[1] - from[1]), from[2] + s * (to[2] - from[2]), from[3] + s * (to[3] - from[3])}, yaw)
    end
    for _ = 1, math.ceil(hold / dt) do go(to, yaw) end
end

-- Flies a number of laps along the path, from rest at its start to rest at its start.
local function fly_laps(count)
    local dt, length = sim.getSimulationTimeStep(), #path.samples * path.step
    local s, speed, before, yaw = 0, 0, nil, nil
    while s < count * length - 0.01 do
        local p, along, most = at_distance(s)
        local braking = math.sqrt(2 * ALONG_MOST * math.max(0, count * length - s))
        speed = math.max(0.05, math.min(speed + ALONG_MOST * dt, most, braking))
        local v = {speed * along[1], speed * along[2], speed * along[3]}
        local a = {0, 0, 0}
        if before then for k = 1, 3 do a[k] = (v[k] - before[k]) / dt end end
        before = v
        yaw = math.atan(along[2], along[1])
        go(goal_for(p, v, a), yaw)
        s = s + speed * dt
    end
    return yaw
end

function sysCall_init()
    pilot = sim.getScript(sim.scripttype_simulation, sim.getObject(':/controller'))
    local samples, step = sample_path()
    path = {samples = samples, step = step, speeds = plan_speeds(samples, step)}
    trail = sim.addDrawingObject(sim.drawing_lines + sim.drawing_cyclic, 3, 0, -1, 600, {1.0, 0.55, 0.1})
    draw_path()
end

function sysCall_thread()
    while not estimate() do sim.step() end
    local home = estimate()
    while true do
        local now = estimate()
        local gate, along = at_distance(0)
        local yaw = math.atan(along[2], along[1])
        local up = {home[1], home[2], START_HEIGHT}
        glide(now, up, CLIMB_TIME, 0, yaw)
        glide(up, gate, distance(up, gate) / 1.0 + 0.5, HOVER_TIME, yaw)
        yaw = fly_laps(LAPS)
        glide(gate, up, distance(up, gate) / 1.0 + 0.5, HOVER_TIME, yaw)
        glide(up, {home[1], home[2], home[3] - 0.03}, up[3] / LAND_SPEED, ON_THE_PAD, yaw)
    end
end
