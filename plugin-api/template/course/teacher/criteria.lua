-- What counts when scripts are graded. Do not give this file to the students.
--
--     tatu grade scene.toml teacher/criteria.lua handed_in/ --csv marks.csv --html marks/

local goals = require('tatu.goals')

function sysCall_init()
    local robot = sim.getObject('/Pioneer_p3dx')
    goals.begin{
        'Drive, do not jump: never /Pioneer_p3dx jumps',
        'Leave the flag where it is: never /Flag jumps',
        {'Reach the flag: /Pioneer_p3dx within 0.4 m of /Flag before 60 s if goal 1', points = 4},
        {'Do not touch the walls: never /Pioneer_p3dx touches /Walls if goal 3', points = 2},
        {'Reach it within 30 s: /Pioneer_p3dx within 0.4 m of /Flag before 30 s if goal 1', points = 1},
        {
            text = 'Stop at the flag',
            points = 1,
            requires = 3,
            during = 2,
            holds = function()
                local v = sim.getObjectVelocity(robot)
                local p = sim.getObjectPosition(robot, sim.getObject('/Flag'))
                return math.sqrt(p[1] ^ 2 + p[2] ^ 2) < 0.5 and math.sqrt(v[1] ^ 2 + v[2] ^ 2) < 0.02
            end,
        },
    }
end

sysCall_sensing, sysCall_cleanup = goals.check, goals.finish
