--- sim.handleGraph
graph = sim.getObject('/graph')
stream = sim.addGraphStream(graph, 'a', 'm')
sim.setGraphStreamValue(graph, stream, 3)
sim.handleGraph(graph, 0.5)
_, _, _, times, values = sim.getGraphCurve(graph, 0, 0)
assert(times[1] == 0.5 and values[1] == 3)
--- sim.resetGraph
graph = sim.getObject('/graph')
stream = sim.addGraphStream(graph, 'a', 'm')
sim.setGraphStreamValue(graph, stream, 3)
sim.handleGraph(graph, 0.5)
sim.resetGraph(graph)
_, _, _, times = sim.getGraphCurve(graph, 0, 0)
assert(#times == 0)
--- sim.setGraphUserData
graph = sim.getObject('/graph')
sim.addGraphStream(graph, 'distance', 'm')
assert(sim.setGraphUserData(graph, 'distance', 0.5) == 1)
--- sim.addGraphStream
graph = sim.getObject('/graph')
stream = sim.addGraphStream(graph, 'speed', 'm/s')
assert(sim.getGraphCurve(graph, 0, 0) == 'speed')
--- sim.setGraphStreamValue
graph = sim.getObject('/graph')
stream = sim.addGraphStream(graph, 'speed', 'm/s')
sim.setGraphStreamValue(graph, stream, 0.5)
sim.handleGraph(graph, 1)
_, _, _, _, values = sim.getGraphCurve(graph, 0, 0)
assert(values[1] == 0.5)
--- sim.setGraphStreamTransformation
graph = sim.getObject('/graph')
stream = sim.addGraphStream(graph, 'a', 'm')
sim.setGraphStreamTransformation(graph, stream, 0, 2, 1)
sim.setGraphStreamValue(graph, stream, 3)
sim.handleGraph(graph, 0)
_, _, _, _, values = sim.getGraphCurve(graph, 0, 0)
assert(values[1] == 7)
--- sim.addGraphCurve
graph = sim.getObject('/graph')
x = sim.addGraphStream(graph, 'x', 'm')
curve = sim.addGraphCurve(graph, 'path', 2, {x, -1}, {0, 5}, 'm')
assert(sim.getGraphCurve(graph, 1, 0) == 'path')
--- sim.duplicateGraphCurveToStatic
graph = sim.getObject('/graph')
x = sim.addGraphStream(graph, 'x', 'm')
curve = sim.addGraphCurve(graph, 'path', 2, {x, -1}, {0, 5}, 'm')
copy = sim.duplicateGraphCurveToStatic(graph, curve, 'first run')
assert(sim.getGraphCurve(graph, 1, 1) == 'first run')
--- sim.destroyGraphCurve
graph = sim.getObject('/graph')
x = sim.addGraphStream(graph, 'x', 'm')
curve = sim.addGraphCurve(graph, 'path', 2, {x, -1}, {0, 5}, 'm')
sim.destroyGraphCurve(graph, curve)
assert(sim.getGraphCurve(graph, 1, 0) == nil)
--- sim.getGraphCurve
graph = sim.getObject('/graph')
sim.addGraphStream(graph, 'a', 'm')
label = sim.getGraphCurve(graph, 0, 0)
assert(label == 'a')
--- sim.getGraphInfo
graph = sim.getObject('/graph')
sim.addGraphStream(graph, 'a', 'm')
title = sim.getGraphInfo(graph)
assert(title == sim.getObjectAlias(graph))
--- sim.addDrawingObject
lines = sim.addDrawingObject(sim.drawing_lines, 2, 0, -1, 1, {1, 0, 0})
assert(sim.addDrawingObjectItem(lines, {0, 0, 0, 1, 0, 0}) == 1)
assert(sim.addDrawingObjectItem(lines, {0, 0, 0, 2, 0, 0}) == 0)
--- sim.addDrawingObjectItem
points = sim.addDrawingObject(sim.drawing_points, 2, 0.1, -1, 0, {1, 0, 0})
assert(sim.addDrawingObjectItem(points, {0, 0, 0}) == 1)
assert(sim.addDrawingObjectItem(points, {0.05, 0, 0}) == 0)
--- sim.removeDrawingObject
lines = sim.addDrawingObject(sim.drawing_lines, 2, 0, -1, 1000, {1, 0, 0})
sim.removeDrawingObject(lines)
assert(not pcall(sim.addDrawingObjectItem, lines, {0, 0, 0, 1, 0, 0}))
--- sim.addParticleObject
dust = sim.addParticleObject(0, 0.01, 1000, {}, 1, 100, {1, 1, 0})
assert(dust > 0)
--- sim.addParticleObjectItem
dust = sim.addParticleObject(0, 0.01, 1000, {}, 1, 100, {1, 1, 0})
assert(sim.addParticleObjectItem(dust, {0, 0, 1, 0, 0, 0}) == 1)
--- sim.removeParticleObject
dust = sim.addParticleObject(0, 0.01, 1000, {}, 1, 100, {1, 1, 0})
assert(sim.removeParticleObject(dust) == 1)
--- sim.floatingViewAdd
view = sim.floatingViewAdd(0.5, 0.5, 0.3, 0.3, 0)
assert(view > 0)
--- sim.floatingViewRemove
view = sim.floatingViewAdd(0.5, 0.5, 0.3, 0.3, 0)
assert(sim.floatingViewRemove(view) == 1)
--- sim.adjustView
view = sim.floatingViewAdd(0.5, 0.5, 0.3, 0.3, 0)
assert(sim.adjustView(view, -1, 256) == 2)
