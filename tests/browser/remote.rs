//! A browser that is driven from outside, in real time, with the input of a real mouse and keyboard: Chromium by its own
//! protocol (CDP), Firefox by `WebDriver BiDi`. Each speaks through a websocket and needs no other program.

use std::fs;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};

use serde_json::{Value, json};

use super::socket::Socket;
use crate::desk::Desk;

/// A browser takes some seconds to start, more on a busy machine.
const START: Duration = Duration::from_secs(90);
/// Size of the window, pixels.
const WINDOW: [u32; 2] = [1440, 1000];

#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Kind {
    Chromium,
    Firefox,
}

/// A running browser with one page.
pub(crate) struct Remote {
    kind: Kind,
    child: Child,
    socket: Socket,
    /// The session of Chromium's page, or Firefox's browsing context.
    target: String,
    last: u64,
    /// What the browser said in between: exceptions, words on the console, requests.
    events: Vec<Value>,
}

impl Drop for Remote {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// Waits until a file is there and complete; returns its text.
fn written(path: &Path, complete: impl Fn(&str) -> bool) -> String {
    let started = Instant::now();
    loop {
        let text = fs::read_to_string(path).unwrap_or_default();
        if complete(&text) {
            return text;
        }
        assert!(started.elapsed() < START, "the browser did not start");
        sleep(Duration::from_millis(50));
    }
}

impl Remote {
    /// Starts a browser with further flags. `before` is a script that runs at the beginning of each page (Chromium only).
    pub(crate) fn start(
        kind: Kind,
        browser: &Path,
        desk: &Desk,
        more: &[&str],
        before: &str,
    ) -> Self {
        // Each browser has a folder of its own: helpers of one that has just ended may still write to theirs.
        let profile = (0..100)
            .map(|count| desk.path(&format!("profile {count}")))
            .find(|profile| fs::create_dir(profile).is_ok())
            .unwrap();
        let mut command = Command::new(browser);
        command.args(["--headless", "--remote-debugging-port=0"]);
        match kind {
            Kind::Chromium => command
                .args(super::FLAGS)
                .arg(format!("--window-size={},{}", WINDOW[0], WINDOW[1]))
                .arg(format!("--user-data-dir={}", profile.display())),
            Kind::Firefox => command
                .args(["--no-remote", "--profile"])
                .arg(&profile)
                .arg(format!("--width={}", WINDOW[0]))
                .arg(format!("--height={}", WINDOW[1])),
        };
        let child = command
            .args(more)
            .arg("about:blank")
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn()
            .unwrap();
        let socket = match kind {
            Kind::Chromium => {
                let text = written(&profile.join("DevToolsActivePort"), |text| {
                    text.contains("/devtools/")
                });
                let (port, path) = text.split_once('\n').unwrap();
                Socket::open(port.parse().unwrap(), path.trim())
            }
            Kind::Firefox => {
                let text = written(&profile.join("WebDriverBiDiServer.json"), |text| {
                    text.contains('}')
                });
                let text: Value = serde_json::from_str(&text).unwrap();
                Socket::open(
                    u16::try_from(text["ws_port"].as_u64().unwrap()).unwrap(),
                    "/session",
                )
            }
        };
        let mut remote = Self {
            kind,
            child,
            socket,
            target: String::new(),
            last: 0,
            events: Vec::new(),
        };
        remote.attach(before);
        remote
    }

    fn attach(&mut self, before: &str) {
        match self.kind {
            Kind::Chromium => {
                let targets = self.call("Target.getTargets", json!({}));
                let page = targets["targetInfos"].as_array().unwrap().iter();
                let page = page
                    .clone()
                    .find(|target| target["type"] == "page")
                    .unwrap();
                let options = json!({ "targetId": page["targetId"], "flatten": true });
                let session = self.call("Target.attachToTarget", options);
                session["sessionId"]
                    .as_str()
                    .unwrap()
                    .clone_into(&mut self.target);
                for domain in ["Page", "Runtime", "Log", "Network"] {
                    self.call(&format!("{domain}.enable"), json!({}));
                }
                self.call(
                    "Page.addScriptToEvaluateOnNewDocument",
                    json!({ "source": before }),
                );
            }
            Kind::Firefox => {
                let session = self.call("session.new", json!({ "capabilities": {} }));
                let capabilities = &session["capabilities"];
                println!(
                    "{} {}",
                    capabilities["browserName"], capabilities["browserVersion"]
                );
                let tree = self.call("browsingContext.getTree", json!({}));
                tree["contexts"][0]["context"]
                    .as_str()
                    .unwrap()
                    .clone_into(&mut self.target);
                let events = json!({ "events": ["log.entryAdded", "network.beforeRequestSent"] });
                self.call("session.subscribe", events);
                let size = json!({ "context": self.target, "viewport": { "width": WINDOW[0], "height": WINDOW[1] } });
                self.call("browsingContext.setViewport", size);
            }
        }
    }

