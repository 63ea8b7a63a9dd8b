//! The commands of the workspace.
//!
//! Each command starts cargo, or bash for `ci`, and returns its exit code. No package of the workspace is linked, so
//! this builds in a moment.

mod audit;
mod gallery;
mod solver;
mod weight;

use std::io::Write;
use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode, ExitStatus, Stdio};

const HELP: &str = "\
The commands of the workspace.

Usage: cargo xtask COMMAND [ARGUMENT]...

  verify [FILTER]... [--quick|--full] [--list] [--json FILE] [--out DIR]
                              run the proof; fails if a claim does not hold
                              filters that all name a case, as fpk-sph/steps, build the cases
                              without optimisation: a changed tolerance has its verdict sooner
  verify --loose [FILTER]...  the same, and list the claims whose tolerance is over ten
                              times the error without a reason for it
  verify --record [--full]    the same, and write docs/verification.md and .json; refused with a loose claim
  verify --stale              say whether that page is older than cases, scenes and references
  run SCENE.json --out DIR [--seed S] [--threads N] [--resume|--overwrite] [--shard K/N]
                              run a scene; killed, it goes on with --resume, or starts
                              from the beginning with --overwrite; it ends with the answers
                              (--quiet: with the paths of its files) and writes a page
  run SCENE.json --out DIR --mpi N
                              the same on N ranks, started by mpirun: an ensemble, block by
                              block, bitwise identical (docs/scaling.md)
  run SCENE.json --out DIR --tolerance T
                              the same, its method refined to an error of T; fails if it
                              is not reached
  advise SCENE.json --tolerance T
                              the cheapest method and size for a scene, from short trial
                              runs of all that solve it
  merge SCENE.json SHARD... --out DIR
                              join the shards of an ensemble
  gallery [--record]          run one scene of each solver, with its page, into target/gallery;
                              --record copies their pictures into docs/pictures
  chart [NAME]... [--list] [--record]
                              draw error against cost; --record writes into docs/charts too
  chart --ladder [NAME]... [--record]
                              leave out one ingredient of each scene at a time: which of
                              them its answers need
  stability [NAME]... [--record]
                              sweep methods to where they fail
  schema [--record]           write the schemas of scenes and the page of their keys into
                              target/schema, or into docs
  materials                   list the materials that scenes of smpm may name: models,
                              constants in SI, sources
  bench [NAME]... [--record] [-- ARG...]
                              run benchmarks, print ratios to rivals; what follows -- goes
                              to criterion, a first word there is a filter on names;
                              `plain` counts instructions against steps written by hand;
                              --record writes docs/benchmarks.md from what was measured
  ci                          all that must hold before a merge, as .ci/run does it
  audit [NAME]... [--list]    checks that take longer or need tools that may be absent:
                              licences, features, interfaces, coverage, mutants, oldest
                              Rust, packages; one that cannot run is skipped
  weight [--record [--build]] lines of Rust by package, and their change since docs/weight.json;
                              --build measures compile times and machine code too
  audit errors [--runs N] [--seed S] [--each]
                              draw scenes with known answers, run them, and say how often the truth
                              lies within the errors that they state
  audit claims [--only NAME]... [--crate NAME]... [--missing] [--record]
                              build with one constant or sign wrong at a time: do the
                              claims of its crate notice? --missing runs those whose source
                              or cases changed; --record writes docs/mutants.md and .json

`cargo xtask --checked COMMAND ...` runs verify, run, advise, merge, chart, stability, schema and materials as
the tests are built: slower, with checks of overflow, and without another build of everything after `cargo test`.

`cargo xtask COMMAND --help` says more about all of these but bench, ci and gallery.
";

/// The commands, and the package whose binary runs each.
const PACKAGES: [(&str, &str); 8] = [
    ("run", "scenes"),
    ("advise", "scenes"),
    ("merge", "scenes"),
    ("schema", "scenes"),
    ("materials", "scenes"),
    ("chart", "work-precision"),
    ("stability", "work-precision"),
    ("verify", "verification"),
];

/// Option that records a benchmark.
const RECORD: &str = "--record";

/// Option that starts ranks of MPI.
const MPI: &str = "--mpi";

