-- BubbleRob's controller: drives ahead; when its nose detects something, backs up in a curve for a while.
--
-- A window has a slider for the speed. The window is optional: without a view, nobody operates it.

local SLOWEST = math.rad(50)     -- rad/s, wheels at the left end of the slider
local FASTEST = math.rad(300)    -- rad/s, wheels at its right end
local BACKING_TIME = 4           -- s
local BACKING = {left = -1 / 2, right = -1 / 8}    -- of the speed ahead

-- Speed for a position of the slider, 0 to 100.
local function speedAt(position)
    return SLOWEST + (FASTEST - SLOWEST) * position / 100
end

function sliderMoved(ui, id, position)
    speed = speedAt(position)
end

local function openWindow()
    local ui = simUI.create(string.format([[
        <ui title="%s speed" closeable="false" layout="vbox">
            <label text="Speed of the wheels"/>
            <hslider id="1" minimum="0" maximum="100" on-change="sliderMoved"/>
        </ui>]], sim.getObjectAlias(sim.getObject(':'))))
    simUI.setSliderValue(ui, 1, 50)
end

function sysCall_init()
    local me = sim.getObject('..')
    local prefix = sim.readCustomStringData(me, 'names') or ''
    left = sim.getObject(':/' .. prefix .. 'leftMotor')
    right = sim.getObject(':/' .. prefix .. 'rightMotor')
    nose = sim.getObject(':/' .. prefix .. 'sensingNose', {noError = true})
    speed = speedAt(50)
    backUntil = -1               -- s; the robot drives ahead after this time
    if sim.readCustomStringData(me, 'window') == 'yes' then openWindow() end
end

function sysCall_actuation()
    local now = sim.getSimulationTime()
    -- While the robot backs up, a detection restarts the timer, as in the tutorial.
    if nose >= 0 and sim.readProximitySensor(nose) == 1 then backUntil = now + BACKING_TIME end
    local backing = now < backUntil
    sim.setJointTargetVelocity(left, speed * (backing and BACKING.left or 1))
    sim.setJointTargetVelocity(right, speed * (backing and BACKING.right or 1))
end
