//! The form of a URDF document: what `urdf-rs` needs, checked before it reads, so that errors name file and line.

use roxmltree::{Document, Node, ParsingOptions};

use super::HandError;

/// Deepest nesting of elements.
const DEEPEST: u32 = 200;

/// What an attribute holds.
#[derive(Clone, Copy)]
enum Value {
    Text,
    /// So many numbers.
    Numbers(usize),
}
use Value::{Numbers, Text};

/// What an element must and may have.
struct Rule {
    /// Its parent, or nothing if that does not matter.
    within: &'static str,
    tag: &'static str,
    needed: &'static [(&'static str, Value)],
    optional: &'static [(&'static str, Value)],
    children: &'static [&'static str],
}

const fn rule(
    within: &'static str,
    tag: &'static str,
    needed: &'static [(&'static str, Value)],
    optional: &'static [(&'static str, Value)],
    children: &'static [&'static str],
) -> Rule {
    Rule {
        within,
        tag,
        needed,
        optional,
        children,
    }
}

const ONE: Value = Numbers(1);
const RULES: [Rule; 24] = [
    rule("robot", "link", &[("name", Text)], &[], &[]),
    rule(
        "robot",
        "joint",
        &[("name", Text), ("type", Text)],
        &[],
        &["parent", "child"],
    ),
    rule("robot", "material", &[("name", Text)], &[], &[]),
    rule("joint", "parent", &[("link", Text)], &[], &[]),
    rule("joint", "child", &[("link", Text)], &[], &[]),
    rule("joint", "axis", &[("xyz", Numbers(3))], &[], &[]),
    rule(
        "joint",
        "limit",
        &[],
        &[
            ("lower", ONE),
            ("upper", ONE),
            ("effort", ONE),
            ("velocity", ONE),
        ],
        &[],
    ),
    rule(
        "joint",
        "mimic",
        &[("joint", Text)],
        &[("multiplier", ONE), ("offset", ONE)],
        &[],
    ),
    rule(
        "joint",
        "dynamics",
        &[],
        &[("damping", ONE), ("friction", ONE)],
        &[],
    ),
    rule(
        "joint",
        "calibration",
        &[],
        &[("rising", ONE), ("falling", ONE)],
        &[],
    ),
    rule(
        "joint",
        "safety_controller",
        &[("k_velocity", ONE)],
        &[
            ("soft_lower_limit", ONE),
            ("soft_upper_limit", ONE),
            ("k_position", ONE),
        ],
        &[],
    ),
    rule(
        "",
        "origin",
        &[],
        &[("xyz", Numbers(3)), ("rpy", Numbers(3))],
        &[],
    ),
    rule("link", "inertial", &[], &[], &["mass", "inertia"]),
    rule("inertial", "mass", &[("value", ONE)], &[], &[]),
    rule(
        "inertial",
        "inertia",
        &[
            ("ixx", ONE),
            ("ixy", ONE),
            ("ixz", ONE),
            ("iyy", ONE),
            ("iyz", ONE),
            ("izz", ONE),
        ],
        &[],
        &[],
    ),
    rule("link", "collision", &[], &[], &["geometry"]),
    rule("link", "visual", &[], &[], &["geometry"]),
    rule("visual", "material", &[("name", Text)], &[], &[]),
    rule("material", "color", &[("rgba", Numbers(4))], &[], &[]),
    rule("geometry", "box", &[("size", Numbers(3))], &[], &[]),
    rule(
        "geometry",
        "cylinder",
        &[("radius", ONE), ("length", ONE)],
        &[],
        &[],
    ),
    rule(
        "geometry",
        "capsule",
        &[("radius", ONE), ("length", ONE)],
        &[],
        &[],
    ),
    rule("geometry", "sphere", &[("radius", ONE)], &[], &[]),
    rule(
        "geometry",
        "mesh",
        &[("filename", Text)],
        &[("scale", Numbers(3))],
        &[],
    ),
];

/// Types of joints that are read, or refused by their name later.
const JOINTS: [&str; 7] = [
    "revolute",
    "continuous",
    "prismatic",
    "fixed",
    "floating",
    "planar",
    "spherical",
];

