//! Lists that belong together, cut into parts for parallel work without a list of the parts.

/// Lists of the same length, or what else can be cut at an index.
pub trait Parts: Send + Sized {
    /// Number of items.
    fn len(&self) -> usize;

    /// Whether it has no item.
    fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The first `at` items, or all if there are fewer, and the others.
    fn split_at(self, at: usize) -> (Self, Self);
}

impl<T: Sync> Parts for &[T] {
    fn len(&self) -> usize {
        <[T]>::len(self)
    }

    fn split_at(self, at: usize) -> (Self, Self) {
        <[T]>::split_at(self, at.min(self.len()))
    }
}

impl<T: Send> Parts for &mut [T] {
    fn len(&self) -> usize {
        <[T]>::len(self)
    }

    fn split_at(self, at: usize) -> (Self, Self) {
        let at = at.min(<[T]>::len(self));
        self.split_at_mut(at)
    }
}

impl<A: Parts, B: Parts> Parts for (A, B) {
    fn len(&self) -> usize {
        self.0.len()
    }

    fn split_at(self, at: usize) -> (Self, Self) {
        let ((a, a_rest), (b, b_rest)) = (self.0.split_at(at), self.1.split_at(at));
        ((a, b), (a_rest, b_rest))
    }
}

impl<A: Parts, B: Parts, C: Parts> Parts for (A, B, C) {
    fn len(&self) -> usize {
        self.0.len()
    }

    fn split_at(self, at: usize) -> (Self, Self) {
        let ((a, a_rest), (b, b_rest), (c, c_rest)) = (self.0.split_at(at), self.1.split_at(at), self.2.split_at(at));
        ((a, b, c), (a_rest, b_rest, c_rest))
    }
}