/// Exit code for an invalid command line.
const USAGE: u8 = 2;

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    if let Some(ended) = weight::as_wrapper(&arguments) {
        return ended;
    }
    let (checked, arguments) = match arguments.split_first() {
        Some((first, rest)) if first == "--checked" => (true, rest),
        _ => (false, &arguments[..]),
    };
    let Some((command, rest)) = arguments.split_first() else {
        say(HELP);
        return ExitCode::from(USAGE);
    };
    match (command.as_str(), package_of(command)) {
        ("run", _) if !checked && rest.iter().any(|argument| argument == MPI) => {
            match ranks(rest) {
                Ok((n_ranks, rest)) => run_on_ranks(n_ranks, &rest),
                Err(error) => {
                    say(&format!("error: {error}\n"));
                    ExitCode::from(USAGE)
                }
            }
        }
        (command, Some(package)) => run_package(
            package,
            checked,
            &[&[command.to_owned()], &documents(command, rest)[..]].concat(),
        ),
        ("bench", _) => start(cargo().args(bench_arguments(rest))),
        ("ci", _) => start(Command::new("bash").arg(".ci/run").current_dir(workspace())),
        ("audit", _) => audit::run(rest),
        ("gallery", _) => gallery::run(rest),
        ("weight", _) => weight::run(rest),
        ("help" | "-h" | "--help", _) => print(HELP),
        (unknown, None) => {
            say(&format!("error: there is no command `{unknown}`\n\n{HELP}"));
            ExitCode::from(USAGE)
        }
    }
}

/// The package whose binary runs a command.
fn package_of(command: &str) -> Option<&'static str> {
    PACKAGES.iter().find(|(name, _)| *name == command).map(|(_, package)| *package)
}

/// Builds the binary of a package, in the test or the release profile, and starts it.
fn run_package(package: &str, checked: bool, arguments: &[String]) -> ExitCode {
    if !checked {
        if !binary("release", package).exists() {
            say(&format!("building {package} (release); the first time takes a few minutes ...\n"));
        }
        return start(cargo().args(run_arguments(package, &build_options(arguments), arguments)));
    }
    let built = start(cargo().args(["test", "--workspace", "--tests", "--no-run", "--quiet"]));
    if built != ExitCode::SUCCESS {
        return built;
    }
    start(Command::new(binary("debug", package)).args(arguments))
}

fn run_arguments(package: &str, options: &[String], arguments: &[String]) -> Vec<String> {
    let start = ["run", "--release", "--quiet", "--package", package];
    let start = start.iter().map(|&word| word.to_owned()).chain(options.iter().cloned());
    start.chain(["--".to_owned()]).chain(arguments.iter().cloned()).collect()
}

/// Options for cargo with which a command is ready sooner.
///
/// A first `run` builds the solver of its scene alone, in half the time; once the proof is built, all are there.
fn build_options(arguments: &[String]) -> Vec<String> {
    match arguments.split_first() {
        _ if names_cases(arguments) => UNOPTIMISED.map(str::to_owned).to_vec(),
        Some((command, rest))
            if ["run", "advise", "merge"].contains(&command.as_str())
                && !binary("release", "verification").exists() =>
        {
            solver::features(rest)
        }
        _ => Vec::new(),
    }
}

/// The cases are compiled without optimisation, in an eighth of the time; solvers, scenes and problems are not concerned. Cargo
/// keeps both builds.
const UNOPTIMISED: [&str; 2] = ["--config", "profile.release.package.verification.opt-level=0"];

/// Whether these are arguments of `verify` that name single cases, which run shorter than their optimisation takes.
fn names_cases(arguments: &[String]) -> bool {
    let Some(("verify", mut rest)) = arguments.split_first().map(|(c, rest)| (c.as_str(), rest))
    else {
        return false;
    };
    let mut n_cases = 0;
    while let Some((argument, further)) = rest.split_first() {
        rest = further;
        match argument.as_str() {
            "--json" | "--out" => rest = rest.get(1..).unwrap_or_default(),
            RECORD | "--full" | "--help" | "-h" => return false,
            option if option.starts_with('-') => {}
            filter if filter.contains('/') => n_cases += 1,
            _ => return false,
        }
    }
    n_cases > 0
}

/// Adds the folders of the workspace to the arguments of `schema`; other commands are unchanged.
fn documents(command: &str, rest: &[String]) -> Vec<String> {
    if command != "schema" {
        return rest.to_vec();
    }
    let folder = |path: &str| workspace().join(path).to_string_lossy().into_owned();
    let is_record = rest.iter().any(|argument| argument == RECORD);
    let out = folder(if is_record { "docs" } else { "target/schema" });
    let places = ["--scenes".to_owned(), folder("tests/scenes"), "--out".to_owned(), out];
    let rest = rest.iter().filter(|argument| *argument != RECORD).cloned();
    places.into_iter().chain(rest).collect()
}

