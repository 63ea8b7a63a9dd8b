//! The marginal densities of a run as moving fields of its page.

use result_figures::{Drawing, Plane};
use result_pages::{Cells, Frame, Layer, Motion, Place, Scale};
use serde_json::Value;

use super::findings;
use crate::findings::Findings;

/// Start of the name of a plane's drawing.
const PLANE: &str = "plane-";

/// Findings of a density scene, with the key that turns on what its page could show.
pub(super) fn findings(result: &Value) -> Result<Findings, serde_json::Error> {
    let mut found = findings::findings(result)?;
    let scene = &result["scene"];
    if scene["planes"].is_null() {
        let text = "The density over time is not shown: the key \"planes\" of the scene names planes of two states, and times. \
                    The density methods have it.";
        found.absent.push(text.to_owned());
    }
    Ok(found)
}

/// A field for each plane that was drawn, its times in order.
pub(super) fn motions(drawings: &[Drawing]) -> Result<Vec<Motion>, serde_json::Error> {
    let mut planes: Vec<(&str, Vec<(&str, &Drawing)>)> = Vec::new();
    for drawing in drawings {
        let Some((name, t)) = drawing.name.rsplit_once("-t") else { continue };
        if !name.starts_with(PLANE) {
            continue;
        }
        match planes.iter_mut().find(|(known, _)| *known == name) {
            Some((_, frames)) => frames.push((t, drawing)),
            None => planes.push((name, vec![(t, drawing)])),
        }
    }
    let n = planes.len();
    planes.iter().map(|(_, frames)| motion(frames, n)).collect()
}

/// A plane; the budget of the page is shared by `n_planes`.
fn motion(drawn: &[(&str, &Drawing)], n_planes: usize) -> Result<Motion, serde_json::Error> {
    let read = |(t, drawing): &(&str, &Drawing)| {
        Ok(((*t).to_owned(), serde_json::from_str::<Plane>(&drawing.data)?))
    };
    let first = read(&drawn[0])?.1;
    let bytes = n_planes * first.values.iter().map(Vec::len).sum::<usize>();
    let shown = Motion::shown_frames(drawn.len(), Motion::BUDGET / bytes.max(1));
    let about = match drawn.len() - shown.len() {
        0 => String::new(),
        left_out => format!("{left_out} of {} times are left out.", drawn.len()),
    };
    let (mut frames, mut cells, mut values) = (Vec::new(), Vec::new(), Vec::new());
    for k in shown {
        let (t, plane) = read(&drawn[k])?;
        let ends = |edges: &[f64]| [edges[0], edges[edges.len() - 1]];
        let count = [plane.x.len() - 1, plane.y.len() - 1];
        cells.push(Cells { count, x: ends(&plane.x), y: ends(&plane.y) });
        #[expect(clippy::cast_possible_truncation, reason = "a byte is what is shown of it")]
        let packed = plane.values.iter().flatten().map(|&value| value as f32).collect();
        values.push(packed);
        frames.push(Frame {
            name: format!("t = {} s", t.trim_end_matches('0').trim_end_matches('.')),
        });
    }
    let [across, up] = [&first.words.x_label, &first.words.y_label];
    let smoothing = first.words.caption.first().cloned().unwrap_or_default();
    let layer =
        Layer { name: "density".to_owned(), unit: String::new(), scale: Scale::SixDecades, values };
    Ok(Motion {
        title: format!("Marginal density of {across} and {up}"),
        about: format!("{smoothing} {about}").trim().to_owned(),
        slider: "time".to_owned(),
        axes: vec![across.clone(), up.clone()],
        frames,
        place: Place::Cells(cells),
        layers: vec![layer],
    })
}
