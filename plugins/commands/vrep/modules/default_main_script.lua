-- Main script of scenes without their own main script: runs the stages of a step in order.

function sysCall_init()
    sim.handleSimulationStart()
    sim.openModule(sim.handle_all)
    sim.handleGraph(sim.handle_all_except_explicit, 0)
end

function sysCall_actuation()
    sim.handleEmbeddedScripts(sim.syscb_actuation)
    sim.handleAddOnScripts(sim.syscb_actuation)
    sim.handleSandboxScript(sim.syscb_actuation)
    sim.handleJointMotion()
    sim.handleDynamics(sim.getSimulationTimeStep())
end

function sysCall_sensing()
    sim.handleSensingStart()
    sim.handleProximitySensor(sim.handle_all_except_explicit)
    sim.handleVisionSensor(sim.handle_all_except_explicit)
    sim.handleEmbeddedScripts(sim.syscb_sensing)
    sim.handleAddOnScripts(sim.syscb_sensing)
    sim.handleSandboxScript(sim.syscb_sensing)
    if sim.getSimulationState() ~= sim.simulation_advancing_lastbeforestop then
        sim.handleGraph(sim.handle_all_except_explicit, sim.getSimulationTime() + sim.getSimulationTimeStep())
    end
end

function sysCall_cleanup()
    sim.handleEmbeddedScripts(sim.syscb_cleanup)
    sim.resetProximitySensor(sim.handle_all_except_explicit)
    sim.resetVisionSensor(sim.handle_all_except_explicit)
    sim.closeModule(sim.handle_all)
end
