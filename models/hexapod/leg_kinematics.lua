-- Closed-form kinematics of one leg: coxa about the vertical, femur and tibia across the leg.
--
-- Frame of a leg: origin on the coxa joint, x outwards, z up; rotated relative to the body by the leg's facing.
-- Lengths in m, angles of the joints in rad: a positive femur angle raises the knee, a positive tibia angle turns the
-- foot outwards. The foot is the centre of its cap. Other scripts call these functions by
--     legs = sim.getScriptFunctions(sim.getScript(sim.scripttype_simulation, sim.getObject('/phantomx/kinematics')))
--     coxa, femur, tibia = legs:jointsOf(0.11, 0, -0.10)

COXA = 0.054                       -- m, coxa joint to femur joint
FEMUR_X, FEMUR_Z = 0.0645, 0.0145  -- m, femur joint to tibia joint
TIBIA = 0.131                      -- m, tibia joint to the centre of the foot's cap: 0.138 less its radius of 0.007
local FEMUR = math.sqrt(FEMUR_X * FEMUR_X + FEMUR_Z * FEMUR_Z)
local BEND = math.atan(FEMUR_Z, FEMUR_X)

function footOf(coxa, femur, tibia)
    local out = COXA + FEMUR * math.cos(femur + BEND) + TIBIA * math.sin(femur + tibia)
    local z = FEMUR * math.sin(femur + BEND) - TIBIA * math.cos(femur + tibia)
    return out * math.cos(coxa), out * math.sin(coxa), z
end

-- Returns the solution with the knee above the line from femur joint to foot. A point out of reach is replaced by the
-- nearest reachable one.
function jointsOf(x, y, z)
    local out = math.sqrt(x * x + y * y) - COXA
    local square = out * out + z * z
    local cosine = (square - FEMUR * FEMUR - TIBIA * TIBIA) / (2 * FEMUR * TIBIA)
    -- The knee bends down by this angle from the line of the femur; 0 is a straight leg.
    local bent = math.acos(math.max(-1, math.min(1, cosine)))
    local line = math.atan(z, out) + math.atan(TIBIA * math.sin(bent), FEMUR + TIBIA * math.cos(bent))
    local femur = line - BEND
    return math.atan(y, x), femur, line - bent + math.pi / 2 - femur
end
