//! Errors of a page.

use result_figures::finite::JsonError;

/// A page cannot be written.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum PageError {
    /// A number of a chart is NaN or infinite.
    #[error("a number of the page is not finite")]
    Number(#[from] JsonError),
    /// A number of a field is NaN or infinite.
    #[error(
        "the field `{layer}` has the value {value} in frame {frame}, which is not a finite number"
    )]
    Field {
        /// Name of the layer, or `position`.
        layer: String,
        /// Frame, from 0.
        frame: usize,
        /// The value.
        value: f64,
    },
    /// A frame has another number of values than its field has places.
    #[error("frame {frame} of the field `{layer}` has {found} values; {expected} are required")]
    Count {
        /// Name of the layer, or `position`.
        layer: String,
        /// Frame, from 0.
        frame: usize,
        /// Its number of values.
        found: usize,
        /// The required number.
        expected: usize,
    },
    /// The template engine returned an error.
    #[error("the template of the page")]
    Template(#[from] minijinja::Error),
}
