//! Tests of scanning in the V-REP style: a script rotates a joint and triggers a ray many times in one call. Each
//! movement of the joint, the sensor's own body, a wall, or the wall's parent affects the next measurement.

use crate::kit::*;

/// Returns a ray along the x axis of a joint, which is mounted on a body at (0, 0, 0.3), and plates whose faces are at
/// x = 2, y = 3 and x = -4. The last plate is a child of a cart.
fn scene(script: &str) -> String {
    let plates = [
        cuboid("ahead", [0.2, 4.0, 1.0], [2.1, 0.0, 0.5], ""),
        cuboid("left", [4.0, 0.2, 1.0], [0.0, 3.1, 0.5], ""),
        "[[object]]\nkind = \"dummy\"\nalias = \"cart\"\nposition_m = [-4.0, 0.0, 0.0]\n".to_owned(),
        cuboid("behind", [0.2, 4.0, 1.0], [-0.1, 0.0, 0.5], "parent = \"/cart\""),
    ];
    let scanner = cuboid("body", [0.1, 0.1, 0.1], [0.0, 0.0, 0.3], "detectable = false");
    let ray = "[[object]]\nkind = \"joint\"\nalias = \"joint\"\nparent = \"/body\"\nmode = \"kinematic\"\n\
               [[object]]\nkind = \"sensor\"\nsensor = \"proximity\"\nalias = \"ray\"\nparent = \"/body/joint\"\n\
               orientation_deg = [0.0, 90.0, 0.0]\nvolume = \"ray\"\nrange_m = 10.0\nexplicit = true\n";
    let head = "function sysCall_init()
            joint, ray, body = sim.getObject('/joint'), sim.getObject('/ray'), sim.getObject('/body')
            ahead, cart = sim.getObject('/ahead'), sim.getObject('/cart')
        end
        local function look(degrees, wanted, what)
            sim.setJointPosition(joint, math.rad(degrees))
            local seen, distance = sim.handleProximitySensor(ray)
            if seen ~= 1 or math.abs(distance - wanted) > 1e-9 then
                error(string.format('%s: seen %d at %.6f, not at %.6f', what, seen, distance, wanted))
            end
        end\n";
    format!("{}{scanner}{ray}{}", plates.concat(), watcher("script", &format!("{head}{script}")))
}

#[test]
fn a_ray_sees_objects_moved_by_its_script_at_once() {
    let script = "
        function sysCall_sensing()
            for round = 0, 9 do
                look(0, 2, 'the joint ahead')
                look(90, 3, 'the joint turned left')
                look(60, 3 / math.sin(math.rad(60)), 'the joint at 60 degrees')
                look(180, 4, 'the joint turned back')
                sim.setObjectPosition(body, -1, { 0.25, 0.5, 0.3 })
                look(0, 1.75, 'the body moved')
                look(90, 2.5, 'the body moved')
                look(180, 4.25, 'the body moved')
                sim.setObjectOrientation(body, -1, { 0, 0, math.pi / 2 })
                look(0, 2.5, 'the body turned')
                look(-90, 1.75, 'the body turned')
                sim.setObjectOrientation(body, -1, { 0, 0, 0 })
                sim.setObjectPosition(body, -1, { 0, 0, 0.3 })
                look(0, 2, 'the body is back')
                sim.setObjectPosition(ahead, -1, { 1.1 + round, 0, 0.5 })
                look(0, 1 + round, 'a wall moved')
                sim.setObjectPosition(cart, -1, { -5 - round / 10, 0, 0 })
                look(180, 5 + round / 10, 'what carries a wall moved')
                sim.setObjectPosition(cart, -1, { -4, 0, 0 })
                sim.setObjectPosition(ahead, -1, { 2.1, 0, 0.5 })
            end
        end";
    for threads in ["1", "2"] {
        TestFolder::scene(&scene(script)).run(&["--steps", "5", "--threads", threads]).good();
    }
}

#[test]
fn created_changed_and_removed_objects_are_seen_at_once() {
    let script = "
        function sysCall_sensing()
            look(0, 2, 'before')
            local wall = sim.copyPasteObjects({ ahead }, 0)[1]
            sim.setObjectPosition(wall, -1, { 1.6, 0, 0.5 })
            look(0, 1.5, 'a copy')
            sim.setObjectPosition(wall, -1, { 1.1, 0, 0.5 })
            look(0, 1, 'the copy moved')
            sim.setObjectParent(wall, cart, true)
            sim.setObjectPosition(cart, -1, { -3.5, 0, 0 })
            look(0, 1.5, 'the copy on a cart')
            sim.removeObjects({ wall })
            look(0, 2, 'the copy is gone')
            sim.setObjectPosition(cart, -1, { -4, 0, 0 })
            look(180, 4, 'the cart is back')
        end";
    TestFolder::scene(&scene(script)).run(&["--steps", "3"]).good();
}

#[test]
fn bodies_moved_by_physics_are_seen_after_each_step() {
    // A box falls in front of the ray. Its upper side passes the height of the ray after 0.2 m.
    let falling = cuboid("falling", [0.2, 0.2, 0.2], [1.0, 0.0, 0.4], "dynamic = true");
    let script = "
        function sysCall_sensing()
            local z = sim.getObjectPosition(sim.getObject('/falling'), -1)[3]
            look(0, z + 0.1 > 0.3 and 0.9 or 2, string.format('the box at %.4f m', z))
            seen = (seen or 0) + (z + 0.1 > 0.3 and 1 or 0)
            if sim.getSimulationTime() > 0.4 and (seen < 2 or z > 0) then error('it does not fall past the ray') end
        end";
    TestFolder::scene(&format!("{}{falling}", scene(script))).run(&["--seconds", "0.5"]).good();
}
