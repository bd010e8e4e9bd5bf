-- The operators of the cell: place pieces from the supply on the belt, and empty a bin when it is full. Also the
-- referee: raises an error if a piece is in a wrong bin or reaches the end of the belt, or if no piece is sorted for a
-- while. This script reads the true positions, which the robot never does.

local COLOURS = {'red', 'yellow', 'green', 'blue'}
local PER_COLOUR = 4
local BINS = {red = {-0.16, 0.36}, yellow = {0.16, 0.36}, green = {-0.16, -0.36}, blue = {0.16, -0.36}}      -- m
local BIN_SIZE = {0.11, 0.10}         -- m: half extents of a bin along x and y
local IN_BIN = 0.29                   -- m: the middle of a piece in a bin is lower than this
local SUPPLY = {-1.35, -0.55, 0.335}  -- m: middle of the supply's tray, height of pieces on it
local START = {-1.45, 0.32}           -- m: x and z of the point above the belt where pieces are placed
local ASIDE = 0.09                    -- m: maximum distance of a piece from the middle of the belt
local EVERY = {2.2, 2.9}              -- s: minimum and maximum interval between pieces
local STAY = 1.5                      -- s: delay until a full bin is emptied
local END = 0.95                      -- m: end of the belt
local IDLE_MOST = 15                  -- s: maximum time without a sorted piece

local pieces, next_time, last_sorted, sorted = {}, 0.5, 0, 0

local function to_supply(piece)
    local i = piece.number - 1
    sim.setObjectPose(piece.handle, {
        SUPPLY[1] + (i % 4 - 1.5) * 0.065, SUPPLY[2] + (i // 4 - 1.5) * 0.065, SUPPLY[3], 0, 0, 0, 1})
    sim.resetDynamicObject(piece.handle)
    piece.where = 'supply'
end

local function lay_down()
    local waiting = {}
    for _, piece in ipairs(pieces) do
        if piece.where == 'supply' then waiting[#waiting + 1] = piece end
    end
    if #waiting == 0 then return end
    local piece = waiting[math.random(#waiting)]
    sim.setObjectPose(piece.handle, {START[1], (2 * math.random() - 1) * ASIDE, START[2], 0, 0, 0, 1})
    sim.resetDynamicObject(piece.handle)
    piece.where = 'belt'
end

local function bin_at(at)
    for colour, bin in pairs(BINS) do
        if math.abs(at[1] - bin[1]) < BIN_SIZE[1] and math.abs(at[2] - bin[2]) < BIN_SIZE[2] and at[3] < IN_BIN then
            return colour
        end
    end
end

local function inspect(piece, now)
    local at = sim.getObjectPosition(piece.handle)
    local bin = bin_at(at)
    if bin and bin ~= piece.colour then
        error(string.format('a %s piece is in the bin for %s ones', piece.colour, bin))
    elseif bin then
        piece.where, piece.since = 'bin', now
        sorted, last_sorted = sorted + 1, now
    elseif at[1] > END or at[3] < 0.2 then
        error(string.format('a %s piece was not sorted: it is at %.2f %.2f %.2f m', piece.colour, at[1], at[2], at[3]))
    end
end

local function empty_full_bins(now)
    for _, colour in ipairs(COLOURS) do
        local inside, newest = {}, 0
        for _, piece in ipairs(pieces) do
            if piece.colour == colour and piece.where == 'bin' then
                inside[#inside + 1] = piece
                newest = math.max(newest, piece.since)
            end
        end
        if #inside == PER_COLOUR and now - newest > STAY then
            for _, piece in ipairs(inside) do to_supply(piece) end
        end
    end
end

function sysCall_init()
    for _, colour in ipairs(COLOURS) do
        for i = 0, PER_COLOUR - 1 do
            local number = #pieces + 1
            pieces[number] = {handle = sim.getObject('/' .. colour .. '_' .. i), colour = colour, number = number,
                where = 'supply'}
        end
    end
    graph = sim.getObject('/sorted')
    stream = sim.addGraphStream(graph, 'sorted pieces', '')
end

function sysCall_actuation()
    local now = sim.getSimulationTime()
    if now >= next_time then
        lay_down()
        next_time = now + EVERY[1] + math.random() * (EVERY[2] - EVERY[1])
    end
    for _, piece in ipairs(pieces) do
        if piece.where == 'belt' then inspect(piece, now) end
    end
    empty_full_bins(now)
    sim.setGraphStreamValue(graph, stream, sorted)
    if now - last_sorted > IDLE_MOST then error(string.format('nothing was sorted for %d s', IDLE_MOST)) end
end
