-- Closed-form kinematics of the legs.
--
-- Frames: the torso's (x ahead, y left, z up) and that of the foot, whose origin is the ankle and which is parallel
-- to the torso's when all joints are at 0. `side` is 1 for the left leg and -1 for the right one. Joints come in the
-- order HipYawPitch, HipRoll, HipPitch, KneePitch, AnklePitch, AnkleRoll, rad. Both legs share the motor of
-- HipYawPitch: a pair of poses is feasible if both solutions agree in that joint, as they do for feet parallel to the
-- torso. Other scripts call these functions by
--     legs = sim.getScriptFunctions(sim.getScript(sim.scripttype_simulation, sim.getObject('/nao/kinematics')))
--     joints = legs:jointsOf(0.017, 0.05, -0.27, 0, 0, 0, 1)

HIP_Y, HIP_Z = 0.05, -0.085        -- m, hip in the torso's frame, left side
THIGH, TIBIA = 0.1, 0.1029         -- m

-- Rotations are lists of three rows. The axis of HipYawPitch is between y and z: the z axis, rotated about x.
local TILT = {[1] = -3 * math.pi / 4, [-1] = -math.pi / 4}

local function rotX(a)
    local s, c = math.sin(a), math.cos(a)
    return {{1, 0, 0}, {0, c, -s}, {0, s, c}}
end

local function rotY(a)
    local s, c = math.sin(a), math.cos(a)
    return {{c, 0, s}, {0, 1, 0}, {-s, 0, c}}
end

local function rotZ(a)
    local s, c = math.sin(a), math.cos(a)
    return {{c, -s, 0}, {s, c, 0}, {0, 0, 1}}
end

local function times(a, b, ...)
    local m = {}
    for i = 1, 3 do
        m[i] = {}
        for j = 1, 3 do
            m[i][j] = a[i][1] * b[1][j] + a[i][2] * b[2][j] + a[i][3] * b[3][j]
        end
    end
    if ... then return times(m, ...) end
    return m
end

local function turned(m, v)
    local r = {}
    for i = 1, 3 do r[i] = m[i][1] * v[1] + m[i][2] * v[2] + m[i][3] * v[3] end
    return r
end

-- Returns the pose of the foot, x y z and rotation (rows), for joint angles.
function footOf(joints, side)
    local tilt = TILT[side]
    local thigh = times(rotX(tilt), rotZ(joints[1]), rotX(joints[2] - tilt), rotY(joints[3]))
    local tibia = times(thigh, rotY(joints[4]))
    local foot = times(tibia, rotY(joints[5]), rotX(joints[6]))
    local a, b = turned(thigh, {0, 0, -THIGH}), turned(tibia, {0, 0, -TIBIA})
    return a[1] + b[1], side * HIP_Y + a[2] + b[2], HIP_Z + a[3] + b[3], foot
end

-- Returns the joint angles that move the ankle to (x, y, z), with the foot rotated by yaw, then pitch, then roll, in
-- the torso's frame. A point out of reach is replaced by the nearest reachable one on its line to the hip.
function jointsOf(x, y, z, roll, pitch, yaw, side)
    local foot = times(rotZ(yaw), rotY(pitch), rotX(roll))
    -- The hip in the foot's frame: the ankle joints point the leg at it, and the knee sets the distance.
    local d = {-x, side * HIP_Y - y, HIP_Z - z}
    local u = {}
    for i = 1, 3 do u[i] = foot[1][i] * d[1] + foot[2][i] * d[2] + foot[3][i] * d[3] end
    local square = u[1] * u[1] + u[2] * u[2] + u[3] * u[3]
    local cosine = (square - THIGH * THIGH - TIBIA * TIBIA) / (2 * THIGH * TIBIA)
    local knee = math.acos(math.max(-1, math.min(1, cosine)))
    local ankleRoll = math.atan(u[2], u[3])
    local anklePitch = math.atan(-THIGH * math.sin(knee), TIBIA + THIGH * math.cos(knee))
        - math.atan(u[1], math.sqrt(u[2] * u[2] + u[3] * u[3]))
    -- The remaining rotation is that of the thigh, as angles about z, x and y in the frame of the tilted axis.
    local tilt = TILT[side]
    local m = times(rotX(-tilt), foot, rotX(-ankleRoll), rotY(-anklePitch - knee))
    local sine = math.max(-1, math.min(1, m[3][2]))
    -- Cosine of the angle about x, which is beyond 90 degrees on the left.
    local middle = side * -math.sqrt(1 - sine * sine)
    local hipRoll = math.atan(sine, middle) + tilt
    local yawPitch = math.atan(-m[1][2] / middle, m[2][2] / middle)
    local hipPitch = math.atan(-m[3][1] / middle, m[3][3] / middle)
    return {yawPitch, (hipRoll + math.pi) % (2 * math.pi) - math.pi, hipPitch, knee, anklePitch, ankleRoll}
end
