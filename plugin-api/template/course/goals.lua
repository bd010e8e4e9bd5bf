-- Checks the goals of the exercise: the lines of the custom data `exercise.goals` of this object.

local goals = require('tatu.goals')

function sysCall_init()
    local data = tatu.get(sim.getObject('..'), 'object.data')
    goals.begin(data['exercise.goals'] or '')
end

sysCall_sensing, sysCall_cleanup = goals.check, goals.finish
