-- Returns the nearest ancestor of the script that has data under a tag; if there is none, the object to which the
-- script belongs. Used by the other modules.

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
