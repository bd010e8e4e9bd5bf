-- The delta robot sorts pieces on a belt: a camera upstream measures their colour and position, the belt's encoder
-- measures their motion since then, and the cup picks them while the belt runs.
--
-- Inputs are the motors, the vacuum in the cup, the camera and the speed of the belt. Lengths are in m in the world;
-- the delta's axis is at x = 0, y = 0, and the belt runs along +x.

local BINS = {                                   -- m: middle of the bin of each colour
    red = {-0.16, 0.36}, yellow = {0.16, 0.36}, green = {-0.16, -0.36}, blue = {0.16, -0.36},
}
local PLACES = {{-0.04, -0.04}, {0.04, -0.04}, {-0.04, 0.04}, {0.04, 0.04}}      -- m: from the middle of a bin
local HUES = {red = 0, yellow = 50, green = 135, blue = 215}                     -- degrees

local PIECE = 0.03                               -- m: height of a piece
local BELT = 0.30                                -- m: height of the belt
local BIN_FLOOR = 0.25                           -- m
local DROP = 0.004                               -- m: pieces are released this far above the floor of a bin
local LIFT = 0.07                                -- m: clearance above pieces on the belt and walls of the bins
local HEIGHT = 1.45                              -- m: of the motors' axes above the floor
local TOOL = 0.10                                -- m: from the platform to the lip of the cup

local CAMERA = {-0.75, 0.0, 0.90}                -- m: faces down, with the columns of the image along the belt
local WINDOW = 0.07                              -- m: half of the part of the image that is used
local MIDDLE = 0.03                              -- m: a piece is measured once it is this near to the middle
local LEAST_HEIGHT = 0.015                            -- m: minimum height of a piece above the belt
local LEAST_PIXELS = 12                          -- minimum number of pixels of a piece
local APART = 0.10                               -- m: minimum distance between pieces

local FIRST_X, LAST_X = -0.30, 0.20              -- m: range in which pieces can be picked
local SPEED = 1.6                                -- m/s: mean speed across
local SHORTEST = 0.22                            -- s: time of a move up or down
local PAUSE = 0.08                               -- s: for the vacuum to build up, or to break
local LEAD = 0.01                                -- s: lag of the motors behind their targets
local WAIT_AT = {-0.2, 0.0}                      -- m

local motors, kinematics, tip, vacuum, camera, belt, tie, at, marks
local last_image = 0         -- sequence number of the last image processed
local travelled = 0          -- m: distance that the belt has moved
local last_seen = -1         -- m: `travelled` when the last piece was seen
-- Pieces that were measured but not yet picked: colour, and x and y on the belt at `travelled` = 0.
local queue = {}
local filled = {}            -- number of pieces in the bin of each colour

-- Vision --------------------------------------------------------------------------------------------------------------

local function colour_of(r, g, b)
    local most, least = math.max(r, g, b), math.min(r, g, b)
    local chroma = most - least
    if chroma < 0.4 * most or most < 40 then return nil end
    local hue
    if most == r then
        hue = 60 * ((g - b) / chroma) % 360
    elseif most == g then
        hue = 60 * ((b - r) / chroma + 2)
    else
        hue = 60 * ((r - g) / chroma + 4)
    end
    for name, value in pairs(HUES) do
        if math.abs((hue - value + 180) % 360 - 180) < 22 then return name end
    end
end

-- Returns colour and position of the piece in the window of a new image, or nil.
local function find_piece()
    local image = tatu.read(camera)
    if image.sequence == last_image then return nil end
    last_image = image.sequence
    local fx, fy, cx, cy = table.unpack(image.intrinsics)
    local distance = CAMERA[3] - BELT - PIECE
    local votes, count, x, y, best = {}, 0, 0, 0, nil
    for row = 0, image.rows - 1 do
        for column = 0, image.columns - 1 do
            local u = -(column - cx) * distance / fx
            local i = row * image.columns + column
            local height = CAMERA[3] - BELT - string.unpack('<f', image.depth, 4 * i + 1)
            if math.abs(u) < WINDOW and height > LEAST_HEIGHT then
                local colour = colour_of(image.rgb:byte(3 * i + 1, 3 * i + 3))
                if colour then
                    votes[colour] = (votes[colour] or 0) + 1
                    count, x, y = count + 1, x + u, y - (row - cy) * distance / fy
                    if not best or votes[colour] > votes[best] then best = colour end
                end
            end
        end
    end
    if count >= LEAST_PIXELS then return best, CAMERA[1] + x / count, CAMERA[2] + y / count end
end

