-- Measures both cameras, and converts their rows of depths to points: x y z in the frame of the device, from right to
-- left. Pixels that detect nothing, or that are outside the scanning angle, are omitted.

local function parameter(name, low, high)
    local value = tonumber(sim.getScriptSimulationParameter(sim.handle_self, name)) or high
    return math.max(low, math.min(high, value))
end

function sysCall_init()
    reference = sim.getObjectHandle('fastHokuyo_ref')
    cameras = {}
    for i = 1, 2 do
        local handle = sim.getObjectHandle('fastHokuyo_sensor' .. i)
        local _, near = sim.getObjectFloatParameter(handle, sim.visionfloatparam_near_clipping)
        local _, opening = sim.getObjectFloatParameter(handle, sim.visionfloatparam_perspective_angle)
        local matrix = sim.getObjectMatrix(handle, reference)
        cameras[i] = { handle = handle, near = near, slope = math.tan(opening / 2), matrix = matrix }
    end
end

function sysCall_sensing()
    local most = math.rad(parameter('scanAngle', 1, 240)) / 2
    local far = parameter('maxScanDistance', 0.1, 1000)
    local points = {}
    for _, camera in ipairs(cameras) do
        if far ~= camera.far then
            camera.far = far
            sim.setObjectFloatParameter(camera.handle, sim.visionfloatparam_far_clipping, far)
        end
        sim.handleVisionSensor(camera.handle)
        local depths = sim.getVisionSensorDepthBuffer(camera.handle)
        local n = #depths
        for i = n, 1, -1 do
            local z = camera.near + depths[i] * (far - camera.near)
            -- Columns are equally spaced on the image plane; the first is at +x of the camera, which is its left.
            local across = camera.slope * (1 - (2 * i - 1) / n)
            if depths[i] < 0.9999 and z * math.sqrt(1 + across * across) < far then
                local point = sim.multiplyVector(camera.matrix, { z * across, 0, z })
                if math.abs(math.atan2(point[2], point[1])) <= most + 1e-6 then
                    for k = 1, 3 do points[#points + 1] = point[k] end
                end
            end
        end
    end
    sim.setStringSignal('measuredDataAtThisTime', sim.packFloatTable(points) or '')
end
