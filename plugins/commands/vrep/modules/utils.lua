-- What scripts of 3.4 and 3.5 used to take in the files of the program: `include('/lua/name.lua')`.

function include(file)
    return require((file:gsub('^.*[/\\]', ''):gsub('%.lua$', '')))
end

return {}
