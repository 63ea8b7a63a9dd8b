//! Suggestions for misspelt names.

/// The candidate most similar to `word`, if its similarity suffices.
#[must_use]
pub fn nearest<'a>(word: &str, candidates: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    // Similarity below which a suggestion misleads more often than it helps.
    const LIKE_ENOUGH: f64 = 0.6;
    let scored = candidates.into_iter().map(|candidate| (similarity(word, candidate), candidate));
    let best = scored.reduce(|best, next| if next.0 > best.0 { next } else { best })?;
    (best.0 >= LIKE_ENOUGH).then_some(best.1)
}

fn similarity(a: &str, b: &str) -> f64 {
    let (a, b) = (a.to_lowercase(), b.to_lowercase());
    strsim::normalized_damerau_levenshtein(&a, &b)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_slip_finds_its_word_and_noise_finds_none() {
        let words = ["intensity", "frequency", "smoothing_length"];
        assert_eq!(nearest("intensty", words), Some("intensity"));
        assert_eq!(nearest("Frequency", words), Some("frequency"));
        assert_eq!(nearest("colour", words), None);
        assert_eq!(nearest("x", []), None);
    }
}
