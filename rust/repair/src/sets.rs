//! Disjoint sets of faces (Tarjan 1975), with a parity between each face and the representative of its set.

/// Disjoint sets in which every item is equal or opposite to the representative.
pub struct Sets {
    /// The item above each one, doubled, and in the lowest bit whether the two are opposite.
    above: Vec<u32>,
}

impl Sets {
    /// Makes a set of each item below `count`, which is less than 2³¹.
    pub fn new(count: usize) -> Self {
        Self { above: (0..count as u32).map(|item| 2 * item).collect() }
    }

    /// Returns the representative of an item, which is the first of its set, and whether the item is opposite to it.
    pub fn root(&mut self, mut item: u32) -> (u32, bool) {
        let mut parity = 0;
        loop {
            let link = self.above[item as usize];
            if link / 2 == item {
                return (item, parity == 1);
            }
            let next = self.above[link as usize / 2];
            // Half the path: the item moves up to the one above its next.
            self.above[item as usize] = next ^ (link & 1);
            parity ^= (next ^ link) & 1;
            item = next / 2;
        }
    }

    /// Joins the sets of two items that are equal or opposite. Returns whether this agrees with what is joined already.
    pub fn join(&mut self, a: u32, b: u32, opposite: bool) -> bool {
        let ((root_a, parity_a), (root_b, parity_b)) = (self.root(a), self.root(b));
        let parity = parity_a ^ parity_b ^ opposite;
        if root_a == root_b {
            return !parity;
        }
        self.above[root_a.max(root_b) as usize] = 2 * root_a.min(root_b) + u32::from(parity);
        true
    }

    /// Returns for every item the number of its set, in the order of their first items, and the number of sets.
    pub fn labels(&mut self) -> (Vec<u32>, usize) {
        let mut count = 0;
        let mut labels = vec![0; self.above.len()];
        for item in 0..self.above.len() as u32 {
            let (root, _) = self.root(item);
            if root == item {
                labels[item as usize] = count;
                count += 1;
            } else {
                labels[item as usize] = labels[root as usize];
            }
        }
        (labels, count as usize)
    }
}
