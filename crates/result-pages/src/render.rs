//! A page as HTML.

use minijinja::{AutoEscape, Environment, Value, context};
use result_figures::finite;
use result_figures::number::short;
use serde::Serialize;

use crate::answer::{Answer, Note};
use crate::chart::{Chart, Series};
use crate::error::PageError;
use crate::motion::{Motion, Packed};
use crate::page::{Fact, Page, SceneKey, Source};
use crate::table::{Cell, Table};

const TEMPLATE: &str = include_str!("../assets/page.html");
/// The style sheet of pages and reports.
pub const STYLE: &str = include_str!("../assets/style.css");
/// The program that sorts every table of class `sortable` by the button in a head.
pub const SORT: &str = include_str!("../assets/sort.js");
const CHARTS: &str = include_str!("../assets/charts.js");
const FIELDS: &str = include_str!("../assets/fields.js");
/// The program of the button `theme`, which changes between light and dark.
pub const THEME: &str = include_str!("../assets/theme.js");
const UPLOT: &str = include_str!("../assets/uplot/uPlot.iife.min.js");
const UPLOT_STYLE: &str = include_str!("../assets/uplot/uPlot.min.css");
const UPLOT_LICENCE: &str = include_str!("../assets/uplot/LICENSE");

/// Largest number of points of all charts together, at 100 bytes or so each.
const MOST_POINTS: usize = 6_000;

/// What the page's programs read.
#[derive(Serialize)]
struct Data<'a> {
    charts: &'a [Chart],
    motions: Vec<Packed>,
}

/// The page as one self-contained file.
///
/// Text is escaped: markup in a title is shown as it is written. The page forbids itself every request.
/// Of a page larger than [`Page::MOST_BYTES`] parts are left out, with a remark: half of the frames or rows of the largest field or
/// table.
///
/// # Errors
/// [`PageError`] for a number that is not finite, or a field with missing values.
pub fn render(page: &Page) -> Result<String, PageError> {
    let mut html = whole(page)?;
    let mut lighter = None;
    while html.len() > Page::MOST_BYTES && lighter.get_or_insert_with(|| page.clone()).lighten() {
        html = lighter.as_ref().map_or(Ok(html), whole)?;
    }
    Ok(html)
}

/// The page as it is.
fn whole(page: &Page) -> Result<String, PageError> {
    let mut environment = Environment::new();
    environment.set_auto_escape_callback(|_| AutoEscape::Html);
    environment.add_template("page.html", TEMPLATE)?;
    let motions = page.motions.iter().map(Motion::packed).collect::<Result<_, _>>()?;
    // A number that is not finite is refused although its point may not be shown.
    finite::check(&Data { charts: &page.charts, motions: Vec::new() })?;
    let (charts, every) = thinned(&page.charts);
    let data = script_text(&Data { charts: &charts, motions })?;
    let mut notes = page.notes.clone();
    // Warnings sort before remarks, and equal notes are shown once.
    notes.sort();
    notes.dedup();
    let html = environment.get_template("page.html")?.render(context! {
        style => Value::from_safe_string(format!("{UPLOT_STYLE}\n{STYLE}")),
        programs => Value::from_safe_string([THEME, SORT, CHARTS, FIELDS].join("\n")),
        uplot => Value::from_safe_string(UPLOT.to_owned()),
        uplot_licence => UPLOT_LICENCE,
        data => Value::from_safe_string(data),
        title => &page.title,
        solver => &page.solver,
        notes => notes.iter().map(note_value).collect::<Vec<_>>(),
        answers => page.answers.iter().map(answer_value).collect::<Vec<_>>(),
        charts => charts.iter().map(chart_value).collect::<Vec<_>>(),
        every => every,
        motions => page.motions.iter().map(motion_value).collect::<Vec<_>>(),
        absent => &page.absent,
        tables => page.tables.iter().map(table_value).collect::<Vec<_>>(),
        facts => page.facts.iter().map(fact_value).collect::<Vec<_>>(),
        scene => page.scene.iter().map(key_value).collect::<Vec<_>>(),
        sources => page.sources.iter().map(source_value).collect::<Vec<_>>(),
        files => &page.files,
        origin => &page.origin,
    })?;
    Ok(html)
}

