//! Nodes of a regular grid and who stands around whom.

/// Marks a node that is not there.
pub const NO_NODE: u32 = u32::MAX;

/// Offset of slot `s` of the 27 around a node.
pub fn offset(s: usize) -> [i32; 3] {
    [s as i32 % 3 - 1, s as i32 / 3 % 3 - 1, s as i32 / 9 - 1]
}

/// Slot of an offset.
pub fn slot(o: [i32; 3]) -> usize {
    ((o[2] + 1) * 9 + (o[1] + 1) * 3 + o[0] + 1) as usize
}

/// Which node stands at which coordinates.
#[derive(Clone, Debug)]
pub struct NodeMap {
    size: [i32; 3],
    node_at: Vec<u32>,
    /// Coordinates of every node, x fastest.
    pub coordinates: Vec<[i32; 3]>,
}

impl NodeMap {
    /// Nodes at these coordinates (none negative), each named as often as one likes.
    pub fn new(places: impl Iterator<Item = [i32; 3]> + Clone) -> Self {
        let size = places.clone().fold([0; 3], |m: [i32; 3], c| std::array::from_fn(|i| m[i].max(c[i] + 1)));
        let mut map = Self {
            size,
            node_at: vec![NO_NODE; size.iter().map(|&s| s as usize).product()],
            coordinates: Vec::new(),
        };
        for c in places {
            let at = map.index(c);
            map.node_at[at] = 0;
        }
        for k in 0..size[2] {
            for j in 0..size[1] {
                for i in 0..size[0] {
                    let at = map.index([i, j, k]);
                    if map.node_at[at] != NO_NODE {
                        map.node_at[at] = map.coordinates.len() as u32;
                        map.coordinates.push([i, j, k]);
                    }
                }
            }
        }
        map
    }

    fn index(&self, c: [i32; 3]) -> usize {
        ((c[2] * self.size[1] + c[1]) * self.size[0] + c[0]) as usize
    }

    /// The node at `c`, or [`NO_NODE`].
    pub fn node(&self, c: [i32; 3]) -> u32 {
        if (0..3).all(|i| (0..self.size[i]).contains(&c[i])) { self.node_at[self.index(c)] } else { NO_NODE }
    }

    /// The 27 nodes around each node.
    pub fn neighbours(&self) -> Vec<[u32; 27]> {
        let around = |c: &[i32; 3]| {
            std::array::from_fn(|s| {
                let o = offset(s);
                self.node(std::array::from_fn(|i| c[i] + o[i]))
            })
        };
        self.coordinates.iter().map(around).collect()
    }
}
