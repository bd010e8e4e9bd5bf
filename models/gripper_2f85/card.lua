-- Measurements of the gripper. Each function runs in a separate world that contains a floor and the gripper, fingers
-- up.

local PAD = 0.0253       -- from the axis of a tip to the face of its pad, m
local TIP = 0.051        -- from the axis of a tip to its end, m
local CLOSED = 0.7929    -- rad

local function part(name)
    return sim.getObject('/robotiq_85_base_link/robotiq_85_' .. name)
end

local function go(angle, seconds)
    sim.setJointTargetPosition(part('left_knuckle_joint'), angle)
    sim.wait(seconds or 2)
end

local function opening()
    return measure.distance(sim.getObjectPosition(part('left_finger_tip_link')),
        sim.getObjectPosition(part('right_finger_tip_link'))) - 2 * PAD
end

local function height()
    return sim.getObjectPosition(part('left_finger_tip_link'), measure.model())[3] + TIP
end

-- Adds a block of 200 g for the gripper, with its middle at a height.
local function block(width, height_of_middle)
    local body = sim.createPrimitiveShape(sim.primitiveshape_cuboid, {width, 0.05, 0.05})
    sim.setObjectInt32Param(body, sim.shapeintparam_respondable, 1)
    sim.setObjectInt32Param(body, sim.shapeintparam_static, 0)
    sim.setShapeMass(body, 0.2)
    sim.setObjectPosition(body, {0, 0, height_of_middle})
    return body
end

-- Hangs the gripper, fingers down, on a slide, with the middle of its pads at half the height of a block on the floor.
-- Returns the slide, whose positive targets move the gripper up.
local function hang()
    local base = measure.model()
    local tcp = sim.getObjectPosition(sim.getObject('/robotiq_85_base_link/tcp'), base)[3]
    local beam = sim.createPrimitiveShape(sim.primitiveshape_cuboid, {0.02, 0.02, 0.02})
    sim.setObjectInt32Param(beam, sim.shapeintparam_respondable, 0)
    sim.setObjectInt32Param(beam, sim.shapeintparam_static, 1)
    sim.setObjectPosition(beam, {0, 0, 0.6})
    local slide = sim.createJoint(sim.joint_prismatic_subtype, sim.jointmode_dynamic, 0)
    sim.setObjectPosition(slide, {0, 0, 0.6})
    sim.setObjectParent(slide, beam, true)
    tatu.set(slide, 'joint.control', 'position')
    tatu.set(slide, 'joint.max_force', 500)
    sim.setObjectPosition(base, {0, 0, 0.025 + tcp})
    sim.setObjectOrientation(base, {math.pi, 0, 0})
    sim.setObjectParent(base, slide, true)
    return slide
end

-- Grips a block on the floor and lifts it. Returns the block and the slide.
local function lifted(width)
    local slide, body = hang(), block(width, 0.025)
    sim.wait(0.5)
    go(0.8, 1.5)
    for i = 1, 20 do
        sim.setJointTargetPosition(slide, 0.1 * i / 20)
        sim.wait(0.05)
    end
    sim.wait(1)
    return body, slide
end

local function shaken(width)
    local body, slide = lifted(width)
    local tcp = sim.getObject('/robotiq_85_base_link/tcp')
    local from, start, most = sim.getObjectPosition(body, tcp), sim.getSimulationTime(), 0
    while sim.getSimulationTime() < start + 20 do
        local time = sim.getSimulationTime() - start
        sim.setJointTargetPosition(slide, 0.1 + 0.02 * math.sin(4 * math.pi * time))
        sim.step()
        most = math.max(most, measure.distance(from, sim.getObjectPosition(body, tcp)))
    end
    if sim.getObjectPosition(body)[3] < 0.08 then error('the block fell') end
    return most
end

-- The force of each pad on a block of 40 mm that hangs between the pads.
local function force()
    local body = lifted(0.04)
    local sum, index = 0, 0
    while true do
        local pair, _, push = sim.getContactInfo(0, body, index)
        if not pair then return sum / 2 end
        sum, index = sum + math.abs(push[1]), index + 1
    end
end

function mass() return measure.mass(measure.model()) end

function rest_drift() return measure.drift(measure.model(), 60) end

function opening_open() sim.wait(1) return opening() end

function opening_half() go(0.4) return opening() end

function opening_closed() go(CLOSED) return opening() end

function height_open() sim.wait(1) return height() end

function height_closed() go(CLOSED) return height() end

function closing_speed()
    sim.wait(0.5)
    sim.setJointTargetPosition(part('left_knuckle_joint'), CLOSED)
    local last, top = opening(), 0
    for _ = 1, 20 do
        sim.wait(0.05)
        local now = opening()
        top = math.max(top, (last - now) / 0.05)
        last = now
    end
    return top
end

function grip_force() return force() end

function grip_force_least() return force() end

function shaken_creep() return shaken(0.05) end

function shaken_creep_wide() return shaken(0.08) end

function shaken_creep_narrow() return shaken(0.02) end
