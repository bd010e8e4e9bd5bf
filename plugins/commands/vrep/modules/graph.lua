-- The script that graphs have since V-REP 4.0. It records samples; views show the curves without its help.

local graph = {}
_S = _S or {}
_S.graph = graph

-- Returns the nearest graph at or above the object to which the script belongs, or nil if there is none.
local function model()
    local at = sim.getObjectAssociatedWithScript(sim.handle_self)
    while at ~= -1 and sim.getObjectType(at) ~= sim.object_graph_type do
        at = sim.getObjectParent(at)
    end
    return at ~= -1 and at or nil
end

function graph.init() end

-- Records a sample. By default, its time is the end of the step.
function graph.handle(time)
    local own = model()
    if own then
        sim.handleGraph(own, time or sim.getSimulationTime() + sim.getSimulationTimeStep())
    end
end

function graph.reset()
    local own = model()
    if own then
        sim.resetGraph(own)
    end
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
