-- Mapping and exploration: an occupancy grid with log-odds from laser and odometry, and frontier-based exploration.
--
-- Occupancy grids: Thrun, Burgard, Fox, "Probabilistic Robotics", chapter 9.
-- Exploration: Yamauchi, "A Frontier-Based Approach for Autonomous Exploration", CIRA 1997.

local WHEEL_RADIUS = 0.033            -- m
local TRACK = 0.160                   -- m, between the wheels
local COUNTS_PER_TURN = 4096          -- of an encoder
local SCANNER_X = -0.032              -- m, of the scanner ahead of the axle
local SCAN_TIME = 0.2                 -- s from the first to the last beam
local BEAM_STEP = 2                   -- every second beam is used
local RANGE = 1.4                     -- m; beams are cut at this range, because they are too far apart beyond it
local START = {-1.6, 0.6, -math.pi / 2}   -- x, y (m), heading (rad) in the frame of the map

local CELL = 0.08                     -- m
local COLUMNS, ROWS = 70, 52
local LEFT, BOTTOM = -2.8, -2.08      -- m, corner of the grid
local HIT, MISS, LIMIT = 0.9, -0.4, 4.0   -- log-odds of a beam that ends in a cell or passes it; maximum magnitude
local OCCUPIED, FREE = 0.5, -0.3      -- log-odds above which a cell is occupied, and below which it is free

local CLEARANCE = 0.28                -- m, from the axle to occupied cells; the robot's radius is 0.12
local STOP, STOP_ANGLE = 0.20, 0.9    -- m and rad, from the scanner: an obstacle within this sector stops the robot
local PLAN_PERIOD = 0.4               -- s
local DRAW_PERIOD = 1.0               -- s
local LOOK_AHEAD = 0.16               -- m
local MAX_SPEED = 0.20                -- m/s
local MAX_TURN = 1.6                  -- rad/s
local ACCELERATION = 1.0              -- m/s^2

local BOARD = {2.95, 0.0, 0.012}      -- m, position at which the origin of the map is drawn

function sysCall_init()
    left, right = sim.getObject(':/wheel_left_joint'), sim.getObject(':/wheel_right_joint')
    left_encoder, right_encoder = sim.getObject(':/wheel_left_encoder'), sim.getObject(':/wheel_right_encoder')
    scanner = sim.getObject(':/base_scan')
    local function drawing(kind, size, color) return sim.addDrawingObject(kind, size, 0, -1, 0, color) end
    free_cells = drawing(sim.drawing_quadpts, 0.96 * CELL, {0.90, 0.91, 0.92})
    frontier_cells = drawing(sim.drawing_quadpts, 0.96 * CELL, {1.0, 0.60, 0.15})
    occupied_cells = drawing(sim.drawing_cubepts, CELL, {0.10, 0.30, 0.55})
    way_line = drawing(sim.drawing_lines, 4, {0.15, 0.45, 0.95})
    robot_mark = drawing(sim.drawing_lines, 4, {0.85, 0.15, 0.15})
    run = 0
end

-- Clears the map; the robot is at START.
local function begin_run()
    run = run + 1
    odds, seen_count = {}, 0          -- log-odds of the observed cells
    x, y, heading = table.unpack(START)
    last_left, last_right = nil, nil
    history = {}                      -- poses, the newest last
    way, target = {}, nil
    planned, drawn, scan_number = -math.huge, -math.huge, 0
    speed, explored = 0, false
end

-- Odometry -------------------------------------------------------------------

local function integrate(now)
    local l, r = tatu.read(left_encoder).ticks, tatu.read(right_encoder).ticks
    local per_count = 2 * math.pi * WHEEL_RADIUS / COUNTS_PER_TURN
    local way_left, way_right = (l - (last_left or l)) * per_count, (r - (last_right or r)) * per_count
    last_left, last_right = l, r
    local ahead, turn = (way_left + way_right) / 2, (way_right - way_left) / TRACK
    x = x + ahead * math.cos(heading + turn / 2)
    y = y + ahead * math.sin(heading + turn / 2)
    heading = heading + turn
    table.insert(history, {time = now, x = x, y = y, heading = heading})
    if #history > 8 then table.remove(history, 1) end
