use gltf_json::accessor::{Accessor, ComponentType, GenericComponentType, Type};
use gltf_json::buffer::{Target, View};
use gltf_json::validation::{Checked, USize64};
use gltf_json::{Extras, Index, Root};

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
        target: Option<Target>,
    ) -> Index<Accessor> {
        let bytes = rows.iter().flatten().flat_map(|number| number.to_le_bytes());
        let view = self.view(root, bytes, target);
        let fold = |pick: fn(f32, f32) -> f32| -> Vec<f32> {
            (0..N).map(|i| rows.iter().map(|row| row[i]).reduce(pick).unwrap_or_default()).collect()
        };
        let (low, high) = (fold(f32::min), fold(f32::max));
        let type_ = match N {
            1 => Type::Scalar,
            3 => Type::Vec3,
            _ => Type::Vec4,
        };
        root.push(Accessor {
            min: Some(low.into()),
            max: Some(high.into()),
            ..accessor(view, rows.len(), ComponentType::F32, type_)
        })
    }

    /// Adds corners of triangles, in the narrowest integers that can represent them.
    pub fn indices(&mut self, root: &mut Root, triangles: &[[u32; 3]]) -> Index<Accessor> {
        let indices = || triangles.iter().flatten();
        let greatest = indices().max().copied().unwrap_or(0);
        // Some graphics cards interpret the maximum of each width as a restart of the primitive.
        let narrow: Option<Vec<u16>> = (greatest < u32::from(u16::MAX))
            .then(|| indices().map(|&index| u16::try_from(index).unwrap_or(u16::MAX)).collect());
        let (bytes, width): (Vec<u8>, _) = match narrow {
            Some(narrow) => (narrow.into_iter().flat_map(u16::to_le_bytes).collect(), ComponentType::U16),
            None => (indices().flat_map(|index| index.to_le_bytes()).collect(), ComponentType::U32),
        };
        let view = self.view(root, bytes, Some(Target::ElementArrayBuffer));
        root.push(accessor(view, 3 * triangles.len(), width, Type::Scalar))
    }

    fn view(
        &mut self,
        root: &mut Root,
        bytes: impl IntoIterator<Item = u8>,
        target: Option<Target>,
    ) -> Index<View> {
        let offset = self.bytes.len();
        self.bytes.extend(bytes);
        let length = self.bytes.len() - offset;
        // Every view begins at a multiple of the widest number.
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
        root.push(View {
            buffer: Index::new(0),
            byte_length: length.into(),
            byte_offset: Some(offset.into()),
            byte_stride: None,
            name: None,
            target: target.map(Checked::Valid),
            extensions: None,
            extras: Extras::default(),
        })
    }
}

fn accessor(view: Index<View>, count: usize, width: ComponentType, type_: Type) -> Accessor {
    Accessor {
        buffer_view: Some(view),
        byte_offset: Some(USize64(0)),
        count: count.into(),
        component_type: Checked::Valid(GenericComponentType(width)),
        extensions: None,
        extras: Extras::default(),
        type_: Checked::Valid(type_),
        min: None,
        max: None,
        name: None,
        normalized: false,
        sparse: None,
    }
}
