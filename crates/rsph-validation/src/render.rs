//! Surfaces seen from one side, as small pictures: the nearest triangle of each pixel, in a colour of its own.

use base64::Engine;
use rsph_core::mesh::TriangleMesh;
use rsph_core::tensor::{Mat3, Vec3};

/// From where a body is seen, without perspective.
#[derive(Clone, Copy, Debug)]
pub(super) struct View {
    /// Rows: right, up, towards the eye.
    turn: Mat3,
    centre: Vec3,
    /// Pixels a length.
    scale: f64,
    size: [usize; 2],
}

impl View {
    /// A picture of that many pixels, seen from the direction `eye`, with `centre` in its middle and y up.
    pub fn new(eye: Vec3, centre: Vec3, scale: f64, size: [usize; 2]) -> Self {
        let eye = eye.normalize();
        let right = Vec3::y().cross(&eye).normalize();
        let turn = Mat3::from_rows(&[right.transpose(), eye.cross(&right).transpose(), eye.transpose()]);
        Self { turn, centre, scale, size }
    }

    /// Width and height in pixels.
    pub fn size(&self) -> [usize; 2] {
        self.size
    }

    /// A point in pixels from the upper left corner, with its nearness to the eye as z.
    pub fn seen(&self, x: &Vec3) -> Vec3 {
        let p = self.turn * (x - self.centre);
        let [half_width, half_height] = self.size.map(|n| 0.5 * n as f64);
        Vec3::new(half_width + self.scale * p.x, half_height - self.scale * p.y, p.z)
    }

    /// Share of a direction that points to the eye.
    fn towards(&self, direction: &Vec3) -> f64 {
        (self.turn * direction).z
    }
}

/// The place on the surface that a pixel shows.
pub(super) struct Spot<'a> {
    /// Corners of the triangle there.
    pub corners: &'a [usize; 3],
    /// Weights of the corners.
    pub weights: [f64; 3],
    /// How much the surface there faces the eye, 0 to 1.
    pub facing: f64,
}

/// Pixels row by row, red, green, blue; `None`: nothing there.
pub(super) type Pixels = Vec<Option<[u8; 3]>>;

/// Draws a surface; `colour` says what a spot looks like.
pub(super) fn render(mesh: &TriangleMesh, view: &View, colour: &dyn Fn(&Spot) -> [u8; 3]) -> Pixels {
    let [width, height] = view.size;
    let mut nearest = vec![f64::NEG_INFINITY; width * height];
    let mut pixels = vec![None; width * height];
    for t in 0..mesh.triangles.len() {
        let corners = mesh.triangles[t].map(|v| v as usize);
        let facing = view.towards(&mesh.normal(t)).abs();
        let [a, b, c] = corners.map(|v| view.seen(&mesh.vertices[v]));
        let area = (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
        let (low, high) = (a.inf(&b).inf(&c), a.sup(&b).sup(&c));
        let range = |low: f64, high: f64, n: usize| {
            low.max(0.0) as usize..(high.max(-1.0) + 1.0).min(n as f64) as usize
        };
        for y in range(low.y, high.y, height) {
            for x in range(low.x, high.x, width) {
                let (px, py) = (x as f64 + 0.5, y as f64 + 0.5);
                let side = |p: &Vec3, q: &Vec3| ((q.x - p.x) * (py - p.y) - (q.y - p.y) * (px - p.x)) / area;
                let (wa, wc) = (side(&b, &c), side(&a, &b));
                let weights = [wa, 1.0 - wa - wc, wc];
                let depth = weights[0] * a.z + weights[1] * b.z + weights[2] * c.z;
                let n = y * width + x;
                if weights.iter().all(|w| *w >= 0.0) && depth > nearest[n] {
                    nearest[n] = depth;
                    pixels[n] = Some(colour(&Spot { corners: &corners, weights, facing }));
                }
            }
        }
    }
    pixels
}

/// Grey by how much the surface faces the eye.
pub(super) fn shaded(spot: &Spot) -> [u8; 3] {
    [(40.0 + 200.0 * spot.facing) as u8; 3]
}

/// Pixels as a PNG in a `data:` address; empty ones are transparent.
pub(super) fn data_address(pixels: &Pixels, size: [usize; 2]) -> Result<String, png::EncodingError> {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, size[0] as u32, size[1] as u32);
    encoder.set_color(png::ColorType::Rgba);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_compression(png::Compression::High);
    let rgba: Vec<u8> =
        pixels.iter().flat_map(|p| p.map_or([0; 4], |[r, g, b]| [r, g, b, u8::MAX])).collect();
    let mut writer = encoder.write_header()?;
    writer.write_image_data(&rgba)?;
    writer.finish()?;
    let text = base64::engine::general_purpose::STANDARD.encode(&bytes);
    Ok(format!("data:image/png;base64,{text}"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use rsph_core::shape::{Shape, SphereShape};

    #[test]
    fn a_sphere_is_a_shaded_disc_before_what_lies_behind() {
        let view = View::new(Vec3::new(0.5, 0.3, 0.7), Vec3::repeat(0.35), 300.0, [120, 100]);
        let sphere = SphereShape::new(0.15, Vec3::repeat(0.35)).unwrap();
        let pixels = render(sphere.surface(), &view, &shaded);
        let covered = pixels.iter().flatten().count() as f64;
        let disc = std::f64::consts::PI * (0.15 * 300.0_f64).powi(2);
        assert!((covered / disc - 1.0).abs() < 0.03, "{covered} {disc}");
        assert!(pixels.iter().flatten().any(|g| g[0] < 80) && pixels.iter().flatten().any(|g| g[0] > 220));
        assert_eq!(pixels[0], None);
        // The nearer side wins: corners are coloured by their nearness.
        let near = |spot: &Spot| {
            let z = |v: usize| view.seen(&sphere.surface().vertices[v]).z;
            [u8::from(spot.corners.iter().all(|v| z(*v) > -0.02)); 3]
        };
        let middle = render(sphere.surface(), &view, &near)[50 * 120 + 60];
        assert_eq!(middle, Some([1; 3]));
    }

    #[test]
    fn pixels_become_an_address() {
        let pixels = vec![None, Some([1, 2, 3]), Some([4, 5, 6]), None];
        let address = data_address(&pixels, [2, 2]).unwrap();
        assert!(address.starts_with("data:image/png;base64,iVBORw0KGgo"), "{address}");
    }
}