/// Refuses what is no URDF, and URDF with missing or unreadable parts. `name` is that of the file. Returns the text with the
/// attributes that `urdf-rs` needs and a hand does not.
pub(super) fn check(name: &str, text: &str) -> Result<String, HandError> {
    let begins = text.trim_start_matches('\u{feff}').trim_start();
    if !begins.starts_with('<') {
        return Err(HandError::NotADescription);
    }
    let options = ParsingOptions {
        allow_dtd: true,
        nodes_limit: 10_000_000,
        ..ParsingOptions::default()
    };
    let document = Document::parse_with_options(text, options).map_err(|error| {
        // The prefix of macros may be undeclared.
        if text.contains("<xacro:") {
            return xacro(name);
        }
        HandError::Element {
            place: format!("{name}, line {}", error.pos().row),
            problem: format!("it is not XML: {error}"),
        }
    })?;
    let form = Form {
        name,
        document: &document,
    };
    form.nesting()?;
    let is_macro = |node: &Node<'_, '_>| {
        let space = node.tag_name().namespace();
        let from_macro = |value: &str| value.contains("${") || value.contains("$(");
        space.is_some_and(|space| space.contains("xacro"))
            || node.attributes().any(|given| from_macro(given.value()))
    };
    let root = document.root_element();
    match root.tag_name().name() {
        "robot" if root.descendants().any(|node| is_macro(&node)) => Err(xacro(name)),
        "robot" => {
            form.robot(root)?;
            Ok(with_velocities(text, root))
        }
        "sdf" => Err(HandError::OtherFormat {
            file: name.to_owned(),
            format: "SDF",
            remedy: "give the URDF or MJCF of the hand".to_owned(),
        }),
        other => Err(form.error(
            root,
            format!("the root element is <{other}>, but that of URDF is <robot> and that of MJCF <mujoco>"),
        )),
    }
}

/// The error of a file whose macros are not expanded: `hand.xacro` or `hand.urdf.xacro`, or macros in `hand.urdf`.
fn xacro(name: &str) -> HandError {
    let stem = name.strip_suffix(".xacro").unwrap_or(name);
    let result = match stem.strip_suffix(".urdf") {
        Some(stem) if name == format!("{stem}.urdf") => format!("{stem}_expanded.urdf"),
        Some(_) => stem.to_owned(),
        None => format!("{stem}.urdf"),
    };
    HandError::OtherFormat {
        file: name.to_owned(),
        format: "xacro",
        remedy: format!("expand its macros first (`xacro {name} > {result}`), and give {result}"),
    }
}

/// The text with a velocity in every `<limit>`: the standard asks for one, and many files have none.
fn with_velocities(text: &str, root: Node<'_, '_>) -> String {
    const TAG: &str = "<limit";
    let limits = root
        .descendants()
        .filter(|node| node.tag_name().name() == "limit" && !node.has_attribute("velocity"));
    let mut completed = String::with_capacity(text.len());
    let mut rest = 0;
    for limit in limits {
        let end = limit.range().start + TAG.len();
        if let Some(before) = text.get(rest..end).filter(|before| before.ends_with(TAG)) {
            completed += before;
            completed += " velocity=\"0\"";
            rest = end;
        }
    }
    completed + text.get(rest..).unwrap_or_default()
}

fn rule_of(node: Node<'_, '_>) -> Option<&'static Rule> {
    let tag = node.tag_name().name();
    let within = node.parent().map_or("", |parent| parent.tag_name().name());
    (RULES.iter()).find(|rule| rule.tag == tag && ["", within].contains(&rule.within))
}

struct Form<'a, 'i> {
    name: &'a str,
    document: &'a Document<'i>,
}

impl Form<'_, '_> {
    /// An error that names the element, the link or joint around it, file and line.
    fn error(&self, node: Node<'_, '_>, problem: impl Into<String>) -> HandError {
        let tag = node.tag_name().name();
        let line = self.document.text_pos_at(node.range().start).row;
        let around = node.ancestors().find(|outer| {
            ["link", "joint"].contains(&outer.tag_name().name()) && outer.has_attribute("name")
        });
        let owner = around.map_or_else(String::new, |outer| {
            let name = outer.attribute("name").unwrap_or_default();
            if outer == node {
                format!(" \"{name}\"")
            } else {
                format!(" of {} \"{name}\"", outer.tag_name().name())
            }
        });
        HandError::Element {
            place: format!("<{tag}>{owner} ({}, line {line})", self.name),
            problem: problem.into(),
        }
    }

    /// Refuses text that is nested so deeply that `urdf-rs` would take minutes.
    fn nesting(&self) -> Result<(), HandError> {
        // Parents come first.
        let mut depths: Vec<u32> = Vec::new();
        for node in self.document.root().descendants() {
            let parent = node.parent().map(|parent| depths[parent.id().get_usize()]);
            let depth = parent.map_or(0, |depth| depth + 1);
            if depth > DEEPEST {
                let problem = format!("elements are nested more than {DEEPEST} deep");
                return Err(self.error(node, problem));
            }
            depths.push(depth);
        }
        Ok(())
    }

    fn robot(&self, root: Node<'_, '_>) -> Result<(), HandError> {
        let parts = root.children().filter(Node::is_element);
        let is_part =
            |node: &Node<'_, '_>| ["link", "joint", "material"].contains(&node.tag_name().name());
        if !root.children().any(|node| node.tag_name().name() == "link") {
            return Err(self.error(
                root,
                "it has no <link>, but a hand is described by links and the joints between them",
            ));
        }
        for part in parts.filter(is_part) {
            if part.tag_name().name() == "joint" {
                self.joint(part)?;
            }
            self.element(part)?;
        }
        Ok(())
    }