/// The number after `--mpi`, and the arguments without both.
fn ranks(rest: &[String]) -> Result<(NonZeroUsize, Vec<String>), String> {
    let at = rest.iter().position(|argument| argument == MPI).unwrap_or(rest.len());
    let number = rest.get(at + 1).ok_or("--mpi needs a number of ranks, e.g. --mpi 2")?;
    let n_ranks =
        number.parse().map_err(|_| format!("--mpi {number}: a number from 1 on is needed"))?;
    Ok((n_ranks, [&rest[..at], &rest[at + 2..]].concat()))
}

/// Builds with MPI and starts a number of ranks, on the machines that mpirun is configured for.
fn run_on_ranks(n_ranks: NonZeroUsize, rest: &[String]) -> ExitCode {
    let mpirun = || Command::new("mpirun");
    if !mpirun().arg("--version").stdout(Stdio::null()).status().is_ok_and(|it| it.success()) {
        say(
            "error: cannot start mpirun: install an MPI (Debian: libopenmpi-dev openmpi-bin libclang-dev)\n",
        );
        return ExitCode::FAILURE;
    }
    if is_refused_as_root() {
        say(
            "error: Open MPI does not start as root, as in containers: set OMPI_ALLOW_RUN_AS_ROOT=1 and \
             OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1, or run as another user\n",
        );
        return ExitCode::FAILURE;
    }
    say("building scenes with MPI (release); the first time takes a few minutes ...\n");
    let build = ["build", "--release", "--quiet", "--package", "scenes", "--features=mpi"];
    let built = start(cargo().args(build).args(solver::features(rest)));
    if built != ExitCode::SUCCESS {
        return built;
    }
    start(
        mpirun()
            .args(["-n", &n_ranks.to_string()])
            .arg(binary("release", "scenes"))
            .arg("run")
            .args(rest),
    )
}

/// Whether mpirun would refuse to start: Open MPI as root, unless two variables allow it. Asked before a build of minutes.
fn is_refused_as_root() -> bool {
    let text = |command: &mut Command| {
        let output = command.output().map(|it| it.stdout).unwrap_or_default();
        String::from_utf8_lossy(&output).into_owned()
    };
    let is_allowed = ["OMPI_ALLOW_RUN_AS_ROOT", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM"]
        .iter()
        .all(|name| std::env::var_os(name).is_some_and(|value| value == "1"));
    !is_allowed
        && text(Command::new("id").arg("-u")).trim() == "0"
        && text(Command::new("mpirun").arg("--version")).contains("Open MPI")
}

fn bench_arguments(rest: &[String]) -> Vec<String> {
    let end_of_names = rest.iter().position(|argument| argument == "--").unwrap_or(rest.len());
    let (names, criterion) = rest.split_at(end_of_names);
    if names.iter().any(|name| name == RECORD) {
        let start =
            ["run", "--release", "--quiet", "--package", "benches", "--bin", "record", "--"];
        let names = names.iter().filter(|name| *name != RECORD).chain(criterion);
        return start.into_iter().map(str::to_owned).chain(names.cloned()).collect();
    }
    let targets = names.iter().flat_map(|name| ["--bench".to_owned(), name.clone()]);
    let start =
        ["bench", "--package", "benches", "--features=rivals"].map(str::to_owned).into_iter();
    start.chain(targets).chain(criterion.iter().cloned()).collect()
}

/// The cargo that started this program.
fn cargo() -> Command {
    Command::new(std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into()))
}

/// The folder above this package, reported by cargo; without cargo the current one, whole: some commands run elsewhere.
fn workspace() -> PathBuf {
    let package = std::env::var_os("CARGO_MANIFEST_DIR").map(PathBuf::from);
    let current = || std::env::current_dir().unwrap_or_else(|_| ".".into());
    package.as_deref().and_then(Path::parent).map_or_else(current, Path::to_owned)
}

/// Path of a package's binary in a profile.
fn binary(profile: &str, package: &str) -> PathBuf {
    let target = std::env::var_os("CARGO_TARGET_DIR")
        .map_or_else(|| workspace().join("target"), PathBuf::from);
    target.join(profile).join(format!("{package}{}", std::env::consts::EXE_SUFFIX))
}

