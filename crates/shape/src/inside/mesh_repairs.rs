/// What was done to the triangles of a mesh so that its inside is well defined.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct MeshRepairs {
    /// How many triangles there were.
    pub triangles: usize,
    /// Vertices that were taken for one with another at the same place.
    pub merged_vertices: usize,
    /// Triangles that were turned to face outwards.
    pub flipped_triangles: usize,
    /// Triangles that were left out because they stood there twice.
    pub doubled_triangles: usize,
    /// Small holes that were closed.
    pub closed_holes: usize,
}

impl MeshRepairs {
    /// Whether anything had to be done.
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
