use std::path::Path;

use cranny_file::{LIFTED_BY, TABLE, are_limits_lifted, excerpt};
use cranny_shape::Aabb;
use cranny_spatial::{FARTHEST_M, Point, Vector};

use crate::SenseError;

/// Cells of a binary octree of `OctoMap`: occupied or free, all others unknown.
#[derive(Clone, Debug, PartialEq)]
pub struct Octree {
    /// Side of the smallest cell, in metres.
    pub resolution_m: f64,
    /// Occupied cells, in the order of the tree.
    pub occupied: Vec<Aabb>,
    /// Free cells, in the order of the tree.
    pub free: Vec<Aabb>,
}

/// Depth of a tree: the root has 2¹⁶ smallest cells along each axis.
const DEPTH: u32 = 16;

/// Maximum number of cells, of 48 bytes each, of which two bytes of a file can hold eight; a floor of 50 m with cells of 5 cm has
/// two million.
const MOST_CELLS: usize = 1 << 22;

/// First line of a file.
const MAGIC: &str = "# Octomap OcTree binary file";

impl Octree {
    /// Reads a binary octree (`.bt`) of the class `OcTree` (Hornung et al. 2013, "`OctoMap`", §IV-A, and the library's
    /// `readBinaryData`).
    ///
    /// # Errors
    /// [`SenseError::Unreadable`]; [`SenseError::Content`] for another format or class, a resolution that is not positive, a tree
    /// deeper than 16 levels, data that is cut short or too long, or another number of nodes than the header states.
    pub fn read(path: &Path) -> Result<Self, SenseError> {
        let bytes =
            TABLE.bytes(path).map_err(|reason| SenseError::Unreadable { path: path.to_owned(), reason })?;
        Self::of_bytes(&bytes).map_err(|problem| SenseError::content(path, problem))
    }

    /// Reads a binary octree from the bytes of a file, as [`Self::read`] does.
    ///
    /// # Errors
    /// A sentence on the fault.
    pub fn of_bytes(bytes: &[u8]) -> Result<Self, String> {
        let (mut rest, mut line) = (bytes, 0);
        let (mut class, mut size, mut resolution_m) = (None, None, None);
        loop {
            let end = rest.iter().position(|byte| *byte == b'\n');
            let end = end.ok_or("the header has no line 'data' (was the file cut short?)")?;
            line += 1;
            let text =
                std::str::from_utf8(&rest[..end]).map_err(|_| format!("line {line} is no text"))?.trim();
            rest = &rest[end + 1..];
            if line == 1 && !text.starts_with(MAGIC) {
                return Err(format!("the first line of a binary octree is '{MAGIC}'"));
            }
            match text.split_once(' ').unwrap_or((text, "")) {
                ("data", _) => break,
                ("id", value) => class = Some(value.trim()),
                ("res", value) => resolution_m = Some((line, value.trim())),
                ("size", value) => size = Some((line, value.trim())),
                ("", _) => {}
                (word, _) if word.starts_with('#') => {}
                (word, _) => {
                    return Err(format!("line {line}: '{}' is no line of the header", excerpt(word)));
                }
            }
        }
        match class {
            Some("OcTree") => {}
            other => {
                return Err(format!(
                    "the class is {}, but only OcTree is read",
                    excerpt(other.unwrap_or("missing"))
                ));
            }
        }
        let (line, text) = resolution_m.ok_or("the header has no line 'res'")?;
        let resolution_m =
            text.parse().map_err(|_| format!("line {line}: '{}' is no resolution", excerpt(text)))?;
        let (tree, nodes) = Self::of_nodes(resolution_m, rest)?;
        let (line, text) = size.ok_or("the header has no line 'size'")?;
        if text.parse() == Ok(nodes) {
            return Ok(tree);
        }
        Err(format!("line {line}: the size is {}, but the data has {nodes} nodes", excerpt(text)))
    }

    /// Reads the data of a binary octree without a header, as in an `octomap_msgs/Octomap` with `binary: true`.
    ///
    /// # Errors
    /// A sentence on the fault.
    pub fn of_data(resolution_m: f64, data: &[u8]) -> Result<Self, String> {
        Self::of_nodes(resolution_m, data).map(|(tree, _)| tree)
    }

