--- simOMPL.createTask
local task = simOMPL.createTask('reach')
simOMPL.destroyTask(task)

--- simOMPL.destroyTask
local task = simOMPL.createTask('reach')
simOMPL.destroyTask(task)
assert(not pcall(simOMPL.setup, task))

--- simOMPL.setAlgorithm
local task = simOMPL.createTask('reach')
simOMPL.setAlgorithm(task, simOMPL.Algorithm.RRTConnect)
assert(not pcall(simOMPL.setAlgorithm, task, simOMPL.Algorithm.pRRT))
simOMPL.destroyTask(task)

--- simOMPL.setCollisionPairs
local ball = sim.createPureShape(1, 0, {0.2, 0.2, 0.2}, 1)
local space = simOMPL.createStateSpace('xy', simOMPL.StateSpaceType.position2d, ball, {-1, -1}, {1, 1}, 1)
local task = simOMPL.createTask('move')
simOMPL.setStateSpace(task, {space})
simOMPL.setCollisionPairs(task, {ball, sim.handle_all})
simOMPL.destroyTask(task)
simOMPL.destroyStateSpace(space)
sim.removeObject(ball)

--- simOMPL.setStateValidityCheckingResolution
local task = simOMPL.createTask('reach')
simOMPL.setStateValidityCheckingResolution(task, 0.005)
assert(not pcall(simOMPL.setStateValidityCheckingResolution, task, 0))
simOMPL.destroyTask(task)

--- simOMPL.setStateValidationCallback
local ball = sim.createPureShape(1, 0, {0.2, 0.2, 0.2}, 1)
local space = simOMPL.createStateSpace('xy', simOMPL.StateSpaceType.position2d, ball, {-1, -1}, {1, 1}, 1)
local task = simOMPL.createTask('move')
simOMPL.setStateSpace(task, {space})
simOMPL.setStateValidationCallback(task, function(state) return state[1] < 0.5 end)
assert(simOMPL.isStateValid(task, {0.4, 0}) and not simOMPL.isStateValid(task, {0.6, 0}))
simOMPL.destroyTask(task)
simOMPL.destroyStateSpace(space)
sim.removeObject(ball)

--- simOMPL.setProjectionEvaluationCallback
local ball = sim.createPureShape(1, 0, {0.2, 0.2, 0.2}, 1)
local space = simOMPL.createStateSpace('xy', simOMPL.StateSpaceType.position2d, ball, {-1, -1}, {1, 1}, 1)
local task = simOMPL.createTask('move')
simOMPL.setStateSpace(task, {space})
simOMPL.setProjectionEvaluationCallback(task, function(state) return {state[1]} end, 1)
assert(simOMPL.projectionSize(task) == 1)
simOMPL.destroyTask(task)
simOMPL.destroyStateSpace(space)
sim.removeObject(ball)

--- simOMPL.setValidStateSamplerCallback
local ball = sim.createPureShape(1, 0, {0.2, 0.2, 0.2}, 1)
local space = simOMPL.createStateSpace('xy', simOMPL.StateSpaceType.position2d, ball, {-1, -1}, {1, 1}, 1)
local task = simOMPL.createTask('move')
simOMPL.setStateSpace(task, {space})
simOMPL.setValidStateSamplerCallback(task, function() return {0, 0} end, function(state) return state end)
simOMPL.destroyTask(task)
simOMPL.destroyStateSpace(space)
sim.removeObject(ball)

--- simOMPL.createStateSpace
local ball = sim.createPureShape(1, 0, {0.2, 0.2, 0.2}, 1)
local space = simOMPL.createStateSpace('pose', simOMPL.StateSpaceType.pose2d, ball, {-1, -1}, {1, 1}, 1)
assert(not pcall(simOMPL.createStateSpace, 'pose', simOMPL.StateSpaceType.pose2d, ball, {-1}, {1, 1}, 1))
simOMPL.destroyStateSpace(space)
sim.removeObject(ball)

--- simOMPL.destroyStateSpace
local ball = sim.createPureShape(1, 0, {0.2, 0.2, 0.2}, 1)
local space = simOMPL.createStateSpace('xyz', simOMPL.StateSpaceType.position3d, ball, {0, 0, 0}, {1, 1, 1}, 1)
simOMPL.destroyStateSpace(space)
sim.removeObject(ball)

--- simOMPL.setDubinsParams
local ball = sim.createPureShape(1, 0, {0.2, 0.2, 0.2}, 1)
local space = simOMPL.createStateSpace('car', simOMPL.StateSpaceType.dubins, ball, {-1, -1}, {1, 1}, 1)
simOMPL.setDubinsParams(space, 0.2, true)
simOMPL.destroyStateSpace(space)
sim.removeObject(ball)

