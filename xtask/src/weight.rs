//! `cargo xtask weight`: lines of Rust, compile time and machine code of each package, against `docs/weight.json`.
//!
//! Lines are counted at once. CPU seconds of the compiler and sizes of binaries need builds from nothing, so they are measured by
//! `--record --build` alone: this program is then cargo's `RUSTC_WRAPPER`, and adds a line for each unit to a file.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::io::Write;
use std::path::Path;
use std::process::{Command, ExitCode};

use serde_json::{Value, json};

use crate::{RECORD, USAGE, cargo, forward, print, say, workspace};

/// File to which the wrapper of the compiler adds its lines; set while `--build` measures.
const UNITS: &str = "XTASK_WEIGHT_UNITS";
const FILE: &str = "docs/weight.json";
/// Folder of the builds from nothing.
const BUILD: &str = "target/weight";
/// The programs whose machine code is measured.
const BINARIES: [&str; 3] = ["scenes", "verification", "work-precision"];

const HELP: &str = "\
Prints the lines of Rust of each package and their change since docs/weight.json.

Usage: cargo xtask weight [--record [--build]]

  --record  write the lines into docs/weight.json
  --build   with --record: also build everything from nothing, in release and for tests, and write
            CPU seconds of the compiler by package and the machine code of the binaries (an hour of CPU time; Linux)
";

/// Lines of `src`, and of tests, examples and benchmarks.
type Lines = BTreeMap<String, [u64; 2]>;

/// The command line after `weight`.
pub(crate) fn run(arguments: &[String]) -> ExitCode {
    let has = |word: &str| arguments.iter().any(|argument| argument == word);
    let (is_record, is_build) = (has(RECORD), has("--build"));
    if has("--help") {
        return print(HELP);
    }
    if arguments.len() != usize::from(is_record) + usize::from(is_build) || is_build && !is_record {
        say(HELP);
        return ExitCode::from(USAGE);
    }
    match weigh(is_record, is_build) {
        Ok(table) => print(&table),
        Err(error) => {
            say(&format!("error: {error}\n"));
            ExitCode::FAILURE
        }
    }
}

fn weigh(is_record: bool, is_build: bool) -> Result<String, String> {
    let root = workspace();
    let lines = lines(&root)?;
    let text = std::fs::read_to_string(root.join(FILE)).unwrap_or_else(|_| "{}".to_owned());
    let mut recorded: Value =
        serde_json::from_str(&text).map_err(|error| format!("{FILE}: {error}"))?;
    let table = table(&lines, &recorded);
    if is_build {
        let (release, test) = (
            "build --release -p scenes -p verification -p work-precision",
            "test --workspace --no-run",
        );
        recorded["cpu_seconds"]["release"] = json!(cpu_seconds(&root, release, lines.keys())?);
        // The next build starts from nothing too.
        recorded["text_bytes"] = json!(text_bytes(&root.join(BUILD).join("release"))?);
        recorded["cpu_seconds"]["test"] = json!(cpu_seconds(&root, test, lines.keys())?);
    }
    if is_record {
        let entry = |(name, [src, tests]): (&String, &[u64; 2])| {
            (name.clone(), json!({ "src": src, "tests": tests }))
        };
        recorded["lines"] = lines.iter().map(entry).collect::<serde_json::Map<_, _>>().into();
        std::fs::write(root.join(FILE), format!("{recorded:#}\n"))
            .map_err(|error| format!("{FILE}: {error}"))?;
    }
    Ok(table)
}

// ---- lines ----

/// Lines of all Rust files that git tracks, by package.
fn lines(root: &Path) -> Result<Lines, String> {
    let output = Command::new("git").args(["ls-files", "-z", "*.rs"]).current_dir(root).output();
    let output = output.map_err(|error| format!("cannot start git: {error}"))?;
    let mut lines = Lines::new();
    for path in String::from_utf8_lossy(&output.stdout).split('\0').filter(|path| !path.is_empty())
    {
        // A file that is deleted but not yet committed has no lines.
        let text = std::fs::read(root.join(path)).unwrap_or_default();
        let n_lines = text.split(|&byte| byte == b'\n').count().saturating_sub(1) as u64;
        let (package, is_src) = place(path);
        lines.entry(package.to_owned()).or_default()[usize::from(!is_src)] += n_lines;
    }
    if lines.is_empty() { Err("git lists no Rust files".to_owned()) } else { Ok(lines) }
}

