-- The floor plan of parts/apartment.toml, in metres from its middle: x to the right, y up.

local plan = {
    width = 5.0, depth = 3.6,         -- between the outer walls
    -- Middle x and y, size along x and y.
    boxes = {
        {0, 1.84, 5.16, 0.08},         -- wall_north
        {0, -1.84, 5.16, 0.08},        -- wall_south
        {2.54, 0, 0.08, 3.6},          -- wall_east
        {-2.54, 0, 0.08, 3.6},         -- wall_west
        {-0.5, 0.7, 0.08, 2.2},        -- wall_hall
        {1.46, 0.3, 2.08, 0.08},       -- wall_bedroom
        {1.0, -1.5, 0.08, 0.6},        -- wall_kitchen
        {-2.35, -0.1, 0.3, 0.9},       -- cupboard
        {-1.55, 1.56, 0.95, 0.44},     -- sofa
        {2.05, 1.3, 0.9, 0.8},         -- bed
        {2.3, -1.25, 0.4, 1.0},        -- kitchen_block
        {0.25, -1.62, 0.4, 0.3},       -- crate
    },
    -- Middle x and y, radius.
    posts = {
        {-0.75, -1.55, 0.13},          -- plant_hall
        {0.05, 1.55, 0.15},            -- plant_bedroom
    },
}

-- Returns the distance (m) of a point from the nearest surface; negative within a wall or a piece of furniture.
function plan.distance(x, y)
    local least = math.huge
    for _, box in ipairs(plan.boxes) do
        local dx, dy = math.abs(x - box[1]) - box[3] / 2, math.abs(y - box[2]) - box[4] / 2
        local outside = math.sqrt(math.max(dx, 0) ^ 2 + math.max(dy, 0) ^ 2)
        least = math.min(least, outside + math.min(0, math.max(dx, dy)))
    end
    for _, post in ipairs(plan.posts) do
        least = math.min(least, math.sqrt((x - post[1]) ^ 2 + (y - post[2]) ^ 2) - post[3])
    end
    return least
end

return plan
