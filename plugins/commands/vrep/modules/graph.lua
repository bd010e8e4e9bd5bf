-- The script of a graph since 4.0: it records by itself. Its curves are shown by views, which need nothing of a script.

local graph = {}
_S = _S or {}
_S.graph = graph

-- The graph at or above the script, which is an object of its own since 4.7.
local function model()
    local at = sim.getObject('.')
    while at ~= -1 and sim.getObjectType(at) ~= sim.object_graph_type do
        at = sim.getObjectParent(at)
    end
    return at
end

function graph.init() end

-- Records now; without a time, for the end of the step.
function graph.handle(time)
    sim.handleGraph(model(), time or sim.getSimulationTime() + sim.getSimulationTimeStep())
end

function graph.reset()
    sim.resetGraph(model())
end

function graph.updateCurves() end

function graph.cleanup() end

function graph.beforeSimulation()
    graph.reset()
end

function graph.afterSimulation() end

function sysCall_init() graph.init() end

function sysCall_beforeSimulation() graph.beforeSimulation() end

function sysCall_sensing()
    if sim.getSimulationState() ~= sim.simulation_advancing_lastbeforestop then
        graph.handle()
    end
end

function sysCall_afterSimulation() graph.afterSimulation() end

function sysCall_cleanup() graph.cleanup() end

return graph
