//! Places without gaps that vertices, triangles and wedges have in buffers.

use relievo_core::Marks;

use crate::connectivity::NONE;

/// Where vertices and triangles are in buffers, and what has changed since they were written.
pub struct Places {
    pub vertices: Order,
    pub triangles: Order,
    /// With gaps: which triangles a wedge has is not known without looking for its vertex.
    pub wedges: Order,
    /// Splits that were made or taken back, each with the vertex it splits.
    pub splits: Vec<[u32; 2]>,
    /// Vertices that are elsewhere.
    pub moved: Vec<u32>,
    /// So much has changed that all is to be written.
    pub is_whole: bool,
}

impl Places {
    pub fn new(vertices: usize, faces: usize, wedges: usize) -> Self {
        let [vertices, triangles, wedges] = [vertices, faces, wedges].map(Order::new);
        Self { vertices, triangles, wedges, splits: Vec::new(), moved: Vec::new(), is_whole: true }
    }

    /// Notes splits that were made or taken back, each with the vertex it splits.
    pub fn note_splits(&mut self, splits: impl IntoIterator<Item = [u32; 2]>) {
        if !self.is_whole {
            self.splits.extend(splits);
            self.limit();
        }
    }

    pub fn note_moved(&mut self, vertices: impl Iterator<Item = u32>) {
        if !self.is_whole {
            self.moved.extend(vertices);
            self.limit();
        }
    }

    /// Lists that are longer than the mesh save nothing.
    pub fn limit(&mut self) {
        if self.splits.len() + self.moved.len() > self.vertices.places.len() {
            (self.splits, self.moved, self.is_whole) = (Vec::new(), Vec::new(), true);
        }
    }
}

/// Items in places without gaps.
pub struct Order {
    /// Of every item its place, or [`NONE`].
    pub places: Vec<u32>,
    /// Of every place its item.
    pub items: Vec<u32>,
    /// Items that are to be written, and whether an item is one of them.
    pub written: Vec<u32>,
    pub is_written: Vec<u64>,
    /// Places that were written.
    pub marks: Marks,
    /// Places whose items are gone.
    pub free: Vec<u32>,
}

impl Order {
    pub fn new(count: usize) -> Self {
        let is_written = vec![0; count.div_ceil(64)];
        Self {
            places: vec![NONE; count],
            items: Vec::new(),
            written: Vec::new(),
            is_written,
            marks: Marks::new(count),
            free: Vec::new(),
        }
    }

    pub fn clear(&mut self) {
        self.items.drain(..).for_each(|item| self.places[item as usize] = NONE);
        self.free.clear();
    }

    pub fn remove(&mut self, item: u32) {
        let place = std::mem::replace(&mut self.places[item as usize], NONE);
        if place != NONE {
            self.free.push(place);
        }
    }

    /// Gives an item a place, if it has none, and has it written.
    pub fn add(&mut self, item: u32) {
        if self.places[item as usize] == NONE {
            let place = self.free.pop().unwrap_or(self.items.len() as u32);
            if place as usize == self.items.len() {
                self.items.push(item);
            }
            self.items[place as usize] = item;
            self.places[item as usize] = place;
        }
        self.write(item);
    }

    pub fn write(&mut self, item: u32) {
        let (word, bit) = (item as usize / 64, 1 << (item % 64));
        if self.is_written[word] & bit == 0 {
            self.is_written[word] |= bit;
            self.written.push(item);
        }
    }

    /// Fills the places that are left free with the last items. Returns those.
    pub fn close(&mut self) -> Vec<u32> {
        self.free.sort_unstable();
        let mut moved = Vec::new();
        while let Some(place) = self.free.pop() {
            let Some(last) = self.items.pop() else { break };
            // The free places behind this one are gone already.
            if place as usize != self.items.len() {
                self.items[place as usize] = last;
                self.places[last as usize] = place;
                moved.push(last);
            }
        }
        moved
    }

    /// The items to be written with their places, and none are from now on.
    pub fn take_written(&mut self) -> Vec<(u32, u32)> {
        let list = self.written.drain(..).map(|item| {
            self.is_written[item as usize / 64] = 0;
            (self.places[item as usize], item)
        });
        list.collect()
    }
}
