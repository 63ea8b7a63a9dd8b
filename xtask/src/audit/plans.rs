//! What each check starts, or why it cannot.

use super::surroundings::Surroundings;

/// The oldest Rust that the workspace names.
const RUST_VERSION: &str = env!("CARGO_PKG_RUST_VERSION");

/// The crates whose tests are quick: a mutant costs a build and a run of them.
const SMALL_CRATES: [&str; 2] = ["smoothing-kernels", "particle-store"];

/// Each target of cargo-fuzz ends after so many inputs, or so many seconds; an input that takes longer than the last is a hang.
const FUZZ_RUNS: u32 = 1_000_000;
const FUZZ_SECONDS: u32 = 600;
const FUZZ_TIMEOUT: u32 = 60;

/// What a check does.
#[derive(Debug, PartialEq)]
pub(super) enum Plan {
    /// Programs with their arguments, one after the other; the first that fails ends the check.
    Start(Vec<Vec<String>>),
    /// Nothing, for this reason.
    Skip(String),
}

/// One of the tests of this package, so that `.ci/run` holds it too.
pub(super) fn language(_: &Surroundings) -> Plan {
    start("cargo test --package xtask --test language", &[])
}

pub(super) fn deny(_: &Surroundings) -> Plan {
    start("cargo deny check", &[])
}

pub(super) fn features(surroundings: &Surroundings) -> Plan {
    // MPI need not be there.
    let command = "cargo hack check --feature-powerset --exclude-features mpi --no-dev-deps";
    start(command, &packages(&surroundings.crates))
}

pub(super) fn semver(surroundings: &Surroundings) -> Plan {
    match surroundings.release_tags.lines().next() {
        Some(tag) => start("cargo semver-checks --workspace --baseline-rev", &[tag.to_owned()]),
        None => Plan::Skip("no tag v* of a release to compare with".to_owned()),
    }
}

pub(super) fn coverage(surroundings: &Surroundings) -> Plan {
    start("cargo llvm-cov --summary-only", &packages(&surroundings.crates))
}

pub(super) fn mutants(_: &Surroundings) -> Plan {
    start("cargo mutants --output target", &packages(&SMALL_CRATES.map(str::to_owned)))
}

pub(super) fn claims(_: &Surroundings) -> Plan {
    start("cargo xtask audit claims", &[])
}

pub(super) fn any_input(_: &Surroundings) -> Plan {
    start("cargo --config env.PROPTEST_CASES='1000000' test --release --test any_input", &[])
}

pub(super) fn resume(_: &Surroundings) -> Plan {
    start("cargo xtask verify run/resume --full", &[])
}

/// Without a sanitizer, so that the stable toolchain does; inputs of any length from the first, since a snapshot is one.
pub(super) fn fuzz(surroundings: &Surroundings) -> Plan {
    let limits = format!(
        "-- -runs={FUZZ_RUNS} -max_total_time={FUZZ_SECONDS} -timeout={FUZZ_TIMEOUT} -len_control=0 -max_len=16384"
    );
    let of = |target: &String| {
        words(&format!("cargo fuzz run --fuzz-dir tests/fuzz --sanitizer none {target} {limits}"))
    };
    Plan::Start(surroundings.fuzz_targets.iter().map(of).collect())
}

/// What `.ci/run` does with the other benchmarks.
pub(super) fn rivals(_: &Surroundings) -> Plan {
    let lint = "cargo clippy --workspace --all-targets --features benches/rivals -- -D warnings";
    let run = "cargo test --workspace --features benches/rivals --bench neighbour --bench particles -- --test";
    Plan::Start([lint, run].map(words).to_vec())
}

pub(super) fn msrv(surroundings: &Surroundings) -> Plan {
    match toolchain(&surroundings.toolchains, RUST_VERSION) {
        Some(name) => {
            start(&format!("rustup run {name} cargo check --locked --workspace --all-targets"), &[])
        }
        None => Plan::Skip(format!("rustup has no toolchain {RUST_VERSION}")),
    }
}

