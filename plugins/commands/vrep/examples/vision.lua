--- sim.readVisionSensor
function sysCall_sensing()
    local result, packet = sim.readVisionSensor(sim.getObject('/eye'))
    -- An object at a depth of 1 m, a quarter of the range from 0.5 to 2.5 m, fills the image.
    assert(result == 0 and #packet == 15 and math.abs(packet[5] - 0.25) < 1e-4)
end
--- sim.handleVisionSensor
local count, packet = sim.handleVisionSensor(sim.getObject('/eye'))
assert(count == 0 and math.abs(packet[15] - 0.25) < 1e-4)
--- sim.resetVisionSensor
local eye = sim.getObject('/eye')
sim.handleVisionSensor(eye)
sim.resetVisionSensor(eye)
assert(sim.readVisionSensor(eye) == -1)
--- sim.checkVisionSensor
local result, packet = sim.checkVisionSensor(sim.getObject('/eye'), sim.getObject('/seen'))
assert(result == 0 and math.abs(packet[5] - 0.25) < 1e-4)
--- sim.checkVisionSensorEx
local depths = sim.checkVisionSensorEx(sim.getObject('/eye'), sim.handle_all, false)
assert(#depths == 16 * 12 and math.abs(depths[1] - 0.25) < 1e-4)
--- sim.getVisionSensorImage
function sysCall_sensing()
    local image = sim.getVisionSensorImage(sim.getObject('/eye'), 0, 0, 4, 2)
    assert(#image == 3 * 4 * 2 and image[1] > 0 and image[1] <= 1)
end
--- sim.getVisionSensorCharImage
function sysCall_sensing()
    local bytes, columns, rows = sim.getVisionSensorCharImage(sim.getObject('/eye'))
    assert(columns == 16 and rows == 12 and #bytes == 3 * 16 * 12)
end
--- sim.getVisionSensorDepthBuffer
function sysCall_sensing()
    local depths = sim.getVisionSensorDepthBuffer(sim.getObject('/eye'))
    assert(#depths == 16 * 12 and math.abs(depths[1] - 0.25) < 1e-4)
end
--- sim.getVisionSensorResolution
local size = sim.getVisionSensorResolution(sim.getObject('/eye'))
assert(size[1] == 16 and size[2] == 12)
--- sim.getVisionSensorRes
local size = sim.getVisionSensorRes(sim.getObject('/eye'))
assert(size[1] == 16 and size[2] == 12)
--- sim.getVisionSensorImg
function sysCall_sensing()
    local bytes, size = sim.getVisionSensorImg(sim.getObject('/eye'), 1)
    assert(#bytes == size[1] * size[2] and bytes:byte(1) > 0)
end
--- sim.getVisionSensorDepth
function sysCall_sensing()
    local packed, size = sim.getVisionSensorDepth(sim.getObject('/eye'), 1)
    assert(math.abs(sim.unpackFloatTable(packed)[1] - 1) < 1e-3)
end
--- sim.setVisionSensorImage
function sysCall_sensing()
    local eye, red = sim.getObject('/eye'), {}
    for i = 1, 16 * 12 do red[3 * i - 2], red[3 * i - 1], red[3 * i] = 1, 0, 0 end
    sim.setVisionSensorImage(eye, red)
    assert(sim.getVisionSensorImg(eye):byte(1) == 255 and sim.getVisionSensorImg(eye):byte(2) == 0)
end
--- sim.setVisionSensorCharImage
function sysCall_sensing()
    local eye = sim.getObject('/eye')
    local image = string.char(1, 2, 3):rep(16 * 12)
    sim.setVisionSensorCharImage(eye, image)
    assert(sim.getVisionSensorImg(eye) == image)
end
--- sim.setVisionSensorImg
function sysCall_sensing()
    local eye = sim.getObject('/eye')
    sim.setVisionSensorImg(eye, string.char(9), 1, {3, 2}, {1, 1})
    assert(sim.getVisionSensorImg(eye, 0, 0, {3, 2}, {1, 1}) == string.char(9, 9, 9))
end
--- sim.createVisionSensor
local made = sim.createVisionSensor(2, {64, 48, 0, 0}, {0.1, 2, 1, 0.1, 0.1, 0.1, 0, 0, 0, 0, 0})
assert(sim.getVisionSensorRes(made)[1] == 64)
--- sim.handleSensorCallbacks
-- Nothing is detected, so no callback is called.
sim.handleSensorCallbacks(sim.getObject('/sonar'))
assert(sim.readProximitySensor(sim.getObject('/sonar')) == 0)
--- sim.getVisionSensorFilter
-- The default filters of a sensor load the image and output it unchanged.
local eye = sim.getObject('/eye')
assert(sim.getVisionSensorFilter(eye, 0) == 1 and sim.getVisionSensorFilter(eye, 1) == 4)
--- sim.setVisionSensorFilter
-- Use a separate sensor, because filters affect all users of a sensor.
local eye = sim.getObject('/filtering')
assert(sim.setVisionSensorFilter(eye, 1, 1, nil, nil, {0, 1, 0}) == 3)
sim.handleVisionSensor(eye)
assert(sim.getVisionSensorImg(eye):byte(1, 3) == 0 and sim.getVisionSensorImg(eye):byte(2) == 255)
--- sim.saveImage
local png = sim.saveImage(string.char(255, 0, 0):rep(6), {3, 2}, 0, '.png', -1)
assert(png:sub(2, 4) == 'PNG')
--- sim.loadImage
local image = string.char(255, 0, 0, 0, 255, 0)
local again, size = sim.loadImage(0, sim.saveImage(image, {1, 2}, 0, '.png', -1))
assert(again == image and size[2] == 2)
--- sim.getScaledImage
local twice, size = sim.getScaledImage(string.char(255, 0, 0), {1, 1}, {2, 2}, 0)
assert(twice == string.char(255, 0, 0):rep(4) and size[1] == 2)
--- sim.transformImage
local result, turned = sim.transformImage(string.char(1, 1, 1, 2, 2, 2), {1, 2}, 4)
assert(result == 1 and turned == string.char(2, 2, 2, 1, 1, 1))
