-- The referee: reads the true position of the quadrotor, which the pilot never does. Counts the gates that are crossed
-- in order, lights the next one, and raises an error if a gate is missed or not crossed in time.

-- As in the pilot: middles of the gates, m, and the direction in which they are crossed, degrees.
local GATES = {
    {3.0, 0.0, 1.3, 60}, {2.4, 3.0, 2.2, 150}, {-0.6, 3.4, 1.2, 200}, {-3.4, 1.4, 1.8, 265},
    {-2.4, -1.8, 2.6, -35}, {0.8, -2.6, 1.3, 15},
}
local HALF = 0.5                          -- m: half of the opening of a gate
local LIT, DARK = {1.0, 0.45, 0.05}, {0.16, 0.42, 0.72}
local GATE_MOST = 25                      -- s: from one gate to the next

local robot, gates, graph, streams
local before, next_gate, since, crossed = nil, 1, 0, 0

-- Returns the position in the frame of a gate: ahead, to the side, and above the middle.
local function in_gate(gate, p)
    local a = math.rad(gate[4])
    local x, y = p[1] - gate[1], p[2] - gate[2]
    return x * math.cos(a) + y * math.sin(a), -x * math.sin(a) + y * math.cos(a), p[3] - gate[3]
end

local function light(index, on)
    tatu.set(gates[index], 'shape.color', on and LIT or DARK)
end

function sysCall_init()
    robot = sim.getObject('/quadrotor')
    gates = {}
    for i = 1, #GATES do
        gates[i] = sim.getObject('/gate_' .. i .. '/lamp')
        light(i, i == 1)
    end
    graph = sim.getObject('/flight')
    streams = {
        sim.addGraphStream(graph, 'error of the estimate', 'm'),
        sim.addGraphStream(graph, 'off the middle', 'm'),
    }
    pilot = sim.getScript(sim.scripttype_simulation, sim.getObject('/quadrotor/controller'))
end

local function cross(p, now)
    local a0, side, up = in_gate(GATES[next_gate], before)
    local a1 = in_gate(GATES[next_gate], p)
    if not (a0 < 0 and a1 >= 0 and math.abs(side) < 2 and math.abs(up) < 2) then return end
    if math.abs(side) > HALF or math.abs(up) > HALF then
        error(string.format('gate %d was missed: %.2f m aside, %.2f m above its middle', next_gate, side, up))
    end
    sim.setGraphStreamValue(graph, streams[2], math.sqrt(side ^ 2 + up ^ 2))
    light(next_gate, false)
    next_gate, crossed, since = next_gate % #GATES + 1, crossed + 1, now
    light(next_gate, true)
    if next_gate == 1 then print(string.format('%d gates after %.1f s', crossed, now)) end
end

function sysCall_sensing()
    local now, p = sim.getSimulationTime(), sim.getObjectPosition(robot)
    if before then cross(p, now) end
    before = p
    local believed = sim.callScriptFunction('getEstimate', pilot)
    if believed then
        local e = math.sqrt((believed[1] - p[1]) ^ 2 + (believed[2] - p[2]) ^ 2 + (believed[3] - p[3]) ^ 2)
        sim.setGraphStreamValue(graph, streams[1], e)
    end
    if now - since > GATE_MOST then
        error(string.format('gate %d was not crossed within %d s', next_gate, GATE_MOST))
    end
end
