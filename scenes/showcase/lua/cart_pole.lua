-- Balances the pole: a regulator (LQR) from the linear model that `tatu.linearize` returns. Pushes the pole every few
-- seconds, and checks that it stays upright and that the cart returns to the middle.

local Matrix = require 'matrix'

local WEIGHTS = {8, 20, 1, 1}     -- of position, angle and their velocities
local COST = 0.05                 -- of the force
local DT = 0.005                  -- s
local EVERY = 5.0                 -- s: from one push to the next
local PUSH = 0.25                 -- N s
local TILT_MOST = math.rad(25)

local rail, slide, pole, gain
local next_push, direction = 3.0, 1

function sysCall_init()
    rail, slide, pole = sim.getObject('/rail'), sim.getObject('/slide'), sim.getObject('/pole')
    local A, B = tatu.linearize(rail, {slide})
    A, B = Matrix.eye(4) + Matrix(A) * DT, Matrix(B) * DT
    -- The Riccati equation, iterated until it stands.
    local Q, P = Matrix.diag(WEIGHTS), Matrix.diag(WEIGHTS)
    for _ = 1, 2000 do
        gain = (B:t() * P * B + Matrix{COST}):solve(B:t() * P * A)
        P = A:t() * P * (A - B * gain) + Q
    end
    tatu.setState(rail, {0.5, 0.15})
end

function sysCall_actuation()
    local q, qd = tatu.getState(rail)
    local force = -(gain * Matrix{q[1], q[2], qd[1], qd[2]})
    tatu.set(slide, 'joint.max_force', force:get(1))
    local now = sim.getSimulationTime()
    if now >= next_push then
        next_push, direction = now + EVERY, -direction
        sim.addForceAndTorque(pole, {direction * PUSH / DT, 0, 0}, {0, 0, 0})
    end
end

function sysCall_sensing()
    local q, qd = tatu.getState(rail)
    if math.abs(q[2]) > TILT_MOST then error('the pole fell') end
    if sim.getSimulationTime() > next_push - 0.1 and math.abs(q[1]) > 0.1 then
        error('the cart did not return to the middle: ' .. q[1] .. ' m')
    end
end
