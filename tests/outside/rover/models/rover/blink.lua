function sysCall_init() print('blinks') end
