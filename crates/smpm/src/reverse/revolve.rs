//! Which states of a run are kept, so that its steps can be reversed one by one within a limit on memory.

/// What to do next in the reversal of a run.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum RevolveAction {
    /// Keep the present state in a slot.
    Keep {
        /// The slot.
        slot: usize,
    },
    /// Return to the state in a slot.
    Return {
        /// The slot.
        slot: usize,
    },
    /// Run forward to the begin of a step, from 0.
    Advance {
        /// The step.
        to: usize,
    },
    /// Reverse a step, from its begin, where the run is.
    Reverse {
        /// The step.
        step: usize,
    },
}

/// `beta(s, r) = (s + r)!/(s! r!)`: the most steps that can be reversed with `s` slots and `r` repetitions.
fn most_steps(slots: usize, repetitions: usize) -> usize {
    let fewer = slots.min(repetitions);
    let mut product = 1_usize;
    for k in 1..=fewer {
        let Some(next) = product.checked_mul(slots + repetitions - fewer + k) else {
            return usize::MAX;
        };
        product = next / k;
    }
    product
}

/// The fewest repetitions with which so many slots suffice for `n` steps.
fn repetitions(n: usize, slots: usize) -> usize {
    // With one slot as many as there are steps.
    (0..n).find(|&r| most_steps(slots, r) >= n).unwrap_or(0)
}

/// The fewest steps forward with which a run of `n` steps is reversed with so many slots, one of them for its start:
///
/// $$ t(n, s) = r n - \beta(s + 1, r - 1), \qquad \beta(s, r - 1) < n \le \beta(s, r), \quad
///    \beta(s, r) = \frac{(s + r)!}{s! \, r!} $$
///
/// Symbols: `n` = steps; `s` = slots; `r` = how often a step is run forward at most. What is needed to reverse a step is
/// computed from the state at its begin and is not counted.
///
/// Source: Griewank and Walther 2000 (Algorithm 799, Revolve).
#[must_use]
pub fn fewest_advances(n_steps: usize, slots: usize) -> usize {
    match repetitions(n_steps, slots) {
        0 => 0,
        r => r * n_steps - most_steps(slots + 1, r - 1),
    }
}

/// Calls with what reverses a run of `n` steps by the fewest steps forward ([`fewest_advances`]), from its start, with so many
/// slots, at least one. A slot is free again when all steps behind it are reversed.
///
/// # Errors
/// The first that the function returns.
pub fn revolve<E>(
    n_steps: usize,
    slots: usize,
    act: &mut impl FnMut(RevolveAction) -> Result<(), E>,
) -> Result<(), E> {
    if n_steps == 0 {
        return Ok(());
    }
    act(RevolveAction::Keep { slot: 0 })?;
    reverse(0..n_steps, (0, slots.max(1)), act)
}

/// Reverses steps whose begin is the present state, kept in slot `first` of the slots `first..end`.
fn reverse<E>(
    steps: std::ops::Range<usize>,
    (first, end): (usize, usize),
    act: &mut impl FnMut(RevolveAction) -> Result<(), E>,
) -> Result<(), E> {
    let (n, slots) = (steps.len(), end - first);
    if n == 1 {
        return act(RevolveAction::Reverse { step: steps.start });
    }
    if slots == 1 {
        for step in steps.clone().rev() {
            if step + 1 < steps.end {
                act(RevolveAction::Return { slot: first })?;
            }
            if step > steps.start {
                act(RevolveAction::Advance { to: step })?;
            }
            act(RevolveAction::Reverse { step })?;
        }
        return Ok(());
    }
    // The largest of the optimal distances to the next slot: few states are kept twice.
    let r = repetitions(n, slots);
    let distance = most_steps(slots, r - 1).min(n - most_steps(slots - 1, r - 1));
    let middle = steps.start + distance;
    act(RevolveAction::Advance { to: middle })?;
    act(RevolveAction::Keep { slot: first + 1 })?;
    reverse(middle..steps.end, (first + 1, end), act)?;
    act(RevolveAction::Return { slot: first })?;
    reverse(steps.start..middle, (first, end), act)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Runs the schedule, and counts its steps forward.
    fn count(n: usize, slots: usize) -> usize {
        let (mut kept, mut at, mut advanced, mut next) = (vec![None; slots], 0, 0, n);
        revolve::<()>(n, slots, &mut |action| {
            match action {
                RevolveAction::Keep { slot } => kept[slot] = Some(at),
                RevolveAction::Return { slot } => at = kept[slot].unwrap(),
                RevolveAction::Advance { to } => {
                    assert!(to > at);
                    advanced += to - at;
                    at = to;
                }
                RevolveAction::Reverse { step } => {
                    assert_eq!((step, step + 1), (at, next), "{n} {slots}");
                    next = step;
                }
            }
            Ok(())
        })
        .unwrap();
        assert_eq!(next, 0);
        advanced
    }

    #[test]
    fn the_steps_forward_are_those_of_the_formula_and_no_schedule_needs_fewer() {
        // t(n, s) = min over m of m + t(n - m, s - 1) + t(m, s), by tables.
        const N: usize = 90;
        let mut least = vec![vec![0_usize; N + 1]; 8];
        for n in 2..=N {
            least[1][n] = n * (n - 1) / 2;
        }
        for s in 2..8 {
            for n in 2..=N {
                let of = |m: usize| m + least[s - 1][n - m] + least[s][m];
                least[s][n] = (1..n).map(of).min().unwrap();
            }
        }
        for s in 1..8 {
            for n in 1..=N {
                assert_eq!(fewest_advances(n, s), least[s][n], "{n} {s}");
                assert_eq!(count(n, s), least[s][n], "{n} {s}");
            }
        }
    }

    #[test]
    fn with_a_slot_for_every_step_each_is_run_once() {
        assert_eq!((count(300, 300), fewest_advances(300, 300)), (299, 299));
        // Griewank and Walther: 1,771 steps with 20 slots take 3 repetitions.
        assert_eq!((most_steps(20, 3), repetitions(1771, 20), repetitions(1772, 20)), (1771, 3, 4));
        assert_eq!(count(5000, 20), fewest_advances(5000, 20));
        assert_eq!(count(1, 1), 0);
        assert_eq!(count(0, 3), 0);
    }
}