    /// Checks an element and those in it by the rules; elements without a rule are skipped.
    fn element(&self, node: Node<'_, '_>) -> Result<(), HandError> {
        let tag = node.tag_name().name();
        if tag == "geometry" {
            self.geometry(node)?;
        } else if let Some(rule) = rule_of(node) {
            for &(name, value) in rule.needed {
                self.attribute(node, name, value, true)?;
            }
            for &(name, value) in rule.optional {
                self.attribute(node, name, value, false)?;
            }
            for &needed in rule.children {
                if !node
                    .children()
                    .any(|child| child.tag_name().name() == needed)
                {
                    let remedy = match needed {
                        "geometry" => format!("give it a shape, or delete the <{tag}>"),
                        _ => "add it".to_owned(),
                    };
                    return Err(self.error(node, format!("<{needed}> is missing: {remedy}")));
                }
            }
        }
        let mut before: Vec<&str> = Vec::new();
        for child in node.children().filter(Node::is_element) {
            let name = child.tag_name().name();
            if name != "geometry" && rule_of(child).is_none() {
                continue;
            }
            let of_link = ["visual", "collision"].contains(&name);
            if before.contains(&name) && !of_link {
                return Err(self.error(
                    child,
                    format!("there is another <{name}> before it: delete one"),
                ));
            }
            before.push(name);
            self.element(child)?;
        }
        Ok(())
    }

    fn geometry(&self, node: Node<'_, '_>) -> Result<(), HandError> {
        const SHAPES: [&str; 5] = ["box", "cylinder", "capsule", "sphere", "mesh"];
        let shapes: Vec<_> = node.children().filter(Node::is_element).collect();
        match shapes.as_slice() {
            [] => Err(self.error(node, "it has no shape: give it one, or delete the element around it")),
            [shape] if SHAPES.contains(&shape.tag_name().name()) => Ok(()),
            [shape] => Err(self.error(
                *shape,
                format!("this shape is not read; those that are: {}", SHAPES.join(", ")),
            )),
            [_, second, ..] => Err(self.error(
                *second,
                "it is the second shape of its <geometry>, which has one: give each an element of its own",
            )),
        }
    }

    fn attribute(
        &self,
        node: Node<'_, '_>,
        name: &str,
        value: Value,
        needed: bool,
    ) -> Result<(), HandError> {
        let Some(text) = node.attribute(name) else {
            if needed {
                return Err(self.error(node, format!("{name} is missing: add {name}=\"…\"")));
            }
            return Ok(());
        };
        let Numbers(count) = value else {
            return Ok(());
        };
        let words: Vec<&str> = text.split_whitespace().collect();
        if let Some(word) = words.iter().find(|word| word.parse::<f64>().is_err()) {
            return Err(self.error(
                node,
                format!("{name}=\"{text}\": \"{word}\" is not a number"),
            ));
        }
        if words.len() != count {
            let (are, has) = (if count == 1 { "is" } else { "are" }, words.len());
            return Err(self.error(
                node,
                format!("{name}=\"{text}\" has {has} numbers where {count} {are} needed"),
            ));
        }
        Ok(())
    }

    /// A joint that is limited needs its limits. One that follows another has the limits of that one.
    fn joint(&self, joint: Node<'_, '_>) -> Result<(), HandError> {
        let Some(kind) = joint.attribute("type") else {
            return Ok(());
        };
        if !JOINTS.contains(&kind) {
            let problem =
                format!("type=\"{kind}\": revolute, continuous, prismatic or fixed is needed");
            return Err(self.error(joint, problem));
        }
        let part = |name: &str| {
            joint
                .children()
                .find(|child| child.tag_name().name() == name)
        };
        let unit = match kind {
            "revolute" => "radians",
            "prismatic" => "metres",
            _ => return Ok(()),
        };
        if part("mimic").is_some() {
            return Ok(());
        }
        let or = if kind == "revolute" {
            ", or write type=\"continuous\" if it turns endlessly"
        } else {
            ""
        };
        let Some(limit) = part("limit") else {
            return Err(self.error(
                joint,
                format!(
                    "a {kind} joint needs limits, but <limit> is missing: add <limit lower=\"…\" upper=\"…\" effort=\"1\" \
                     velocity=\"1\"/> in {unit}{or}"
                ),
            ));
        };
        let given = ["lower", "upper"].map(|name| limit.attribute(name));
        if given == [None, None] {
            return Err(self.error(
                limit,
                format!("a {kind} joint needs lower and upper, which are missing: add them in {unit}{or}"),
            ));
        }
        // The standard takes a missing one as 0.
        let [lower, upper] = given.map(|text| text.unwrap_or("0").trim().parse::<f64>());
        if let (Ok(lower), Ok(upper)) = (lower, upper)
            && lower >= upper
        {
            return Err(self.error(
                limit,
                format!(
                    "the range from {lower} to {upper} is empty: give a lower below the upper, or write type=\"fixed\" for a \
                     joint that does not move"
                ),
            ));
        }
        Ok(())
    }
}
