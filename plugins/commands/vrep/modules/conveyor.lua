-- The script of a conveyor belt. Other scripts write a target speed or position; the script publishes the belt's state.
-- `efficient`: the belt is a static box whose surface moves objects; otherwise, it consists of pads that move along a
-- path.

local conveyor = {}

local model_with = require 'models.model_with'

local function model()
    return model_with('__config__')
end

local function read(tag)
    return sim.readCustomTableData(model(), tag) or {}
end

local function default(config)
    return {
        length = config.length or 1,
        targetVel = config.targetVel or 0.1,
        accel = config.accel or 0.01,
        radius = config.radius or config.rollerRadius or 0.1,
        type = config.type or 1,
    }
end

local function children(name, tag)
    local out = {}
    for _, h in ipairs(sim.getObjectsInTree(model(), sim.handle_all, 1)) do
        local own = sim.readCustomDataBlock(h, tag)
        -- Other parts of a conveyor have the same tag with another value.
        if sim.getObjectAlias(h) == name or own == 'a' then
            out[#out + 1] = h
        end
    end
    return out
end

function conveyor.init()
    conveyor.config = default(read('__config__'))
    conveyor.pos, conveyor.vel, conveyor.target = 0, 0, { vel = conveyor.config.targetVel }
    if not conveyor.efficient then
        conveyor.pads, conveyor.rollers = children('pad', 'PATHPAD'), children('jrol', 'PATHROL')
        local path = sim.readCustomDataBlock(model(), 'PATH')
        if path and #path > 0 then
            local poses = sim.unpackDoubleTable(path)
            conveyor.points, conveyor.turns = {}, {}
            for i = 1, #poses, 7 do
                table.move(poses, i, i + 2, #conveyor.points + 1, conveyor.points)
                table.move(poses, i + 3, i + 6, #conveyor.turns + 1, conveyor.turns)
            end
            conveyor.lengths, conveyor.total = sim.getPathLengths(conveyor.points, 3)
        end
    end
end

-- Advances the belt by one step towards its target speed or position, with limited acceleration. Returns the distance
-- that it moved.
local function advance(dt)
    local accel, vel = conveyor.config.accel, conveyor.target.vel
    if conveyor.target.pos then
        local left = conveyor.target.pos - conveyor.pos
        -- Limit the speed so that the belt can still stop at the target, and does not pass it in this step.
        local fastest = math.sqrt(2 * accel * math.abs(left))
        vel = math.min(fastest, math.abs(left) / dt) * (left < 0 and -1 or 1)
    end
    local change = math.max(-accel * dt, math.min(accel * dt, vel - conveyor.vel))
    local before = conveyor.vel
    conveyor.vel = before + change
    local moved = (before + conveyor.vel) / 2 * dt
    if conveyor.target.pos and math.abs(conveyor.target.pos - conveyor.pos - moved) < 1e-9 then
        conveyor.vel = 0
    end
    conveyor.pos = conveyor.pos + moved
    return moved
end

local function throw_on(moved, dt)
    local box = sim.getObject('./forwarder', { proxy = model() })
    local matrix = sim.getObjectMatrix(box, sim.handle_world)
    matrix[4], matrix[8], matrix[12] = 0, 0, 0
    local v = sim.multiplyVector(matrix, { moved / dt, 0, 0 })
    sim.resetDynamicObject(box)
    for i = 1, 3 do
        sim.setObjectFloatParam(box, 2999 + i, v[i])
    end
end

local function carry()
    for i, pad in ipairs(conveyor.lengths and conveyor.pads or {}) do
        local at = (conveyor.pos + (i - 1) * conveyor.total / #conveyor.pads) % conveyor.total
        sim.setObjectPosition(pad, sim.getPathInterpolatedConfig(conveyor.points, conveyor.lengths, at), model())
        local turn = sim.getPathInterpolatedConfig(conveyor.turns, conveyor.lengths, at, nil, { 2, 2, 2, 2 })
        sim.setObjectQuaternion(pad, turn, model())
    end
    for _, joint in ipairs(conveyor.config.type == 2 and conveyor.rollers or {}) do
        sim.setJointPosition(joint, conveyor.pos / conveyor.config.radius)
    end
end

function conveyor.actuation()
    local told = read('__ctrl__')
    if told.vel or told.pos then
        conveyor.target = told.vel and { vel = told.vel } or { pos = told.pos }
        sim.writeCustomTableData(model(), '__ctrl__', {})
    end
    local dt = sim.getSimulationTimeStep()
    local moved = advance(dt)
    if moved == 0 then
        return
    end
    if conveyor.efficient then
        throw_on(moved, dt)
    else
        carry()
    end
    sim.writeCustomTableData(model(), '__state__', { pos = conveyor.pos, vel = conveyor.vel })
end

function conveyor.afterSimulation()
    conveyor.pos, conveyor.vel, conveyor.target = 0, 0, { vel = conveyor.config.targetVel }
    if not conveyor.efficient then
        carry()
    end
end

function sysCall_init() conveyor.init() end

function sysCall_actuation() conveyor.actuation() end

function sysCall_afterSimulation() conveyor.afterSimulation() end

return conveyor
