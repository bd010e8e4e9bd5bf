-- Prints the speeds that a robot publishes as the signals GVLeft and GVRight; nothing before the first ones.

if sim_call_type == sim_childscriptcall_initialization then
    console = simAuxiliaryConsoleOpen('Speeds', 500, 0)
end

if sim_call_type == sim_childscriptcall_sensing then
    local left, right = simGetFloatSignal('GVLeft'), simGetFloatSignal('GVRight')
    if left and right then
        simAuxiliaryConsolePrint(console, string.format('left %.2f right %.2f\n', left, right))
    end
end
