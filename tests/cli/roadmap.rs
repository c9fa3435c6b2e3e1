//! `landscape export X.landscape roadmap` and `landscape route`.

use serde_json::Value;

use crate::desk::{Desk, assert_says};

/// A landscape of grasps with its grasps in the folder.
fn desk() -> Desk {
    let desk = Desk::with_grasps();
    desk.add_landscape("g.landscape");
    desk
}

fn list(value: &Value) -> &Vec<Value> {
    value.as_array().unwrap()
}

/// Every path is in the road map, from one of its minima to the other, with rising times and a target for each joint.
#[test]
fn a_road_map_has_every_path() {
    let desk = desk();
    desk.succeed("export g.landscape roadmap -q -o map.json");
    let (map, files) = (desk.json("map.json"), desk.landscape("g.landscape"));
    assert_eq!(map["made_by"], "landscape");
    assert_eq!(list(&map["nodes"]).len(), files.minima.len());
    let joints = list(&map["joint_names"]).len();
    let pathed = |a: u64, b: u64| files.paths.iter().any(|row| (row.a, row.b) == (a, b));
    let edges = files.edges.iter().filter(|edge| pathed(edge.a, edge.b));
    assert_eq!(list(&map["edges"]).len(), edges.count());
    assert!(!list(&map["edges"]).is_empty());
    for edge in list(&map["edges"]) {
        let points = list(&edge["trajectory"]);
        let seconds = points
            .iter()
            .map(|point| point["seconds"].as_f64().unwrap());
        assert!(seconds.is_sorted_by(|one, next| one <= next));
        for (end, point) in [(0, &points[0]), (1, &points[points.len() - 1])] {
            let node = &map["nodes"][usize::try_from(edge["ends"][end].as_u64().unwrap()).unwrap()];
            for (met, known) in list(&point["joints"]).iter().zip(list(&node["joints"])) {
                assert!((met.as_f64().unwrap() - known.as_f64().unwrap()).abs() < 1e-6);
            }
            assert_eq!(list(&point["targets"]).len(), joints);
        }
        assert!(edge["forward"].is_null());
    }
}

/// The way between two minima goes along edges that meet, none of which is above its height.
#[test]
fn a_route_is_made_of_edges_that_meet() {
    let desk = desk();
    let route = desk.document("route g.landscape m0 m1 --json");
    let edges = list(&route["edges"]);
    assert_eq!(
        (&edges[0]["from"], &edges[edges.len() - 1]["to"]),
        (&"m0".into(), &"m1".into())
    );
    assert!(
        edges
            .windows(2)
            .all(|pair| pair[0]["to"] == pair[1]["from"])
    );
    let heights = edges.iter().map(|edge| edge["height"].as_f64().unwrap());
    assert_eq!(route["height"].as_f64(), heights.max_by(f64::total_cmp));
    assert_eq!(list(&route["minima"]).len(), edges.len() + 1);
    let driven = desk.document("route g.landscape m0 m1 --json --drive");
    for edge in list(&driven["edges"]) {
        assert!(
            edge["succeeded"].as_u64() <= edge["of"].as_u64() && edge["of"].as_u64() <= Some(4)
        );
    }
}

#[test]
fn mistakes_say_what_to_do() {
    let desk = desk();
    for (line, said) in [
        (
            "route g.landscape m0 m0",
            &["m0 and m0 are the same minimum"][..],
        ),
        ("route g.landscape m0 m999", &["m999", "there are"]),
        ("route g.landscape m0 third", &["third", "such as m0"]),
        ("export g.parquet csv --drive", &["--drive", "roadmap"]),
        (
            "export g.landscape roadmap --grasp 1 -o a.json",
            &["leave out --grasp"],
        ),
        ("export g.parquet roadmap -o a.json", &["g.parquet"]),
    ] {
        assert_says(&desk.mistake(line), said);
    }
}