/// The package of a file, and whether it is in `src`.
fn place(path: &str) -> (&str, bool) {
    let mut parts = path.split('/');
    let (package, inside) = match (parts.next(), parts.next()) {
        (Some("crates"), Some(name)) => (name, parts.next()),
        (Some("tests"), Some("fuzz")) => ("fuzz-targets", Some("tests")),
        (Some("tests"), Some("problems")) => ("reference-problems", parts.next()),
        (Some("tests"), inside) => ("verification", inside),
        (first, inside) => (first.unwrap_or_default(), inside),
    };
    (package, inside == Some("src"))
}

/// Packages with their lines, the change since the record, and the sum; then what the record says of builds.
fn table(lines: &Lines, recorded: &Value) -> String {
    let mut text = format!("{:<24}{:>8}{:>8}{:>9}\n", "lines of Rust", "src", "tests", "change");
    let (mut sums, mut before_all) = ([0; 2], 0);
    let gone = recorded["lines"].as_object().into_iter().flatten().map(|(name, _)| name);
    for name in lines.keys().chain(gone.filter(|name| !lines.contains_key(*name))) {
        let before: u64 =
            ["src", "tests"].iter().filter_map(|key| recorded["lines"][name][key].as_u64()).sum();
        let [src, tests] = lines.get(name).copied().unwrap_or_default();
        text.push_str(&row(name, [src, tests], before));
        sums = [sums[0] + src, sums[1] + tests];
        before_all += before;
    }
    text.push_str(&row("sum", sums, before_all));
    for (profile, seconds) in recorded["cpu_seconds"].as_object().into_iter().flatten() {
        let all = seconds.as_object().into_iter().flatten().filter_map(|(_, it)| it.as_f64());
        let _ =
            writeln!(text, "recorded: {:.0} CPU seconds to compile ({profile})", all.sum::<f64>());
    }
    for (name, bytes) in recorded["text_bytes"].as_object().into_iter().flatten() {
        let megabytes = 1e-6 * bytes.as_f64().unwrap_or(0.0);
        let _ = writeln!(text, "recorded: {megabytes:.1} MB of machine code in {name}");
    }
    text
}

fn row(name: &str, [src, tests]: [u64; 2], before: u64) -> String {
    let change = (src + tests).cast_signed() - before.cast_signed();
    format!("{name:<24}{src:>8}{tests:>8}{change:>+9}\n")
}

// ---- builds ----

/// Builds from nothing; returns CPU seconds by package, other crates as `dependencies`.
fn cpu_seconds<'a>(
    root: &Path,
    build: &str,
    packages: impl Iterator<Item = &'a String>,
) -> Result<BTreeMap<String, f64>, String> {
    let folder = root.join(BUILD);
    let units = folder.join("units");
    let _ = std::fs::remove_dir_all(&folder);
    let error = |error: std::io::Error| format!("{}: {error}", folder.display());
    std::fs::create_dir_all(&folder).map_err(error)?;
    let status = cargo()
        .args(build.split_whitespace())
        .arg("--locked")
        .current_dir(root)
        .env("CARGO_TARGET_DIR", &folder)
        .env("RUSTC_WRAPPER", std::env::current_exe().map_err(error)?)
        .env(UNITS, &units)
        .status();
    if !status.is_ok_and(|status| status.success()) {
        return Err(format!("cargo {build} failed"));
    }
    let ours: Vec<&String> = packages.collect();
    let mut seconds: BTreeMap<String, f64> = BTreeMap::new();
    for line in std::fs::read_to_string(&units).map_err(error)?.lines() {
        let (unit, of_unit) = line.split_once(' ').unwrap_or((line, "0"));
        let is_ours = ours.iter().any(|name| *name == unit);
        let package = if is_ours { unit } else { "dependencies" };
        *seconds.entry(package.to_owned()).or_insert(0.0) += of_unit.parse().unwrap_or(0.0);
    }
    Ok(seconds.into_iter().map(|(name, sum)| (name, f64::round(sum))).collect())
}

