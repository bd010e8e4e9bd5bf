-- Prints the depth in the middle of the image each second. At each key `w`, saves the images of the Kinect: the
-- colours, and the depths as grey, black near and white far.

if sim_call_type == sim_childscriptcall_initialization then
    depth = simGetObjectHandle('kinect_depth')
    rgb = simGetObjectHandle('kinect_rgb')
    resolution = simGetVisionSensorResolution(depth)
    near = 0.01
    far = 3.5
    pictures, told = 0, -1
end

if sim_call_type == sim_childscriptcall_sensing then
    local wanted = false
    local message, data = simGetSimulatorMessage()
    while message ~= -1 do
        wanted = wanted or (message == sim_message_keypress and data[1] == string.byte('w'))
        message, data = simGetSimulatorMessage()
    end

    local second = math.floor(simGetSimulationTime() + 0.001)
    if second ~= told then
        told = second
        local x, y = math.floor(resolution[1] / 2), math.floor(resolution[2] / 2)
        local value = simGetVisionSensorDepthBuffer(depth, x, y, 1, 1)[1]
        simAddStatusbarMessage(string.format('the middle is %.3f m away', near + value * (far - near)))
    end

    if wanted then
        pictures = pictures + 1
        local name = 'kinect_' .. pictures
        simSaveImage(simGetVisionSensorCharImage(rgb), resolution, 0, name .. '_rgb.png', -1)
        local grey = {}
        for i, value in ipairs(simGetVisionSensorDepthBuffer(depth)) do
            local level = string.char(math.floor(value * 255 + 0.5))
            grey[i] = level .. level .. level
        end
        simSaveImage(table.concat(grey), resolution, 0, name .. '_depth.png', -1)
        simAddStatusbarMessage('saved ' .. name)
    end
end
