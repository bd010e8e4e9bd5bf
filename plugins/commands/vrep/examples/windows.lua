--- sim.createUI
local w = sim.createUI('panel', 1, {10, 4}, {16, 16}, {})
assert(sim.getUIHandle('panel') == w)
sim.removeUI(w)
assert(not pcall(sim.getUIHandle, 'panel'))
--- sim.removeUI
local w = sim.createUI('gone', 0, {2, 2}, {16, 16}, {})
sim.removeUI(w)
assert(not pcall(sim.removeUI, w))
--- sim.getUIHandle
assert(not pcall(sim.getUIHandle, 'nothing'))
--- sim.createUIButton
local w = sim.createUI('buttons', 0, {4, 2}, {16, 16}, {})
local b = sim.createUIButton(w, {0, 0}, {2, 1}, sim.buttonproperty_label)
sim.setUIButtonLabel(w, b, 'go')
assert(sim.getUIButtonLabel(w, b) == 'go')
sim.removeUI(w)
--- sim.getUIButtonLabel
local w = sim.createUI('label', 0, {4, 2}, {16, 16}, {})
local b = sim.createUIButton(w, {0, 0}, {2, 1}, sim.buttonproperty_label)
assert(sim.getUIButtonLabel(w, b) == '')
sim.removeUI(w)
--- sim.setUIButtonLabel
local w = sim.createUI('label', 0, {4, 2}, {16, 16}, {})
local b = sim.createUIButton(w, {0, 0}, {2, 1}, sim.buttonproperty_button)
sim.setUIButtonLabel(w, b, 'up', 'down')
assert(sim.getUIButtonLabel(w, b) == 'up')
sim.removeUI(w)
--- sim.getUISlider
local w = sim.createUI('slider', 0, {4, 2}, {16, 16}, {})
local b = sim.createUIButton(w, {0, 0}, {2, 1}, sim.buttonproperty_slider)
assert(sim.getUISlider(w, b) == 0)
sim.removeUI(w)
--- sim.setUISlider
local w = sim.createUI('slider', 0, {4, 2}, {16, 16}, {})
local b = sim.createUIButton(w, {0, 0}, {2, 1}, sim.buttonproperty_slider)
sim.setUISlider(w, b, 500)
assert(sim.getUISlider(w, b) == 500)
sim.removeUI(w)
--- sim.getUIEventButton
local w = sim.createUI('events', 0, {4, 2}, {16, 16}, {})
local bits = sim.buttonproperty_slider + sim.buttonproperty_enabled
local b = sim.createUIButton(w, {0, 0}, {2, 1}, bits)
assert(sim.getUIEventButton(w) == -1)
tatu.actOnButtons(w, 1, 'change', 250)
local button, values = sim.getUIEventButton(w)
assert(button == b and values[1] == 250 and sim.getUISlider(w, b) == 250)
assert(sim.getUIEventButton(w) == -1)
sim.removeUI(w)
--- tatu.actOnButtons
local w = sim.createUI('panel', 0, {4, 2}, {16, 16}, {})
local down = sim.buttonproperty_staydown + sim.buttonproperty_enabled
local b = sim.createUIButton(w, {0, 0}, {2, 1}, down)
tatu.actOnButtons(w, 1, 'click')
assert(sim.getUIButtonProperty(w, b) == down + sim.buttonproperty_isdown)
assert(not pcall(tatu.actOnButtons, w, 2, 'click'))
sim.removeUI(w)
--- sim.getUIProperty
local w = sim.createUI('bits', 0, {4, 2}, {16, 16}, {})
assert(sim.getUIProperty(w) % 2 == sim.ui_property_visible)
sim.removeUI(w)
--- sim.setUIProperty
local w = sim.createUI('bits', 3, {4, 2}, {16, 16}, {})
sim.setUIProperty(w, 1)
assert(sim.getUIProperty(w) == 1)
sim.removeUI(w)
--- sim.getUIButtonProperty
local w = sim.createUI('bits', 0, {4, 2}, {16, 16}, {})
local b = sim.createUIButton(w, {0, 0}, {2, 1}, sim.buttonproperty_slider)
assert(sim.getUIButtonProperty(w, b) == sim.buttonproperty_slider)
sim.removeUI(w)
--- sim.setUIButtonProperty
local w = sim.createUI('bits', 0, {4, 2}, {16, 16}, {})
local b = sim.createUIButton(w, {0, 0}, {2, 1}, sim.buttonproperty_slider)
sim.setUIButtonProperty(w, b, sim.buttonproperty_slider + sim.buttonproperty_enabled)
assert(sim.getUIButtonProperty(w, b) == 18)
sim.removeUI(w)
--- sim.getUIPosition
local w = sim.createUI('place', 0, {4, 2}, {16, 16}, {})
local at = sim.getUIPosition(w)
assert(at[1] == 0 and at[2] == 0)
sim.removeUI(w)
--- sim.setUIPosition
local w = sim.createUI('place', 0, {4, 2}, {16, 16}, {})
sim.setUIPosition(w, {10, 20})
assert(sim.getUIPosition(w)[2] == 20)
sim.removeUI(w)
--- sim.setUIButtonColor
local w = sim.createUI('colors', 0, {4, 2}, {16, 16}, {})
local b = sim.createUIButton(w, {0, 0}, {2, 1}, sim.buttonproperty_button)
sim.setUIButtonColor(w, b, {1, 0, 0}, nil, {1, 1, 1})
sim.removeUI(w)
