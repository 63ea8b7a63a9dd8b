//! Frames, fields and rows that are left out of a page that is too large.

use crate::answer::Note;
use crate::motion::{Motion, Place};
use crate::page::Page;
use crate::table::Table;

/// Fewest frames that are halved.
const FEW_FRAMES: usize = 3;
/// Fewest rows of a table that are halved.
const FEW_ROWS: usize = 20;

impl Page {
    /// Largest page (bytes).
    pub const MOST_BYTES: usize = 3_000_000;

    /// Leaves out a part of the largest field or table, with a remark: half of the frames, the field if it has few, or half of the
    /// rows. Returns whether there was such a part.
    pub(crate) fn lighten(&mut self) -> bool {
        let field = self.motions.iter_mut().enumerate().max_by_key(|(_, field)| field.n_bytes());
        let table = self.tables.iter_mut().filter(|table| table.rows.len() >= FEW_ROWS);
        let table = table.max_by_key(|table| table.n_bytes());
        let what = match (field, table) {
            (None, None) => return false,
            (Some((_, field)), Some(table)) if table.n_bytes() > field.n_bytes() => table.halve(),
            (None, Some(table)) => table.halve(),
            (Some((_, field)), _) if field.frames.len() >= FEW_FRAMES => field.halve(),
            (Some((number, _)), _) => format!("\"{}\"", self.motions.remove(number).title),
        };
        let note = Note::Remark(format!(
            "left out: {what}, since this page would be larger than {} MB; the files have all",
            Self::MOST_BYTES / 1_000_000
        ));
        if !self.notes.contains(&note) {
            self.notes.push(note);
        }
        true
    }
}

impl Table {
    /// About what its rows take.
    fn n_bytes(&self) -> usize {
        const TAGS: usize = 30;
        self.rows.iter().flatten().map(|cell| cell.text.len() + TAGS).sum()
    }

    /// The first half of its rows; says what is left out.
    fn halve(&mut self) -> String {
        self.rows.truncate(self.rows.len() / 2);
        format!("the last rows of \"{}\"", self.title)
    }
}

impl Motion {
    /// About what its values take.
    fn n_bytes(&self) -> usize {
        let layers = self.layers.iter().flat_map(|layer| &layer.values).map(Vec::len);
        let places = match &self.place {
            Place::Cells(_) => 0,
            Place::Points(points) => 2 * points.positions.iter().map(Vec::len).sum::<usize>(),
        };
        // Four characters for three bytes.
        (layers.sum::<usize>() + places) * 4 / 3
    }

    /// Every other frame, the last one among them; says what is left out.
    fn halve(&mut self) -> String {
        let n = self.frames.len();
        every_other(&mut self.frames, n);
        match &mut self.place {
            Place::Cells(cells) => every_other(cells, n),
            Place::Points(points) => every_other(&mut points.positions, n),
        }
        self.layers.iter_mut().for_each(|layer| every_other(&mut layer.values, n));
        format!("frames of \"{}\"", self.title)
    }
}

/// Every other entry, the last one among them, unless there is one for all `n` frames.
fn every_other<T>(entries: &mut Vec<T>, n: usize) {
    if entries.len() != n {
        return;
    }
    let mut left = n;
    entries.retain(|_| {
        left -= 1;
        left.is_multiple_of(2)
    });
}
