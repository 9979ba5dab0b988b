use roxmltree::Node;

use super::element::{children, elements, fault, index, indices, unknown};

/// Rule by which the vertices of a primitive form polygons.
pub(super) enum Primitive {
    Triangles,
    Polylist,
    Polygon,
    Strip,
    Fan,
}

impl Primitive {
    /// Rule of an element; `None` for one that is no primitive with a surface.
    pub(super) fn of(element: Node) -> Option<Self> {
        Some(match element.tag_name().name() {
            "triangles" => Self::Triangles,
            "polylist" => Self::Polylist,
            "polygons" => Self::Polygon,
            "tristrips" => Self::Strip,
            "trifans" => Self::Fan,
            _ => return None,
        })
    }

    /// Polygons of an element of this kind, as indices into the vertices.
    ///
    /// # Errors
    /// A message with the line: leftover indices, a count other than announced, a polygon with holes.
    pub(super) fn polygons(&self, element: Node, inputs: &Inputs) -> Result<Vec<Vec<usize>>, String> {
        for part in elements(element) {
            match part.tag_name().name() {
                "input" | "p" | "extra" => {}
                "vcount" if matches!(self, Self::Polylist) => {}
                "ph" => return Err(fault(part, "a polygon with holes (<ph>) is not read (triangulate it)")),
                _ => return Err(unknown(part)),
            }
        }
        // The counts of a list of polygons are those of its only list of corners.
        if matches!(self, Self::Polylist)
            && let Some(second) = children(element, "p").nth(1)
        {
            return Err(fault(second, "there is a <p> before this one"));
        }
        let mut polygons = Vec::new();
        let mut lists = 0;
        for list in children(element, "p") {
            lists += 1;
            let indices = indices(list)?;
            let stride = inputs.stride;
            if !indices.len().is_multiple_of(stride) {
                let count = indices.len();
                return Err(fault(
                    list,
                    &format!("{count} indices are no whole number of corners of {stride} each"),
                ));
            }
            let vertices: Vec<usize> = indices.chunks(stride).map(|corner| corner[inputs.vertex]).collect();
            self.add_polygons(element, list, &vertices, &mut polygons)?;
        }
        let actual = if matches!(self, Self::Triangles | Self::Polylist) { polygons.len() } else { lists };
        match element.attribute("count") {
            Some(count) if index(element, count)? != actual => {
                let tag = element.tag_name().name();
                Err(fault(element, &format!("{count} {tag} are announced, but there are {actual}")))
            }
            _ => Ok(polygons),
        }
    }

    fn add_polygons(
        &self,
        element: Node,
        list: Node,
        vertices: &[usize],
        polygons: &mut Vec<Vec<usize>>,
    ) -> Result<(), String> {
        match self {
            Self::Triangles => {
                if !vertices.len().is_multiple_of(3) {
                    let count = vertices.len();
                    return Err(fault(list, &format!("{count} corners are no whole number of triangles")));
                }
                polygons.extend(vertices.chunks_exact(3).map(<[usize]>::to_vec));
            }
            Self::Polygon => polygons.push(vertices.to_vec()),
            Self::Fan => {
                polygons
                    .extend((2..vertices.len()).map(|at| vec![vertices[0], vertices[at - 1], vertices[at]]));
            }
            Self::Strip => {
                // Every second triangle of a strip has the opposite winding.
                let turned = |(at, t): (usize, &[usize])| {
                    if at % 2 == 0 { vec![t[0], t[1], t[2]] } else { vec![t[1], t[0], t[2]] }
                };
                polygons.extend(vertices.windows(3).enumerate().map(turned));
            }
            Self::Polylist => {
                let mut counts = children(element, "vcount");
                let counts = match (counts.next(), counts.next()) {
                    (Some(counts), None) => counts,
                    (None, _) => return Err(fault(element, "there is no <vcount>")),
                    (_, Some(second)) => return Err(fault(second, "there is a <vcount> before this one")),
                };
                let mut rest = vertices;
                for count in indices(counts)? {
                    let (polygon, behind) = rest
                        .split_at_checked(count)
                        .ok_or_else(|| fault(counts, "it counts more corners than there are"))?;
                    polygons.push(polygon.to_vec());
                    rest = behind;
                }
                if !rest.is_empty() {
                    let (left, all) = (rest.len(), vertices.len());
                    return Err(fault(counts, &format!("it leaves {left} of {all} corners over")));
                }
            }
        }
        Ok(())
    }
}

/// Position of the vertex among the indices of a corner.
pub(super) struct Inputs<'a> {
    /// Number of indices of each corner.
    pub(super) stride: usize,
    /// Position of the vertex index among them.
    pub(super) vertex: usize,
    /// Input of the vertices, if any.
    pub(super) element: Option<Node<'a, 'a>>,
}

impl<'a> Inputs<'a> {
    /// # Errors
    /// A message with the line: an offset that is no index, more than one input of vertices.
    pub(super) fn of(primitive: Node<'a, 'a>) -> Result<Self, String> {
        let mut inputs = Self { stride: 1, vertex: 0, element: None };
        for input in children(primitive, "input") {
            let offset = input.attribute("offset").map_or(Ok(0), |offset| index(input, offset))?;
            inputs.stride = inputs.stride.max(offset.saturating_add(1));
            if input.attribute("semantic") == Some("VERTEX") {
                inputs.vertex = offset;
                if inputs.element.replace(input).is_some() {
                    return Err(fault(input, "a second <input> of VERTEX"));
                }
            }
        }
        Ok(inputs)
    }
}