/// The charts with at most [`MOST_POINTS`] points, and every how many of their points one is kept; the last ones are.
fn thinned(charts: &[Chart]) -> (Vec<Chart>, usize) {
    let n: usize = charts.iter().flat_map(|chart| &chart.series).map(|it| it.points.len()).sum();
    let every = n.div_ceil(MOST_POINTS).max(1);
    let mut charts = charts.to_vec();
    for series in charts.iter_mut().flat_map(|chart| &mut chart.series) {
        let mut left = series.points.len();
        series.points.retain(|_| {
            left -= 1;
            left.is_multiple_of(every)
        });
    }
    (charts, every)
}

/// JSON that may be the text of a `<script>`: no character of it can end or open a tag.
fn script_text(data: &impl Serialize) -> Result<String, PageError> {
    finite::check(data)?;
    let text = serde_json::to_string(data).map_err(finite::JsonError::from)?;
    Ok(text.replace('<', "\\u003c").replace('>', "\\u003e").replace('&', "\\u0026"))
}

fn note_value(note: &Note) -> Value {
    context! { is_warning => note.is_warning(), text => note.text() }
}

fn answer_value(answer: &Answer) -> Value {
    context! {
        quantity => &answer.quantity,
        at => &answer.at,
        value => answer.short_value(),
        error => answer.short_error(),
        relative => answer.relative_error(),
        unit => &answer.unit,
        how => &answer.how,
    }
}

/// The text of a chart for readers of the screen: ranges and last values.
fn chart_value(chart: &Chart) -> Value {
    let points = || chart.series.iter().flat_map(|series| &series.points);
    let (low, high) = points().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), it| {
        (low.min(it.x), high.max(it.x))
    });
    let last = |series: &Series| {
        let point = series.points.last()?;
        let answer = Answer {
            quantity: series.name.clone(),
            at: String::new(),
            value: point.y,
            error: point.error,
            bound: point.bound,
            unit: String::new(),
            how: point.how.clone(),
        };
        Some(format!("{}: {}", series.name, answer.value_and_error()))
    };
    let lasts: Vec<String> = chart.series.iter().filter_map(last).collect();
    let [low, high] = [low, high].map(|end| short(Some(end)));
    let ends = format!("{} from {low} to {high}", chart.x_label);
    let text = format!("{}, {ends}. Last values: {}.", chart.y_label, lasts.join("; "));
    context! { title => &chart.title, text => text }
}

fn motion_value(motion: &Motion) -> Value {
    let layers: Vec<String> = motion.layers.iter().map(|layer| layer.name.clone()).collect();
    context! {
        title => &motion.title,
        about => &motion.about,
        slider => &motion.slider,
        n_frames => motion.frames.len(),
        n_axes => motion.axes.len(),
        layers => layers,
    }
}

fn table_value(table: &Table) -> Value {
    let cell = |cell: &Cell| context! { text => &cell.text, number => cell.number };
    let row = |row: &Vec<Cell>| row.iter().map(cell).collect::<Vec<Value>>();
    context! {
        title => &table.title,
        about => &table.about,
        heads => &table.heads,
        rows => table.rows.iter().map(row).collect::<Vec<_>>(),
    }
}

fn fact_value(fact: &Fact) -> Value {
    context! { name => &fact.name, text => &fact.text }
}

fn key_value(key: &SceneKey) -> Value {
    context! {
        key => &key.key,
        value => &key.value,
        unit => &key.unit,
        is_default => key.is_default,
        meaning => &key.meaning,
    }
}

fn source_value(source: &Source) -> Value {
    context! { key => source.key, text => source.text, role => source.role }
}
