-- For the other modules: the nearest object above the script that has data under a tag; if none has, the object that the
-- script belongs to.

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
