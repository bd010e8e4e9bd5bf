-- Drives any robot with two driven wheels by keys: the arrow keys or w, a, s and d; the space bar stops the robot.
-- Options: robot=           path of the robot's base; default: the first model with two such wheels
--          left=, right=    paths of the wheel joints, if they are not found automatically
--          speed=0.5        speed that a key adds to both wheels, rad/s
--          turn=0.25        speed that a key adds to one wheel and subtracts from the other, rad/s
--          most=10          maximum speed of a wheel, rad/s
--
--     tatu run scene.toml --interactive --addon key_teleop
--     tatu run scene.toml --keys keys.txt --addon key_teleop:robot=/Pioneer_p3dx
--
-- The robot's own controller drives the robot until the first key press; after that, only the keys do. The x axis of
-- the base must point forward.

function sysCall_info()
    return {autoStart = false, menu = 'Drive\nBy keys'}
end

local options, wheels, forward, turning

-- Key codes of simulator messages: 2007 to 2010 are the arrow keys; other keys have their character codes.
local keys = {
    [2007] = 'up', [2008] = 'down', [2009] = 'left', [2010] = 'right',
    [119] = 'up', [115] = 'down', [97] = 'left', [100] = 'right', [32] = 'stop',
}

-- Returns the y axis and the z axis of an object in the world frame.
local function axes(object)
    local m = sim.getObjectMatrix(object, -1)
    return {m[2], m[6], m[10]}, {m[3], m[7], m[11]}
end

local function dot(a, b)
    return a[1] * b[1] + a[2] * b[2] + a[3] * b[3]
end

-- Returns a wheel: its joint, its distance to the left of the base (m), and the sign of its forward rotation.
local function wheel(base, joint)
    local left, _ = axes(base)
    local _, axis = axes(joint)
    local p, q = sim.getObjectPosition(joint, -1), sim.getObjectPosition(base, -1)
    local along = dot(axis, left)
    return {
        joint = joint, level = math.abs(along), sign = along < 0 and -1 or 1,
        left = dot({p[1] - q[1], p[2] - q[2], p[3] - q[3]}, left),
    }
end

-- Returns the two driven wheels of a base: on each side, the outermost joint with a motor and a lateral axis.
local function find(base)
    local best = {}
    for _, joint in ipairs(tatu.list('joint', base)) do
        if tatu.get(joint, 'joint.type') == 'revolute' and tatu.get(joint, 'joint.control') == 'velocity' then
            local w = wheel(base, joint)
            local side = w.left > 0 and 'left' or 'right'
            if w.level > 0.9 and (not best[side] or math.abs(w.left) > math.abs(best[side].left)) then
                best[side] = w
            end
        end
    end
    return best.left and best.right and best
end

local function search()
    if options.left ~= '' and options.right ~= '' then
        local left, right = sim.getObject(options.left), sim.getObject(options.right)
        local base = options.robot ~= '' and sim.getObject(options.robot) or sim.getObjectParent(left)
        return {left = wheel(base, left), right = wheel(base, right)}, base
    end
    if options.robot ~= '' then
        local base = sim.getObject(options.robot)
        return find(base), base
    end
    for _, base in ipairs(tatu.list()) do
        local found = tatu.get(base, 'object.model_base') and find(base)
        if found then
            return found, base
        end
    end
end

function sysCall_init()
    options = tatu.options{robot = '', left = '', right = '', speed = 0.5, turn = 0.25, most = 10}
end

function sysCall_beforeSimulation()
    local base
    wheels, base = search()
    if not wheels then
        error('key_teleop: no robot with two driven wheels was found; select the joints with the options '
            .. 'left=/Robot/leftMotor,right=/Robot/rightMotor')
    end
    forward, turning = nil, 0
    sim.addLog(sim.verbosity_scriptinfos, 'key_teleop: drives ' .. tatu.get(base, 'object.path'))
end

local function pressed(key)
    forward = forward or 0
    if key == 'up' then
        forward = forward + options.speed
    elseif key == 'down' then
        forward = forward - options.speed
    elseif key == 'left' then
        turning = turning + options.turn
    elseif key == 'right' then
        turning = turning - options.turn
    else
        forward, turning = 0, 0
    end
    forward = math.min(math.max(forward, -options.most), options.most)
    turning = math.min(math.max(turning, -options.most), options.most)
end

function sysCall_actuation()
    local message, data = sim.getSimulatorMessage()
    while message ~= -1 do
        if message == sim.message_keypress and keys[data[1]] then
            pressed(keys[data[1]])
        end
        message, data = sim.getSimulatorMessage()
    end
    if forward then
        local function drive(w, speed)
            speed = math.min(math.max(speed, -options.most), options.most)
            sim.setJointTargetVelocity(w.joint, speed * w.sign)
        end
        drive(wheels.left, forward - turning)
        drive(wheels.right, forward + turning)
    end
end