--- simOMPL.setStateSpace
local ball = sim.createPureShape(1, 0, {0.2, 0.2, 0.2}, 1)
local space = simOMPL.createStateSpace('xy', simOMPL.StateSpaceType.position2d, ball, {-1, -1}, {1, 1}, 1)
local task = simOMPL.createTask('move')
simOMPL.setStateSpace(task, {space})
assert(simOMPL.getStateSpaceDimension(task) == 2)
simOMPL.destroyTask(task)
simOMPL.destroyStateSpace(space)
sim.removeObject(ball)

--- simOMPL.setStateSpaceForJoints
local joint = sim.createJoint(sim.joint_revolute_subtype, sim.jointmode_passive, 0)
local task = simOMPL.createTask('turn')
simOMPL.setStateSpaceForJoints(task, {joint})
assert(simOMPL.getStateSpaceDimension(task) == 1)
simOMPL.destroyTask(task)
sim.removeObject(joint)

--- simOMPL.setStartState
local ball = sim.createPureShape(1, 0, {0.2, 0.2, 0.2}, 1)
local space = simOMPL.createStateSpace('xy', simOMPL.StateSpaceType.position2d, ball, {-1, -1}, {1, 1}, 1)
local task = simOMPL.createTask('move')
simOMPL.setStateSpace(task, {space})
simOMPL.setStartState(task, {0.5, 0.5})
assert(not pcall(simOMPL.setStartState, task, {0.5}))
simOMPL.destroyTask(task)
simOMPL.destroyStateSpace(space)
sim.removeObject(ball)

--- simOMPL.setGoalState
local ball = sim.createPureShape(1, 0, {0.2, 0.2, 0.2}, 1)
local space = simOMPL.createStateSpace('xy', simOMPL.StateSpaceType.position2d, ball, {-1, -1}, {1, 1}, 1)
local task = simOMPL.createTask('move')
simOMPL.setStateSpace(task, {space})
simOMPL.setGoalState(task, {0.5, 0.5})
simOMPL.destroyTask(task)
simOMPL.destroyStateSpace(space)
sim.removeObject(ball)

--- simOMPL.addGoalState
local ball = sim.createPureShape(1, 0, {0.2, 0.2, 0.2}, 1)
local space = simOMPL.createStateSpace('xy', simOMPL.StateSpaceType.position2d, ball, {-1, -1}, {1, 1}, 1)
local task = simOMPL.createTask('move')
simOMPL.setStateSpace(task, {space})
simOMPL.setGoalState(task, {0.5, 0.5})
simOMPL.addGoalState(task, {-0.5, 0.5})
simOMPL.destroyTask(task)
simOMPL.destroyStateSpace(space)
sim.removeObject(ball)

--- simOMPL.setGoalStates
local ball = sim.createPureShape(1, 0, {0.2, 0.2, 0.2}, 1)
local space = simOMPL.createStateSpace('xy', simOMPL.StateSpaceType.position2d, ball, {-1, -1}, {1, 1}, 1)
local task = simOMPL.createTask('move')
simOMPL.setStateSpace(task, {space})
simOMPL.setGoalStates(task, {{0.5, 0.5}, {-0.5, 0.5}})
simOMPL.destroyTask(task)
simOMPL.destroyStateSpace(space)
sim.removeObject(ball)

--- simOMPL.setGoal
local ball = sim.createPureShape(1, 0, {0.2, 0.2, 0.2}, 1)
local space = simOMPL.createStateSpace('xy', simOMPL.StateSpaceType.position2d, ball, {-1, -1}, {1, 1}, 1)
local task = simOMPL.createTask('move')
simOMPL.setStateSpace(task, {space})
local carried, target = sim.createDummy(0.01), sim.createDummy(0.01)
sim.setObjectParent(carried, ball, true)
sim.setObjectPosition(target, -1, {0.5, 0.2, 0})
simOMPL.setGoal(task, carried, target, 0.1, {1, 1, 0, 0})
simOMPL.setStartState(task, {-0.5, 0})
local solved, path = simOMPL.compute(task, 2)
assert(solved and math.abs(path[#path - 1] - 0.5) < 0.11)
sim.removeObject(carried)
sim.removeObject(target)
simOMPL.destroyTask(task)
simOMPL.destroyStateSpace(space)
sim.removeObject(ball)

--- simOMPL.setGoalCallback
local ball = sim.createPureShape(1, 0, {0.2, 0.2, 0.2}, 1)
local space = simOMPL.createStateSpace('xy', simOMPL.StateSpaceType.position2d, ball, {-1, -1}, {1, 1}, 1)
local task = simOMPL.createTask('move')
simOMPL.setStateSpace(task, {space})
simOMPL.setStartState(task, {-0.5, 0})
simOMPL.setGoalCallback(task, function(state) return state[1] > 0.5, 0.5 - state[1] end)
local solved, path = simOMPL.compute(task, 2)
assert(solved and path[#path - 1] > 0.5)
simOMPL.destroyTask(task)
simOMPL.destroyStateSpace(space)
sim.removeObject(ball)
