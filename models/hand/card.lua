-- Measurements of `card.toml`. Blocks float between the fingers until the fingers have closed on them.

local EDGE = 0.04      -- m: of the block that is gripped

local function hand()
    return sim.getObject('/hand')
end

local function finger(i)
    return sim.getObject('/hand/panda_finger_joint' .. i)
end

-- Distance between the pads' faces, which are at y = 0 of the fingers' frames.
local function width()
    local left = sim.getObjectPosition(sim.getObject('/hand/panda_leftfinger'), hand())
    local right = sim.getObjectPosition(sim.getObject('/hand/panda_rightfinger'), hand())
    return left[2] - right[2]
end

local function block(mass, aside)
    local shape = sim.createPrimitiveShape(sim.primitiveshape_cuboid, {EDGE, EDGE, EDGE})
    sim.setShapeMass(shape, mass)
    sim.setObjectPosition(shape, {0, aside or 0, 0}, sim.getObject('/hand/panda_hand_tcp'))
    sim.setBoolProperty(shape, 'shape.respondable', true)
    return shape
end

local function close(seconds)
    sim.setJointTargetPosition(finger(1), 0)
    sim.wait(seconds)
end

function mass()
    return measure.mass(measure.model())
end

function rest_drift()
    return measure.drift(hand(), 60)
end

function opening()
    sim.setJointTargetPosition(finger(1), 0.04)
    sim.wait(1)
    return width()
end

function closed()
    close(1)
    return width()
end

function finger_speed()
    sim.wait(0.2)
    sim.setJointTargetPosition(finger(1), 0)
    local first, last
    for _ = 1, 100 do
        sim.step()
        local position, time = sim.getJointPosition(finger(1)), sim.getSimulationTime()
        if position < 0.03 and not first then first = {position, time} end
        if position > 0.01 then last = {position, time} end
    end
    return (first[1] - last[1]) / (last[2] - first[2])
end

function symmetry()
    local shape, most = block(0.05, 0.005), 0
    sim.setBoolProperty(shape, 'shape.dynamic', true)
    sim.setObjectPosition(shape, {0, 0.005, EDGE / 2 + 0.066})
    sim.setJointTargetPosition(finger(1), 0)
    for _ = 1, 200 do
        sim.step()
        most = math.max(most, math.abs(sim.getJointPosition(finger(1)) - sim.getJointPosition(finger(2))))
    end
    return most
end

function grip_force()
    block(1)
    close(2)
    return math.abs(sim.getJointForce(finger(1)))
end

-- Hangs the hand on a vertical slide, and shakes it there.
function slip_when_shaken()
    local post = sim.createPrimitiveShape(sim.primitiveshape_cuboid, {0.05, 0.05, 0.05})
    sim.setObjectPosition(post, {0, 0, 0.5})
    local slide = sim.createJoint(sim.joint_prismatic_subtype, sim.jointmode_dynamic, 0)
    sim.setObjectPosition(slide, {0, 0, 0.5})
    sim.setObjectParent(slide, post, true)
    sim.setJointInterval(slide, false, {-0.5, 1})
    tatu.set(slide, 'joint.control', 'position')
    tatu.set(slide, 'joint.max_force', 500)
    sim.setObjectPosition(hand(), {0, 0, 0.5})
    sim.setObjectParent(hand(), slide, true)
    local shape = block(0.2)
    close(1)
    sim.setBoolProperty(shape, 'shape.dynamic', true)
    sim.wait(1)
    local tcp = sim.getObject('/panda_hand_tcp')
    local before = sim.getObjectPosition(shape, tcp)
    local start, most, travel = sim.getSimulationTime(), 0, 0
    while sim.getSimulationTime() < start + 20 do
        local t = sim.getSimulationTime() - start
        sim.setJointTargetPosition(slide, 0.025 * math.sin(2 * math.pi * 2 * t))
        sim.step()
        travel = math.max(travel, sim.getJointPosition(slide))
        most = math.max(most, measure.distance(before, sim.getObjectPosition(shape, tcp)))
    end
    if travel < 0.02 then error(string.format('the slide has moved by %.4f m, expected 0.025', travel)) end
    return most
end
