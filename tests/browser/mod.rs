//! A real browser without a window, and a page in it with a script that acts like a person.

mod remote;
mod socket;

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use serde_json::Value;

pub(crate) use remote::{Kind, Remote};

use crate::desk::Desk;

/// Flags of Chromium for tests: no sandbox, for tests may run as root, no background work, rendering in software.
const FLAGS: [&str; 8] = [
    "--no-sandbox",
    "--disable-gpu",
    "--enable-unsafe-swiftshader",
    "--disable-quic",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
];

/// What the page must not have caused: errors, requests and breaches of its policy, collected from its first moment.
const WATCH: &str = r#"<script>
const mishaps = [];
// The browser's clock runs ahead to the next timer and does not wait for frames, so frames are timers here.
requestAnimationFrame = paint => setTimeout(() => paint(performance.now()), 16);
cancelAnimationFrame = clearTimeout;
addEventListener("error", event => mishaps.push("error: " + event.message));
addEventListener("unhandledrejection", event => mishaps.push("rejection: " + event.reason));
addEventListener("securitypolicyviolation", event => mishaps.push("policy: " + event.violatedDirective + " " + event.blockedURI));
for (const kind of ["error", "warn"]) {
  const told = console[kind];
  console[kind] = (...words) => { mishaps.push(kind + ": " + words.join(" ")); told.apply(console, words); };
}
</script>"#;

/// What a script of a test uses: waiting, events, and the end with a result.
const PERSON: &str = r#"
const wait = ms => new Promise(done => setTimeout(done, ms));
const settled = async () => { for (let k = 0; k < 3; k++) await new Promise(done => requestAnimationFrame(done)); await wait(20); };
const press = async (target, key, more = {}) => {
  target.dispatchEvent(new KeyboardEvent("keydown", { key, bubbles: true, cancelable: true, ...more }));
  await settled();
};
const point = async (target, kind, [x, y], more = {}) => {
  const box = target.getBoundingClientRect();
  const place = { clientX: box.left + x, clientY: box.top + y, bubbles: true, cancelable: true, pointerId: 1, ...more };
  target.dispatchEvent(kind === "click" ? new MouseEvent(kind, place) : new PointerEvent(kind, place));
  await settled();
};
const type = async (field, text) => { field.value = text; field.dispatchEvent(new Event("input", { bubbles: true })); await settled(); };
const byteText = bytes => { let text = ""; for (const byte of bytes) text += String.fromCharCode(byte); return btoa(text); };
const finish = result => {
  const requests = performance.getEntriesByType("resource").map(entry => entry.name).filter(name => !name.startsWith("blob:"));
  const told = document.createElement("pre");
  told.id = "result";
  told.textContent = byteText(new TextEncoder().encode(JSON.stringify({ ...result, mishaps, requests })));
  document.body.append(told);
};
const ready = new Promise(done => (document.body.dataset.ready ? done() : document.addEventListener("ready", done)));
"#;

/// Chromium, or Chrome: the one that `LANDSCAPE_BROWSER` names, else one that is installed.
pub(crate) fn browser() -> Option<PathBuf> {
    let names = ["chromium", "chromium-browser", "google-chrome", "chrome"];
    found("LANDSCAPE_BROWSER", "chromium", &names)
}

/// Firefox: the one that `LANDSCAPE_FIREFOX` names, else one that is installed.
pub(crate) fn firefox() -> Option<PathBuf> {
    found(
        "LANDSCAPE_FIREFOX",
        "firefox-esr",
        &["firefox-esr", "firefox"],
    )
}

/// Where the tests must be complete (`CI=true`, or the variable is set), a missing browser is a failure. Elsewhere the test
/// is counted as skipped.
fn found(variable: &str, package: &str, names: &[&str]) -> Option<PathBuf> {
    if let Some(named) = std::env::var_os(variable) {
        let named = PathBuf::from(named);
        assert!(
            named.is_file(),
            "{variable}: there is no {}",
            named.display()
        );
        return Some(named);
    }
    let folders = std::env::var_os("PATH").unwrap_or_default();
    let found = std::env::split_paths(&folders)
        .flat_map(|folder| names.iter().map(move |name| folder.join(name)))
        .find(|path| path.is_file());
    let needed = std::env::var("CI").is_ok_and(|value| value == "true");
    assert!(
        found.is_some() || !needed,
        "no browser is installed, but CI=true: install {package}"
    );
    if found.is_none() {
        crate::skipped::skipped(&format!("no browser ({package}) on this machine"));
    }
    found
}

/// Runs the browser on a page in the desk until the page is still; returns its standard output.
pub(crate) fn browse(
    browser: &Path,
    desk: &Desk,
    page: &str,
    fragment: &str,
    more: &[&str],
) -> String {
    let profile = desk.path(&format!("profile of {page}"));
    let address = format!("file://{}#{fragment}", desk.path(page).display());
    let output = Command::new(browser)
        .args([
            "--headless",
            "--hide-scrollbars",
            "--virtual-time-budget=60000",
        ])
        .args(FLAGS)
        .args(more)
        .arg(format!("--user-data-dir={}", profile.display()))
        .arg(address.replace(' ', "%20"))
        .output()
        .unwrap();
    // A profile that is in use would refuse the next run.
    let _ = fs::remove_dir_all(&profile);
    String::from_utf8_lossy(&output.stdout).into_owned()
}

/// Acts on a copy of a page in the desk with a script, which calls `finish` with its result. The page must not have caused
/// an error, a warning, a request or a breach of its policy.
pub(crate) fn act(browser: &Path, desk: &Desk, page: &str, fragment: &str, script: &str) -> Value {
    let text = fs::read_to_string(desk.path(page)).unwrap();
    let policy = "script-src 'sha256-";
    let start = text.find(policy).expect("the page has a policy") + "script-src ".len();
    let end = start + text[start..].find(';').unwrap();
    let person = format!(
        "<script>{PERSON}\nready.then(async () => {{\n{script}\n}}).catch(error => finish({{ failed: String(error.stack) }}));</script></body>"
    );
    // The last end of the body, for scripts may hold one.
    let body = text.rfind("</body>").unwrap();
    let head = text.find("<title>").unwrap();
    let acted = [
        &text[..start],
        "'unsafe-inline'",
        &text[end..head],
        WATCH,
        &text[head..body],
        &person,
        &text[body + "</body>".len()..],
    ];
    fs::write(desk.path("acted.html"), acted.concat()).unwrap();
    let document = browse(
        browser,
        desk,
        "acted.html",
        fragment,
        &["--dump-dom", "--window-size=1440,1000"],
    );
    let result = document.split("<pre id=\"result\">").nth(1);
    let result = result.unwrap_or_else(|| {
        panic!(
            "the script did not finish: {}",
            &document[document.len().saturating_sub(2000)..]
        )
    });
    let bytes = STANDARD
        .decode(result.split("</pre>").next().unwrap())
        .unwrap();
    let result: Value = serde_json::from_slice(&bytes).unwrap();
    assert!(result["failed"].is_null(), "{}", result["failed"]);
    assert_eq!(result["mishaps"], Value::Array(Vec::new()));
    assert_eq!(result["requests"], Value::Array(Vec::new()));
    result
}