    /// Calls a method of the protocol and waits for its result.
    pub(crate) fn call(&mut self, method: &str, parameters: Value) -> Value {
        self.last += 1;
        let mut message = json!({ "id": self.last, "method": method });
        message["params"] = parameters;
        if self.kind == Kind::Chromium && !self.target.is_empty() {
            message["sessionId"] = json!(self.target);
        }
        self.socket.send(&message);
        loop {
            let mut answer = self.socket.receive();
            if answer["id"] == self.last {
                assert!(answer["error"].is_null(), "{method}: {answer}");
                return answer["result"].take();
            }
            self.events.push(answer);
        }
    }

    /// Opens a page of the desk.
    pub(crate) fn open(&mut self, desk: &Desk, page: &str, fragment: &str) {
        let url = format!("file://{}#{fragment}", desk.path(page).display());
        match self.kind {
            Kind::Chromium => self.call("Page.navigate", json!({ "url": url })),
            Kind::Firefox => {
                let place = json!({ "context": self.target, "url": url, "wait": "complete" });
                self.call("browsingContext.navigate", place)
            }
        };
        self.wait_until("location.protocol === 'file:' && document.body?.dataset.ready === '1'");
    }

    pub(crate) fn reload(&mut self) {
        self.evaluate("document.body.dataset.ready = 'old'");
        match self.kind {
            Kind::Chromium => self.call("Page.reload", json!({})),
            Kind::Firefox => {
                let place = json!({ "context": self.target, "wait": "complete" });
                self.call("browsingContext.reload", place)
            }
        };
        self.wait_until("document.body?.dataset.ready === '1'");
    }

    /// Waits until an expression is true.
    pub(crate) fn wait_until(&mut self, expression: &str) {
        let started = Instant::now();
        while self.evaluate(&format!("Boolean({expression})")) != json!(true) {
            assert!(started.elapsed() < START, "never true: {expression}");
            sleep(Duration::from_millis(30));
        }
    }

    /// The value of an expression in the page, which may be a promise.
    pub(crate) fn evaluate(&mut self, expression: &str) -> Value {
        let told =
            format!("(async () => JSON.stringify(await (async () => ({expression}))() ?? null))()");
        let text = match self.kind {
            Kind::Chromium => {
                let options =
                    json!({ "expression": told, "awaitPromise": true, "returnByValue": true });
                let result = self.call("Runtime.evaluate", options);
                assert!(
                    result["exceptionDetails"].is_null(),
                    "{expression}: {result}"
                );
                result["result"]["value"].clone()
            }
            Kind::Firefox => {
                let options = json!({ "expression": told, "awaitPromise": true, "target": { "context": self.target } });
                let result = self.call("script.evaluate", options);
                assert_eq!(result["type"], "success", "{expression}: {result}");
                result["result"]["value"].clone()
            }
        };
        serde_json::from_str(text.as_str().unwrap()).unwrap()
    }

