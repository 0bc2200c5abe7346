//! What a picture has covered so far, by cells: names are placed among their neighbours, however many there are elsewhere.

use std::collections::HashMap;

use crate::svg::PictureFrame;

/// Side of a cell [px].
const CELL: f64 = 40.0;
/// Where so many frames lie in a cell nothing can be read, wherever the next name stands.
const CROWD: usize = 64;

#[derive(Debug, Default)]
pub(super) struct Covered {
    frames: Vec<PictureFrame>,
    /// The frames that reach into each cell.
    cells: HashMap<[i64; 2], Vec<usize>>,
}

impl Covered {
    pub fn add(&mut self, frame: PictureFrame) {
        for cell in cells(&frame) {
            let frames = self.cells.entry(cell).or_default();
            if frames.len() < CROWD {
                frames.push(self.frames.len());
            }
        }
        self.frames.push(frame);
    }

    /// The area that a frame has in common with all of them, crowds aside.
    pub fn overlap(&self, frame: &PictureFrame) -> f64 {
        let mut near: Vec<usize> = cells(frame).filter_map(|cell| self.cells.get(&cell)).flatten().copied().collect();
        near.sort_unstable();
        near.dedup();
        near.into_iter().map(|index| frame.overlap(&self.frames[index])).sum()
    }

    pub fn frames(&self) -> &[PictureFrame] {
        &self.frames
    }
}

/// The cells that a frame reaches into.
fn cells(frame: &PictureFrame) -> impl Iterator<Item = [i64; 2]> + use<> {
    let range = |start: f64, length: f64| [start, start + length].map(|end| (end / CELL).floor() as i64);
    let ([left, right], [top, bottom]) = (range(frame.x, frame.width), range(frame.y, frame.height));
    (left..=right).flat_map(move |x| (top..=bottom).map(move |y| [x, y]))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::alike::Alike;

    #[test]
    fn the_area_in_common_is_that_with_every_frame() {
        let place = |k: usize| {
            let wave = |pace: f64| 90.0 * (pace * (k + 1) as f64).sine();
            PictureFrame {
                x: wave(0.7),
                y: wave(1.9),
                width: 1.0 + wave(2.3).abs(),
                height: 1.0 + 0.3 * wave(3.1).abs(),
            }
        };
        let mut covered = Covered::default();
        for k in 0..CROWD {
            let frame = place(k);
            let expected: f64 = covered.frames().iter().map(|other| frame.overlap(other)).sum();
            assert_eq!(covered.overlap(&frame), expected, "{k}");
            covered.add(frame);
        }
    }
}
