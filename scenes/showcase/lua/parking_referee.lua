-- Referee: reads true poses, which the robot does not know. Measures the accuracy of the parked car, and moves the cars
-- ahead of the gap before each search, so that the gap is different each time.

local GAPS = {1.15, 1.25, 1.18, 1.3}    -- m, in order
local REAR_EDGE = 1.01          -- m: x of the front bumper of the car behind the gap
local CAR = 0.58                -- m: length of the cars
local MIDDLE = 0.171            -- m, distance of the car's middle ahead of its frame, which is at the rear axle
local FIRST, LATER = 30, 50     -- s: time limits until the car is first parked, and until it is parked again
local STILL = 2.0               -- s at rest that count as parked
local ASIDE = 0.06              -- m: maximum offset of the middle of the car from the middle of the row
local SLANT = math.rad(5)       -- rad
local TOUCH = 0.005             -- m
local CLOSE = 0.3               -- m: larger distances are not measured
local EVERY = 0.2               -- s between two measurements

function sysCall_init()
    car = sim.getObject('/racecar')
    ahead = {sim.getObject('/car_3'), sim.getObject('/car_4')}
    others = {sim.getObject('/car_1'), sim.getObject('/car_2'), ahead[1], ahead[2], sim.getObject('/house')}
    count, since, still, next_at, least = 0, 0, 0, 0, math.huge
end

local function move_cars()
    local gap = GAPS[count % #GAPS + 1]
    for i, other in ipairs(ahead) do
        local p = sim.getObjectPosition(other)
        sim.setObjectPosition(other, {REAR_EDGE + gap + CAR / 2 + (i - 1) * (CAR + 0.15), p[2], p[3]})
    end
end

local function judge(now)
    local p, q = sim.getObjectPosition(car), sim.getObjectPosition(others[2])
    local slant = sim.getObjectOrientation(car)[3]
    local gap = sim.getObjectPosition(ahead[1])[1] - CAR / 2 - REAR_EDGE
    local aside = p[2] + MIDDLE * math.sin(slant) - q[2]
    local along = p[1] + MIDDLE - (REAR_EDGE + gap / 2)
    if math.abs(aside) > ASIDE or math.abs(slant) > SLANT then
        error(string.format('parked badly: %.3f m aside, %.1f degrees', aside, math.deg(slant)))
    end
    count = count + 1
    print(string.format('%5.1f s: parked in a gap of %.2f m, %+.0f mm aside, %+.0f mm along, %+.1f degrees', now, gap,
        1000 * aside, 1000 * along, math.deg(slant)))
    print(string.format('         at least %.0f mm from other cars and the house', 1000 * least))
    since, least = now, math.huge
end

function sysCall_sensing()
    local now = sim.getSimulationTime()
    if now < next_at then return end
    next_at = now + EVERY
    local p = sim.getObjectPosition(car)
    for _, other in ipairs(others) do
        local near, data = sim.checkDistance(car, other, CLOSE)
        if near == 1 then least = math.min(least, data[7]) end
        if near == 1 and data[7] < TOUCH then error('the car touches ' .. sim.getObjectAlias(other)) end
    end
    local moved = last and math.sqrt((p[1] - last[1]) ^ 2 + (p[2] - last[2]) ^ 2) > 0.001
    still = moved and 0 or still + EVERY
    last = p
    if still > STILL and p[2] < 0 and not done then
        done = true
        judge(now)
    elseif p[2] > 0.2 and p[1] < 0.2 and done then
        done = false
        move_cars()
    end
    if now - since > (count == 0 and FIRST or LATER) then error('the car is not parked in time') end
end
