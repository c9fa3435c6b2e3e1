//! Sizes and times of pages of large landscapes.

use std::fs;
use std::time::{Duration, Instant};

use serde_json::json;

use super::{made, succeed};
use crate::browser::{act, browse, browser};
use crate::desk::Desk;

/// The page of a landscape of so many minima is at most `most` bytes, the same again, and usable. A browser takes some
/// seconds to start; the limits on times leave room for slow machines.
fn of(count: usize, groups: usize, most: usize, longest: Duration) {
    let desk = Desk::empty();
    made::landscape(count, groups, &desk.path("g.landscape"));
    succeed(&desk, "report g.landscape -q");
    let page = fs::read(desk.path("g.report.html")).unwrap();
    println!("{count} minima: {:.2} MB", 1e-6 * page.len() as f64);
    assert!(page.len() <= most, "{count} minima: {} bytes", page.len());
    if count < 1000 {
        succeed(&desk, "report g.landscape -q -o again.html");
        assert!(
            fs::read(desk.path("again.html")).unwrap() == page,
            "the same bytes again"
        );
    }
    let Some(browser) = browser() else { return };
    let started = Instant::now();
    let document = browse(&browser, &desk, "g.report.html", "", &["--dump-dom"]);
    println!(
        "{count} minima: shown after {:.1} s, with the start of the browser",
        started.elapsed().as_secs_f64()
    );
    assert!(document.contains("data-ready=\"1\"") && started.elapsed() < longest);
    let script = r"
const times = [];
for (const item of [1, 5, 9, 13]) { change({ hover: item }); await wait(600); times.push(panels.scene.views[0].x[0] - model.coordinates(item)[0]); }
finish({ count: model.count, off: Math.max(...times.map(Math.abs)), rows: document.querySelectorAll('#table .rows .row').length, circles: model.sides[0].graph.x.length });";
    let told = act(&browser, &desk, "g.report.html", "", script);
    assert_eq!(told["count"], count);
    assert!(told["off"].as_f64().unwrap() < 1e-6 && told["rows"].as_u64().unwrap() < 60);
    let circles = if count > 500 { groups } else { count };
    assert_eq!(told["circles"], json!(circles));
}

#[test]
fn a_page_of_400_grasps_is_small_and_quick() {
    of(400, 40, 2_500_000, Duration::from_secs(20));
}

#[test]
fn a_page_of_10_000_grasps_is_small_and_quick() {
    of(10_000, 300, 8_000_000, Duration::from_secs(40));
}
