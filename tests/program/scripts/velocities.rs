//! Tests of the velocities that scripts and graphs get: of the frame of an object, and of its centre of mass.

use crate::{kit::*, scripts::graphs::table};

/// A body whose centre of mass is 0.5 m beside its frame turns freely at 2 rad/s about it, so the frame moves at 1 m/s.
fn spinning(more: &str) -> String {
    format!(
        "gravity_m_s2 = [0, 0, 0]\n[[object]]\nkind = \"shape\"\nalias = \"body\"\ndynamic = true\nmass_kg = 2.0\n\
         com_m = [0.5, 0, 0]\ninertia_kg_m2 = [0.1, 0.1, 0.1]\ninitial_angular_velocity_rad_s = [0, 0, 2]\n{more}"
    )
}

#[test]
fn object_velocity_is_that_of_the_frame() {
    let probe = watcher(
        "probe",
        "function sysCall_init() body = sim.getObject('/body') end
        function sysCall_sensing()
            local v, w = sim.getObjectVelocity(body)
            local c = sim.getVelocity(body)
            local x = sim.getObjectFloatParam(body, sim.objfloatparam_abs_x_velocity)
            local p = sim.getObjectPosition(body)
            if last then
                print(string.format('velocities %.6f %.6f %.6f %.6f %.6f %.6f %.6f %.6f', v[1], v[2], w[3], c[1], c[2], x,
                    (p[1] - last[1]) / 0.05, (p[2] - last[2]) / 0.05))
            end
            last = p
        end",
    );
    let err = TestFolder::scene(&spinning(&probe)).run(&["--steps", "20"]).good().err;
    let lines: Vec<Vec<f64>> = err
        .lines()
        .filter_map(|l| l.split_once("velocities "))
        .map(|(_, l)| l.split(' ').map(|x| x.trim().parse().unwrap()).collect())
        .collect();
    assert!(lines.len() >= 19, "{err}");
    for l in lines {
        assert!(((l[0] * l[0] + l[1] * l[1]).sqrt() - 1.0).abs() < 1e-3, "{l:?}");
        assert!(
            (l[2] - 2.0).abs() < 1e-3 && l[3].abs() < 1e-6 && l[4].abs() < 1e-6 && (l[5] - l[0]).abs() < 1e-6,
            "{l:?}"
        );
        // The mean velocity of a step, from its positions, is that of the middle of the step: 0.05 rad before its end.
        let (s, c) = 0.05f64.sin_cos();
        let middle = [l[0] * c + l[1] * s, l[1] * c - l[0] * s];
        assert!((l[6] - middle[0]).abs() < 2e-3 && (l[7] - middle[1]).abs() < 2e-3, "{l:?}");
    }
}

#[test]
fn graphs_record_the_speed_of_the_frame() {
    let graph = "[[object]]\nkind = \"graph\"\nalias = \"G\"\nstreams = [\n\
                 { name = \"speed\", unit = \"m/s\", of = \"/body\", data = \"speed\" },\n\
                 { name = \"turning\", unit = \"rad/s\", of = \"/body\", data = \"turning\" },\n]\n";
    let place = TestFolder::scene(&spinning(graph));
    place.run(&["--steps", "5", "--graphs", "out"]).good();
    let (_, rows) = table(&place.read("out/G.csv"));
    assert_eq!(rows.len(), 5);
    rows.iter().for_each(|r| assert!((r[1] - 1.0).abs() < 1e-3 && (r[2] - 2.0).abs() < 1e-3, "{r:?}"));
}
