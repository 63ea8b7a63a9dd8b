//! Errors of a scene, displayed with their source by miette.

use miette::{Diagnostic, LabeledSpan, NamedSource, Severity, SourceCode, SourceSpan};

use crate::nearest::nearest;

/// Longest line that is displayed (bytes): a longer one, of a file without line breaks, hides what is said of it.
const WIDEST_DRAWN: usize = 400;

/// A name and its text.
#[derive(Debug, Clone)]
pub(super) struct Origin {
    pub(super) name: String,
    pub(super) text: String,
}

/// An invalid value and its location.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{message} (at `{path}`)")]
pub struct Objection {
    /// The key, e.g. `system.viscous_damper.intensity` or `times[3]`.
    pub path: String,
    /// Description, e.g. `the intensity is -0.2 m^2/s^3 and must not be negative`.
    pub message: String,
    /// Remedy, if known.
    pub help: Option<String>,
}

impl Objection {
    /// An objection to the value at `path`.
    #[must_use]
    pub fn new(path: impl Into<String>, message: impl Into<String>) -> Self {
        Self { path: path.into(), message: message.into(), help: None }
    }

    /// An objection to a name that is none of those known, with the nearest of them.
    #[must_use]
    pub fn unknown<'a>(
        path: impl Into<String>,
        what: &str,
        name: &str,
        known: impl IntoIterator<Item = &'a String>,
    ) -> Self {
        let known: Vec<&str> = known.into_iter().map(String::as_str).collect();
        Self::new(path, format!("there is no {what} `{name}`"))
            .with_nearest(name, &known, || format!("available: {}", known.join(", ")))
    }

    /// Adds the known name that is nearest to a misspelt one as a hint, else other words.
    #[must_use]
    pub fn with_nearest(
        self,
        name: &str,
        known: &[&str],
        otherwise: impl FnOnce() -> String,
    ) -> Self {
        let nearest = nearest(name, known.iter().copied());
        self.with_help(nearest.map_or_else(otherwise, |it| format!("did you mean `{it}`?")))
    }

    /// Adds a hint.
    #[must_use]
    pub fn with_help(self, help: impl Into<String>) -> Self {
        Self { help: Some(help.into()), ..self }
    }
}

/// An error inside the text.
#[derive(Debug, Clone)]
pub struct Mistake {
    /// Description of the error.
    pub message: String,
    /// Path of the key, e.g. `system.viscous_damper.intensity`; empty for the whole scene.
    pub path: String,
    /// Line, from 1.
    pub line: usize,
    /// Column in characters, from 1.
    pub column: usize,
    /// Suggestion.
    pub help: Option<String>,
    /// Displayed range; none on a line that is too long.
    pub(super) span: Option<SourceSpan>,
    pub(super) label: String,
    pub(super) source: NamedSource<String>,
}

/// Error of a scene file.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum SceneError {
    /// The file cannot be read.
    #[error("cannot read the scene {path}")]
    Unreadable {
        /// Its path.
        path: String,
        /// Error of the file system.
        source: std::io::Error,
    },
    /// The file is not text.
    #[error("the scene {path} is not UTF-8: byte {offset} is no character")]
    NotUtf8 {
        /// Its path.
        path: String,
        /// Offset of the first invalid byte, from 0.
        offset: usize,
    },
    /// The file is empty.
    #[error("the scene {path} is empty")]
    Empty {
        /// Its path.
        path: String,
    },
    /// An error at a line and column.
    #[error("{}", headline(.0))]
    Mistake(Box<Mistake>),
}

fn headline(mistake: &Mistake) -> String {
    let Mistake { message, path, line, column, .. } = mistake;
    let name = mistake.source.name();
    let key = if path.is_empty() { String::new() } else { format!(" (at `{path}`)") };
    format!("{message}{key}, {name} line {line} column {column}")
}

impl SceneError {
    /// The error, if it has a position in the text.
    #[must_use]
    pub fn mistake(&self) -> Option<&Mistake> {
        if let Self::Mistake(mistake) = self { Some(mistake) } else { None }
    }

    pub(super) fn at(
        origin: &Origin,
        path: &str,
        range: std::ops::Range<usize>,
        message: String,
        label: &str,
        help: Option<String>,
    ) -> Self {
        let (line, column) = line_and_column(&origin.text, range.start);
        let span = (range.start, range.end.saturating_sub(range.start)).into();
        Self::Mistake(Box::new(Mistake {
            message,
            path: path.to_owned(),
            line,
            column,
            help,
            span: (width(&origin.text, &range) <= WIDEST_DRAWN).then_some(span),
            label: label.into(),
            source: NamedSource::new(&origin.name, origin.text.clone()),
        }))
    }
}

impl Diagnostic for SceneError {
    fn severity(&self) -> Option<Severity> {
        Some(Severity::Error)
    }
    fn help(&self) -> Option<Box<dyn std::fmt::Display + '_>> {
        let help = self.mistake()?.help.as_ref()?;
        Some(Box::new(help))
    }
    fn source_code(&self) -> Option<&dyn SourceCode> {
        let mistake = self.mistake().filter(|mistake| mistake.span.is_some())?;
        Some(&mistake.source)
    }
    fn labels(&self) -> Option<Box<dyn Iterator<Item = LabeledSpan> + '_>> {
        let mistake = self.mistake()?;
        let label = LabeledSpan::new_with_span(Some(mistake.label.clone()), mistake.span?);
        Some(Box::new(std::iter::once(label)))
    }
}

/// Length in bytes of the longest line that overlaps a range.
fn width(text: &str, range: &std::ops::Range<usize>) -> usize {
    let [start, end] = [range.start, range.end].map(|at| at.min(text.len()));
    let before = text.as_bytes()[..start].iter().rev().take_while(|&&byte| byte != b'\n').count();
    let behind = text.as_bytes()[end..].iter().take_while(|&&byte| byte != b'\n').count();
    let lines = &text.as_bytes()[start - before..end.max(start) + behind];
    lines.split(|&byte| byte == b'\n').map(<[u8]>::len).max().unwrap_or(0)
}

/// Line and column, from 1, of a byte; columns count characters.
fn line_and_column(text: &str, offset: usize) -> (usize, usize) {
    let mut end = offset.min(text.len());
    while !text.is_char_boundary(end) {
        end -= 1;
    }
    let before = &text[..end];
    let line_start = before.rfind('\n').map_or(0, |newline| newline + 1);
    (before.matches('\n').count() + 1, before[line_start..].chars().count() + 1)
}