/// Runs the compiler if cargo started this program as its wrapper: the arguments are the compiler and its own.
pub(crate) fn as_wrapper(arguments: &[String]) -> Option<ExitCode> {
    let (units, (compiler, rest)) = (std::env::var_os(UNITS)?, arguments.split_first()?);
    let status = match Command::new(compiler).args(rest).status() {
        Ok(status) => status,
        Err(error) => {
            say(&format!("error: cannot start {compiler}: {error}\n"));
            return Some(ExitCode::FAILURE);
        }
    };
    // A test program is a crate with a name of its own; cargo names the package here.
    let name = std::env::var("CARGO_PKG_NAME");
    let file = std::fs::OpenOptions::new().append(true).create(true).open(units);
    if let (Ok(name), Ok(mut file)) = (name, file) {
        let stat = std::fs::read_to_string("/proc/self/stat").unwrap_or_default();
        // One write, so that units compiled at once do not mix. A lost line leaves a sum too small.
        let _ = file.write_all(format!("{name} {}\n", child_seconds(&stat)).as_bytes());
    }
    Some(forward(status))
}

/// CPU seconds of all children that have ended, from the text of `/proc/self/stat`: fields 16 and 17, in hundredths.
fn child_seconds(stat: &str) -> f64 {
    let after_name = stat.rsplit(')').next().unwrap_or_default();
    let fields = after_name.split_whitespace().skip(13).take(2);
    fields.filter_map(|field| field.parse::<f64>().ok()).sum::<f64>() / 100.0
}

/// Bytes of machine code of the binaries, as `size` of the linker's package prints them.
fn text_bytes(folder: &Path) -> Result<BTreeMap<&'static str, u64>, String> {
    let of = |name| {
        let path = folder.join(name);
        let output = Command::new("size").arg("-A").arg(&path).output();
        let output = output.map_err(|error| format!("cannot start size: {error}"))?;
        let text = String::from_utf8_lossy(&output.stdout);
        let line = text.lines().find(|line| line.starts_with(".text "));
        let bytes = line.and_then(|line| line.split_whitespace().nth(1)?.parse().ok());
        bytes
            .map(|bytes| (name, bytes))
            .ok_or_else(|| format!("size finds no .text in {}", path.display()))
    };
    BINARIES.into_iter().map(of).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_file_counts_for_its_package() {
        for (path, expected) in [
            ("crates/smpm/src/grid/nodes.rs", ("smpm", true)),
            ("crates/smpm/tests/laws/main.rs", ("smpm", false)),
            ("tests/src/cases/smpm/disks.rs", ("verification", true)),
            ("tests/fuzz/fuzz_targets/a.rs", ("fuzz-targets", false)),
            ("xtask/tests/tree/edges.rs", ("xtask", false)),
        ] {
            assert_eq!(place(path), expected, "{path}");
        }
        assert!(lines(&workspace()).unwrap()["xtask"][0] > 500);
    }

    #[test]
    fn the_table_has_the_change_of_each_package_and_of_the_sum() {
        let lines = Lines::from([("smpm".to_owned(), [120, 30])]);
        let recorded = json!({
            "lines": { "smpm": { "src": 100, "tests": 30 }, "gone": { "src": 50, "tests": 0 } },
            "text_bytes": { "scenes": 12_500_000 },
        });
        let expected = "\
            lines of Rust                src   tests   change\n\
            smpm                         120      30      +20\n\
            gone                           0       0      -50\n\
            sum                          120      30      -30\n\
            recorded: 12.5 MB of machine code in scenes\n";
        assert_eq!(table(&lines, &recorded), expected);
    }

    #[test]
    fn seconds_of_children_are_read_after_a_name_with_spaces() {
        let stat = "7 (a (b) c) S 1 7 7 0 -1 0 0 0 0 0 5 6 1250 50 20 0";
        assert!((child_seconds(stat) - 13.0).abs() < 1e-12);
    }
}
