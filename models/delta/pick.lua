-- The delta robot carries pieces from one tray to the other, one after another, and then back, in an endless loop.
-- The positions of the trays are constants; whether the cup holds a piece is measured by the sensor in the cup, which
-- represents the vacuum switch of a real gripper.

local TRAYS = {-0.26, 0.26}                      -- m: y of the trays' middles, in the frame of the base
local PLACES = {{-0.12, -0.07}, {0, -0.07}, {0.12, -0.07}, {-0.12, 0.07}, {0, 0.07}, {0.12, 0.07}}   -- m: in a tray
local TOP = 0.38                                 -- m: height of a piece's top above the floor, on its tray
local HEIGHT = 1.45                              -- m: of the motors' axes above the floor
local TOOL = 0.10                                -- m: distance from the platform to the lip of the cup
local LIFT = 0.08                                -- m: lift of pieces above the trays
local SPEED = 0.9                                -- m/s: mean speed across
local SHORTEST = 0.25                            -- s: time of a move up or down
local PAUSE = 0.1                                -- s: for the vacuum to build up, or to break

local motors, kinematics, tip, vacuum, tie

local function aim(position)
    local angles, why = kinematics:inverse(position)
    if not angles then
        error(string.format('the position %.3f %.3f %.3f m: %s', position[1], position[2], position[3], why))
    end
    for i, motor in ipairs(motors) do sim.setJointTargetPosition(motor, angles[i]) end
end

local at

-- Moves the lip of the cup in a straight line, from rest to rest: x and y in the frame of the base, z above the floor.
local function move(x, y, z)
    local to = {x, y, z + TOOL - HEIGHT}
    local way = math.sqrt((to[1] - at[1]) ^ 2 + (to[2] - at[2]) ^ 2 + (to[3] - at[3]) ^ 2)
    local seconds, start, t = math.max(SHORTEST, way / SPEED), sim.getSimulationTime(), 0
    while t < 1 do
        t = math.min((sim.getSimulationTime() - start) / seconds, 1)
        local s = t * t * t * (10 + t * (6 * t - 15))
        aim{at[1] + s * (to[1] - at[1]), at[2] + s * (to[2] - at[2]), at[3] + s * (to[3] - at[3])}
        sim.step()
    end
    -- Targets are followed with a lag of half a step, and reached after two steps.
    sim.wait(PAUSE)
    at = to
end

-- Ties the piece under the cup to its lip.
local function grip()
    local found, _, _, piece = sim.readProximitySensor(vacuum)
    if found ~= 1 then error('there is no piece under the cup') end
    tie = sim.createDummy(0.01)
    sim.setObjectPose(tie, sim.getObjectPose(tip))
    sim.setObjectParent(tie, piece, true)
    tatu.set(tie, 'dummy.link', sim.getObjectAlias(tip, 2))
end

local function release()
    sim.removeObjects{tie}
    tie = nil
end

local function carry(from, to)
    move(from[1], from[2], TOP + LIFT)
    move(from[1], from[2], TOP)
    grip()
    move(from[1], from[2], TOP + LIFT)
    move(to[1], to[2], TOP + LIFT)
    move(to[1], to[2], TOP)
    release()
    move(to[1], to[2], TOP + LIFT)
end

function sysCall_init()
    motors = {}
    for i = 1, 3 do motors[i] = sim.getObject(':/motor_' .. i) end
    kinematics = sim.getScriptFunctions(sim.getScript(sim.scripttype_simulation, sim.getObject(':/kinematics')))
    tip, vacuum = sim.getObject(':/suction_tip'), sim.getObject(':/vacuum')
end

function sysCall_thread()
    local angles = {}
    for i, motor in ipairs(motors) do angles[i] = sim.getJointPosition(motor) end
    at = kinematics:forward(angles)
    local tray = 1
    while true do
        for _, place in ipairs(PLACES) do
            carry({place[1], place[2] + TRAYS[tray]}, {place[1], place[2] + TRAYS[3 - tray]})
        end
        tray = 3 - tray
    end
end
