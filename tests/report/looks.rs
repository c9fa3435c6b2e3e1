//! What the page is for everyone: contrast, colours for all kinds of colour blindness, a visible focus, no motion where none
//! is wanted.

use serde_json::json;

use super::{desk_with_page, numbers};
use crate::browser::{Kind, Remote, act, browser};

/// Finds texts whose contrast with what is behind them is below that of WCAG AA. Colours are composed on a canvas, as the
/// browser composes them, so that no form of colour need be understood here.
const AUDIT: &str = r##"
const canvas = document.createElement("canvas");
canvas.width = canvas.height = 1;
const pen = canvas.getContext("2d", { willReadFrequently: true });
const painted = colours => {
  for (const colour of ["#fff", ...colours]) { pen.fillStyle = colour; pen.fillRect(0, 0, 1, 1); }
  return [...pen.getImageData(0, 0, 1, 1).data].slice(0, 3);
};
const light = channels => {
  const [r, g, b] = channels.map(c => ((c /= 255) <= 0.04045 ? c / 12.92 : ((c + 0.055) / 1.055) ** 2.4));
  return 0.2126 * r + 0.7152 * g + 0.0722 * b;
};
const contrast = (a, b) => { const [p, q] = [light(a) + 0.05, light(b) + 0.05]; return Math.max(p, q) / Math.min(p, q); };
const pale = [];
let texts = 0;
const audit = where => {
  const walker = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT);
  while (walker.nextNode()) {
    const text = walker.currentNode.textContent.trim();
    const element = walker.currentNode.parentElement;
    if (!text || element.closest("script, style, noscript, option") || !element.checkVisibility({ visibilityProperty: true })) continue;
    const behind = [];
    for (let at = element; at; at = at.parentElement) behind.unshift(getComputedStyle(at).backgroundColor);
    const { color, fontSize, fontWeight } = getComputedStyle(element);
    const [size, bold] = [parseFloat(fontSize), fontWeight >= 700];
    const ratio = contrast(painted(behind), painted([...behind, color]));
    texts++;
    if (ratio < (size >= 24 || (bold && size >= 18.66) ? 3 : 4.5)) pale.push(`${where}: “${text.slice(0, 40)}” ${ratio.toFixed(2)}`);
  }
};
const schemes = [];
for (const scheme of ["light", "dark"]) {
  if ((look.dark ? "dark" : "light") !== scheme) document.getElementById("theme").click();
  await settled();
  audit(scheme);
  change({ level: 0.2, query: "energy <", pins: [1, 2] });
  await settled();
  audit(scheme + ", level");
  change({ level: null, query: "m", pins: [] });
  openExport();
  audit(scheme + ", export");
  byId("export").close();
  openHelp();
  audit(scheme + ", help");
  byId("help").close();
  panels.label.open();
  panels.label.give("Tripod");
  panels.label.choose("");
  audit(scheme + ", labels");
  byId("chooser").close();
  panels.label.close();
  tip(["one", "two"]);
  audit(scheme + ", tip");
  tip(null);
  const own = name => painted([look[name]]);
  schemes.push({
    scheme,
    texts: ["ink", "soft"].map(name => contrast(own(name), own("paper"))),
    marks: ["line", "pale", "route", "accent"].map(name => [name, contrast(own(name), own("paper"))]),
    families: FAMILY[scheme].map(colour => [colour, contrast(painted([colour]), own("paper"))]),
    ground: contrast(own("accent"), painted([getComputedStyle(document.body).backgroundColor])),
    colours: FAMILY[scheme].map(colour => painted([colour])),
    others: ["line", "pale", "route"].map(own),
  });
}
finish({ pale, texts, schemes });
"##;

#[test]
fn everything_can_be_seen_in_light_and_dark() {
    let Some(browser) = browser() else { return };
    let desk = desk_with_page();
    let told = act(&browser, &desk, "g.report.html", "sel=m3,m17", AUDIT);
    assert_eq!(told["pale"], json!([]));
    assert!(
        told["texts"].as_u64().unwrap() > 2000,
        "all states were looked at: {}",
        told["texts"]
    );
    for scheme in told["schemes"].as_array().unwrap() {
        let least = |list: &str| {
            let pairs = scheme[list].as_array().unwrap().iter();
            pairs
                .map(|pair| pair[1].as_f64().unwrap())
                .fold(f64::INFINITY, f64::min)
        };
        // Texts and marks on canvases, and the ring of the focus on the ground of the page.
        assert!(
            numbers(&scheme["texts"]).iter().all(|ratio| *ratio >= 4.5),
            "{scheme}"
        );
        assert!(
            least("marks") >= 3.0 && least("families") >= 3.0,
            "{scheme}"
        );
        assert!(scheme["ground"].as_f64().unwrap() >= 3.0, "{scheme}");
        let colours = |list: &str| -> Vec<[f64; 3]> {
            let colours = scheme[list].as_array().unwrap().iter();
            colours
                .map(|colour| <[f64; 3]>::try_from(numbers(colour)).unwrap())
                .collect()
        };
        let (families, others) = (colours("colours"), colours("others"));
        for (k, family) in families.iter().enumerate() {
            for other in &families[..k] {
                let gap = distance(family, other);
                assert!(gap > 0.09, "{family:?} and {other:?}: {gap}");
            }
            for other in &others {
                let gap = distance(family, other);
                assert!(gap > 0.08, "{family:?} and {other:?}: {gap}");
            }
        }
    }
}

