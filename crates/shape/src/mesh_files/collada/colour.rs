use std::collections::HashMap;

use roxmltree::{Node, NodeId};

use super::element::{HasTag, child, text};
use super::references::References;

/// Red, green, blue, opacity, if a material gives them.
pub(super) type Colour = Option<[f32; 4]>;

/// Colours of materials and effects, each read once.
#[derive(Default)]
pub(super) struct Colours(HashMap<NodeId, Colour>);

impl Colours {
    /// Diffuse colour of a material, which refers to an effect; `name` is that of the material.
    pub(super) fn of_material(&mut self, name: &str, references: &References<'_>) -> Colour {
        let material = references.first(name, "material")?;
        if let Some(known) = self.0.get(&material.id()) {
            return *known;
        }
        let instance = child(material, "instance_effect");
        let effect = instance.and_then(|instance| references.first(instance.attribute("url")?, "effect"));
        let colour = effect.and_then(|effect| *self.0.entry(effect.id()).or_insert_with(|| diffuse(effect)));
        self.0.insert(material.id(), colour);
        colour
    }
}

fn diffuse(effect: Node) -> Colour {
    let diffuse = effect.descendants().find(|node| node.has_tag_name_of("diffuse"))?;
    let words = text(child(diffuse, "color")?).ok()?;
    let numbers: Vec<f32> = words.split_ascii_whitespace().filter_map(|word| word.parse().ok()).collect();
    numbers.first_chunk().copied().filter(|colour| colour.iter().all(|part| part.is_finite()))
}

/// Materials that a node binds to the symbols of a geometry: the target of each symbol, the first where there are several.
pub(super) fn bindings<'a>(instance: Node<'a, 'a>) -> HashMap<&'a str, &'a str> {
    let mut bound = HashMap::new();
    for node in instance.descendants().filter(|node| node.has_tag_name_of("instance_material")) {
        if let Some(symbol) = node.attribute("symbol") {
            bound.entry(symbol).or_insert_with(|| node.attribute("target").unwrap_or(symbol));
        }
    }
    bound
}