pub(super) fn publish(_: &Surroundings) -> Plan {
    start("cargo publish --locked --workspace --dry-run", &[])
}

/// One program: these words, then these arguments.
fn start(text: &str, arguments: &[String]) -> Plan {
    Plan::Start(vec![[words(text), arguments.to_vec()].concat()])
}

fn words(text: &str) -> Vec<String> {
    text.split_whitespace().map(str::to_owned).collect()
}

fn packages(names: &[String]) -> Vec<String> {
    names.iter().flat_map(|name| ["--package".to_owned(), name.clone()]).collect()
}

/// The name of a toolchain of this version, of any patch level, in what `rustup toolchain list` prints.
fn toolchain<'a>(list: &'a str, version: &str) -> Option<&'a str> {
    let is_of_version = |name: &&str| match name.strip_prefix(version) {
        Some(rest) => rest.is_empty() || rest.starts_with(['.', '-']),
        None => false,
    };
    list.lines().filter_map(|line| line.split_whitespace().next()).find(is_of_version)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn surroundings() -> Surroundings {
        Surroundings {
            crates: vec!["smpm".to_owned()],
            fuzz_targets: vec!["smpm_bodies".to_owned(), "sde_field".to_owned()],
            toolchains: String::new(),
            release_tags: String::new(),
        }
    }

    fn plan(text: &str) -> Plan {
        start(text, &[])
    }

    #[test]
    fn the_feature_matrix_is_of_the_crates_that_are_there() {
        let expected = "cargo hack check --feature-powerset --exclude-features mpi --no-dev-deps --package smpm";
        assert_eq!(features(&surroundings()), plan(expected));
    }

    #[test]
    fn interfaces_are_compared_with_the_newest_release() {
        let tagged = Surroundings { release_tags: "v0.2.0\nv0.1.0\n".to_owned(), ..surroundings() };
        let expected = "cargo semver-checks --workspace --baseline-rev v0.2.0";
        assert_eq!(semver(&tagged), plan(expected));
    }

    #[test]
    fn before_the_first_release_interfaces_are_not_compared() {
        assert!(matches!(semver(&surroundings()), Plan::Skip(_)));
    }

    #[test]
    fn the_oldest_rust_is_found_at_any_patch_level_and_by_no_other_number() {
        let list = "stable-x86_64-unknown-linux-gnu (active, default)\n\
                    1.890.0-x86_64-unknown-linux-gnu\n1.89.1-x86_64-unknown-linux-gnu\n";
        assert_eq!(toolchain(list, "1.89"), Some("1.89.1-x86_64-unknown-linux-gnu"));
        assert_eq!(toolchain("1.89-x86_64-apple-darwin", "1.89"), Some("1.89-x86_64-apple-darwin"));
        assert_eq!(toolchain(list, "1.8"), None);
        assert_eq!(toolchain("", "1.89"), None);
    }

    #[test]
    fn without_the_oldest_rust_its_check_says_which_is_missing() {
        let Plan::Skip(reason) = msrv(&surroundings()) else { panic!("starts something") };
        assert!(reason.contains(RUST_VERSION), "{reason}");
    }

    #[test]
    fn every_target_of_cargo_fuzz_is_run_by_itself() {
        let Plan::Start(runs) = fuzz(&surroundings()) else { panic!("starts nothing") };
        let start = words("cargo fuzz run --fuzz-dir tests/fuzz --sanitizer none");
        for (run, target) in runs.iter().zip(["smpm_bodies", "sde_field"]) {
            assert_eq!(run[..start.len()], start);
            assert_eq!(run[start.len()], target);
        }
        assert_eq!(runs.len(), 2);
    }

    #[test]
    fn mutants_are_made_of_crates_that_exist() {
        let here = Surroundings::look().unwrap().crates;
        assert!(SMALL_CRATES.iter().all(|name| here.iter().any(|known| known == name)), "{here:?}");
    }
}
