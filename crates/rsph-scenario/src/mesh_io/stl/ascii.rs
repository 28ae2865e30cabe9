//! STL as text. Read here and not by the library, which ends at the first of several solids, refuses the "nan"
//! that programs write as normal of a flat triangle, and does not say in which line something is wrong.

use super::super::{MeshWithParts, shown};
use rsph_core::tensor::Vec3;

/// The triangles of all solids, each with three vertices of its own.
pub(super) fn triangles(text: &str) -> Result<MeshWithParts, String> {
    let mut read = MeshWithParts::default();
    let mut solid = String::new();
    let mut corners = 0;
    let mut last = 0;
    for (number, line) in text.lines().enumerate() {
        let wrong =
            |what: &str| Err(format!("line {} of the STL file, \"{}\": {what}", number + 1, shown(line)));
        let mut words = line.split_whitespace();
        let Some(word) = words.next() else { continue };
        last = number + 1;
        match word.to_ascii_lowercase().as_str() {
            "vertex" => {
                let Some(vertex) = vertex(words) else {
                    return wrong("a vertex is three numbers, with decimal points and blanks between them");
                };
                read.mesh.vertices.push(vertex);
                corners += 1;
            }
            "facet" if corners != 0 => return wrong("the facet before it does not end"),
            "endfacet" => {
                if corners != 3 {
                    return wrong(&format!("this facet has {corners} vertices, and three are a triangle"));
                }
                let next = read.mesh.vertices.len() as u32;
                read.name(&solid, read.mesh.triangles.len());
                read.mesh.triangles.push([next - 3, next - 2, next - 1]);
                corners = 0;
            }
            "solid" => solid = words.collect::<Vec<_>>().join(" "),
            // Normals are computed from the vertices.
            "facet" | "outer" | "endloop" | "endsolid" => {}
            _ => return wrong("solid, facet, outer, vertex, endloop, endfacet or endsolid is allowed here"),
        }
    }
    if corners != 0 {
        return Err(format!("the STL file ends in line {last}, in the middle of a facet: it is cut off"));
    }
    Ok(read)
}

fn vertex<'a>(words: impl Iterator<Item = &'a str>) -> Option<Vec3> {
    let mut numbers = words.map(|w| w.parse::<f64>().ok().filter(|x| x.is_finite()));
    let vertex = Vec3::new(numbers.next()??, numbers.next()??, numbers.next()??);
    numbers.next().is_none().then_some(vertex)
}