/// Full protanopia, deuteranopia and tritanopia in linear RGB. Source: Machado, Oliveira and Fernandes (2009),
/// doi:10.1109/TVCG.2009.113, severity 1.
const BLINDNESS: [[[f64; 3]; 3]; 4] = [
    [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
    [
        [0.152_286, 1.052_583, -0.204_868],
        [0.114_503, 0.786_281, 0.099_216],
        [-0.003_882, -0.048_116, 1.051_998],
    ],
    [
        [0.367_322, 0.860_646, -0.227_968],
        [0.280_085, 0.672_501, 0.047_413],
        [-0.011_820, 0.042_940, 0.968_881],
    ],
    [
        [1.255_528, -0.076_749, -0.178_779],
        [-0.078_411, 0.930_809, 0.147_602],
        [0.004_733, 0.691_367, 0.303_900],
    ],
];

fn times(matrix: &[[f64; 3]; 3], vector: [f64; 3]) -> [f64; 3] {
    matrix.map(|row| row.iter().zip(vector).map(|(a, b)| a * b).sum())
}

/// Least distance of two colours in Oklab (where black and white are 1 apart) over normal sight and three kinds of colour
/// blindness. Oklab: Ottosson (2020).
fn distance(a: &[f64; 3], b: &[f64; 3]) -> f64 {
    let linear = |channel: f64| {
        let c = channel / 255.0;
        if c <= 0.04045 {
            c / 12.92
        } else {
            libm::pow((c + 0.055) / 1.055, 2.4)
        }
    };
    let cones = [
        [0.412_221_470_8, 0.536_332_536_3, 0.051_445_992_9],
        [0.211_903_498_2, 0.680_699_545_1, 0.107_396_956_6],
        [0.088_302_461_9, 0.281_718_837_6, 0.629_978_700_5],
    ];
    let lab = [
        [0.210_454_255_3, 0.793_617_785, -0.004_072_046_8],
        [1.977_998_495_1, -2.428_592_205, 0.450_593_709_9],
        [0.025_904_037_1, 0.782_771_766_2, -0.808_675_766],
    ];
    let seen = |colour: &[f64; 3], sight: &[[f64; 3]; 3]| {
        let light = times(sight, colour.map(linear)).map(|c| c.clamp(0.0, 1.0));
        times(&lab, times(&cones, light).map(libm::cbrt))
    };
    let gap = |sight| {
        let (a, b) = (seen(a, sight), seen(b, sight));
        a.iter()
            .zip(b)
            .map(|(a, b)| (a - b).powi(2))
            .sum::<f64>()
            .sqrt()
    };
    BLINDNESS.iter().map(gap).fold(f64::INFINITY, f64::min)
}

/// Whoever goes through the page by the Tab key sees where he is.
#[test]
fn the_focus_is_visible() {
    let Some(browser) = browser() else { return };
    let desk = desk_with_page();
    let mut remote = Remote::start(Kind::Chromium, &browser, &desk, &[], "");
    remote.open(&desk, "g.report.html", "sel=m3,m17&pin=m3");
    let mut stops = Vec::new();
    for _ in 0..200 {
        remote.keys(&["Tab"]);
        let told = remote.evaluate(
            "(() => { const at = document.activeElement; if (at === document.body) return null; \
             const { outlineStyle, outlineWidth } = getComputedStyle(at); const box = at.getBoundingClientRect(); \
             return [at.id || at.className || at.tagName + at.textContent.slice(0, 9), outlineStyle, parseFloat(outlineWidth), \
             box.bottom > 0 && box.top < innerHeight]; })()",
        );
        if told.is_null() {
            break;
        }
        assert!(
            told[1] != "none" && told[2].as_f64().unwrap() >= 2.0 && told[3] == true,
            "{told}"
        );
        stops.push(told[0].as_str().unwrap().to_owned());
    }
    let all = stops.join(" ");
    for stop in [
        "query",
        "colour",
        "label-start",
        "export-open",
        "help-open",
        "theme",
        "level",
        "CANVAS",
        "scroll",
        "chip",
        "SUMMARY",
        "INPUT",
    ] {
        assert!(all.contains(stop), "{stop} cannot be reached: {all}");
    }
}

/// Where no motion is wanted, a hand is at once where it is to be; else it glides.
#[test]
fn nothing_moves_where_no_motion_is_wanted() {
    let Some(browser) = browser() else { return };
    let desk = desk_with_page();
    for (flag, still) in [
        ("--force-prefers-reduced-motion", true),
        ("--mute-audio", false),
    ] {
        let mut remote = Remote::start(Kind::Chromium, &browser, &desk, &[flag], "");
        remote.open(&desk, "g.report.html", "");
        let mut ask = |grasp: usize| {
            remote.evaluate(&format!(
                "(async () => {{ change({{ hover: {grasp} }}); await new Promise(requestAnimationFrame); await null; \
                 const view = panels.scene.views[0]; const moving = view.frame !== undefined; \
                 const there = view.x.every((value, k) => value === model.coordinates({grasp})[k]); \
                 return [moving, there, document.getAnimations().length, matchMedia('(prefers-reduced-motion: reduce)').matches]; }})()",
            ))
        };
        // On a busy machine a frame may take longer than the motion, so motion is looked for several times.
        let told = (30..36)
            .map(&mut ask)
            .find(|told| told[0] != json!(still))
            .unwrap();
        assert_eq!(told, json!([!still, still, 0, still]));
    }
}
