//! The rows of a case: all claims where they are few, the worst of each family where they are many.

use result_figures::ErrorKind;
use result_figures::markdown::{self, text};
use result_figures::number::{self, counted};

use crate::report::{CaseRecord, Claim, ClaimKind};

/// Of more claims than this the worst are shown.
pub(super) const MOST_ROWS: usize = 12;

/// The table of a case and what it refers to.
pub(super) struct Rows {
    /// Markdown.
    pub(super) table: String,
    /// What is not in it.
    pub(super) left_out: Option<String>,
    /// The methods that its column `by` numbers, from 1.
    pub(super) methods: Vec<String>,
    /// The reasons that its column `why` numbers, from 1.
    pub(super) reasons: Vec<String>,
}

/// A claim that represents `count` of them.
struct Shown<'a> {
    claim: &'a Claim,
    count: usize,
}

pub(super) fn of_case(case: &CaseRecord) -> Rows {
    let (shown, left_out) = shown(case);
    let is_grouped = shown.iter().any(|shown| shown.count > 1);
    let (mut methods, mut reasons) = (Vec::new(), Vec::new());
    let mut rows = Vec::new();
    for Shown { claim, count } in &shown {
        let by = number_of(&mut methods, &claim.method);
        let why = number_of(&mut reasons, &claim.reason);
        let mut row = cells(claim, &case.id);
        row.splice(6..6, [by, why]);
        if is_grouped {
            row.insert(1, count.to_string());
        }
        rows.push(row);
    }
    let heads = [
        "claim",
        "quantity",
        "measured",
        "reference",
        "error",
        "tolerance",
        "by",
        "why",
        "used",
        "",
    ];
    let mut heads: Vec<String> = heads.map(str::to_owned).to_vec();
    if is_grouped {
        heads.insert(1, "of".to_owned());
    }
    Rows { table: markdown::table(&heads, &rows), left_out, methods, reasons }
}

/// What is shown of a case, and what is said of the rest.
fn shown(case: &CaseRecord) -> (Vec<Shown<'_>>, Option<String>) {
    if case.claims.len() <= MOST_ROWS {
        return (case.claims.iter().map(|claim| Shown { claim, count: 1 }).collect(), None);
    }
    let mut families = families(&case.claims);
    families.sort_by(|a, b| urgency(b.claim).total_cmp(&urgency(a.claim)));
    // What failed or falls short is never left out.
    let must = families.iter().filter(|shown| urgency(shown.claim) > 1.0).count();
    let rest = families.split_off(families.len().min(must.max(MOST_ROWS)));
    let n_rest: usize = rest.iter().map(|shown| shown.count).sum();
    let left_out = rest.first().map(|worst| {
        let used = percent(worst.claim.used());
        let (n_rest, n_families) = (counted(n_rest, "claim"), rest.len());
        format!("{n_rest} more, of {n_families} quantities or reasons; the worst used {used}")
    });
    (families, left_out)
}

/// The worst claim of each family, in the order in which they begin: one quantity, held for one reason, whatever the method.
/// A claim that failed or falls short has its own row.
fn families(claims: &[Claim]) -> Vec<Shown<'_>> {
    let mut families: Vec<Shown<'_>> = Vec::new();
    for claim in claims {
        let is_of =
            |shown: &&mut Shown<'_>| is_family(shown.claim, claim) && urgency(shown.claim) <= 1.0;
        let family = if urgency(claim) > 1.0 { None } else { families.iter_mut().find(is_of) };
        match family {
            Some(shown) => {
                shown.count += 1;
                if urgency(claim) > urgency(shown.claim) {
                    shown.claim = claim;
                }
            }
            None => families.push(Shown { claim, count: 1 }),
        }
    }
    families
}

fn is_family(a: &Claim, b: &Claim) -> bool {
    let same_measure = a.error_kind == b.error_kind && a.unit == b.unit;
    same_measure && a.quantity == b.quantity && a.grounds() == b.grounds()
}

/// Failed claims come before those that fall short, these before those that hold, and of these the one that used most of its
/// tolerance first; those that hold have at most 1.
fn urgency(claim: &Claim) -> f64 {
    if !claim.passed {
        3.0
    } else if claim.falls_short() {
        2.0
    } else {
        claim.used().unwrap_or(0.0).min(1.0)
    }
}

/// Name, quantity, measured, reference, error, tolerance, used, verdict.
fn cells(claim: &Claim, case_id: &str) -> Vec<String> {
    let name = claim.id.strip_prefix(case_id).unwrap_or(&claim.id).trim_start_matches('/');
    let unit = claim.unit.as_ref().map_or_else(String::new, |unit| format!(" ({unit})"));
    let kind = match (claim.error, claim.error_kind) {
        // A factor has its x.
        (None, _) | (_, ErrorKind::Ratio) => String::new(),
        (Some(_), kind) => format!(" {}", kind.name()),
    };
    vec![
        text(name),
        text(&format!("{}{unit}", claim.quantity)),
        number::with_uncertainty(claim.measured, claim.standard_error),
        number::with_uncertainty(claim.reference, claim.reference_error),
        format!("{}{kind}", number::error(claim.error, claim.error_kind)),
        number::short(claim.tolerance),
        match claim.kind {
            ClaimKind::RegressionBound => "regression bound".to_owned(),
            ClaimKind::Structural => "structural".to_owned(),
            ClaimKind::Accuracy => percent(claim.used()),
        },
        if claim.passed { "passed".to_owned() } else { "**failed**".to_owned() },
    ]
}

fn percent(used: Option<f64>) -> String {
    match used {
        None => "-".to_owned(),
        Some(used) if used > 0.0 && used < 0.01 => "under 1 %".to_owned(),
        Some(used) => format!("{:.0} %", 100.0 * used),
    }
}

/// The number of `words` in `list`, which takes them in if they are new.
fn number_of(list: &mut Vec<String>, words: &str) -> String {
    if words.is_empty() {
        return String::new();
    }
    let place = list.iter().position(|known| known == words).unwrap_or_else(|| {
        list.push(words.to_owned());
        list.len() - 1
    });
    (place + 1).to_string()
}