end

-- Returns the pose at a time within the last few steps, interpolated between two stored poses.
local function pose_at(time)
    local after = #history
    while after > 2 and history[after - 1].time > time do after = after - 1 end
    local b = history[after]
    local a = history[math.max(1, after - 1)]
    local part = b.time > a.time and (time - a.time) / (b.time - a.time) or 1
    part = math.max(0, math.min(1, part))
    return a.x + part * (b.x - a.x), a.y + part * (b.y - a.y), a.heading + part * (b.heading - a.heading)
end

-- Grid -----------------------------------------------------------------------

local function cell_of(px, py)
    return math.floor((px - LEFT) / CELL), math.floor((py - BOTTOM) / CELL)      -- column and row, from 0
end

local function middle_of(index)
    return LEFT + (index % COLUMNS + 0.5) * CELL, BOTTOM + (index // COLUMNS + 0.5) * CELL
end

-- Bresenham's line from one cell to another: marks the cells on it as missed, and its end as hit or missed. A cell that
-- any beam of a scan hits is not marked as missed by other beams, which graze it.
local function trace(marks, column, row, to_column, to_row, last)
    local dx, dy = math.abs(to_column - column), -math.abs(to_row - row)
    local step_x, step_y = column < to_column and 1 or -1, row < to_row and 1 or -1
    local rest = dx + dy
    while column ~= to_column or row ~= to_row do
        local index = row * COLUMNS + column
        if not marks[index] then marks[index] = MISS end
        local twice = 2 * rest
        if twice >= dy then rest, column = rest + dy, column + step_x end
        if twice <= dx then rest, row = rest + dx, row + step_y end
    end
    local index = row * COLUMNS + column
    if last == HIT or not marks[index] then marks[index] = last end
end

local function inside(column, row)
    return column >= 0 and column < COLUMNS and row >= 0 and row < ROWS
end

-- The beams of a scan are sent one after the other, the last one now, each from the pose of the robot at that time.
local function add_scan(scan, now)
    local marks = {}
    local beams = #scan.distance
    for i = 1, beams, BEAM_STEP do
        local distance = scan.distance[i]
        if distance < math.huge then
            local px, py, h = pose_at(now - SCAN_TIME * (1 - (i - 1) / (beams - 1)))
            px, py = px + SCANNER_X * math.cos(h), py + SCANNER_X * math.sin(h)
            local a = h + scan.angle[i]
            local column, row = cell_of(px, py)
            local reach = math.min(distance, RANGE)
            local to_column, to_row = cell_of(px + reach * math.cos(a), py + reach * math.sin(a))
            if inside(column, row) and inside(to_column, to_row) then
                trace(marks, column, row, to_column, to_row, distance <= RANGE and HIT or MISS)
            end
        end
    end
    for index, change in pairs(marks) do
        if not odds[index] then seen_count = seen_count + 1 end
        odds[index] = math.max(-LIMIT, math.min(LIMIT, (odds[index] or 0) + change))
    end
end

-- Exploration ----------------------------------------------------------------

local NEIGHBOURS = {{1, 0}, {-1, 0}, {0, 1}, {0, -1}, {1, 1}, {1, -1}, {-1, 1}, {-1, -1}}

-- Returns the cells that the axle must not enter, because an occupied cell is too near.
local function blocked_cells()
    local reach = math.floor(CLEARANCE / CELL)
    local offsets = {}
    for dx = -reach, reach do
        for dy = -reach, reach do
            if (dx * dx + dy * dy) * CELL * CELL <= CLEARANCE * CLEARANCE then
                table.insert(offsets, dy * COLUMNS + dx)
            end
        end
    end
    local blocked = {}
    for index, value in pairs(odds) do
        if value > OCCUPIED then
            for _, offset in ipairs(offsets) do blocked[index + offset] = true end
        end
    end
    return blocked
end

local function is_frontier(index)
    local unknown = 0
    for _, n in ipairs(NEIGHBOURS) do
        if not odds[index + n[2] * COLUMNS + n[1]] then unknown = unknown + 1 end
    end
    return unknown >= 2
end

-- Breadth-first search over free cells. Returns the cells in the order in which they are reached, and the predecessor
-- of each. Only cells for which `passable` is true are expanded.
local function search(start, passable)
    local from, queue, head = {[start] = start}, {start}, 1
    while queue[head] do
        local here = queue[head]
        head = head + 1
        for _, n in ipairs(NEIGHBOURS) do
            local there = here + n[2] * COLUMNS + n[1]
            if not from[there] and (odds[there] or 0) < FREE and passable(there) then
                from[there] = here
                table.insert(queue, there)
            end
        end
    end
    return queue, from
end

local function way_back(from, cell, way)
    while from[cell] ~= cell do
        table.insert(way, 1, cell)
        cell = from[cell]
    end
    return way
end

-- Returns the path to the nearest frontier, or to the last target while that is still a frontier, so that the robot
-- does not oscillate between two of the same distance. From a position that is too narrow, the path first leads out of
-- it.
local function plan()
    local blocked = blocked_cells()
    local column, row = cell_of(x, y)
    local start = row * COLUMNS + column
    local exit, leave = start, {}
    if blocked[start] then
        local cells, from = search(start, function() return true end)
        for _, cell in ipairs(cells) do
            if not blocked[cell] then
                exit, leave = cell, way_back(from, cell, {})
                break
            end
        end
    end
    local cells, from = search(exit, function(cell) return not blocked[cell] end)
    local frontiers = {}
    for _, cell in ipairs(cells) do
        if is_frontier(cell) then table.insert(frontiers, cell) end
    end
    if not (target and from[target] and is_frontier(target)) then target = frontiers[1] end
    way = target and way_back(from, target, {}) or {}
    for i = #leave, 1, -1 do table.insert(way, 1, leave[i]) end
    return frontiers
end

-- Driving --------------------------------------------------------------------

local function drive(wanted, turn)
    local most = ACCELERATION * sim.getSimulationTimeStep()
    speed = speed + math.max(-most, math.min(most, wanted - speed))
    sim.setJointTargetVelocity(left, (speed - turn * TRACK / 2) / WHEEL_RADIUS)
    sim.setJointTargetVelocity(right, (speed + turn * TRACK / 2) / WHEEL_RADIUS)
end

-- Returns whether an obstacle ahead is so near that the robot must stop.
local function obstacle_ahead(scan)
    for i, distance in ipairs(scan.distance) do
        if distance < STOP and math.abs(scan.angle[i]) < STOP_ANGLE then return true end
    end
    return false
end

-- Drives towards the first cell of the path that is LOOK_AHEAD away, or the last one; turns on the spot if it is
-- behind.
local function follow()
    local tx, ty
    while way[1] do
        tx, ty = middle_of(way[1])
        if #way == 1 or math.sqrt((tx - x) ^ 2 + (ty - y) ^ 2) > LOOK_AHEAD then break end
        table.remove(way, 1)
    end
    if not tx or math.sqrt((tx - x) ^ 2 + (ty - y) ^ 2) < CELL / 2 then return drive(0, 0) end
    local bearing = math.atan(ty - y, tx - x) - heading
    bearing = math.atan(math.sin(bearing), math.cos(bearing))
    local wanted = math.abs(bearing) < 0.6 and MAX_SPEED * math.cos(bearing) or 0
    if obstacle then wanted = 0 end
    drive(wanted, math.max(-MAX_TURN, math.min(MAX_TURN, 2.5 * bearing)))
end

-- Drawing --------------------------------------------------------------------

local function draw_cells(drawing, indices, height)
    sim.addDrawingObjectItem(drawing, nil)
    local items = {}
    for _, index in ipairs(indices) do
        local px, py = middle_of(index)
        local n = #items
        items[n + 1], items[n + 2], items[n + 3] = BOARD[1] + px, BOARD[2] + py, BOARD[3] + height
        items[n + 4], items[n + 5], items[n + 6] = 0, 0, 1      -- the direction that the mark faces
    end
    if #items > 0 then sim.addDrawingObjectItem(drawing, items) end
end

local function draw_map(frontiers)
    local free, occupied = {}, {}
    for index = 0, COLUMNS * ROWS - 1 do
        local value = odds[index] or 0
        if value < FREE then table.insert(free, index) end
        if value > OCCUPIED then table.insert(occupied, index) end
    end
    draw_cells(free_cells, free, 0)
    draw_cells(frontier_cells, frontiers, 0.003)
    draw_cells(occupied_cells, occupied, CELL / 2)
end

local function line(drawing, ax, ay, bx, by)
    local z = BOARD[3] + 0.03
    sim.addDrawingObjectItem(drawing, {BOARD[1] + ax, BOARD[2] + ay, z, BOARD[1] + bx, BOARD[2] + by, z})
end

local function draw_robot()
    sim.addDrawingObjectItem(robot_mark, nil)
    local radius, corners = 0.10, 10
    for i = 1, corners do
        local a, b = 2 * math.pi * i / corners, 2 * math.pi * (i + 1) / corners
        line(robot_mark, x + radius * math.cos(a), y + radius * math.sin(a), x + radius * math.cos(b),
            y + radius * math.sin(b))
    end
    line(robot_mark, x, y, x + 0.2 * math.cos(heading), y + 0.2 * math.sin(heading))
    sim.addDrawingObjectItem(way_line, nil)
    local ax, ay = x, y
    for _, index in ipairs(way) do
        local bx, by = middle_of(index)
        line(way_line, ax, ay, bx, by)
        ax, ay = bx, by
    end
end

-- Steps ----------------------------------------------------------------------

-- For the referee: returns the map as log-odds, row by row, 0 where nothing is known.
local function publish_map()
    local all = {}
    for index = 0, COLUMNS * ROWS - 1 do all[index + 1] = odds[index] or 0 end
    sim.setStringSignal('map', sim.packFloatTable(all))
    sim.setInt32Signal('explored', run)
end

local function think(now)
    local scan = tatu.read(scanner)
    if scan.sequence ~= scan_number then
        scan_number = scan.sequence
        obstacle = obstacle_ahead(scan)
        if #history > 4 then add_scan(scan, now) end
    end
    if now - planned >= PLAN_PERIOD and seen_count > 0 then
        planned = now
        local frontiers = plan()
        explored = #frontiers == 0
        if explored then publish_map() end
        if explored or now - drawn >= DRAW_PERIOD then
            drawn = now
            draw_map(frontiers)
        end
    end
end

function sysCall_actuation()
    if run == 0 or explored then
        speed = 0
        sim.setJointTargetVelocity(left, 0)
        sim.setJointTargetVelocity(right, 0)
    else
        follow()
    end
end

function sysCall_sensing()
    -- The start button: a signal with the number of a run.
    if (sim.getInt32Signal('start') or 0) > run then begin_run() end
    if run == 0 then return end
    local now = sim.getSimulationTime() + sim.getSimulationTimeStep()      -- sensors measure at the end of the step
    integrate(now)
    if not explored then think(now) end
    draw_robot()
    sim.setFloatSignal('odometry_x', x)
    sim.setFloatSignal('odometry_y', y)
    sim.setFloatSignal('known', seen_count * CELL * CELL)
end
