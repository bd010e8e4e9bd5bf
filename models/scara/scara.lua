-- Moves all pieces of a tray to the other one, one by one, and then back, in an endless loop. The joints are the only
-- input: fingers that close farther than on a piece indicate that a slot is empty. The dummies `tray_a` and `tray_b`
-- are the middles of the trays.

local ROWS, COLUMNS = 2, 3      -- slots of a tray, along x and y of the base
local PITCH = 0.06              -- m, between slots
local ABOVE = 0.006             -- m, height of the finger tips above the tray when they grip
local LIFT = 0.055              -- m, height of the finger tips above the tray while moving between slots
local TOOL = 0.076              -- m, from the shaft's lower end to the finger tips
local HEADING = 0               -- rad, of the gripper in the base's frame: its fingers close along y
local ELBOW = 1                 -- elbow to the right
local SPEED = {4.0, 4.0, 1.7, 0.4}      -- rad/s and m/s: maximum speeds of arm 1, arm 2, the shaft's turn and slide
local OPEN, CLOSED = 0.01, 0    -- m, positions of a finger
local EMPTY = 0.001             -- m, a finger that closes farther than this holds nothing
local GRIP_TIME = 0.35          -- s, to open or close

function sysCall_init()
    base = sim.getObject(':')
    joints = {}
    for i, name in ipairs{'base_arm_motor', 'arm_motor', 'shaft_rotation_motor', 'shaft_linear_motor'} do
        joints[i] = sim.getObject(':/' .. name)
    end
    finger = sim.getObject(':/finger_left_motor')
    trays = {sim.getObject(':/tray_a'), sim.getObject(':/tray_b')}
    kinematics = sim.getScript(sim.scripttype_childscript, sim.getObject(':/kinematics'))
end

-- Fraction of a path after a fraction of its time, with minimum jerk; the maximum speed is 1.875 times the mean.
local function ease(t)
    return t ^ 3 * (10 - 15 * t + 6 * t ^ 2)
end

-- Moves all joints to their positions, so that they arrive at the same time.
local function move(goal)
    local from, duration = {}, 0.2
    for i, joint in ipairs(joints) do
        from[i] = sim.getJointTargetPosition(joint)
        duration = math.max(duration, 1.875 * math.abs(goal[i] - from[i]) / SPEED[i])
    end
    local start = sim.getSimulationTime()
    repeat
        local t = math.min(1, (sim.getSimulationTime() - start) / duration)
        for i, joint in ipairs(joints) do
            sim.setJointTargetPosition(joint, from[i] + ease(t) * (goal[i] - from[i]))
        end
        sim.step()
    until t == 1
    -- Targets are followed with a lag of half a step; a single target is reached after two steps.
    sim.step()
    sim.step()
end

-- Returns the joint positions with the finger tips over a slot of a tray, at a height above its surface.
local function over(tray, row, column, height)
    local p = sim.getObjectPosition(tray, base)
    p[1] = p[1] + (row - (ROWS + 1) / 2) * PITCH
    p[2] = p[2] + (column - (COLUMNS + 1) / 2) * PITCH
    p[3] = p[3] + height + TOOL
    local found = sim.callScriptFunction('inverse', kinematics, p, HEADING, ELBOW)
    if not found then
        error(string.format('%s, row %d, column %d: out of reach at %.3f %.3f %.3f m in the frame of the base',
            sim.getObjectAlias(tray), row, column, p[1], p[2], p[3] - TOOL))
    end
    return found
end

local function grip(target)
    sim.setJointTargetPosition(finger, target)
    sim.wait(GRIP_TIME)
end

-- Moves to a slot, opens or closes the gripper there, and moves up again.
local function visit(tray, row, column, target)
    move(over(tray, row, column, LIFT))
    move(over(tray, row, column, ABOVE))
    grip(target)
    move(over(tray, row, column, LIFT))
end

function sysCall_thread()
    local from, to = trays[1], trays[2]
    while true do
        for row = 1, ROWS do
            for column = 1, COLUMNS do
                grip(OPEN)
                visit(from, row, column, CLOSED)
                if sim.getJointPosition(finger) > EMPTY then visit(to, row, column, OPEN) end
            end
        end
        from, to = to, from
        -- Without pieces, the robot moves slowly.
        sim.wait(1)
    end
end