    /// Returns the tree and its number of nodes.
    fn of_nodes(resolution_m: f64, data: &[u8]) -> Result<(Self, u64), String> {
        let half_m = resolution_m * f64::from(1_u32 << (DEPTH - 1));
        if !(resolution_m > 0.0 && half_m.is_finite()) {
            return Err(format!(
                "the resolution is {resolution_m}, but a cell has a positive side in metres"
            ));
        }
        let tree = Self { resolution_m, occupied: Vec::new(), free: Vec::new() };
        let mut nodes = Nodes { rest: data, tree, count: 0 };
        if !data.is_empty() {
            nodes.count = 1;
            nodes.read(Point::origin(), half_m, DEPTH)?;
        }
        if !nodes.rest.is_empty() {
            return Err(format!("{} bytes follow the last node", nodes.rest.len()));
        }
        Ok((nodes.tree, nodes.count))
    }
}

/// Nodes that are being read.
struct Nodes<'a> {
    rest: &'a [u8],
    tree: Octree,
    count: u64,
}

impl Nodes<'_> {
    /// Reads the children of a node of this centre and half side (m): two bits each, 1 for free, 2 for occupied, 3 for a node with
    /// children, which follow behind all bits of the node.
    fn read(&mut self, center: Point, half_m: f64, depth: u32) -> Result<(), String> {
        let Some((bits, rest)) = self.rest.split_first_chunk() else {
            return Err("the data ends within the tree (was the file cut short?)".to_owned());
        };
        self.rest = rest;
        let bits = u16::from_le_bytes(*bits);
        let half_m = 0.5 * half_m;
        let child = |index: u16| {
            let sign = |bit: u16| if index & bit == 0 { -half_m } else { half_m };
            center + Vector::new(sign(1), sign(2), sign(4))
        };
        for index in 0..8 {
            let kind = (bits >> (2 * index)) & 3;
            self.count += u64::from(kind != 0);
            let cells = match kind {
                1 => &mut self.tree.free,
                2 => &mut self.tree.occupied,
                _ => continue,
            };
            let cell = Aabb { center: child(index), half_extents: Vector::repeat(half_m) };
            if cell.center.coords.amax() + half_m > FARTHEST_M {
                return Err(format!("a cell lies more than {FARTHEST_M} m from the origin"));
            }
            cells.push(cell);
        }
        if self.tree.free.len() + self.tree.occupied.len() > MOST_CELLS && !are_limits_lifted() {
            return Err(format!("the tree has more than {MOST_CELLS} cells ({LIFTED_BY} lifts this limit)"));
        }
        for index in (0..8).filter(|index| (bits >> (2 * index)) & 3 == 3) {
            if depth == 1 {
                return Err(format!("the tree is deeper than {DEPTH} levels"));
            }
            self.read(child(index), half_m, depth - 1)?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use cranny_spatial::Stream;

    use super::*;

    /// Set of smallest cells by their keys, true where occupied, that is written as `OctoMap` writes it: children of one kind are
    /// pruned.
    type Cells = BTreeMap<[u32; 3], bool>;

    /// Kind of a node: 1 free, 2 occupied, 3 inner, 0 unknown; its own bytes; and its number of nodes.
    fn written(cells: &Cells, low: [u32; 3], side: u32) -> (u16, Vec<u8>, u64) {
        let inside =
            |key: &[u32; 3]| (0..3).all(|axis| key[axis] >= low[axis] && key[axis] < low[axis] + side);
        let own: Cells = cells.iter().filter(|(key, _)| inside(key)).map(|(key, is)| (*key, *is)).collect();
        if side == 1 {
            let kind = own.get(&low).map_or(0, |is_occupied| 1 + u16::from(*is_occupied));
            return (kind, Vec::new(), u64::from(kind != 0));
        }
        if own.is_empty() {
            return (0, Vec::new(), 0);
        }
        let half = side / 2;
        let children: Vec<_> = (0..8_u32)
            .map(|index| written(&own, [0, 1, 2].map(|axis| low[axis] + half * ((index >> axis) & 1)), half))
            .collect();
        let kinds: Vec<u16> = children.iter().map(|child| child.0).collect();
        if kinds.iter().all(|kind| *kind == kinds[0] && (*kind == 1 || *kind == 2)) {
            return (kinds[0], Vec::new(), 1);
        }
        let bits = kinds.iter().enumerate().fold(0_u16, |bits, (index, kind)| bits | kind << (2 * index));
        let mut bytes = bits.to_le_bytes().to_vec();
        let mut count = 1;
        for (_, own, nodes) in children {
            bytes.extend(own);
            count += nodes;
        }
        (3, bytes, count)
    }

    fn file(cells: &Cells, resolution_m: f64) -> Vec<u8> {
        let (kind, data, count) = written(cells, [0; 3], 1 << DEPTH);
        assert!(kind == 3 || kind == 0);
        let header = format!(
            "{MAGIC}\n# (feel free to add / change comments, but leave the first line as it is!)\n#\nid OcTree\n\
             size {count}\nres {resolution_m}\ndata\n"
        );
        [header.as_bytes(), &data].concat()
    }

    #[test]
    fn cells_are_read_where_they_were_written() {
        const MIDDLE: u32 = 1 << (DEPTH - 1);
        let mut random = Stream::new(1, 0);
        let mut cells = Cells::new();
        // A block that is pruned, and single cells.
        for index in 0..512 {
            let key = [0, 3, 6].map(|shift| MIDDLE + 8 + ((index >> shift) & 7));
            cells.insert(key, true);
        }
        for _ in 0..300 {
            let key = [0; 3].map(|_: u32| MIDDLE - 20 + u32::try_from(random.index(40)).unwrap());
            cells.insert(key, random.uniform() < 0.5);
        }
        let tree = Octree::of_bytes(&file(&cells, 0.05)).unwrap();
        // Each cell of the tree as smallest cells.
        let mut found = Cells::new();
        for (boxes, is_occupied) in [(&tree.occupied, true), (&tree.free, false)] {
            for aabb in boxes {
                #[allow(
                    clippy::cast_possible_truncation,
                    clippy::cast_sign_loss,
                    reason = "small whole numbers"
                )]
                let (low, count) = (
                    [0, 1, 2].map(|axis| (f64::from(MIDDLE) + aabb.low()[axis] / 0.05).round() as u32),
                    (2.0 * aabb.half_extents.x / 0.05).round() as u32,
                );
                for index in 0..count * count * count {
                    let offset = [index % count, (index / count) % count, index / count / count];
                    found.insert([0, 1, 2].map(|axis| low[axis] + offset[axis]), is_occupied);
                }
            }
        }
        assert_eq!(found, cells);
        assert!(tree.occupied.len() < 512, "the block is pruned");
    }

    #[test]
    fn false_octrees_are_refused() {
        let mut cells = Cells::new();
        cells.insert([40000, 30000, 32768], true);
        let sound = file(&cells, 0.01);
        let tree = Octree::of_bytes(&sound).unwrap();
        let center = tree.occupied[0].center;
        let expected = Point::new(72.325, -27.675, 0.005);
        assert!((center - expected).norm() < 1e-9, "{center}");
        let replaced = |from: &str, to: &str| {
            let at = sound.windows(from.len()).position(|window| window == from.as_bytes()).unwrap();
            Octree::of_bytes(&[&sound[..at], to.as_bytes(), &sound[at + from.len()..]].concat()).unwrap_err()
        };
        assert!(replaced("id OcTree", "id ColorOcTree").contains("the class is ColorOcTree"));
        assert!(replaced("res 0.01", "res -1").contains("the resolution is -1"));
        assert!(replaced("res 0.01", "res wide").contains("line 6: 'wide' is no resolution"));
        assert!(replaced("res 0.01", "res 1").contains("more than 1000 m"));
        assert!(replaced("size 17", "size 18").contains("the size is 18, but the data has 17 nodes"));
        assert!(replaced("# Octomap", "# Otcomap").contains("the first line"));
        assert!(replaced("\ndata\n", "\ndate\n").contains("'date' is no line of the header"));
        let cut = Octree::of_bytes(&sound[..sound.len() - 1]).unwrap_err();
        assert!(cut.contains("ends within the tree"), "{cut}");
        let long = Octree::of_bytes(&[&sound[..], &[0]].concat()).unwrap_err();
        assert!(long.contains("1 bytes follow"), "{long}");
        let deep = Octree::of_data(0.01, &[0xff; 4096]).unwrap_err();
        assert!(deep.contains("deeper than 16 levels"), "{deep}");
        assert_eq!(Octree::of_data(0.1, &[]).unwrap().occupied, []);
    }
}
