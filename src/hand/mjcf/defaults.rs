//! Default classes: attributes of elements that do not state them themselves.

use std::collections::BTreeMap;

use super::super::HandError;
use super::element::Element;

/// The class of elements that name none.
const MAIN: &str = "main";

/// All classes.
#[derive(Debug, Default)]
pub(super) struct Defaults<'a> {
    classes: BTreeMap<&'a str, Class<'a>>,
    main: Option<&'a str>,
}

#[derive(Debug, Default)]
struct Class<'a> {
    parent: Option<&'a str>,
    /// Elements that hold the attributes, in the order of the file.
    elements: Vec<&'a Element>,
}

impl<'a> Defaults<'a> {
    pub(super) fn of(root: &'a Element) -> Result<Self, HandError> {
        let mut defaults = Self::default();
        for element in root.children_named("default") {
            let name = element.attribute("class").unwrap_or(MAIN);
            if *defaults.main.get_or_insert(name) != name {
                return Err(element.error(format!(
                    "\"{name}\" is a second outermost class: nest it in the first"
                )));
            }
            defaults.add(element, name, None)?;
        }
        Ok(defaults)
    }

    fn add(
        &mut self,
        element: &'a Element,
        name: &'a str,
        parent: Option<&'a str>,
    ) -> Result<(), HandError> {
        let class = self.classes.entry(name).or_default();
        if class.parent.is_some() && class.parent != parent {
            return Err(element.error(format!("there are two classes \"{name}\"")));
        }
        class.parent = parent;
        for child in &element.children {
            if child.tag == "default" {
                let Some(inner) = child.attribute("class") else {
                    return Err(child.error("a nested default needs a class"));
                };
                if inner == name {
                    return Err(child.error("a class cannot be nested in itself"));
                }
                self.add(child, inner, Some(name))?;
            } else if let Some(class) = self.classes.get_mut(name) {
                class.elements.push(child);
            }
        }
        Ok(())
    }

    /// Attributes of an element: its own, then those of its class (`class`, else `inherited` from a body's `childclass`),
    /// then those of the enclosing classes.
    pub(super) fn resolve<'b>(
        &'b self,
        element: &'b Element,
        inherited: Option<&'b str>,
    ) -> Result<Attributes<'b>, HandError> {
        let own = element.attribute("class").or(inherited).or(self.main);
        let mut chain = vec![element];
        let mut class = own;
        // Nesting is finite: a class has one parent, which was read before it.
        for _ in 0..=self.classes.len() {
            let Some(name) = class else { break };
            let Some(known) = self.classes.get(name) else {
                return Err(element.error(format!("no default class is called \"{name}\"")));
            };
            let matching = known.elements.iter().rev();
            chain.extend(matching.filter(|defaults| defaults.tag == element.tag));
            class = known.parent;
        }
        Ok(Attributes { chain })
    }
}

/// The attributes of an element with their defaults.
#[derive(Debug)]
pub(super) struct Attributes<'a> {
    /// The element, then its defaults, nearest first.
    chain: Vec<&'a Element>,
}

impl<'a> Attributes<'a> {
    /// The element itself, for error messages.
    pub(super) fn element(&self) -> &'a Element {
        self.chain[0]
    }

    pub(super) fn text(&self, name: &str) -> Option<&'a str> {
        self.chain
            .iter()
            .find_map(|element| element.attribute(name))
    }

    pub(super) fn numbers(&self, name: &str) -> Result<Option<Vec<f64>>, HandError> {
        let text = self.text(name);
        text.map(|text| self.element().numbers(name, text))
            .transpose()
    }

    pub(super) fn exactly<const N: usize>(
        &self,
        name: &str,
    ) -> Result<Option<[f64; N]>, HandError> {
        let text = self.text(name);
        text.map(|text| self.element().exactly(name, text))
            .transpose()
    }

    /// The element or the nearest of its defaults that has one of these attributes.
    pub(super) fn nearest(&self, names: &[&str]) -> Option<&'a Element> {
        let has = |element: &&&Element| names.iter().any(|name| element.attribute(name).is_some());
        self.chain.iter().find(has).copied()
    }
}
