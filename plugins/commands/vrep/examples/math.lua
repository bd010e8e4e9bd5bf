--- sim.buildIdentityMatrix
local m = sim.buildIdentityMatrix()
assert(#m == 12 and m[1] == 1 and m[6] == 1 and m[11] == 1 and m[12] == 0)
--- sim.buildMatrix
local m = sim.buildMatrix({0, 0, 1}, {0, 0, math.pi / 2})
assert(m[12] == 1 and math.abs(m[5] - 1) < 1e-9)
--- sim.buildMatrixQ
local m = sim.buildMatrixQ({0, 0, 1}, {0, 0, 1, 0})
assert(m[12] == 1 and math.abs(m[1] + 1) < 1e-9)
--- sim.multiplyMatrices
local m = sim.multiplyMatrices(sim.buildMatrix({1, 0, 0}, {0, 0, 0}), sim.buildMatrix({0, 2, 0}, {0, 0, 0}))
assert(m[4] == 1 and m[8] == 2)
--- sim.multiplyVector
local p = sim.multiplyVector(sim.buildMatrix({1, 0, 0}, {0, 0, 0}), {1, 2, 3})
assert(p[1] == 2 and p[3] == 3)
--- sim.getInvertedMatrix
assert(sim.getInvertedMatrix(sim.buildMatrix({1, 2, 3}, {0, 0, 0}))[12] == -3)
--- sim.copyMatrix
local a = sim.buildIdentityMatrix()
local b = sim.copyMatrix(a)
b[1] = 5
assert(a[1] == 1)
--- sim.interpolateMatrices
local m = sim.interpolateMatrices(sim.buildIdentityMatrix(), sim.buildMatrix({2, 0, 0}, {0, 0, 1}), 0.5)
assert(math.abs(m[4] - 1) < 1e-9 and math.abs(sim.getEulerAnglesFromMatrix(m)[3] - 0.5) < 1e-9)
--- sim.getEulerAnglesFromMatrix
local e = sim.getEulerAnglesFromMatrix(sim.buildMatrix({0, 0, 0}, {0.1, 0.2, 0.3}))
assert(math.abs(e[1] - 0.1) < 1e-9 and math.abs(e[2] - 0.2) < 1e-9 and math.abs(e[3] - 0.3) < 1e-9)
--- sim.getQuaternionFromMatrix
local q = sim.getQuaternionFromMatrix(sim.buildMatrix({0, 0, 0}, {0, 0, math.pi / 2}))
assert(math.abs(q[3] - math.sqrt(0.5)) < 1e-9)
--- sim.getRotationAxis
local axis, angle = sim.getRotationAxis(sim.buildIdentityMatrix(), sim.buildMatrix({0, 0, 0}, {0, 0, 1}))
assert(math.abs(angle - 1) < 1e-9 and math.abs(axis[3] - 1) < 1e-9)
--- sim.rotateAroundAxis
local m = sim.rotateAroundAxis(sim.buildMatrix({1, 0, 0}, {0, 0, 0}), {0, 0, 1}, {0, 0, 0}, math.pi / 2)
assert(math.abs(m[8] - 1) < 1e-9)
--- sim.buildPose
local p = sim.buildPose({0, 0, 1}, {0, 0, math.pi})
assert(p[3] == 1 and math.abs(p[6]) > 0.999)
--- sim.multiplyPoses
local p = sim.multiplyPoses({1, 0, 0, 0, 0, 0, 1}, {0, 2, 0, 0, 0, 0, 1})
assert(p[1] == 1 and p[2] == 2)
--- sim.getPoseInverse
assert(sim.getPoseInverse({1, 2, 3, 0, 0, 0, 1})[2] == -2)
--- sim.interpolatePoses
assert(math.abs(sim.interpolatePoses({0, 0, 0, 0, 0, 0, 1}, {2, 0, 0, 0, 0, 0, 1}, 0.25)[1] - 0.5) < 1e-9)
--- sim.matrixToPose
assert(sim.matrixToPose(sim.buildMatrix({1, 2, 3}, {0, 0, 0}))[3] == 3)
--- sim.poseToMatrix
assert(sim.poseToMatrix({1, 2, 3, 0, 0, 0, 1})[12] == 3)
--- sim.yawPitchRollToAlphaBetaGamma
local a, b, g = sim.yawPitchRollToAlphaBetaGamma(0.5, 0, 0)
assert(math.abs(g - 0.5) < 1e-9)
--- sim.alphaBetaGammaToYawPitchRoll
local y, p, r = sim.alphaBetaGammaToYawPitchRoll(sim.yawPitchRollToAlphaBetaGamma(0.3, 0.2, 0.1))
assert(math.abs(y - 0.3) < 1e-9 and math.abs(p - 0.2) < 1e-9 and math.abs(r - 0.1) < 1e-9)
--- sim.boolOr32
assert(sim.boolOr32(5, 2) == 7)
--- sim.boolAnd32
assert(sim.boolAnd32(5, 4) == 4)
--- sim.boolXor32
assert(sim.boolXor32(5, 1) == 4)
--- sim.packFloatTable
assert(sim.packFloatTable({1.5, -2}) == '\0\0\xC0\x3F\0\0\0\xC0')
--- sim.unpackFloatTable
local t = sim.unpackFloatTable(sim.packFloatTable({1, 2, 3}), 1, 1)
assert(#t == 1 and t[1] == 2)
--- sim.packDoubleTable
assert(#sim.packDoubleTable({1, 2}) == 16)
--- sim.unpackDoubleTable
assert(sim.unpackDoubleTable(sim.packDoubleTable({0.1}))[1] == 0.1)
--- sim.packInt32Table
assert(sim.packInt32Table({258}) == '\2\1\0\0')
--- sim.unpackInt32Table
assert(sim.unpackInt32Table(sim.packInt32Table({-1}))[1] == -1)
--- sim.packUInt32Table
assert(sim.packUInt32Table({258}) == '\2\1\0\0')
--- sim.unpackUInt32Table
assert(sim.unpackUInt32Table('\255\255\255\255')[1] == 4294967295)
--- sim.packUInt16Table
assert(sim.packUInt16Table({258}) == '\2\1')
--- sim.unpackUInt16Table
assert(sim.unpackUInt16Table('\2\1')[1] == 258)
--- sim.packUInt8Table
assert(sim.packUInt8Table({65, 66}) == 'AB')
--- sim.unpackUInt8Table
assert(sim.unpackUInt8Table('AB')[2] == 66)
