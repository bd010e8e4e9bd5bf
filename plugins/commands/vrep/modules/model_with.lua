-- Returns the nearest object above the script that has custom data under a tag or, if there is none, the object to
-- which the script belongs. The other modules use this function to find their model.

return function(tag)
    local at, first = sim.getObject('.'), nil
    while at ~= -1 do
        if sim.getObjectType(at) ~= sim.object_script_type then
            local data = sim.readCustomDataBlock(at, tag)
            if data and #data > 0 then
                return at
            end
            first = first or at
        end
        at = sim.getObjectParent(at)
    end
    return first
end
