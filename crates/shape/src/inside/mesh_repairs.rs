/// Repairs to the triangles of a mesh that make its inside well defined.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct MeshRepairs {
    /// Number of triangles of the mesh.
    pub triangles: usize,
    /// Number of vertices merged with another at the same position.
    pub merged_vertices: usize,
    /// Number of triangles turned to face outwards.
    pub flipped_triangles: usize,
    /// Number of duplicate triangles left out.
    pub doubled_triangles: usize,
    /// Number of small holes closed.
    pub closed_holes: usize,
}

impl MeshRepairs {
    /// Returns true if any repair was needed.
    pub fn is_any(&self) -> bool {
        self.merged_vertices + self.flipped_triangles + self.doubled_triangles + self.closed_holes > 0
    }
}

impl std::fmt::Display for MeshRepairs {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        let triangles = self.triangles;
        let done = [
            (self.closed_holes, "small holes closed, and what they lead to taken for full".to_owned()),
            (self.flipped_triangles, format!("of {triangles} triangles turned to face outwards")),
            (self.doubled_triangles, format!("of {triangles} triangles left out that stand there twice")),
            (self.merged_vertices, "vertices joined with others less than 1 µm away".to_owned()),
        ];
        let said: Vec<String> = done
            .iter()
            .filter(|(count, _)| *count > 0)
            .map(|(count, what)| format!("{count} {what}"))
            .collect();
        write!(f, "its mesh was repaired: {}", said.join(", "))
    }
}
