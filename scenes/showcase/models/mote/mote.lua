-- A mote drives ahead and turns away from obstacles that its range finder detects, randomly to the left or the right.
-- Its course also bends slightly, by a different amount for each mote, so that a crowd spreads out.
--
-- The script runs in parallel with those of all other motes, because it only reads its sensor and sets its two motors.

local RADIUS = 0.016        -- m, of the wheels
local TRACK = 0.064         -- m, between the wheels
local SPEED = 0.20          -- m/s
local TURN = 3.5            -- rad/s, while an obstacle is near
local BEND = 0.25           -- rad/s, maximum turning rate while no obstacle is near
local HOLD = {0.2, 0.7}     -- s: minimum and maximum duration of a turn

local left, right, eye, bend, side, until_time

local function drive(ahead, turn)
    sim.setJointTargetVelocity(left, (ahead - turn * TRACK / 2) / RADIUS)
    sim.setJointTargetVelocity(right, (ahead + turn * TRACK / 2) / RADIUS)
end

function sysCall_init()
    left, right, eye = sim.getObject(':/left'), sim.getObject(':/right'), sim.getObject(':/eye')
    bend, side, until_time = BEND * (2 * math.random() - 1), 1, 0
end

function sysCall_actuation()
    local now = sim.getSimulationTime()
    local seen = sim.readProximitySensor(eye)
    if seen == 1 then
        if now >= until_time then side = math.random() < 0.5 and -1 or 1 end
        until_time = now + HOLD[1] + (HOLD[2] - HOLD[1]) * math.random()
    end
    if now < until_time then
        drive(seen == 1 and 0 or SPEED / 2, side * TURN)
    else
        drive(SPEED, bend)
    end
end
