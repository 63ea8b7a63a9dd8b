//! Placement of a label beside a point where it overlaps least.

use super::canvas::text_width;

/// A rectangle on the sheet: left, top, right, bottom.
#[derive(Debug, Clone, Copy)]
pub(super) struct Block {
    left: f64,
    top: f64,
    right: f64,
    bottom: f64,
}

impl Block {
    pub(super) const fn new(left: f64, top: f64, right: f64, bottom: f64) -> Self {
        Self { left, top, right, bottom }
    }

    pub(super) fn around((x, y): (f64, f64), radius: f64) -> Self {
        Self::new(x - radius, y - radius, x + radius, y + radius)
    }

    fn overlap(&self, other: &Self) -> f64 {
        let width = self.right.min(other.right) - self.left.max(other.left);
        let height = self.bottom.min(other.bottom) - self.top.max(other.top);
        width.max(0.0) * height.max(0.0)
    }

    fn area(&self) -> f64 {
        (self.right - self.left) * (self.bottom - self.top)
    }
}

/// Occupied areas of the sheet.
#[derive(Debug)]
pub(super) struct Occupied {
    frame: Block,
    blocks: Vec<Block>,
}

impl Occupied {
    pub(super) const fn new(frame: Block) -> Self {
        Self { frame, blocks: Vec::new() }
    }

    pub(super) fn add(&mut self, block: Block) {
        self.blocks.push(block);
    }

    /// Marks a line as occupied, as small squares along it.
    pub(super) fn add_line(&mut self, points: &[(f64, f64)]) {
        const STEP: f64 = 4.0;
        for ends in points.windows(2) {
            let (dx, dy) = (ends[1].0 - ends[0].0, ends[1].1 - ends[0].1);
            let length = dx.hypot(dy);
            let mut done = 0.0;
            while done < length {
                let at = (ends[0].0 + dx * done / length, ends[0].1 + dy * done / length);
                self.add(Block::around(at, STEP / 2.0));
                done += STEP;
            }
        }
    }

    /// Centre of the least occupied position beside `point` for a text, which then occupies it.
    pub(super) fn place_text(&mut self, text: &str, size: f64, point: (f64, f64)) -> (f64, f64) {
        let (half_width, half_height) = (text_width(text, size) / 2.0, 0.6 * size);
        // Nearer and higher positions come first and win ties.
        let sides = [
            (0.7, -0.7),
            (-0.7, -0.7),
            (0.7, 0.7),
            (-0.7, 0.7),
            (0.0, -1.0),
            (0.0, 1.0),
            (1.0, 0.0),
            (-1.0, 0.0),
        ];
        let spots = [8.0, 14.0, 21.0].into_iter().flat_map(|gap: f64| {
            sides.into_iter().map(move |(x, y): (f64, f64)| {
                let beside = if x == 0.0 { 0.0 } else { x.signum() * half_width };
                (point.0 + beside + gap * x, point.1 + y * (gap + half_height))
            })
        });
        let block = |(x, y): (f64, f64)| {
            Block::new(x - half_width, y - half_height, x + half_width, y + half_height)
        };
        let cost = |spot: (f64, f64)| {
            let block = block(spot);
            let outside = block.area() - block.overlap(&self.frame);
            4.0 * outside + self.blocks.iter().map(|other| block.overlap(other)).sum::<f64>()
        };
        let scored = spots.map(|spot| (cost(spot), spot));
        let best = scored.reduce(|best, next| if next.0 < best.0 - 1.0 { next } else { best });
        let spot = best.map_or(point, |(_, spot)| spot);
        self.add(block(spot));
        spot
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_avoid_what_is_there_and_stay_in_the_frame() {
        let mut occupied = Occupied::new(Block::new(0.0, 0.0, 200.0, 100.0));
        let point = (100.0, 50.0);
        occupied.add(Block::around(point, 4.0));
        let first = occupied.place_text("1,700", 10.0, point);
        let second = occupied.place_text("1,700", 10.0, point);
        assert!(first.0 > 100.0 && first.1 < 50.0);
        assert!((first.0 - second.0).abs() > 20.0 || (first.1 - second.1).abs() > 10.0);
        let corner = occupied.place_text("1,700", 10.0, (199.0, 1.0));
        assert!(corner.0 < 199.0 && corner.1 > 1.0);
    }
}