fn start(command: &mut Command) -> ExitCode {
    match command.status() {
        Ok(status) => forward(status),
        Err(error) => {
            say(&format!("error: cannot start {}: {error}\n", command.get_program().display()));
            ExitCode::FAILURE
        }
    }
}

/// Exit code of the started program; 1 if a signal ended it.
fn forward(status: ExitStatus) -> ExitCode {
    status.code().and_then(|code| u8::try_from(code).ok()).map_or(ExitCode::FAILURE, ExitCode::from)
}

/// Prints text on standard output; fails if it is closed.
fn print(text: &str) -> ExitCode {
    match std::io::stdout().write_all(text.as_bytes()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(_) => ExitCode::FAILURE,
    }
}

fn say(text: &str) {
    // Without stderr the exit code still reports the error.
    let _ = std::io::stderr().write_all(text.as_bytes());
}

#[cfg(test)]
mod tests {
    use super::*;

    fn words(text: &str) -> Vec<String> {
        text.split_whitespace().map(str::to_owned).collect()
    }

    #[test]
    fn only_filters_that_all_name_a_case_go_without_optimisation() {
        let is_unoptimised =
            |text: &str| build_options(&words(text)).iter().any(|word| word == "--config");
        assert!(is_unoptimised("verify fpk-sph/steps"));
        assert!(is_unoptimised("verify --quick fpk-sph/steps --json out/a.json smpm/disks"));
        for text in [
            "verify",
            "verify --quick --out target/verify",
            "verify fpk-sph",
            "verify fpk-sph/steps smpm",
            "verify --full peridyn-sde/inference",
            "run tests/scenes/fpk/viscous_damper.json",
        ] {
            assert!(!is_unoptimised(text), "{text}");
        }
    }

    #[test]
    fn each_command_reaches_its_package_with_its_arguments() {
        let expected =
            words("run --release --quiet --package verification -- verify fpk-sph --quick");
        let package = package_of("verify").unwrap();
        let arguments = words("verify fpk-sph --quick");
        assert_eq!(run_arguments(package, &[], &arguments), expected);
        let options = words("--no-default-features --features=cli,fpk");
        let expected = words(
            "run --release --quiet --package scenes --no-default-features --features=cli,fpk -- run a.json",
        );
        assert_eq!(run_arguments("scenes", &options, &words("run a.json")), expected);
        assert_eq!(package_of("run"), Some("scenes"));
        assert_eq!(package_of("chart"), Some("work-precision"));
        assert_eq!(package_of("bench"), None);
    }

    #[test]
    fn schemas_go_where_they_are_recorded_only_if_asked() {
        let written = documents("schema", &words("--record"));
        assert!(written.last().unwrap().ends_with("docs"), "{written:?}");
        let tried = documents("schema", &[]);
        assert!(tried.last().unwrap().ends_with("target/schema"), "{tried:?}");
        assert_eq!(documents("run", &words("--record")), words("--record"));
    }

    #[test]
    fn ranks_are_a_number_behind_their_flag() {
        let (n_ranks, rest) = ranks(&words("a.json --mpi 4 --out b")).unwrap();
        assert_eq!((n_ranks.get(), rest), (4, words("a.json --out b")));
        for wrong in ["a.json --mpi", "--mpi 0 a.json", "--mpi two a.json"] {
            assert!(ranks(&words(wrong)).unwrap_err().contains("--mpi"), "{wrong}");
        }
    }

    #[test]
    fn benchmarks_are_named_before_and_criterion_is_told_after_the_dashes() {
        assert_eq!(bench_arguments(&[]), words("bench --package benches --features=rivals"));
        let expected =
            words("bench --package benches --features=rivals --bench fpk --bench sde -- --test");
        assert_eq!(bench_arguments(&words("fpk sde -- --test")), expected);
        assert_eq!(
            bench_arguments(&words("-- --test")),
            words("bench --package benches --features=rivals -- --test")
        );
    }

    #[test]
    fn a_record_of_benchmarks_is_made_by_a_program_of_its_own() {
        let expected =
            words("run --release --quiet --package benches --bin record -- smpm -- APIC");
        assert_eq!(bench_arguments(&words("smpm --record -- APIC")), expected);
    }
}