local function watch_belt()
    local speed = tonumber(sim.readCustomStringData(belt, 'belt_speed')) or 0
    travelled = travelled + speed * sim.getSimulationTimeStep()
    local colour, x, y = find_piece()
    if colour and math.abs(x - CAMERA[1]) < MIDDLE and travelled - last_seen > APART then
        last_seen = travelled
        queue[#queue + 1] = {colour = colour, x = x - travelled, y = y}
    end
end

-- Draws the estimated positions of the pieces: white rings above the belt.
local function draw()
    sim.addDrawingObjectItem(marks, nil)
    for _, piece in ipairs(queue) do
        local x, z = piece.x + travelled, BELT + PIECE + 0.002
        for i = 1, 12 do
            local a, b = (i - 1) * math.pi / 6, i * math.pi / 6
            sim.addDrawingObjectItem(marks, {x + 0.034 * math.cos(a), piece.y + 0.034 * math.sin(a), z,
                x + 0.034 * math.cos(b), piece.y + 0.034 * math.sin(b), z})
        end
    end
end

-- Motion --------------------------------------------------------------------------------------------------------------

-- Sets the targets of the motors for the lip of the cup.
local function aim(lip)
    local angles, why = kinematics:inverse{lip[1], lip[2], lip[3] + TOOL - HEIGHT}
    if not angles then error(string.format('the lip at %.3f %.3f %.3f m: %s', lip[1], lip[2], lip[3], why)) end
    for i, motor in ipairs(motors) do sim.setJointTargetPosition(motor, angles[i]) end
end

-- Moves the lip from rest, or from a moving target, to `target()`, which may move as well: a fifth-order polynomial
-- reduces the offset from the target to zero, so the lip arrives with the target's velocity.
local function follow(seconds, target)
    local start, t = sim.getSimulationTime(), 0
    local first = target()
    local off = {at[1] - first[1], at[2] - first[2], at[3] - first[3]}
    while t < 1 do
        t = math.min((sim.getSimulationTime() - start) / seconds, 1)
        local rest = 1 - t * t * t * (10 + t * (6 * t - 15))
        local goal = target()
        at = {goal[1] + rest * off[1], goal[2] + rest * off[2], goal[3] + rest * off[3]}
        aim(at)
        sim.step()
    end
end

local function move(x, y, z)
    local way = math.sqrt((x - at[1]) ^ 2 + (y - at[2]) ^ 2 + (z - at[3]) ^ 2)
    follow(math.max(SHORTEST, way / SPEED), function() return {x, y, z} end)
end

-- Ties the piece under the cup to its lip; returns whether there is one.
local function grip()
    local found, _, _, piece = sim.readProximitySensor(vacuum)
    if found ~= 1 then return false end
    tie = sim.createDummy(0.01)
    sim.setObjectPose(tie, sim.getObjectPose(tip))
    sim.setObjectParent(tie, piece, true)
    tatu.set(tie, 'dummy.link', sim.getObjectAlias(tip, 2))
    return true
end

local function release()
    sim.removeObjects{tie}
    tie = nil
end

-- Picks a piece from the moving belt; returns whether the vacuum holds it.
local function take(piece)
    local function above(height)
        return function()
            local speed = tonumber(sim.readCustomStringData(belt, 'belt_speed')) or 0
            return {piece.x + travelled + speed * LEAD, piece.y, BELT + PIECE + height}
        end
    end
    local way = math.abs(piece.x + travelled - at[1]) + math.abs(piece.y - at[2])
    follow(math.max(SHORTEST, way / SPEED), above(LIFT))
    follow(SHORTEST, above(0))
    follow(PAUSE, above(0))
    local held = grip()
    follow(SHORTEST, above(LIFT))
    return held
end

local function put(colour)
    filled[colour] = (filled[colour] or 0) % #PLACES + 1
    local place, bin = PLACES[filled[colour]], BINS[colour]
    local x, y, top = bin[1] + place[1], bin[2] + place[2], BELT + PIECE + LIFT
    move(x, y, top)
    move(x, y, BIN_FLOOR + PIECE + DROP)
    sim.wait(PAUSE)
    release()
    move(x, y, top)
end

function sysCall_init()
    motors = {}
    for i = 1, 3 do motors[i] = sim.getObject(':/motor_' .. i) end
    kinematics = sim.getScriptFunctions(sim.getScript(sim.scripttype_simulation, sim.getObject(':/kinematics')))
    tip, vacuum = sim.getObject(':/suction_tip'), sim.getObject(':/vacuum')
    camera, belt = sim.getObject('/gantry/camera'), sim.getObject('/conveyor')
    marks = sim.addDrawingObject(sim.drawing_lines, 2, 0, -1, 200, {1, 1, 1})
end

function sysCall_sensing()
    watch_belt()
    draw()
end

function sysCall_thread()
    local angles = {}
    for i, motor in ipairs(motors) do angles[i] = sim.getJointPosition(motor) end
    at = kinematics:forward(angles)
    at[3] = at[3] + HEIGHT - TOOL
    move(WAIT_AT[1], WAIT_AT[2], BELT + PIECE + LIFT)
    while true do
        local piece = queue[1]
        if piece and piece.x + travelled > LAST_X then
            table.remove(queue, 1)      -- too late for this piece: it continues to the end of the belt
        elseif piece and piece.x + travelled > FIRST_X then
            local held = take(piece)
            table.remove(queue, 1)
            if held then put(piece.colour) end
        else
            sim.step()
        end
    end
end
