//! Tests that results do not depend on the C library's mathematical functions, which have different implementations for
//! processors with and without fused multiply-add and wide registers.

use crate::kit::*;

/// Calls every function of `math` and the power operator with many arguments, and prints all digits to the status bar.
const MATH_SCRIPT: &str = "
function sysCall_init()
    local f = {math.sin, math.cos, math.tan, math.exp, math.asin, math.acos, math.atan, math.log}
    local g = {math.sinh, math.cosh, math.tanh, math.log10, math.pow}
    local bits = 0
    local function take(v) bits = bits * 31 + string.unpack('i8', string.pack('d', v)) end
    for i = 1, 3000 do
        local x = (i * 0.000329) ^ 1.1
        for _, h in ipairs(f) do take(h(x)) end
        for _, h in ipairs(g) do take(h(x * 3, 1.7)) end
        take(math.sin(x * 100)) take(math.log(x + 1, 2)) take(math.atan(x, 0.3)) take(x ^ 0.37)
    end
    sim.addStatusbarMessage(tostring(bits))
    motors = {sim.getObject('./Pioneer_p3dx_leftMotor'), sim.getObject('./Pioneer_p3dx_rightMotor')}
end
function sysCall_actuation()
    local t = sim.getSimulationTime()
    for i, m in ipairs(motors) do sim.setJointTargetVelocity(m, 2 + math.sin(t * i)) end
end
";

#[test]
#[cfg(all(target_arch = "x86_64", target_env = "gnu"))]
fn the_c_library_decides_no_bits() {
    let sensors = "[[object]]\nkind = \"sensor\"\nsensor = \"laser\"\nparent = \"/Pioneer_p3dx\"\nalias = \"laser\"\nposition_m = [0.1, 0, 0.3]\n\
                   [[object]]\nkind = \"sensor\"\nsensor = \"gps\"\nparent = \"/Pioneer_p3dx\"\nalias = \"gps\"\n";
    let walls = cuboid("wall", [0.1, 6.0, 1.0], [2.0, 0.0, 0.5], "respondable = true");
    let place = TestFolder::scene(&format!("{FLOOR}{walls}{}{sensors}", pioneer(MATH_SCRIPT, "")));
    let trace = |file: &str, env: &[(&str, &str)]| {
        let all = ["run", "scene.toml", "--seconds", "3", "--trace", file, "--watch", "/Pioneer_p3dx/laser"];
        let done = run(program(), place.path(), &all, env);
        assert_eq!(done.code, 0, "{}", done.err);
        place.read(file)
    };
    let usual = trace("a.jsonl", &[]);
    // Makes glibc select the code for a processor without these instructions.
    let plain = trace("b.jsonl", &[("GLIBC_TUNABLES", "glibc.cpu.hwcaps=-FMA,-AVX2,-AVX,-FMA4")]);
    assert!(usual == plain, "the results differ without fused multiply-add");
    assert!(usual.contains("statusbar\":[\""), "the script has printed nothing");
}
