//! Lists of agents.

use relievo_crowd::{parse_agents, parse_walkers, square};

use crate::arm::built;

#[test]
fn a_square_of_agents_is_read_back() {
    let model = built(8, 8);
    let text = square(&model, 1000, 1.5);
    let agents = parse_agents(&text, &[&model]).unwrap();
    assert_eq!(agents.len(), 1000);
    let seconds = model.clips[0].poses.len() as f64 / f64::from(model.clips[0].rate);
    assert!(agents.iter().all(|agent| (0.0..=seconds).contains(&agent.phase)));
    let phases: std::collections::BTreeSet<u64> = agents.iter().map(|agent| agent.phase.to_bits()).collect();
    assert!(phases.len() > 500);
}

#[test]
fn lines_have_columns_names_and_remarks() {
    let model = built(8, 8);
    let text = "# a list\n\n1 2 3 90 2 bend 0.25 # first\n0 0 0 0 -1 0 0 0\n";
    let agents = parse_agents(text, &[&model]).unwrap();
    assert_eq!((agents.len(), agents[0].clip, agents[0].phase), (2, 0, 0.25));
    // A turn by 90 degrees about y brings x to -z.
    let moved = agents[0].transform.transform_point3(glam::DVec3::X);
    assert!(moved.distance(glam::DVec3::new(1.0, 2.0, 1.0)) < 1e-12, "{moved}");
    for (line, word) in [
        ("1 2 3", "columns"),
        ("1 2 3 0 1 bend x", "number"),
        ("1 2 3 0 1 bent 0", "bend"),
        ("1 2 inf 0 1 bend 0", "number"),
        ("1 2 3 0 1 bend 0 4", "model"),
        ("1 2 3 0 1 bend 0 0 fast", "number"),
        ("1 2 3 0 1 bend 0 0 1 1", "columns"),
    ] {
        let error = parse_agents(&format!("\n{line}\n"), &[&model]).unwrap_err().to_string();
        assert!(error.contains("line 2") && error.contains(word), "{error}");
    }
}

#[test]
fn walkers_go_along_their_heading() {
    let model = built(8, 8);
    let walkers = parse_walkers("1 2 3 90 2 bend 0.25 0 4\n1 2 3 90 2 bend 0.25\n", &[&model]).unwrap();
    // A turn by 90 degrees about y brings z to x.
    let end = walkers[0].at(0.5).transform;
    assert!(end.translation.distance(glam::DVec3::new(3.0, 2.0, 3.0)) < 1e-12, "{end}");
    assert_eq!(end.matrix3, walkers[0].agent.transform.matrix3);
    assert_eq!((walkers[1].at(9.0), walkers[0].at(0.0)), (walkers[1].agent, walkers[1].agent));
}
