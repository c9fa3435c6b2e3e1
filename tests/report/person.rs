//! The same walk through the page, with a mouse and a keyboard as a person has them, in each browser.

use serde_json::{Value, json};

use super::{desk_with_page, numbers};
use crate::browser::{Kind, Remote, browser, firefox};
use crate::desk::assert_says;

/// Where a leaf of the tree is in the window.
fn leaf(remote: &mut Remote, item: usize) -> [f64; 2] {
    place(
        remote,
        &format!(
            "(() => {{ scrollTo(0, 0); const box = panels.tree.drawing.canvas.getBoundingClientRect(); \
             const [x, y] = panels.tree.at({item}); return [box.left + x, box.top + y]; }})()"
        ),
    )
}

fn place(remote: &mut Remote, expression: &str) -> [f64; 2] {
    let place = numbers(&remote.evaluate(expression));
    [place[0], place[1]]
}

/// A place in an element, as parts of its width and height.
fn part_of(remote: &mut Remote, selector: &str, [x, y]: [f64; 2]) -> [f64; 2] {
    let script = format!(
        "(() => {{ const element = document.querySelector({}); element.scrollIntoView({{ block: 'center' }}); \
         const box = element.getBoundingClientRect(); return [box.left + {x} * box.width, box.top + {y} * box.height]; }})()",
        json!(selector)
    );
    place(remote, &script)
}

const STATE: &str = "JSON.stringify({ ...state, hover: null, look: 0, labels: 0 })";

/// Hover, choice, level, pins, search and scrubber, and the same state after a reload.
fn walk(remote: &mut Remote, solid: bool) {
    let [x, y] = leaf(remote, 5);
    remote.mouse(&[[x + 40.0, y + 40.0], [x, y]], false);
    let told = remote.evaluate("[state.hover, byId('tip').textContent.slice(0, 2), document.querySelector('.row.hover')?.dataset.item]");
    assert_eq!(told, json!([5, "m5", "5"]));
    if solid {
        remote
            .wait_until("document.querySelector('#scene .caption').textContent.startsWith('m5 ')");
        remote.wait_until("Math.max(...model.coordinates(5).map((value, k) => Math.abs(value - panels.scene.views[0].x[k]))) < 1e-6");
    }

    let at = leaf(remote, 9);
    remote.mouse(&[at], false);
    remote.keys(&["p"]);
    assert_eq!(
        remote.evaluate("state.pins"),
        if solid { json!([9]) } else { json!([]) }
    );

    for item in [3, 17] {
        let at = leaf(remote, item);
        remote.click(at);
    }
    assert_eq!(remote.evaluate("state.selected"), json!([3, 17]));
    let words = remote.evaluate("document.querySelector('#way .words').textContent");
    assert_says(words.as_str().unwrap(), &["From m3 to m17", "pass"]);

    let handle = part_of(remote, ".level", [0.5, 0.5]);
    let wanted = place(
        remote,
        "[0, panels.tree.drawing.canvas.getBoundingClientRect().top + panels.tree.y((panels.tree.low + panels.tree.top) / 2)]",
    )[1];
    let half = [handle[0], f64::midpoint(handle[1], wanted)];
    remote.mouse(&[handle, half, [handle[0], wanted]], true);
    let off = remote.evaluate("(state.level - (panels.tree.low + panels.tree.top) / 2) / (panels.tree.top - panels.tree.low)");
    assert!(off.as_f64().unwrap().abs() < 0.02, "{off}");
    assert!(
        remote
            .evaluate("derived.basins.list.length")
            .as_u64()
            .unwrap()
            > 0
    );

    let field = part_of(remote, "#query", [0.3, 0.5]);
    remote.click(field);
    remote.keys(&["m", "1", "7"]);
    assert_eq!(
        remote.evaluate("[state.query, derived.passing, byId('answer').textContent]"),
        json!(["m17", 1, "1 of 60"])
    );

    let ends = [0.02, 0.25, 0.5].map(|x| part_of(remote, "#way input", [x, 0.5]));
    remote.mouse(&ends, true);
    let step = remote.evaluate("state.step").as_f64().unwrap();
    assert!((0.4..0.6).contains(&step), "{step}");

    let before = remote.evaluate(STATE);
    // The address is written a moment after the last change. An earlier moment of the same drag may stand in it until then.
    remote.wait_until("location.hash === '#' + fragment()");
    // What a fragment holds has fewer digits, so the state is compared after two readings.
    remote.reload();
    let once = remote.evaluate(STATE);
    remote.reload();
    assert_eq!(remote.evaluate(STATE), once);
    assert_eq!(rounded(&before), rounded(&once));
    assert_eq!(remote.mishaps(), Vec::<String>::new());
}

/// A state with its numbers to four digits.
fn rounded(state: &Value) -> Value {
    let mut state: Value = serde_json::from_str(state.as_str().unwrap()).unwrap();
    for name in ["level", "step"] {
        let digits = format!("{:.3e}", state[name].as_f64().unwrap());
        state[name] = json!(digits);
    }
    state
}

#[test]
fn a_person_explores_in_chromium() {
    let Some(browser) = browser() else { return };
    let desk = desk_with_page();
    let mut remote = Remote::start(Kind::Chromium, &browser, &desk, &[], "");
    remote.open(&desk, "g.report.html", "");
    walk(&mut remote, true);
}

/// Where three dimensions are missing, everything else works, and a sentence says so.
#[test]
fn a_person_explores_without_webgl() {
    let Some(browser) = browser() else { return };
    let desk = desk_with_page();
    let mut remote = Remote::start(Kind::Chromium, &browser, &desk, &["--disable-3d-apis"], "");
    remote.open(&desk, "g.report.html", "");
    let sentence = remote.evaluate("document.querySelector('#scene .alone').textContent");
    assert_says(
        sentence.as_str().unwrap(),
        &["cannot draw in three dimensions", "work without it"],
    );
    walk(&mut remote, false);
}

/// A smoke test in the other family of browsers. Its rendering may lack three dimensions, where the machine does.
#[test]
fn a_person_explores_in_firefox() {
    let Some(browser) = firefox() else { return };
    let desk = desk_with_page();
    let mut remote = Remote::start(Kind::Firefox, &browser, &desk, &[], "");
    remote.open(&desk, "g.report.html", "");
    let solid = remote.evaluate("Boolean(panels.scene.views)") == json!(true);
    println!("Firefox draws in three dimensions: {solid}");
    walk(&mut remote, solid);
}
