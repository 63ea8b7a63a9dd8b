//! What each check starts, or why it cannot.

use super::surroundings::Surroundings;

/// The oldest Rust that the workspace names.
const RUST_VERSION: &str = env!("CARGO_PKG_RUST_VERSION");

/// The crates whose tests are quick: a mutant costs a build and a run of them.
const SMALL_CRATES: [&str; 2] = ["smoothing-kernels", "particle-store"];

/// What a check does.
#[derive(Debug, PartialEq)]
pub(super) enum Plan {
    /// A program and its arguments.
    Start(Vec<String>),
    /// Nothing, for this reason.
    Skip(String),
}

pub(super) fn deny(_: &Surroundings) -> Plan {
    start("cargo deny check", &[])
}

pub(super) fn features(surroundings: &Surroundings) -> Plan {
    start("cargo hack check --feature-powerset --no-dev-deps", &packages(&surroundings.crates))
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

pub(super) fn any_input(_: &Surroundings) -> Plan {
    start("cargo --config env.PROPTEST_CASES='1000000' test --release --test any_input", &[])
}

pub(super) fn resume(_: &Surroundings) -> Plan {
    start("cargo xtask verify run/resume --full", &[])
}

pub(super) fn fuzz(_: &Surroundings) -> Plan {
    Plan::Skip("there are no targets of cargo-fuzz yet; `any-input` is what there is".to_owned())
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

/// These words, then these arguments.
fn start(words: &str, arguments: &[String]) -> Plan {
    let words = words.split_whitespace().map(str::to_owned);
    Plan::Start(words.chain(arguments.iter().cloned()).collect())
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
            toolchains: String::new(),
            release_tags: String::new(),
        }
    }

    fn words(text: &str) -> Plan {
        start(text, &[])
    }

    #[test]
    fn the_feature_matrix_is_of_the_crates_that_are_there() {
        let expected = "cargo hack check --feature-powerset --no-dev-deps --package smpm";
        assert_eq!(features(&surroundings()), words(expected));
    }

    #[test]
    fn interfaces_are_compared_with_the_newest_release() {
        let tagged = Surroundings { release_tags: "v0.2.0\nv0.1.0\n".to_owned(), ..surroundings() };
        let expected = "cargo semver-checks --workspace --baseline-rev v0.2.0";
        assert_eq!(semver(&tagged), words(expected));
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
    fn mutants_are_made_of_crates_that_exist() {
        let here = Surroundings::look().unwrap().crates;
        assert!(SMALL_CRATES.iter().all(|name| here.iter().any(|known| known == name)), "{here:?}");
    }
}
