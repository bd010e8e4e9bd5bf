-- Method 3, a command of a plugin: this script only calls it, in each step. The behaviour is in plugin/bubble.c.

local note = require 'note'

function sysCall_init()
    left, right, nose = sim.getObject(':/leftMotor'), sim.getObject(':/rightMotor'), sim.getObject(':/sensingNose')
    if not bubble then
        note.show(sim.getObject('..'), 'NO PLUGIN', 'start with TATU_PLUGIN_PATH=control_types/plugin/build')
    end
end

function sysCall_actuation()
    if bubble then bubble.drive(left, right, nose) end
end
