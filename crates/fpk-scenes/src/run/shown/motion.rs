//! The marginal densities of a run as moving fields of its page.

use result_pages::{Cells, Frame, Layer, Motion, Place, Scale};

use super::pictures::PlaneAt;

/// The note that names the key for the density over time.
pub(crate) const ABSENT: &str = "The density over time is not shown: the key \"planes\" of the scene names planes of two states, and times. \
                                The density methods have it.";

/// A field for each plane that was observed, its times in order.
pub(crate) fn motions(observed: &[PlaneAt]) -> Vec<Motion> {
    let mut planes: Vec<Vec<&PlaneAt>> = Vec::new();
    for plane in observed {
        match planes.iter_mut().find(|known| known[0].states == plane.states) {
            Some(frames) => frames.push(plane),
            None => planes.push(vec![plane]),
        }
    }
    let n = planes.len();
    planes.iter().map(|frames| motion(frames, n)).collect()
}

/// A plane over time; the budget of the page is shared by `n_planes`.
fn motion(observed: &[&PlaneAt], n_planes: usize) -> Motion {
    let first = &observed[0].chart;
    let bytes = n_planes * first.values.iter().map(Vec::len).sum::<usize>();
    let shown = Motion::shown_frames(observed.len(), Motion::BUDGET / bytes.max(1));
    let about = match observed.len() - shown.len() {
        0 => String::new(),
        left_out => format!("{left_out} of {} times are left out.", observed.len()),
    };
    let (mut frames, mut cells, mut values) = (Vec::new(), Vec::new(), Vec::new());
    for PlaneAt { t, chart, .. } in shown.into_iter().map(|k| observed[k]) {
        let ends = |edges: &[f64]| [edges[0], edges[edges.len() - 1]];
        let count = [chart.x.len() - 1, chart.y.len() - 1];
        cells.push(Cells { count, x: ends(&chart.x), y: ends(&chart.y) });
        #[expect(clippy::cast_possible_truncation, reason = "a byte is what is shown of it")]
        let packed = chart.values.iter().flatten().map(|&value| value as f32).collect();
        values.push(packed);
        let t = format!("{t:.3}");
        frames.push(Frame {
            name: format!("t = {} s", t.trim_end_matches('0').trim_end_matches('.')),
        });
    }
    let [across, up] = [&first.words.x_label, &first.words.y_label];
    let smoothing = first.words.caption.first().cloned().unwrap_or_default();
    let layer =
        Layer { name: "density".to_owned(), unit: String::new(), scale: Scale::SixDecades, values };
    Motion {
        title: format!("Marginal density of {across} and {up}"),
        about: format!("{smoothing} {about}").trim().to_owned(),
        slider: "time".to_owned(),
        axes: vec![across.clone(), up.clone()],
        frames,
        place: Place::Cells(cells),
        layers: vec![layer],
    }
}
