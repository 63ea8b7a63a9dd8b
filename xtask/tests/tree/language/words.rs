//! The words that this project does not use, and the field's words in their place.

/// Words of the same meaning, and what to write instead.
pub(crate) struct Entry {
    /// In small letters. A `*` at the end of a word stands for any ending.
    pub(crate) avoid: &'static [&'static str],
    pub(crate) write: &'static str,
}

const fn entry(avoid: &'static [&'static str], write: &'static str) -> Entry {
    Entry { avoid, write }
}

/// Phrases that a reader of the field would have to translate.
pub(crate) const ENTRIES: &[Entry] = &[
    entry(&["mean run", "mean runs"], "reference run (all parameters at their means)"),
    entry(&["initial law", "initial laws"], "initial distribution, initial density"),
    entry(&["fresh lattice", "fresh lattices", "lay a lattice"], "remeshing; a new lattice"),
    entry(&["gift", "gifts"], "particle-to-grid transfer (P2G)"),
    entry(&["grip", "grips"], "prescribed displacement; boundary condition"),
    entry(&["ledger", "ledgers"], "conserved totals"),
    entry(&["plain step", "plain steps"], "hand-written baseline"),
    entry(&["plain number", "plain numbers"], "`f64`"),
    entry(&["tell", "tells", "told", "telling"], "report, print, return"),
    entry(&["stands", "stand", "stood"], "is; is stored; is in"),
    entry(&["to roundoff"], "within roundoff"),
    entry(&["the same bits", "to the bit"], "bitwise identical"),
    entry(&["seam", "seams"], "interface; extension trait"),
    entry(&["growth of a bond"], "relative squared elongation"),
    entry(&["window of the noise"], "modulating function (window)"),
    entry(&["ripple", "ripples"], "post-shock oscillation"),
    entry(&["c.v."], "coefficient of variation"),
    entry(&["as measured bands", "band of as measured"], "regression bounds"),
    entry(&["goes on with", "goes on from", "go on with", "go on from"], "continues; resumes"),
    entry(&["come to its end", "came to its end", "comes to its end"], "finished; ends"),
    entry(&["of themselves"], "(name the statistics)"),
    entry(&["pulled apart", "pull apart"], "loaded in tension"),
    entry(&["looked after"], "checked"),
    entry(&["whence"], "so; from which"),
    entry(&["again and again"], "repeatedly"),
    entry(&["is had", "are had", "was had"], "is computed"),
    entry(&["hears", "hear"], "receives; observes"),
    entry(&["does not forget"], "has no stationary state"),
    entry(&["seen, without a claim"], "measured once; no claim holds it"),
    entry(&["way of a shell"], "history of a bond"),
    entry(&["who is", "who are", "who enters", "who stands"], "which; name the thing"),
];

/// Forms of verbs in comments, by which a sentence is complete.
pub(crate) const VERBS: &[&str] = &[
    "act", "add", "advance", "affect", "allow", "appear", "apply", "are", "ascend", "ask", "be",
    "became", "become", "been", "begin", "being", "belong", "break", "came", "can", "cannot",
    "carry", "change", "come", "contain", "cost", "costs", "could", "count", "depend", "did",
    "differ", "do", "does", "draw", "end", "equals", "exceed", "excites", "exist", "fail", "find",
    "fix", "follow", "get", "give", "gives", "go", "got", "has", "have", "hold", "holds", "ignore",
    "include", "is", "keep", "kept", "know", "let", "lie", "lose", "make", "makes", "may", "mean",
    "move", "must", "need", "needs", "panic", "ran", "reach", "read", "reads", "remain", "require",
    "return", "returns", "run", "runs", "said", "save", "say", "see", "serve", "should", "show",
    "solves", "start", "stay", "sum", "take", "takes", "took", "use", "uses", "vanish", "was",
    "went", "were", "will", "win", "work", "would", "write",
];

/// Words that end in `s` and are hardly ever verbs.
pub(crate) const NO_VERBS: &[&str] = &[
    "across",
    "afterwards",
    "always",
    "analysis",
    "axis",
    "basis",
    "besides",
    "bias",
    "bytes",
    "class",
    "its",
    "lens",
    "less",
    "mass",
    "minus",
    "moments",
    "names",
    "numbers",
    "otherwise",
    "plus",
    "process",
    "radius",
    "samples",
    "series",
    "states",
    "stress",
    "this",
    "threads",
    "thus",
    "towards",
    "units",
    "values",
    "words",
];
