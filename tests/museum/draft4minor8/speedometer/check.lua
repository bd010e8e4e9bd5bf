-- The window opens once, and shows the speed of the ball in each step. A click on its button stops the ball.
local ball, opened, points, step = nil, nil, 0, 0

function sysCall_init()
    ball = sim.getObject('/ball')
    tatu.on('ui.window', function(e)
        if e.widgets then
            assert(not opened, 'the window was opened twice')
            opened = e
        elseif e.set.curves then
            points = #e.set.curves[1].y
        end
    end)
end

function sysCall_sensing()
    step = step + 1
    if step ~= 20 then return end
    assert(#opened.widgets == 5 and opened.widgets[5].element == 'button')
    assert(points >= 18, 'the plot has ' .. points .. ' points')
    local v = sim.getObjectVelocity(ball)
    assert(math.abs(v[1] - 0.02) < 1e-6, 'the ball moves at ' .. v[1] .. ' m/s')
    speedometer.window(opened.window, 4, 'click')
    v = sim.getObjectVelocity(ball)
    assert(v[1] == 0 and v[3] == 0, 'the ball was not stopped')
end

function sysCall_cleanup()
    assert(step >= 20, 'the run was too short for the check: 20 steps are needed')
end

local ended = sysCall_cleanup
function sysCall_cleanup()
    if ended then ended() end
    print('points', points)
end
