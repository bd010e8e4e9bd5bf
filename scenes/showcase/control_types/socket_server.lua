-- Method 4, a custom socket protocol: sends the sensor reading in each step, and applies the speeds that a program
-- sends.
--
--     to the program     "TIME SEEN\n": simulation time (s); 1 if the nose detects something, else 0
--     from the program   "LEFT RIGHT\n": speeds of the wheels (rad/s)
--
-- The script is the server, so that programs may connect and disconnect. It never waits for them, so the other robots
-- keep running. If a program is silent for PATIENCE, the robot is stopped.

local note = require 'note'

local ADDRESS, PORT = '127.0.0.1', 20000
local PATIENCE = 1.0                -- s

-- Returns whether the user allows sockets. Opening one without permission would raise a warning.
local function may_listen()
    return sim.getStringProperty(sim.handle_scene, 'scene.allow'):find('net=', 1, true)
end

function sysCall_init()
    robot = sim.getObject('..')
    left, right, nose = sim.getObject(':/leftMotor'), sim.getObject(':/rightMotor'), sim.getObject(':/sensingNose')
    port = tonumber(sim.readCustomStringData(robot, 'port')) or PORT
    help = 'python3 control_types/socket_client.py'
    if may_listen() then
        server = assert(require('socket').bind(ADDRESS, port))
        server:settimeout(0)
    else
        help = string.format('--allow net=%s:%d in the command that starts the scene', ADDRESS, port)
    end
    heard = sim.getSimulationTime()     -- s, when the last line was received; initially the start
end

-- Returns the last line received, or nil. Older lines are out of date.
local function last_line()
    local last
    while true do
        local line, failure, part = client:receive('*l', begun)
        begun = not line and part or nil        -- the beginning of an incomplete line
        if failure == 'closed' then
            client:close()
            client = nil
            return last
        end
        if not line then return last end
        last = line
    end
end

local function drive(left_speed, right_speed)
    sim.setJointTargetVelocity(left, left_speed)
    sim.setJointTargetVelocity(right, right_speed)
end

function sysCall_actuation()
    local now = sim.getSimulationTime()
    if server and not client then
        client, begun = server:accept(), nil
        if client then client:settimeout(0) end
    end
    local line = client and last_line()
    local left_speed, right_speed = (line or ''):match('^(%S+) (%S+)$')
    if tonumber(left_speed) and tonumber(right_speed) then
        drive(tonumber(left_speed), tonumber(right_speed))
        heard = now
        note.hide(robot)
    elseif now - heard > PATIENCE then
        drive(0, 0)
        note.show(robot, 'NO CLIENT', help)
    end
end

function sysCall_sensing()
    if client then
        client:send(string.format('%.3f %d\n', sim.getSimulationTime(), sim.readProximitySensor(nose) == 1 and 1 or 0))
    end
end
