//! Names that scenes had once, each with its successor.

/// A removed name and its successor. An unknown name that a scene had once is reported with its successor in place of the
/// known names.
#[derive(Debug, Clone, Copy)]
pub struct Retired {
    /// The end of its path, from the key that holds it: `method.log_density_fit`, or `lattice.overlap` for a key.
    pub path: &'static str,
    /// What to use, after the words "use": a name and a reason with a measurement.
    pub successor: &'static str,
}

/// The entry of a name by the path at which a scene has it.
pub(super) fn retired_at<'a>(retired: &'a [Retired], path: &str) -> Option<&'a Retired> {
    let is_end = |end: &str| {
        path.strip_suffix(end).is_some_and(|before| before.is_empty() || before.ends_with('.'))
    };
    retired.iter().find(|it| is_end(it.path))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_name_is_retired_under_its_key_alone() {
        let retired =
            ["method.log_density_fit", "scheme.heun"].map(|path| Retired { path, successor: "" });
        let is_retired = |path: &str| retired_at(&retired, path).is_some();
        assert!(is_retired("method.log_density_fit"));
        assert!(is_retired("method.flow_map_fit.scheme.heun"));
        assert!(!is_retired("system.log_density_fit"));
        assert!(!is_retired("method.flow_map_fit.my_scheme.heun"));
    }
}
