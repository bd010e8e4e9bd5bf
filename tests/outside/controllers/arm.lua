-- Computes what the part `pid` computes, in the same order.
local p, i, d, target = 30, 20, 4, math.rad(40)

function sysCall_init()
    joint, sum = sim.getObject('/post/elbow'), 0
end

function sysCall_dyn(call)
    if call.afterStep then return end
    local off = target - sim.getFloatProperty(joint, 'joint.position')
    sum = sum + off * call.dt
    local torque = p * off + i * sum - d * sim.getFloatProperty(joint, 'joint.velocity')
    sim.setFloatProperty(joint, 'joint.max_force', torque)
end
