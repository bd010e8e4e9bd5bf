-- The vision sensor's filter: edges white, everything else black.

local simVision = require 'simVision'

local THRESHOLD = 0.2    -- difference of neighbours that counts as an edge, of 0 to 1

function sysCall_vision(data)
    simVision.sensorImgToWorkImg(data.handle)
    simVision.edgeDetectionOnWorkImg(data.handle, THRESHOLD)
    simVision.workImgToSensorImg(data.handle)
end
