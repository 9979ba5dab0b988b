use crate::gltf_json::{
    Accessor, BufferView, ELEMENT_ARRAY_BUFFER, FLOAT, Index, Root, UNSIGNED_INT, UNSIGNED_SHORT, push,
};

/// Single buffer of a `.glb`, with the accessors into it.
#[derive(Default)]
pub(crate) struct GltfBuffer {
    pub bytes: Vec<u8>,
}

impl GltfBuffer {
    /// Adds rows of numbers; `target` is set for data that goes to the graphics card unchanged.
    pub fn numbers<const N: usize>(
        &mut self,
        root: &mut Root,
        rows: &[[f32; N]],
        target: Option<u32>,
    ) -> Index {
        let bytes = rows.iter().flatten().flat_map(|number| number.to_le_bytes());
        let buffer_view = self.view(root, bytes, target);
        let fold = |pick: fn(f32, f32) -> f32| -> Vec<f64> {
            (0..N).map(|i| rows.iter().map(|row| row[i]).reduce(pick).unwrap_or_default().into()).collect()
        };
        let (min, max) = (Some(fold(f32::min)), Some(fold(f32::max)));
        let shape = match N {
            1 => "SCALAR",
            3 => "VEC3",
            _ => "VEC4",
        };
        let accessor = Accessor { buffer_view, component_type: FLOAT, count: rows.len(), shape, min, max };
        push(&mut root.accessors, accessor)
    }

    /// Adds corners of triangles, in the narrowest integers that can represent them.
    pub fn indices(&mut self, root: &mut Root, triangles: &[[u32; 3]]) -> Index {
        let indices = || triangles.iter().flatten();
        let greatest = indices().max().copied().unwrap_or(0);
        // Some graphics cards interpret the maximum of each width as a restart of the primitive.
        let narrow: Option<Vec<u16>> = (greatest < u32::from(u16::MAX))
            .then(|| indices().map(|&index| u16::try_from(index).unwrap_or(u16::MAX)).collect());
        let (bytes, component_type): (Vec<u8>, _) = match narrow {
            Some(narrow) => (narrow.into_iter().flat_map(u16::to_le_bytes).collect(), UNSIGNED_SHORT),
            None => (indices().flat_map(|index| index.to_le_bytes()).collect(), UNSIGNED_INT),
        };
        let buffer_view = self.view(root, bytes, Some(ELEMENT_ARRAY_BUFFER));
        let (count, shape) = (3 * triangles.len(), "SCALAR");
        let accessor = Accessor { buffer_view, component_type, count, shape, min: None, max: None };
        push(&mut root.accessors, accessor)
    }

    fn view(&mut self, root: &mut Root, bytes: impl IntoIterator<Item = u8>, target: Option<u32>) -> Index {
        let byte_offset = self.bytes.len();
        self.bytes.extend(bytes);
        let byte_length = self.bytes.len() - byte_offset;
        // Every view begins at a multiple of the widest number.
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
        push(&mut root.buffer_views, BufferView { buffer: 0, byte_length, byte_offset, target })
    }
}
