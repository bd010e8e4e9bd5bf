-- Checks the goals of an exercise: the lines of the custom data `exercise.goals` of this object, whose syntax is described
-- in docs/guide/exercises.md.

local goals = require('tatu.goals')

function sysCall_init()
    local data = tatu.get(sim.getObject('..'), 'object.data')
    goals.begin(data['exercise.goals'] or '')
end

function sysCall_sensing()
    goals.check()
end

function sysCall_cleanup()
    goals.finish()
end