    /// Moves the mouse through these places of the window, with its button pressed if it drags; then lets it go.
    pub(crate) fn mouse(&mut self, places: &[[f64; 2]], drags: bool) {
        match self.kind {
            Kind::Chromium => {
                for (k, [x, y]) in places.iter().enumerate() {
                    let event = |kind: &str, held: bool| {
                        let button = if held { "left" } else { "none" };
                        json!({ "type": kind, "x": x, "y": y, "button": button, "buttons": i32::from(held), "clickCount": 1 })
                    };
                    let moved = event("mouseMoved", drags && k > 0);
                    self.call("Input.dispatchMouseEvent", moved);
                    if drags && k == 0 {
                        let pressed = event("mousePressed", true);
                        self.call("Input.dispatchMouseEvent", pressed);
                    }
                    if drags && k + 1 == places.len() {
                        let mut released = event("mouseReleased", true);
                        released["buttons"] = json!(0);
                        self.call("Input.dispatchMouseEvent", released);
                    }
                }
            }
            Kind::Firefox => {
                let mut steps = Vec::new();
                for (k, [x, y]) in places.iter().enumerate() {
                    let (x, y) = (x.round(), y.round());
                    steps.push(json!({ "type": "pointerMove", "x": x, "y": y, "duration": 20 }));
                    if drags && k == 0 {
                        steps.push(json!({ "type": "pointerDown", "button": 0 }));
                    }
                }
                if drags {
                    steps.push(json!({ "type": "pointerUp", "button": 0 }));
                }
                let mouse = json!([{ "type": "pointer", "id": "mouse", "actions": steps }]);
                self.call(
                    "input.performActions",
                    json!({ "context": self.target, "actions": mouse }),
                );
            }
        }
        self.settle();
    }

    pub(crate) fn click(&mut self, place: [f64; 2]) {
        self.mouse(&[place], true);
    }

    /// Types letters; `Tab`, `Enter` and `Escape` are keys.
    pub(crate) fn keys(&mut self, keys: &[&str]) {
        for key in keys {
            match self.kind {
                Kind::Chromium => {
                    let (name, code, text) = match *key {
                        "Tab" => ("Tab", 9, ""),
                        "Enter" => ("Enter", 13, "\r"),
                        "Escape" => ("Escape", 27, ""),
                        letter => (letter, 0, letter),
                    };
                    let mut event =
                        json!({ "type": "keyDown", "key": name, "windowsVirtualKeyCode": code });
                    if !text.is_empty() {
                        event["text"] = json!(text);
                    }
                    self.call("Input.dispatchKeyEvent", event);
                    let event =
                        json!({ "type": "keyUp", "key": name, "windowsVirtualKeyCode": code });
                    self.call("Input.dispatchKeyEvent", event);
                }
                Kind::Firefox => {
                    let value = match *key {
                        "Tab" => "\u{e004}",
                        "Enter" => "\u{e007}",
                        "Escape" => "\u{e00c}",
                        letter => letter,
                    };
                    let steps = json!([{ "type": "keyDown", "value": value }, { "type": "keyUp", "value": value }]);
                    let keyboard = json!([{ "type": "key", "id": "keys", "actions": steps }]);
                    self.call(
                        "input.performActions",
                        json!({ "context": self.target, "actions": keyboard }),
                    );
                }
            }
        }
        self.settle();
    }

    /// Waits until the page has painted twice.
    pub(crate) fn settle(&mut self) {
        self.evaluate("new Promise(done => requestAnimationFrame(() => requestAnimationFrame(() => done(1))))");
    }

    /// Exceptions, warnings and errors on the console, and requests for anything but the page itself.
    pub(crate) fn mishaps(&self) -> Vec<String> {
        let told = |event: &Value| {
            let (method, what) = (event["method"].as_str()?, &event["params"]);
            let request = |url: &Value| {
                let url = url.as_str().unwrap_or_default();
                let own = ["file:", "blob:", "data:", "about:", "chrome:"]
                    .iter()
                    .any(|scheme| url.starts_with(scheme));
                (!own).then(|| format!("request: {url}"))
            };
            let loud = |level: &Value| {
                ["error", "warning", "warn", "assert"]
                    .iter()
                    .any(|word| level == *word)
            };
            match method {
                "Runtime.exceptionThrown" => Some(what.to_string()),
                "Runtime.consoleAPICalled" => loud(&what["type"]).then(|| what.to_string()),
                // The driver of software rendering warns that it is slow.
                "Log.entryAdded" => (loud(&what["entry"]["level"])
                    && !what.to_string().contains("GL Driver Message"))
                .then(|| what.to_string()),
                "log.entryAdded" => loud(&what["level"]).then(|| what.to_string()),
                "Network.requestWillBeSent" | "network.beforeRequestSent" => {
                    request(&what["request"]["url"])
                }
                _ => None,
            }
        };
        self.events.iter().filter_map(told).collect()
    }
}
