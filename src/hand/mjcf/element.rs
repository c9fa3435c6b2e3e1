//! XML elements with their lines; included files are inserted in place.

use std::sync::Arc;

use super::super::HandError;
use super::super::sources::Files;

/// Deepest nesting of elements and of included files.
const DEEPEST: usize = 200;
/// Largest number of elements of a description, included files counted.
const MOST: usize = 1_000_000;

/// An XML element.
#[derive(Debug, Clone)]
pub(super) struct Element {
    pub(super) tag: String,
    attributes: Vec<(String, String)>,
    pub(super) children: Vec<Self>,
    file: Arc<str>,
    line: u32,
}

impl Element {
    pub(super) fn attribute(&self, name: &str) -> Option<&str> {
        let found = self.attributes.iter().find(|(known, _)| known == name);
        found.map(|(_, value)| value.as_str())
    }

    pub(super) fn children_named<'a>(&'a self, tag: &'a str) -> impl Iterator<Item = &'a Self> {
        self.children.iter().filter(move |child| child.tag == tag)
    }

    /// `geom "palm" (hand.xml, line 12)`.
    pub(super) fn place(&self) -> String {
        let name = self
            .attribute("name")
            .or_else(|| self.attribute("file"))
            .map_or_else(String::new, |name| format!(" \"{name}\""));
        format!("<{}>{name} ({}, line {})", self.tag, self.file, self.line)
    }

    pub(super) fn error(&self, problem: impl Into<String>) -> HandError {
        HandError::Element {
            place: self.place(),
            problem: problem.into(),
        }
    }

    /// A true or false value.
    pub(super) fn flag(&self, name: &str, default: bool) -> Result<bool, HandError> {
        match self.attribute(name) {
            None => Ok(default),
            Some("true") => Ok(true),
            Some("false") => Ok(false),
            Some(other) => Err(self.error(format!("{name}=\"{other}\": true or false is needed"))),
        }
    }

    /// Numbers in an attribute's text; an error names `self`.
    pub(super) fn numbers(&self, name: &str, text: &str) -> Result<Vec<f64>, HandError> {
        let numbers: Option<Vec<f64>> = text
            .split_whitespace()
            .map(|word| word.parse().ok().filter(|number: &f64| number.is_finite()))
            .collect();
        numbers.ok_or_else(|| self.error(format!("{name}=\"{text}\": finite numbers are needed")))
    }

    /// Exactly `N` numbers.
    pub(super) fn exactly<const N: usize>(
        &self,
        name: &str,
        text: &str,
    ) -> Result<[f64; N], HandError> {
        let numbers = self.numbers(name, text)?;
        let count = numbers.len();
        <[f64; N]>::try_from(numbers).ok().ok_or_else(|| {
            self.error(format!(
                "{name}=\"{text}\" has {count} numbers where {N} are needed"
            ))
        })
    }
}

/// The root element, with all included files inserted.
pub(super) fn read(name: &str, text: &str, files: &dyn Files) -> Result<Element, HandError> {
    let mut reading = Reading {
        files,
        included: vec![name.to_owned()],
        open: vec![name.to_owned()],
        count: 0,
    };
    let mut roots = reading.document(name, text, 0)?;
    match roots.pop() {
        Some(root) if root.tag == "mujoco" => Ok(root),
        Some(root) => Err(root.error("the root element of MJCF is <mujoco>")),
        None => Err(HandError::NoDescription),
    }
}

/// A document and its line ends. Counting lines anew for each element would take quadratic time.
struct Source {
    name: Arc<str>,
    breaks: Vec<usize>,
}

impl Source {
    /// The line of a byte, counted from 1.
    fn line(&self, at: usize) -> u32 {
        let line = self.breaks.partition_point(|&end| end < at) + 1;
        u32::try_from(line).unwrap_or(u32::MAX)
    }
}

struct Reading<'a> {
    files: &'a dyn Files,
    /// The documents read so far.
    included: Vec<String>,
    /// The document that is read, after those that include it.
    open: Vec<String>,
    count: usize,
}

impl Reading<'_> {
    /// The root of a document.
    fn document(
        &mut self,
        name: &str,
        text: &str,
        depth: usize,
    ) -> Result<Vec<Element>, HandError> {
        let options = roxmltree::ParsingOptions {
            nodes_limit: 10_000_000,
            ..roxmltree::ParsingOptions::default()
        };
        let document = roxmltree::Document::parse_with_options(text, options).map_err(|error| {
            HandError::Element {
                place: format!("{name}, line {}", error.pos().row),
                problem: format!("it is not XML: {error}"),
            }
        })?;
        let source = Source {
            name: Arc::from(name),
            breaks: text.match_indices('\n').map(|(at, _)| at).collect(),
        };
        self.convert(&document.root_element(), &source, depth)
    }

    /// Converts an element; an `<include>` gives the elements of its file.
    fn convert(
        &mut self,
        node: &roxmltree::Node<'_, '_>,
        source: &Source,
        depth: usize,
    ) -> Result<Vec<Element>, HandError> {
        let mut element = Element {
            tag: node.tag_name().name().to_owned(),
            attributes: (node.attributes())
                .map(|attribute| (attribute.name().to_owned(), attribute.value().to_owned()))
                .collect(),
            children: Vec::new(),
            file: source.name.clone(),
            line: source.line(node.range().start),
        };
        self.count += 1;
        if depth > DEEPEST || self.count > MOST {
            return Err(element.error("the description is nested too deeply or too large"));
        }
        if element.tag == "include" {
            return self.include(&element, depth);
        }
        for child in node.children().filter(roxmltree::Node::is_element) {
            let children = self.convert(&child, source, depth + 1)?;
            element.children.extend(children);
        }
        Ok(vec![element])
    }

    fn include(&mut self, element: &Element, depth: usize) -> Result<Vec<Element>, HandError> {
        let Some(reference) = element.attribute("file") else {
            return Err(element.error("file is missing"));
        };
        let given = reference;
        let reference = reference.trim_start_matches("./");
        if let Some(at) = self.open.iter().position(|known| known == reference) {
            let problem = match &self.open[at + 1..] {
                [] => format!("{reference} includes itself: delete this line"),
                between => format!(
                    "{reference} includes itself by way of {}: delete one of the includes",
                    between.join(", ")
                ),
            };
            return Err(element.error(problem));
        }
        if self.included.iter().any(|known| known == reference) {
            return Err(element.error(format!(
                "{reference} is included a second time, which MuJoCo does not allow either: delete one of the includes"
            )));
        }
        self.included.push(reference.to_owned());
        let text = self
            .files
            .include(given)
            .map_err(|problem| element.error(problem))?;
        self.open.push(reference.to_owned());
        let roots = self.document(reference, &text, depth + 1)?;
        self.open.pop();
        Ok(roots.into_iter().flat_map(|root| root.children).collect())
    }
}
