-- Referee: reads the true position of the robot, which the robot does not know. Measures the times of the runs, and
-- compares the robot's estimate of its position with the true one.

local START = {0.0, 0.12}       -- m: x and y of the start are between these
local GOAL = {0.36, 0.60}       -- m: x and y of the goal are between these
local FIRST_GOAL = 60           -- s: time limit for finding the goal
local FAST_GOAL = 105           -- s: time limit for the end of the fast run
local REPEAT = 50               -- s: time limit for a later run
local MOST_ERROR = 0.02         -- m: maximum error of the estimate

function sysCall_init()
    robot = sim.getObject('/ePuck')
    arrived, next_is_goal, since, worst = 0, true, 0, 0
    deadline = FIRST_GOAL
end

local function inside(p, square)
    return p[1] > square[1] and p[1] < square[2] and p[2] > square[1] and p[2] < square[2]
end

function sysCall_sensing()
    local now, p = sim.getSimulationTime(), sim.getObjectPosition(robot)
    local x, y = sim.getFloatSignal('maze_x'), sim.getFloatSignal('maze_y')
    if x then
        local off = math.sqrt((x - p[1]) ^ 2 + (y - p[2]) ^ 2)
        worst = math.max(worst, off)
        if off > MOST_ERROR then error(string.format('the estimate is %.3f m off', off)) end
    end
    if inside(p, next_is_goal and GOAL or START) then
        arrived = arrived + 1
        print(string.format('%6.1f s: %s reached in %.1f s; the estimate was at most %.1f mm off',
            now, next_is_goal and 'goal' or 'start', now - since, 1000 * worst))
        next_is_goal, since = not next_is_goal, now
        deadline = arrived < 3 and FAST_GOAL or now + REPEAT
    elseif now > deadline then
        error('the ' .. (next_is_goal and 'goal' or 'start') .. ' was not reached in time')
    end
end
