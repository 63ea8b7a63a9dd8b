//! Drives a page in a headless browser.

use std::path::{Path, PathBuf};
use std::process::Command;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use serde_json::Value;

/// Names of the browsers that can drive a page.
const BROWSERS: [&str; 3] = ["chromium", "chromium-browser", "google-chrome"];
/// Collects errors from the first script on.
const LISTENER: &str = include_str!("listen.js");
/// Uses the page as a reader would, and leaves what it saw.
const DRIVER: &str = include_str!("drive.js");
/// Runs axe-core on the page.
const AXE_DRIVER: &str = include_str!("axe.js");
/// The text between which the driver leaves it.
const MARKS: [&str; 2] = ["<pre id=\"outcome\">", "</pre>"];
/// Width of the narrow frame (pixels).
const NARROW: u32 = 400;

/// The browser of this machine, if it has one.
pub(crate) fn browser() -> Option<PathBuf> {
    let folders: Vec<PathBuf> = std::env::split_paths(&std::env::var_os("PATH")?).collect();
    BROWSERS.iter().find_map(|name| folders.iter().map(|it| it.join(name)).find(|it| it.is_file()))
}

/// What the driver saw on a page.
pub(crate) fn drive(browser: &Path, html: &str) -> Value {
    let heard = html.replacen("<title>", &format!("<script>{LISTENER}</script><title>"), 1);
    let (start, end) = heard.rsplit_once("</body>").expect("the end of the page");
    outcome(browser, &format!("{start}<script>{DRIVER}</script></body>{end}"))
}

/// The program of axe-core that `AXE_CORE` names, if it does.
pub(crate) fn axe() -> Option<String> {
    let path = std::env::var_os("AXE_CORE")?;
    Some(std::fs::read_to_string(path).expect("the file that AXE_CORE names"))
}

/// Rules of axe-core that a page violates in either theme, and how many it keeps.
pub(crate) fn violations(browser: &Path, axe: &str, html: &str) -> Value {
    let (start, end) = html.rsplit_once("</body>").expect("the end of the page");
    let axe = axe.replace("</script>", "<\\/script>");
    let scripts = format!("<script>{axe}</script><script>{AXE_DRIVER}</script>");
    outcome(browser, &format!("{start}{scripts}</body>{end}"))
}

/// The width that the page takes in a frame of 400 pixels.
pub(crate) fn width_in_a_narrow_frame(browser: &Path, html: &str) -> f64 {
    let inner = html.replace('&', "&amp;").replace('"', "&quot;");
    let page = format!(
        "<!doctype html><body><iframe style=\"width:{NARROW}px;height:900px;border:0\" srcdoc=\"{inner}\"></iframe><script>\
         addEventListener('load', () => {{\
           const root = document.querySelector('iframe').contentDocument.documentElement;\
           const outcome = document.createElement('pre');\
           outcome.id = 'outcome';\
           outcome.textContent = btoa(JSON.stringify({{ width: root.scrollWidth }}));\
           document.body.append(outcome);\
         }});</script></body>"
    );
    outcome(browser, &page)["width"].as_f64().expect("a width")
}

/// Opens a page from a file and returns what it left.
fn outcome(browser: &Path, html: &str) -> Value {
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("page.html");
    std::fs::write(&file, html).expect("the page");
    let profile = folder.path().join("profile");
    let output = Command::new(browser)
        .args([
            "--headless=new",
            "--no-sandbox",
            "--disable-gpu",
            "--disable-quic",
            "--no-first-run",
        ])
        .args(["--disable-background-networking", "--disable-component-update", "--disable-sync"])
        .args(["--window-size=1200,1000", "--virtual-time-budget=8000", "--dump-dom"])
        .arg(format!("--user-data-dir={}", profile.display()))
        .arg(format!("file://{}", file.display()))
        .output()
        .expect("the browser");
    let dom = String::from_utf8_lossy(&output.stdout);
    let (_, rest) =
        dom.rsplit_once(MARKS[0]).expect("an outcome; an error in the driver leaves none");
    let (text, _) = rest.split_once(MARKS[1]).expect("its end");
    serde_json::from_slice(&STANDARD.decode(text).expect("base64")).expect("JSON")
}
